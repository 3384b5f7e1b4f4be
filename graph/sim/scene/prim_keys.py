"""The keys of inline prims: one small function for each key."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from graph.base import asset_roots
from graph.base.records import dataclass, field
from graph.base.suggest import did_you_mean
from graph.sim.geometry.closed_forms import SOLIDS
from graph.sim.scene.prim_paths import is_path
from graph.sim.usd import Gf, Sdf, Tf, Usd, UsdGeom, UsdPhysics

from . import assets, nonvisual, prim_attributes
from .layers import Checked, check_scene
from .prim_attributes import apply_schema, number, numbers, set_transform
from .stage import Warn

SensorConfig = Callable[[Any, str, Any], None]
Keys = Mapping[str, Any]
Handler = Callable[["PrimContext", Any, Keys, str, set[str]], None]

AUX_LEVELS = ("NONE", "BASIC", "EXTRA", "FULL")
CHANNELS = "_replicator:rendervar:GenericModelOutput:channels"
EXCLUDE = "tickgraph:exclude"
SENSOR_API = "OmniSensorAPI"
PLAIN = {
    "isaac:nameOverride": "string",
    "isaac:namespace": "string",
    "omni:kit:centerOfInterest": "vector3d",
    "omni:rtx:usdluxVersion": "int",
}
"""Attributes of any prim that Isaac Sim reads and no schema declares, name -> USD value type: its frame in TF, the
namespace of topics below it, what a camera looks at, the version by which a light is read.
"""


class SensorPrims(Protocol):
    """The interface to sensor types that the keys of a prim use."""

    @property
    def attributes(self) -> Mapping[str, str]:
        """Attributes that no schema declares: name -> USD value type."""

    @property
    def aux_levels(self) -> Sequence[str]:
        """The values that aux_output_level may have."""


@dataclass
class PrimContext:
    """What the keys of all prims share; `implied` are parents that were created implicitly."""

    stage: Any
    folder: Path
    roots: Sequence[Path]
    sensor_config: SensorConfig | None
    sensor_types: Mapping[str, SensorPrims]
    warn: Warn
    implied: set[str] = field(default_factory=set)
    checked: dict[Path, Checked] = field(default_factory=dict)
    """The files that were referenced so far."""

    def referenced(self, file: Path) -> Any:
        """The layer of a file that a prim references; each file is checked once."""
        if file not in self.checked:
            variables = self.stage.GetRootLayer().expressionVariables
            self.checked[file] = check_scene(file, self.roots, self.warn, variables=variables)
        return Sdf.Layer.FindOrOpen(str(file))

    def confirm(self, before: Sequence[Any]) -> None:
        """Raises UserError if the references led to a file that was not checked; `before`: layers used before them."""
        if self.checked:
            every = list(self.checked.values())
            files = {name: file for one in every for name, file in one.files.items()}
            Checked([], files).confirm(self.stage, before)

    def define(self, path: str, kind: Any, referenced: bool) -> None:
        """Creates the prim and its missing parents (as Xforms). Raises ValueError if its type is wrong."""
        if kind not in (None, *self.sensor_types) and not Usd.SchemaRegistry().FindConcretePrimDefinition(str(kind)):
            raise ValueError(f"there is no prim type {kind!r}{did_you_mean(str(kind), concrete_types())}")
        sdf = Sdf.Path(path)
        for parent in sdf.GetPrefixes()[:-1]:
            above = self.stage.GetPrimAtPath(parent)
            if above and _of_instance(above):
                raise ValueError(f"{parent} is an instance; nothing can be added below it")
            if not above or not above.IsDefined():
                self.stage.DefinePrim(parent, "Xform")
                self.implied.add(str(parent))
        prim = self.stage.GetPrimAtPath(sdf)
        existing = str(prim.GetTypeName()) if prim and prim.IsDefined() else None
        if existing and kind and kind != existing and path not in self.implied:
            raise ValueError(f"the scene already has {existing} there; leave the type out to change it")
        self.implied.discard(path)
        if kind or existing is None:
            self.stage.DefinePrim(sdf, str(kind) if kind else ("" if referenced else "Xform"))

    def define_new(self, prims: Mapping[str, Any]) -> None:
        """Creates at once, before the others, the prims that are new in the scene.

        If they were created one by one, USD would examine all siblings for each, in quadratic time. Left to `define`
        are prims at or below a reference or an instance, those that the scene has, and those of unknown types.
        """
        referencing = {path for path, keys in prims.items() if isinstance(keys, Mapping) and "reference" in keys}
        known = {None, *self.sensor_types, *concrete_types()}
        layer, free = self.stage.GetEditTarget().GetLayer(), set[str]()
        with Sdf.ChangeBlock():
            for path, keys in prims.items():
                kind = keys.get("type") if isinstance(keys, Mapping) else self
                prefixes = [str(prefix) for prefix in Sdf.Path(path).GetPrefixes()]
                if not isinstance(kind, str | None) or kind not in known or not referencing.isdisjoint(prefixes):
                    continue
                fresh = [prefix for prefix in prefixes if prefix not in free and not self.stage.GetPrimAtPath(prefix)]
                if (path not in fresh and path not in free) or not self._extends(path, fresh, free):
                    continue
                for prefix in fresh:
                    spec = Sdf.CreatePrimInLayer(layer, prefix)
                    spec.specifier, spec.typeName = Sdf.SpecifierDef, "Xform"
                    self.implied.add(prefix)
                free.update(fresh)
                self.implied.discard(path)
                layer.GetPrimAtPath(path).typeName = kind or "Xform"

    def _extends(self, path: str, fresh: Sequence[str], free: set[str]) -> bool:
        """Whether the parent of the new prims exists, is defined, and is not part of an instance."""
        above = str(Sdf.Path(fresh[0] if fresh else path).GetParentPath())
        prim = self.stage.GetPrimAtPath(above)
        return above == "/" or above in free or bool(prim and prim.IsDefined() and not _of_instance(prim))

    def own_attributes(self, prim: Any) -> Mapping[str, str]:
        """Attributes that a prim may have beside those of schemas: name -> USD value type."""
        kind = self.sensor_types.get(str(prim.GetTypeName()))
        return {**PLAIN, **kind.attributes} if kind is not None else PLAIN

    def set_property(self, prim: Any, name: str, value: Any) -> None:
        """Sets one entry of `attributes`; a mistake is reported with its name."""
        try:
            prim_attributes.set_property(prim, name, value, self.own_attributes(prim), tuple(KEYS))
        except ValueError as error:
            raise ValueError(f"{name}: {error}") from error

    def require_sensor(self, prim: Any, what: str) -> None:
        """Raises ValueError for a prim that is not a sensor. what: the action that needs a sensor."""
        sensors = tuple(dict.fromkeys((*self.sensor_types, *schema_sensors())))
        if prim.GetTypeName() not in sensors:
            raise ValueError(f"only sensors {what} ({', '.join(sensors)}), not {prim.GetTypeName()}")


def _of_instance(prim: Any) -> bool:
    return bool(prim.IsInstance() or prim.IsInstanceProxy())


@cache
def concrete_types() -> list[str]:
    """The prim types that can be written."""
    registry = Usd.SchemaRegistry()
    types = Tf.Type.FindByName("UsdTyped").GetAllDerivedTypes()
    return sorted({str(name) for each in types if (name := registry.GetConcreteSchemaTypeName(each))})


@cache
def schema_sensors() -> tuple[str, ...]:
    """The prim types that are sensors by their schema, because OmniSensorAPI is built in."""
    registry = Usd.SchemaRegistry()
    definitions = {kind: registry.FindConcretePrimDefinition(kind) for kind in concrete_types()}
    return tuple(kind for kind, found in definitions.items() if SENSOR_API in found.GetAppliedAPISchemas())


def _reference(context: PrimContext, prim: Any, keys: Keys, name: str, done: set[str]) -> None:
    if not isinstance(keys[name], str):
        raise ValueError(f"{keys[name]!r} is not the name of a USD file")
    layer = _referenced_layer(context, prim, keys[name])
    roots = [root.name for root in layer.rootPrims]
    if layer.HasDefaultPrim():
        prim.GetReferences().AddReference(layer.identifier)
    elif len(roots) == 1:
        prim.GetReferences().AddReference(layer.identifier, f"/{roots[0]}")
    else:
        raise ValueError(f"{keys[name]} has no defaultPrim and {len(roots)} root prims; give it a defaultPrim")


def _referenced_layer(context: PrimContext, prim: Any, asset: str) -> Any:
    """The layer of a file, of a mapped address or of a stand-in. Raises ValueError for an address that is not here."""
    mapped = assets.mapped(asset)
    if mapped is None and (found := assets.stand_in(asset)):
        context.checked.setdefault(Path(asset), Checked([found.layer], {found.layer.identifier: None}))
        code, message = found.note()
        context.warn(code, asset, f"{message} ({prim.GetPath()} asks for it)")
        return found.layer
    if mapped is None and asset_roots.names_asset(asset):
        raise ValueError(assets.not_here(asset))
    return context.referenced(mapped or (context.folder / Path(asset).expanduser()).absolute())


def _schemas(context: PrimContext, prim: Any, keys: Keys, name: str, done: set[str]) -> None:
    for schema in [keys[name]] if isinstance(keys[name], str) else keys[name]:
        apply_schema(prim, str(schema))


def _config(context: PrimContext, prim: Any, keys: Keys, name: str, done: set[str]) -> None:
    done.update(("config", "variant"))
    if "config" not in keys:
        raise ValueError("a variant needs the config that it is of")
    context.require_sensor(prim, "have one")
    if context.sensor_config is None:
        raise ValueError("there are no sensor configurations here")
    context.sensor_config(prim, keys["config"], keys.get("variant"))


def _aux(context: PrimContext, prim: Any, keys: Keys, name: str, done: set[str]) -> None:
    if keys[name] not in AUX_LEVELS:
        raise ValueError(f"{keys[name]!r} is not one of {', '.join(AUX_LEVELS)}")
    context.require_sensor(prim, "have one")
    kind = context.sensor_types.get(str(prim.GetTypeName()))
    if kind is not None and keys[name] not in kind.aux_levels:
        raise ValueError(f"{prim.GetTypeName()} has {' and '.join(kind.aux_levels)}, not {keys[name]}")
    prim.CreateAttribute(CHANNELS, Sdf.ValueTypeNames.StringArray, custom=True).Set([keys[name]])


def _transform(context: PrimContext, prim: Any, keys: Keys, name: str, done: set[str]) -> None:
    if name in ("orient", "rotate") and "orient" in keys and "rotate" in keys:
        done.update(("orient", "rotate"))
        raise ValueError("orient and rotate exclude each other")
    value = keys[name]
    if name == "scale" and isinstance(value, (int, float)):
        value = [value] * 3
    parts = numbers(value, 4 if name == "orient" else 3)
    if name == "scale" and 0 in parts:
        raise ValueError("a scale of 0 makes it flat")
    if name == "orient":
        largest = max(map(abs, parts))
        if largest == 0:
            raise ValueError("a quaternion of zeros is not a rotation")
        parts = [part / largest for part in parts]  # first, so that neither end of the doubles is left
        length = math.hypot(*parts)
        parts = [part / length for part in parts]
    set_transform(prim, **{name: parts})


def _mount(context: PrimContext, prim: Any, keys: Keys, name: str, done: set[str]) -> None:
    """The mounting error, as ops after those of the pose: they act in the prim's own axes."""
    done.update(("mount_translate", "mount_rotate"))
    if not prim.IsA(UsdGeom.Xformable):
        raise ValueError(f"{prim.GetTypeName() or 'a prim without type'} has no transform")
    schema, double = UsdGeom.Xformable(prim), UsdGeom.XformOp.PrecisionDouble
    for key, kind in (("mount_translate", "translate"), ("mount_rotate", "rotateXYZ")):
        if key in keys:
            attribute = prim.GetAttribute(f"xformOp:{kind}:mounting")
            add = schema.AddTranslateOp if kind == "translate" else schema.AddRotateXYZOp
            op = UsdGeom.XformOp(attribute) if attribute else add(double, "mounting")
            op.Set(Gf.Vec3d(*numbers(keys[key], 3)))


