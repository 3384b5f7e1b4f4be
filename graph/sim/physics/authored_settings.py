"""Compares the physics settings that a stage authors with the table of simulated settings."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import lru_cache
from typing import Any

from graph.base.errors import Problem, UserError
from graph.base.records import dataclass, field
from graph.base.suggest import closest
from graph.sim.attributes import applied_schemas
from graph.sim.scene.physics_settings import (
    ARRAYS,
    INSTANCES,
    NAMESPACES,
    RELATIONSHIPS,
    ROLES,
    SCHEMAS,
    SIMULATED,
    TOKENS,
    VECTORS,
    generic,
)
from graph.sim.scene.scan import JOINT_KINDS, SOFT, SOFT_ATTACHMENTS
from graph.sim.scene.stage import Warn
from graph.sim.scene.stored_settings import ACTUATOR, NEUTRAL, QUIET_SCHEMAS, STORED, UNKNOWN, Stored, stored_as
from graph.sim.scene.value_types import fits
from graph.sim.usd import EARLIEST, Sdf, Tf, Usd, UsdPhysics

CODE = "physics-setting-stored"

_API_ROLES = {
    "PhysicsRigidBodyAPI": "body",
    "PhysicsCollisionAPI": "collider",
    "PhysicsMaterialAPI": "material",
    "PhysicsArticulationRootAPI": "root",
    **dict.fromkeys(SOFT, "soft"),
    "OmniPhysicsDeformableBodyAPI": "soft",
    "OmniPhysicsBaseMaterialAPI": "material",
    "OmniPhysicsDeformableMaterialAPI": "material",
    "OmniPhysicsSurfaceDeformableMaterialAPI": "material",
    "PhysxDeformableSurfaceMaterialAPI": "material",
    "PhysxDeformableBodyMaterialAPI": "material",
    "PhysxPBDMaterialAPI": "material",
}


@dataclass
class StoredSettings:
    """Settings without effect, collected so that those with the same reason make one line."""

    _found: dict[str, tuple[str, dict[str, None], dict[str, None]]] = field(default_factory=dict)

    def add(self, path: str, name: str, why: str) -> None:
        """Adds a name (of an attribute, relationship or schema) on the prim at `path`, and why it has no effect."""
        place = f"{path}.{name}" if ":" in name else path
        _, names, prims = self._found.setdefault(why, (place, {}, {}))
        names[name], prims[path] = None, None

    def lines(self) -> Iterator[tuple[str, str]]:
        """(place, message), one for each reason: the first setting in full, the others by name and number."""
        for why, (place, names, prims) in self._found.items():
            first, *others = names
            also = f"; so {'do' if len(others) > 1 else 'does'} {_listed(others)}" if others else ""
            several = f" ({len(prims):,} prims)" if len(prims) > 1 else ""
            what = "it" if ":" in first else first
            yield place, f"{what} is kept on the prim and changes nothing{several}: {why}{also}"

    def tell(self, warn: Warn) -> None:
        """Gives a warning for each line, `physics-setting-stored`."""
        for where, message in self.lines():
            warn(CODE, where, message)


def check_settings(stage: Any, warn: Warn, *, mirrors: bool = False) -> None:
    """Checks every physics setting that a stage authors.

    Settings that are not simulated give the warning `physics-setting-stored`, one line for each reason. mirrors: the
    stage mirrors an MJCF model, whose own attributes (`mjc:`) are simulated unchanged. Raises UserError, one line each,
    for simulated properties whose kind or type differs from their schemas.
    """
    stored, problems = StoredSettings(), list[Problem]()
    for prim in _prims(stage):
        apis = applied_schemas(prim)
        names = [name for name in prim.GetAuthoredPropertyNames() if name.startswith(NAMESPACES)]
        if names or apis or str(prim.GetTypeName()).startswith(SCHEMAS):
            _look(prim, apis, names, mirrors, stored, problems)
    if problems:
        raise UserError(problems)
    stored.tell(warn)


def _prims(stage: Any) -> Iterator[Any]:
    """Every prim outside of graphs but actuators, which a node reads; prims that instances share only once."""
    seen = set()
    prims = iter(Usd.PrimRange(stage.GetPseudoRoot(), Usd.TraverseInstanceProxies()))
    for prim in prims:
        if prim.IsInstance():
            prototype = prim.GetPrototype().GetPath()
            if prototype in seen:
                prims.PruneChildren()
            seen.add(prototype)
        if prim.GetTypeName() == "OmniGraph":  # its nodes have states, and no physics
            prims.PruneChildren()
        elif prim.GetTypeName() != ACTUATOR:
            yield prim


def _look(
    prim: Any, apis: list[str], names: list[str], mirrors: bool, stored: StoredSettings, problems: list[Problem]
) -> None:
    path, kind = str(prim.GetPath()), str(prim.GetTypeName())
    schemas, by_type, roles = _read_as(kind, tuple(apis))
    for schema in schemas:
        if not (mirrors and schema.startswith("Mjc")):
            stored.add(path, schema, stored_as(schema).why)
    if by_type and not mirrors:  # its attributes are parameters only
        return
    for name in names:
        if mirrors and name.startswith("mjc:"):
            continue
        known, instance = generic(name)
        if problem := _type_problem(prim, name, known):
            problems.append(Problem(problem))
        elif not _counts(known, instance, roles) and not _neutral(prim, name, known):
            stored.add(path, name, _why(known, instance, roles).why)


@lru_cache(maxsize=4096)
def _read_as(kind: str, apis: tuple[str, ...]) -> tuple[tuple[str, ...], bool, frozenset[str]]:
    """For prims of a type with API schemas: those of the schemas that are not simulated, whether the type is, their
    roles.
    """
    names = [api.partition(":")[0] for api in apis]
    every = dict.fromkeys([kind, *names])
    schemas = tuple(name for name in every if name.startswith(SCHEMAS) and name not in QUIET_SCHEMAS)
    found = {role for name in names if (role := _API_ROLES.get(name))}
    if role := _type_role(kind):
        found.add(role)
    return schemas, kind in schemas and stored_as(kind) is not UNKNOWN, frozenset(found)


@lru_cache(maxsize=1024)
def _type_role(kind: str) -> str:
    """The role of all prims of a type."""
    if kind in SOFT_ATTACHMENTS:
        return "attachment"
    known = Usd.SchemaRegistry.GetTypeFromName(kind)
    types = (*JOINT_KINDS, (UsdPhysics.Scene, "scene"), (UsdPhysics.CollisionGroup, "group"))
    return next((role for base, role in types if known and known.IsA(Tf.Type(base))), "")


def _counts(known: str, instance: str, roles: frozenset[str]) -> bool:
    where = roles.intersection(SIMULATED.get(known, ()))
    if not where or not instance or known.startswith("physxMimicJoint"):
        return bool(where)
    return any(instance in INSTANCES.get(role, ()) for role in where)


def _why(known: str, instance: str, roles: frozenset[str]) -> Stored:
    """Why a name has no effect on a prim with some roles."""
    places = SIMULATED.get(known)
    if places is None:
        row = stored_as(known)
        near = closest(known, _every_name(), 0.85) if row is UNKNOWN else None
        return Stored(f'{row.why}: did you mean "{near.replace("*", instance)}"?', ()) if near else row
    if not roles.intersection(places):
        return Stored(f"it counts on {' or '.join(ROLES[place] for place in places)}", ())
    fitting = [name for role in places if role in roles for name in INSTANCES.get(role, ())]
    return Stored(f"this joint has no axis {instance}; write {' or '.join(fitting)} in its place", ())


def _every_name() -> list[str]:
    return [*SIMULATED, *(name for row in STORED for name in row.names)]


def _neutral(prim: Any, name: str, known: str) -> bool:
    """Whether a setting asks for the default behaviour."""
    attribute = prim.GetAttribute(name)
    if not attribute:
        return not prim.GetRelationship(name).HasAuthoredTargets()
    value = attribute.Get(EARLIEST)
    if known in NEUTRAL:
        return bool(value == NEUTRAL[known])
    if isinstance(value, (bool, int, float)):
        return not value or math.isinf(value)
    return value is None or (hasattr(value, "__len__") and not any(value))


@lru_cache(maxsize=1024)
def _wanted(known: str) -> Any:
    """The required type of a property: "rel", one of `Sdf.ValueTypeNames`, or None for any."""
    registry = Usd.SchemaRegistry()
    for name, attributes in _usd_physics().items():
        if known in attributes:
            found = registry.FindAppliedAPIPrimDefinition(name) or registry.FindConcretePrimDefinition(name)
            spec = found.GetSchemaPropertySpec(attributes[known])
            return "rel" if isinstance(spec, Sdf.RelationshipSpec) else spec.typeName
    types = Sdf.ValueTypeNames
    if known not in SIMULATED or known in ARRAYS:
        return None
    if known in RELATIONSHIPS:
        return "rel"
    return types.Token if known in TOKENS else types.Vector3f if known in VECTORS else types.Float


@lru_cache(maxsize=1)
def _usd_physics() -> dict[str, dict[str, str]]:
    """By schema of UsdPhysics, its own properties as the table writes them, and as its definition does."""
    registry, out = Usd.SchemaRegistry(), {}
    for kind in Tf.Type.FindByName("UsdSchemaBase").GetAllDerivedTypes():
        if not str(kind.typeName).startswith("UsdPhysics"):
            continue
        name = registry.GetSchemaTypeName(kind)
        found = registry.FindAppliedAPIPrimDefinition(name) or registry.FindConcretePrimDefinition(name)
        if found:
            every = {each.replace("__INSTANCE_NAME__", "*"): each for each in found.GetPropertyNames()}
            out[name] = {known: each for known, each in every.items() if known.startswith(NAMESPACES)}
    return out


def _type_problem(prim: Any, name: str, known: str) -> str:
    """What is wrong with the kind or type of a simulated property, or ""."""
    wanted = _wanted(known)
    if wanted is None:
        return ""
    if wanted != "rel":
        value = prim.GetAttribute(name).Get(EARLIEST) if prim.GetAttribute(name).HasAuthoredValue() else None
        if value is not None and fits(value, wanted):  # specs take far longer to ask
            return ""
    where = f"{prim.GetPath()}.{name}"
    for spec in prim.GetProperty(name).GetPropertyStack(EARLIEST):
        is_relationship = isinstance(spec, Sdf.RelationshipSpec)
        if wanted == "rel" and not is_relationship:
            return f"{where} is an attribute; it must be a relationship: `rel {name} = </Path/Of/Prim>`"
        if wanted != "rel" and is_relationship:
            return f"{where} is a relationship; it must be an attribute: `{wanted} {name} = ...`"
        if wanted == "rel":
            continue
        said = spec.default if spec.HasDefaultValue() else value if spec.HasInfo("timeSamples") else None
        if said is not None and not fits(said, wanted):
            return f"{where} is a {spec.typeName}; it must be a {wanted}"
    return ""


def _listed(names: list[str]) -> str:
    shown = names if len(names) <= 4 else [*names[:3], f"{len(names) - 3} more"]
    return shown[0] if len(shown) == 1 else f"{', '.join(shown[:-1])} and {shown[-1]}"
