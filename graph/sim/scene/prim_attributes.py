"""Attributes, relationships and transforms of a prim by name, with values as read from YAML or JSON."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Iterable, Mapping
from functools import lru_cache
from types import MappingProxyType
from typing import Any

import numpy as np

from graph.base.suggest import closest, did_you_mean
from graph.sim import transforms
from graph.sim.scene.prim_paths import is_path
from graph.sim.usd import EARLIEST, Gf, Sdf, Tf, Usd, UsdGeom

from . import unregistered
from .stored_settings import QUIET_SCHEMAS

_INSTANCE = "__INSTANCE_NAME__"
_WHOLE = {"int": 2**31, "int64": 2**63}
_COUNTS = {"uchar": 2**8, "uint": 2**32, "uint64": 2**64}


def set_property(
    prim: Any,
    name: str,
    value: Any,
    declared: Mapping[str, str] = MappingProxyType({}),
    keys: Collection[str] = (),
) -> None:
    """Sets one attribute (its type comes from the schema) or relationship (a prim path or a list of them).

    An API schema that has the property is applied if needed. declared: further attributes that the prim may have, name
    -> USD value type; a missing one is created. keys: names that files write beside attributes, for suggestions. Raises
    ValueError for an unknown name, with the nearest known ones, and for a value that does not fit.
    """
    if not Sdf.Path.IsValidNamespacedIdentifier(name):
        raise ValueError("this cannot be the name of an attribute")
    found = _property(prim, name, value, declared, keys)
    if isinstance(found, Usd.Relationship):
        found.SetTargets([_path(path) for path in ([value] if isinstance(value, str) else list(value))])
        return
    converted = convert(found.GetTypeName(), value)
    allowed = prim.GetPrimDefinition().GetPropertyMetadata(name, "allowedTokens")
    if allowed and converted not in list(allowed):
        raise ValueError(f"{value!r} is not one of {', '.join(allowed)}")
    try:
        found.Set(converted)
    except (Tf.ErrorException, TypeError, OverflowError) as error:
        raise ValueError(f"USD refuses {value!r}: {' '.join(str(error).split())[-160:]}") from error


def apply_schema(prim: Any, name: str) -> None:
    """Applies an API schema, `Name` or `Name:instance`. Raises ValueError for an unknown schema."""
    schema, _, instance = name.partition(":")
    known = _api_schemas()
    instanced = known.get(schema, unregistered.takes_instance(schema))
    if instanced is None:
        raise ValueError(f"there is no API schema {schema!r}{did_you_mean(schema, [*known, *QUIET_SCHEMAS])}")
    if instanced != bool(instance):
        raise ValueError(f"{schema} is applied " + ("with an instance, as Name:instance" if instanced else "once"))
    if schema not in known:
        prim.AddAppliedSchema(name)
        return
    if not (prim.ApplyAPI(schema, instance) if instance else prim.ApplyAPI(schema)):
        raise ValueError(f"{schema} cannot be applied to {prim.GetTypeName() or 'a prim without type'}")


def convert(type_name: Any, value: Any) -> Any:
    """A plain value as a value of an `Sdf.ValueTypeName`; quaternions are w, x, y, z. Raises ValueError."""
    scalar = type_name.scalarType
    if not type_name.isArray:
        return _scalar(scalar, value)
    if isinstance(value, (str, bytes)) or not hasattr(value, "__iter__"):
        raise ValueError(f"{value!r} is not a list; the attribute is {type_name}")
    return type(type_name.defaultValue)([_scalar(scalar, each) for each in value])


def number(value: Any, finite: bool = True) -> float:
    """A number; bool, text and NaN are refused. Raises ValueError."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise ValueError(f"{value!r} is not a number")
    if math.isnan(value) or (finite and math.isinf(value)):
        raise ValueError(f"{value} is not a finite number")
    return float(value)


def numbers(value: Any, count: int) -> list[float]:
    """`count` finite numbers. Raises ValueError."""
    if isinstance(value, (str, bytes)) or not hasattr(value, "__iter__") or len(value) != count:
        raise ValueError(f"{value!r} is not a list of {count} numbers")
    return [number(each) for each in value]


