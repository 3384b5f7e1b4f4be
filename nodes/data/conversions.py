"""Conversion of values to numbers and to text."""

from __future__ import annotations

from typing import Any

from graph.node import Attribute, Database, node_type
from graph.values.types import INTEGER_RANGES, NUMBERS, TYPES

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
def to_double(db: Database) -> None:
    """Convert numbers, tuples and arrays to doubles; true is 1."""
    value = db.inputs.value
    db.outputs.converted = value.astype(float) if hasattr(value, "astype") else float(value)


def _to_real(name: str, storage: str) -> None:
    """Declares the node type `name`, which converts to numbers of that storage."""

    def compute(db: Database) -> None:
        import numpy as np

        from graph.values.coercion import dtype_of

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


def _to_whole(name: str, storage: str, *more: str) -> None:
    """Declares the node type `name`, which converts to whole numbers of that storage."""
    highest = INTEGER_RANGES[storage][1]

    def compute(db: Database) -> None:
        import numpy as np

        from graph.values.coercion import dtype_of

        given = db.inputs.value
        try:
            value = np.asarray(float(given) if isinstance(given, str) else given)
        except ValueError:
            db.fail(f'input value is "{given}", which is not a number')
        whole = np.trunc(value) if value.dtype.kind == "f" else value
        if value.size and not (np.isfinite(whole).all() and whole.min() >= 0 and int(whole.max()) <= highest):
            db.fail(f"input value is {given}, which has no whole number from 0 to {highest}")
        converted = whole.astype(dtype_of(TYPES[storage]))
        db.outputs.converted = converted if converted.ndim else converted.item()

    compute.__doc__ = (
        f"Convert numbers to whole ones from 0 to {highest}, cut off towards zero; negative and too large ones fail."
    )
    node_type(
        f"omni.graph.nodes.{name}",
        version=1,
        inputs={"value": Attribute(("bool", "bool[]", *NUMBERS, *_ARRAYS, *more), "the number or array to convert")},
        outputs={"converted": Attribute((storage, f"{storage}[]"), "the whole numbers")},
        resolve=renamed("value", "converted", storage),
    )(compute)


_to_whole("ToUint64", "uint64")
_to_whole("ToUchar", "uchar", "string")


@node_type(
    "omni.graph.nodes.ToString",
    version=1,
    inputs={"value": Attribute(VALUES, "the value to write down")},
    outputs={"converted": Attribute("string", "the value as text")},
)
def to_string(db: Database) -> None:
    """Convert a value to text: numbers in their shortest form, tuples in ( ), arrays in [ ]."""
    is_array = str(db.input_type("value")).endswith("[]")
    db.outputs.converted = written(db.inputs.value, is_array)


@node_type(
    "omni.graph.nodes.ToToken",
    version=1,
    inputs={"value": Attribute(VALUES, "the value to write down")},
    outputs={"converted": Attribute("token", "the value as a token")},
)
def to_token(db: Database) -> None:
    """Convert a value to a token, with the text of ToString."""
    db.outputs.converted = written(db.inputs.value, str(db.input_type("value")).endswith("[]"))


def written(value: Any, is_array: bool) -> str:
    """A value as text; `is_array` distinguishes [1, 2] (an array) from (1, 2) (a tuple)."""
    value = value.tolist() if hasattr(value, "tolist") else value
    if not isinstance(value, list):
        return str(value)
    start, end = "[]" if is_array else "()"
    return start + ", ".join(written(one, False) for one in value) + end