def _size(context: PrimContext, prim: Any, keys: Keys, name: str, done: set[str]) -> None:
    attribute = prim.GetAttribute(name) if prim.HasAttribute(name) else None
    if not attribute or not prim.IsA(UsdGeom.Gprim):
        has = [size for size in SIZES if prim.HasAttribute(size)]
        raise ValueError(f"{prim.GetTypeName()} has no {name}" + (f"; it has {', '.join(has)}" if has else ""))
    if name == "axis":
        if keys[name] not in ("X", "Y", "Z"):
            raise ValueError(f"{keys[name]!r} is not one of X, Y, Z")
        attribute.Set(keys[name])
        return
    value = number(keys[name])
    if value <= 0:
        raise ValueError(f"{value:g} is not above 0")
    attribute.Set(value)


def _points(context: PrimContext, prim: Any, keys: Keys, name: str, done: set[str]) -> None:
    from graph.sim.geometry.polygons import usable_faces

    done.update(("points", "faces"))
    if not prim.IsA(UsdGeom.Mesh):
        raise ValueError(f"{prim.GetTypeName()} has no points and faces; a Mesh has")
    if "points" not in keys or "faces" not in keys:
        raise ValueError("a mesh needs both points and faces")
    points = np.array([numbers(point, 3) for point in keys["points"]]).reshape(-1, 3)
    counts, indices = [], []
    for face in keys["faces"]:
        if len(face) < 3 or any(type(i) is not int or i.bit_length() > 62 for i in face):
            raise ValueError(f"the face {face!r} is not a list of 3 or more point numbers")
        counts.append(len(face))
        indices.extend(face)
    wrong: list[str] = []
    usable_faces(points, np.array(counts, dtype=np.int64), np.array(indices, dtype=np.int64), wrong.append)
    if wrong:
        raise ValueError(wrong[0].replace("; they are left out", "").replace(" and are left out", ""))
    mesh = UsdGeom.Mesh(prim)
    mesh.GetPointsAttr().Set([tuple(point) for point in points.tolist()])
    mesh.GetFaceVertexCountsAttr().Set(counts)
    mesh.GetFaceVertexIndicesAttr().Set(indices)
    mesh.GetSubdivisionSchemeAttr().Set(UsdGeom.Tokens.none)


