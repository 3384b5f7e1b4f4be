"""Values as doubles and as text."""

from __future__ import annotations

from typing import Any

from graph import Attribute, node_type
from graph.types import NUMBERS, TYPES

from .like_inputs import renamed
from .promotion import REAL_ROLES, ROLES, double_of, real_of

_ARRAYS = tuple(f"{number}[]" for number in NUMBERS)
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


def _to_real(name: str, storage: str) -> None:
    """Declares the node type `name`: numbers in that storage."""

    def compute(db: Any) -> None:
        import numpy as np

        from graph.values import dtype_of

        value, dtype = db.inputs.value, dtype_of(TYPES[storage])
        with np.errstate(over="ignore"):
            converted = np.asarray(value).astype(dtype)
        db.outputs.converted = converted if converted.ndim else converted.item()

    compute.__doc__ = f"Convert numbers, tuples and arrays to {storage}; true is 1, what is too large is infinite."
    node_type(
        f"omni.graph.nodes.{name}",
        version=1,
        inputs={
            "role": Attribute(
                "token", "role of the result", default="None", allowed_tokens=REAL_ROLES, literal_only=True
            ),
            "value": Attribute(("bool", "bool[]", "numerics"), "the value to convert"),
        },
        outputs={"converted": Attribute(("decimals",), f"the value in {storage}, of the same shape")},
        resolve=real_of(storage),
    )(compute)


_to_real("ToFloat", "float")
_to_real("ToHalf", "half")


@node_type(
    "omni.graph.nodes.ToUint64",
    version=1,
    inputs={"value": Attribute(("bool", "bool[]", "numeric_scalers", *_ARRAYS), "the number or array to convert")},
    outputs={"converted": Attribute(("uint64", "uint64[]"), "the whole numbers")},
    resolve=renamed("value", "converted", "uint64"),
)
def to_uint64(db: Any) -> None:
    """Convert numbers to whole ones of 64 bits, cut off towards zero; negative and too large ones fail."""
    import numpy as np

    value = np.asarray(db.inputs.value)
    real = value.dtype.kind == "f"
    whole = np.trunc(value) if real else value
    if value.size and (not np.isfinite(whole).all() or whole.min() < 0 or (real and whole.max() >= 2.0**64)):
        db.fail(f"input value is {db.inputs.value}, which has no whole number from 0 to 2^64 - 1")
    converted = whole.astype(np.uint64)
    db.outputs.converted = converted if converted.ndim else converted.item()


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