def _scalar(type_name: Any, value: Any) -> Any:
    name, default = str(type_name), type_name.defaultValue
    if isinstance(default, bool):
        if not isinstance(value, bool):
            raise ValueError(f"{value!r} is neither true nor false")
        return value
    if name in _WHOLE or name in _COUNTS:
        whole = number(value)
        low, high = (0, _COUNTS[name]) if name in _COUNTS else (-_WHOLE[name], _WHOLE[name])
        if whole != int(whole) or not low <= whole < high:
            raise ValueError(f"{value!r} is not a whole number{' from 0' if low == 0 else ''} that a {name} can hold")
        return int(value)
    if isinstance(default, (str, Sdf.AssetPath)):
        if not isinstance(value, str):
            raise ValueError(f"{value!r} is not text; the attribute is {name}")
        return Sdf.AssetPath(value) if isinstance(default, Sdf.AssetPath) else value
    if isinstance(default, (float, Sdf.TimeCode)):
        return type(default)(number(value, finite=False))
    if isinstance(default, (Gf.Quatd, Gf.Quatf, Gf.Quath)):
        return type(default)(*numbers(value, 4))
    dimension = getattr(default, "dimension", None)
    if isinstance(dimension, tuple):
        if isinstance(value, (str, bytes)) or not hasattr(value, "__len__") or len(value) != dimension[0]:
            raise ValueError(f"{value!r} is not a list of {dimension[0]} rows")
        return type(default)([numbers(row, dimension[1]) for row in value])
    if isinstance(dimension, int):
        kind = int if name.startswith("int") else float
        return type(default)(*map(kind, numbers(value, dimension)))
    raise ValueError(f"attributes of type {name} cannot be set here")


def _property(prim: Any, name: str, value: Any, declared: Mapping[str, str], keys: Collection[str]) -> Any:
    existing = _defined(prim, name)
    if existing:
        return existing
    if name in declared:
        kind = Sdf.ValueTypeNames.Find(declared[name])
        if not kind:
            raise ValueError(f"its sensor type declares it as {declared[name]!r}; declare a USD type such as 'double'")
        return prim.CreateAttribute(name, kind)
    if name.split(":")[:2] == ["material", "binding"]:  # its schema does not list its properties: purposes are free
        apply_schema(prim, "MaterialBindingAPI")
        return prim.CreateRelationship(name, custom=False)
    schemas, templates = _api_properties()
    if name in schemas:
        apply_schema(prim, schemas[name])
        return _defined(prim, name)
    for pattern, schema in templates:
        match = pattern.fullmatch(name)
        if match:
            apply_schema(prim, f"{schema}:{match.group(1)}")
            return _defined(prim, name)
    if found := _unregistered(prim, name, value):
        return found
    own = sorted({*prim.GetPropertyNames(), *declared})
    ends = {one.rpartition(":")[2]: one for one in own}
    known = [*keys, *own, *schemas, *unregistered.names()]
    near = ending_alike(own, name) or closest(name, known) or ends.get(closest(name, ends) or "")
    more = f" and {len(own) - LISTED} more" if len(own) > LISTED else ""
    meant = f'the prim\'s own key "{near}"' if near in keys else f'"{near}"'
    hint = f"did you mean {meant}?" if near else f"its own are {', '.join(own[:LISTED])}{more}"
    raise ValueError(f"{prim.GetTypeName() or 'a prim without type'} has no attribute {name!r}; {hint}")


def _unregistered(prim: Any, name: str, value: Any) -> Any:
    """Creates an attribute or relationship that physics knows although no schema here defines it; None if it does not.

    The API schema of PhysX that has it is applied too.
    """
    kind = unregistered.value_type(name, value)
    if not kind:
        return None
    schema = unregistered.schema_of(name)
    if schema and schema not in prim.GetPrimTypeInfo().GetAppliedAPISchemas():
        prim.AddAppliedSchema(schema)
    if kind == "rel":
        return prim.CreateRelationship(name, custom=False)
    return prim.CreateAttribute(name, Sdf.ValueTypeNames.Find(kind), custom=False)