def _rigid_body(context: PrimContext, prim: Any, keys: Keys, name: str, done: set[str]) -> None:
    wanted = _truth(keys[name])
    if not wanted and not prim.HasAPI(UsdPhysics.RigidBodyAPI):
        return
    if not prim.IsA(UsdGeom.Xformable):
        raise ValueError(f"{prim.GetTypeName()} cannot move")
    UsdPhysics.RigidBodyAPI.Apply(prim).CreateRigidBodyEnabledAttr(wanted)


LIGHTEST, FASTEST = 1e-30, 1e30
"""USD stores masses and velocities as float32, which begins near 1.2e-38 and ends near 3.4e38."""


def _mass(context: PrimContext, prim: Any, keys: Keys, name: str, done: set[str]) -> None:
    value = number(keys[name])
    if not LIGHTEST <= value <= FASTEST:
        raise ValueError(f"{value:g} is not above 0" if value <= 0 else f"{value:g} is not from 1e-30 to 1e30")
    api = UsdPhysics.MassAPI.Apply(prim)
    (api.CreateMassAttr if name == "mass" else api.CreateDensityAttr)(value)


def _velocity(context: PrimContext, prim: Any, keys: Keys, name: str, done: set[str]) -> None:
    parts = numbers(keys[name], 3)
    if max(map(abs, parts)) > FASTEST:
        raise ValueError(f"{keys[name]!r} is faster than {FASTEST:g}")
    if not prim.HasAPI(UsdPhysics.RigidBodyAPI):
        raise ValueError("only a body moves by itself; add rigid_body: true")
    api = UsdPhysics.RigidBodyAPI(prim)
    (api.CreateVelocityAttr if name == "velocity" else api.CreateAngularVelocityAttr)(tuple(parts))


