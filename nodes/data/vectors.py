"""Vectors split into components and made from them."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from graph.node import Attribute, Database, node_type
from graph.values.coercion import dtype_of
from graph.values.types import concrete_type

from .numbers import check_lengths, input_type
from .promotion import components_of, tuple_from

if TYPE_CHECKING:
    from graph.node.declaration import Compute

AXES = "xyzw"
PART = ("numeric_scalers",)
PARTS = ("numeric_scalers", "numeric_arrays")
WHOLE = ("numeric_tuples",)


def _break(count: int) -> Callable[[Any], None]:
    """The compute function that splits a vector of `count`."""
    names = AXES[:count]

    def compute(db: Database) -> None:
        parts = db.inputs.tuple.tolist()
        if len(parts) != count or isinstance(parts[0], list):
            db.fail(f"input tuple is {db.inputs.tuple}; it must have {count} components")
        outputs = db.outputs
        for name, part in zip(names, parts, strict=True):
            setattr(outputs, name, part)

    return compute


def _break_outputs(count: int) -> dict[str, Attribute]:
    return {axis: Attribute(PART, f"component {axis}") for axis in AXES[:count]}


_break2, _break4 = _break(2), _break(4)


@node_type(
    "omni.graph.nodes.BreakVector2",
    version=1,
    inputs={"tuple": Attribute(WHOLE, "a vector of two")},
    outputs=_break_outputs(2),
    resolve=components_of("tuple", "xy"),
)
def break_vector2(db: Database) -> None:
    """Split a vector of two."""
    _break2(db)


def _three_known(db: Database) -> Compute | None:
    """BreakVector3 for a vector of known size: nothing to check."""
    if input_type(db, "tuple") is None:
        return None
    inputs, outputs = db.inputs, db.outputs

    def compute(db: Database) -> None:
        outputs.x, outputs.y, outputs.z = inputs.tuple.tolist()

    return compute


_break3 = _break(3)


@node_type(
    "omni.graph.nodes.BreakVector3",
    version=1,
    inputs={"tuple": Attribute(WHOLE, "a vector of three")},
    outputs=_break_outputs(3),
    resolve=components_of("tuple", "xyz"),
    specialize=_three_known,
)
def break_vector3(db: Database) -> None:
    """Split a vector of three."""
    _break3(db)


@node_type(
    "omni.graph.nodes.BreakVector4",
    version=1,
    inputs={"tuple": Attribute(WHOLE, "a vector of four")},
    outputs=_break_outputs(4),
    resolve=components_of("tuple", "xyzw"),
)
def break_vector4(db: Database) -> None:
    """Split a vector of four (or a quaternion, w last)."""
    _break4(db)


def _make(count: int) -> Callable[[Any], None]:
    """The compute function that makes a vector of `count`; arrays give an array of vectors."""

    def compute(db: Database) -> None:
        import numpy as np

        parts = [getattr(db.inputs, axis) for axis in AXES[:count]]
        arrays = [part for part in parts if hasattr(part, "__len__")]
        check_lengths(db, arrays)
        wanted = db.output_type("tuple")
        dtype = np.result_type(*parts) if wanted is None else dtype_of(concrete_type(wanted).component)
        result = np.empty((*{len(array) for array in arrays}, count), dtype)
        for axis, part in enumerate(parts):
            result[..., axis] = part
        db.outputs.tuple = result

    return compute


def _make_inputs(count: int) -> dict[str, Attribute]:
    return {axis: Attribute(PARTS, f"component {axis}, or an array of them") for axis in AXES[:count]}


MADE = {"tuple": Attribute(("numeric_tuples", "numeric_arrays"), "the vector, or the array of vectors")}
_make2, _make3, _make4 = _make(2), _make(3), _make(4)


@node_type(
    "omni.graph.nodes.MakeVector2",
    version=1,
    inputs=_make_inputs(2),
    outputs=MADE,
    resolve=tuple_from("xy", "tuple"),
)
def make_vector2(db: Database) -> None:
    """Make a vector of two; arrays of one length give an array of vectors, a number is repeated for each."""
    _make2(db)


@node_type(
    "omni.graph.nodes.MakeVector3",
    version=1,
    inputs=_make_inputs(3),
    outputs=MADE,
    resolve=tuple_from("xyz", "tuple"),
)
def make_vector3(db: Database) -> None:
    """Make a vector of three; arrays of one length give an array of vectors, a number is repeated for each."""
    _make3(db)


@node_type(
    "omni.graph.nodes.MakeVector4",
    version=1,
    inputs=_make_inputs(4),
    outputs=MADE,
    resolve=tuple_from("xyzw", "tuple"),
)
def make_vector4(db: Database) -> None:
    """Make a vector of four; arrays of one length give an array of vectors, a number is repeated for each."""
    _make4(db)
