"""Whether authored values can be read as values of the types that schemas give their attributes."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from graph.sim.usd import EARLIEST, Sdf, Usd


def type_problems(prim: Any) -> Iterator[str]:
    """A line for each authored attribute of a sensor whose value does not fit the type in its schemas.

    Only those of its own type and of schemas whose attributes begin with `omni:`; others are not the sensor's.
    """
    own, all_of_them = _definition(str(prim.GetTypeName())), prim.GetPrimDefinition()
    for attribute in prim.GetAuthoredAttributes():
        name = attribute.GetName()
        schemas = all_of_them if name.startswith("omni:") else own
        schema = None if schemas is None else schemas.GetSchemaAttributeSpec(name)
        if schema is None:
            continue
        value = attribute.Get(EARLIEST)
        if value is not None and not fits(value, schema.typeName):
            written = attribute.GetPropertyStack(EARLIEST)[0].typeName  # the attribute has the type of its schema
            yield f"{attribute.GetPath()} is a {written}; it must be a {schema.typeName}"


def _definition(prim_type: str) -> Any:
    return Usd.SchemaRegistry().FindConcretePrimDefinition(prim_type)


def fits(value: Any, wanted: Any) -> bool:
    """Whether a value can be read as a value of a USD type: of the same type, or another kind of number."""
    example = wanted.defaultValue
    if isinstance(value, Sdf.ValueBlock) or type(value) is type(example):
        return True
    if wanted.isArray:
        is_array = hasattr(value, "__len__") and type(value).__name__.endswith("Array")
        return is_array and (not len(value) or fits(value[0], wanted.scalarType))
    numbers = (bool, int, float)
    if isinstance(example, numbers):
        return isinstance(value, numbers)
    if isinstance(example, (str, Sdf.AssetPath)):
        return isinstance(value, str)
    return hasattr(value, "__len__") == hasattr(example, "__len__") and _same_shape(value, example)


def _same_shape(value: Any, example: Any) -> bool:
    if hasattr(example, "GetImaginary"):
        return hasattr(value, "GetImaginary")
    return hasattr(value, "__len__") and len(value) == len(example) and isinstance(value[0], (int, float))