def _collision(context: PrimContext, prim: Any, keys: Keys, name: str, done: set[str]) -> None:
    solid = str(prim.GetTypeName()) in SOLIDS or prim.IsA(UsdGeom.Mesh)
    if name not in keys and not (solid and keys.get("type")):
        return
    wanted = _truth(keys.get(name, True))
    if wanted and not solid:
        raise ValueError(f"{prim.GetTypeName()} has no surface to collide with")
    if wanted or prim.HasAPI(UsdPhysics.CollisionAPI):
        UsdPhysics.CollisionAPI.Apply(prim).CreateCollisionEnabledAttr(wanted)


def _visible(context: PrimContext, prim: Any, keys: Keys, name: str, done: set[str]) -> None:
    if not prim.IsA(UsdGeom.Imageable):
        raise ValueError(f"{prim.GetTypeName()} is never visible")
    shown = UsdGeom.Tokens.inherited if _truth(keys[name]) else UsdGeom.Tokens.invisible
    UsdGeom.Imageable(prim).GetVisibilityAttr().Set(shown)


def _color(context: PrimContext, prim: Any, keys: Keys, name: str, done: set[str]) -> None:
    if not prim.IsA(UsdGeom.Gprim):
        raise ValueError(f"{prim.GetTypeName()} has no colour; shapes and meshes have")
    UsdGeom.Gprim(prim).GetDisplayColorAttr().Set([tuple(numbers(keys[name], 3))])


