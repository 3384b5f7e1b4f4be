"""Vectors taken apart and put together."""

from __future__ import annotations

from typing import Any

from graph import Attribute, node_type
from graph.types import concrete_type
from graph.values import dtype_of

from .promotion import components_of, tuple_from

PART = ("numeric_scalers",)
PARTS = ("numeric_scalers", "numeric_arrays")


@node_type(
    "omni.graph.nodes.BreakVector3",
    version=1,
    inputs={"tuple": Attribute(("numeric_tuples",), "a vector of three")},
    outputs={axis: Attribute(PART, f"component {axis}") for axis in "xyz"},
    resolve=components_of("tuple", "xyz"),
)
def break_vector3(db: Any) -> None:
    """Take a vector of three apart."""
    outputs = db.outputs
    outputs.x, outputs.y, outputs.z = db.inputs.tuple.tolist()


@node_type(
    "omni.graph.nodes.MakeVector3",
    version=1,
    inputs={axis: Attribute(PARTS, f"component {axis}, or an array of them") for axis in "xyz"},
    outputs={"tuple": Attribute(("numeric_tuples", "numeric_arrays"), "the vector, or the array of vectors")},
    resolve=tuple_from("xyz", "tuple"),
)
def make_vector3(db: Any) -> None:
    """Put a vector of three together; arrays of one length give an array of vectors, a number stretches to it."""
    import numpy as np

    parts = [db.inputs.x, db.inputs.y, db.inputs.z]
    lengths = {len(part) for part in parts if hasattr(part, "__len__")}
    if len(lengths) > 1:
        db.fail(f"the arrays have {' and '.join(map(str, sorted(lengths)))} elements; they need one length")
    dtype = dtype_of(concrete_type(db.output_type("tuple")).component)
    shape = (*lengths, 3)
    result = np.empty(shape, dtype)
    for axis, part in enumerate(parts):
        result[..., axis] = part
    db.outputs.tuple = result
