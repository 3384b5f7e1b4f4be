"""Values as doubles and as text."""

from __future__ import annotations

from typing import Any

from graph import Attribute, node_type

from .promotion import ROLES, double_of

VALUES = ("bool", "bool[]", "numerics", "path", "string", "token", "token[]")


@node_type(
    "omni.graph.nodes.ToDouble",
    version=1,
    inputs={
        "role": Attribute("token", "role of the result", default="None", allowed_tokens=ROLES, literal_only=True),
        "value": Attribute(("bool", "bool[]", "numerics"), "the value to convert"),
    },
    outputs={"converted": Attribute(("decimals",), "the value in doubles, of the same shape")},
    resolve=double_of,
)
def to_double(db: Any) -> None:
    """Convert numbers, tuples and arrays to doubles; true is 1."""
    value = db.inputs.value
    db.outputs.converted = value.astype(float) if hasattr(value, "astype") else float(value)


@node_type(
    "omni.graph.nodes.ToString",
    version=1,
    inputs={"value": Attribute(VALUES, "the value to write down")},
    outputs={"converted": Attribute("string", "the value as text")},
)
def to_string(db: Any) -> None:
    """Write a value down: numbers in their shortest form, tuples in ( ), arrays in [ ]."""
    is_array = str(db.input_type("value")).endswith("[]")
    db.outputs.converted = written(db.inputs.value, is_array)


def written(value: Any, is_array: bool) -> str:
    """A value as text; `is_array` tells [1, 2] (an array) from (1, 2) (a tuple)."""
    value = value.tolist() if hasattr(value, "tolist") else value
    if not isinstance(value, list):
        return str(value)
    start, end = "[]" if is_array else "()"
    return start + ", ".join(written(one, False) for one in value) + end