def _material(context: PrimContext, prim: Any, keys: Keys, name: str, done: set[str]) -> None:
    nonvisual.bind(context.stage, prim, nonvisual.parse(keys[name]))


def _semantics(context: PrimContext, prim: Any, keys: Keys, name: str, done: set[str]) -> None:
    value = keys[name] if isinstance(keys[name], Mapping) else {"class": keys[name]}
    for taxonomy, labels in value.items():
        texts = [labels] if isinstance(labels, str) else list(labels)
        if not all(isinstance(text, str) for text in texts):
            raise ValueError(f"{labels!r} is not a label or a list of labels")
        apply_schema(prim, f"SemanticsLabelsAPI:{taxonomy}")
        prim.GetAttribute(f"semantics:labels:{taxonomy}").Set(texts)


def _exclude(context: PrimContext, path: str, value: Any) -> None:
    prim = context.stage.GetPrimAtPath(path)
    context.require_sensor(prim, "exclude what they never hit")
    targets = [value] if isinstance(value, str) else list(value)
    for target in targets:
        valid = isinstance(target, str) and is_path(target) and target.startswith("/")
        if not valid or not context.stage.GetPrimAtPath(target):
            known = [str(each.GetPath()) for each in context.stage.Traverse()]
            raise ValueError(f"there is no prim {target!r}{did_you_mean(str(target), known)}")
    prim.CreateRelationship(EXCLUDE, custom=True).SetTargets([Sdf.Path(target) for target in targets])


def _truth(value: Any) -> bool:
    if not isinstance(value, bool):
        raise ValueError(f"{value!r} is neither true nor false")
    return value


SIZES = ("size", "radius", "height", "width", "length", "axis")

OTHER_WORDS = {
    "position": "translate",
    "location": "translate",
    "pos": "translate",
    "rotation": "rotate",
    "euler": "rotate",
    "rpy": "rotate",
    "orientation": "orient",
    "quaternion": "orient",
    "quat": "orient",
}
"""The keys that words of other tools stand for."""

KEYS: dict[str, Handler | None] = {
    "type": None,
    "reference": _reference,
    "schemas": _schemas,
    "config": _config,
    "variant": _config,
    "aux_output_level": _aux,
    "translate": _transform,
    "orient": _transform,
    "rotate": _transform,
    "scale": _transform,
    "mount_translate": _mount,
    "mount_rotate": _mount,
    **dict.fromkeys(SIZES, _size),
    "points": _points,
    "faces": _points,
    "rigid_body": _rigid_body,
    "mass": _mass,
    "density": _mass,
    "velocity": _velocity,
    "angular_velocity": _velocity,
    "collision": _collision,
    "visible": _visible,
    "color": _color,
    "material": _material,
    "semantics": _semantics,
    "exclude": None,
    "attributes": None,
}
"""Every key, in the order in which they are written; those without a function are handled in `prims`."""

FINAL: dict[str, Callable[[PrimContext, str, Any], None]] = {"exclude": _exclude}
"""Keys that name other prims: written after all prims exist."""