LISTED = 12
"""Most names that a line lists."""


def ending_alike(properties: Iterable[str], name: str) -> str | None:
    """The one property whose last part is this name in another case: `omni:sensor:tickRate` for tick_rate."""

    def bare(text: str) -> str:
        return text.rpartition(":")[2].replace("_", "").lower()

    found = [str(known) for known in properties if bare(str(known)) == bare(name)]
    return found[0] if len(found) == 1 else None


def _defined(prim: Any, name: str) -> Any:
    if prim.HasRelationship(name):
        return prim.GetRelationship(name)
    return prim.GetAttribute(name) if prim.HasAttribute(name) else None


def _path(text: Any) -> Any:
    if not isinstance(text, str) or not is_path(text) or not Sdf.Path(text).IsAbsolutePath():
        raise ValueError(f"{text!r} is not the path of a prim, such as /World/Box")
    return Sdf.Path(text)


@lru_cache(maxsize=1)
def _api_schemas() -> dict[str, bool]:
    """API schemas that can be applied, and whether they take an instance name."""
    registry = Usd.SchemaRegistry()
    names = {}
    for schema in Tf.Type.FindByName("UsdAPISchemaBase").GetAllDerivedTypes():
        name = registry.GetAPISchemaTypeName(schema)
        if name and registry.FindAppliedAPIPrimDefinition(name):
            names[str(name)] = bool(registry.IsMultipleApplyAPISchema(schema))
    return names


@lru_cache(maxsize=1)
def _api_properties() -> tuple[dict[str, str], list[tuple[re.Pattern[str], str]]]:
    """The API schema that brings a property: by name, or by pattern with the instance's name as its group."""
    registry = Usd.SchemaRegistry()
    single: dict[str, str] = {}
    multiple = []
    for schema, instanced in sorted(_api_schemas().items()):
        for name in registry.FindAppliedAPIPrimDefinition(schema).GetPropertyNames():
            if instanced:
                multiple.append((re.compile(re.escape(name).replace(_INSTANCE, "([A-Za-z_][A-Za-z0-9_]*)")), schema))
            else:
                single.setdefault(name, schema)
    return single, multiple


def set_transform(
    prim: Any,
    translate: list[float] | None = None,
    orient: list[float] | None = None,
    rotate: list[float] | None = None,
    scale: list[float] | None = None,
) -> None:
    """Writes the given parts as xformOps translate, orient (w, x, y, z) or rotateXYZ (degrees), and scale.

    A prim with other ops keeps the parts that are not given, rewritten as these ops. Raises ValueError if the prim has
    no transform, or if its old one has a shear, which these parts cannot express.
    """
    if not prim.IsA(UsdGeom.Xformable):
        raise ValueError(f"{prim.GetTypeName() or 'a prim without type'} has no transform")
    schema = UsdGeom.Xformable(prim)
    names = [op.GetOpName() for op in schema.GetOrderedXformOps()]
    old = transforms.from_usd(schema.GetLocalTransformation(EARLIEST)) if names else np.eye(4)
    rigid = transforms.rigid_part(old)
    rest = (transforms.inverse_rigid(rigid) @ old)[:3, :3]
    if np.abs(rest - np.diag(np.diag(rest))).max() > 1e-9 * np.abs(rest).max() and not scale:
        raise ValueError("its transform is sheared; put the new parts on a parent Xform")
    reset = schema.GetResetXformStack()
    for name in names:
        prim.RemoveProperty(name)
    schema.ClearXformOpOrder()
    double = UsdGeom.XformOp.PrecisionDouble
    schema.AddTranslateOp(double).Set(Gf.Vec3d(*(translate or rigid[:3, 3].tolist())))
    if rotate is not None:
        schema.AddRotateXYZOp(double).Set(Gf.Vec3d(*rotate))
    else:
        schema.AddOrientOp(double).Set(Gf.Quatd(*(orient or transforms.quaternion(rigid[:3, :3]).tolist())))
    schema.AddScaleOp(double).Set(Gf.Vec3d(*(scale or np.diag(rest).tolist())))
    if reset:
        schema.SetResetXformStack(True)
