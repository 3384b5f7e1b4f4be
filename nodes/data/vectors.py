"""Vectors split into components and made from them; their lengths, products and directions, row by row in arrays."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from graph.node import Attribute, Database, KnownTypes, node_type
from graph.values.coercion import dtype_of
from graph.values.types import INTEGER_RANGES, concrete_type

from .like_inputs import length_of, product_of, same_type
from .numbers import aligned, bound, changed, check_lengths, fitting, input_type, quietly, settled, widened
from .promotion import components_of, promoted, tuple_from

if TYPE_CHECKING:
    from graph.node.declaration import Compute

AXES = "xyzw"

_NUMBERS = {2: "two", 3: "three", 4: "four"}


def _declare_break(count: int, more: str = "") -> None:
    """Declares the node type that splits a vector of `count`; more: what follows in its description."""
    names = AXES[:count]

    def compute(db: Database) -> None:
        parts = db.inputs.tuple.tolist()
        if len(parts) != count or isinstance(parts[0], list):
            db.fail(f"input tuple is {db.inputs.tuple}; it must have {count} components")
        outputs = db.outputs
        for name, part in zip(names, parts, strict=True):
            setattr(outputs, name, part)

    compute.__doc__ = f"Split a vector of {_NUMBERS[count]}{more}."
    node_type(
        f"omni.graph.nodes.BreakVector{count}",
        version=1,
        inputs={"tuple": Attribute(("numeric_tuples",), f"a vector of {_NUMBERS[count]}")},
        outputs={axis: Attribute(("numeric_scalers",), f"component {axis}") for axis in names},
        resolve=components_of("tuple", names),
        specialize=_three_known if count == 3 else None,
    )(compute)


def _three_known(db: Database) -> Compute | None:
    """BreakVector3 for a vector of known size: nothing to check."""
    if input_type(db, "tuple") is None:
        return None
    inputs, outputs = db.inputs, db.outputs

    def compute(db: Database) -> None:
        outputs.x, outputs.y, outputs.z = inputs.tuple.tolist()

    return compute


def _declare_make(count: int) -> None:
    """Declares the node type that makes a vector of `count`; arrays give an array of vectors."""
    names = AXES[:count]

    def compute(db: Database) -> None:
        import numpy as np

        parts = [getattr(db.inputs, axis) for axis in names]
        arrays = [part for part in parts if hasattr(part, "__len__")]
        check_lengths(db, arrays)
        wanted = db.output_type("tuple")
        dtype = np.result_type(*parts) if wanted is None else dtype_of(concrete_type(wanted).component)
        result = np.empty((*{len(array) for array in arrays}, count), dtype)
        for axis, part in enumerate(parts):
            result[..., axis] = part
        db.outputs.tuple = result

    compute.__doc__ = (
        f"Make a vector of {_NUMBERS[count]}; arrays of one length give an array of vectors, a number is repeated for "
        "each."
    )
    either = ("numeric_scalers", "numeric_arrays")
    node_type(
        f"omni.graph.nodes.MakeVector{count}",
        version=1,
        inputs={axis: Attribute(either, f"component {axis}, or an array of them") for axis in names},
        outputs={"tuple": Attribute(("numeric_tuples", "numeric_arrays"), "the vector, or the array of vectors")},
        resolve=tuple_from(names, "tuple"),
    )(compute)


for _count, _more in ((2, ""), (3, ""), (4, " (or a quaternion, w last)")):
    _declare_break(_count, _more)
    _declare_make(_count)


VECTORS = tuple(
    f"{kind}[{size}]{many}" for kind in ("double", "float", "half") for size in (2, 3, 4) for many in ("", "[]")
)
VECTORS3 = tuple(f"vector{kind}[3]{many}" for kind in "dfh" for many in ("", "[]"))


@node_type(
    "omni.graph.nodes.Magnitude",
    version=1,
    inputs={"input": Attribute(("numerics",), "a number, a vector, or an array of either")},
    outputs={"magnitude": Attribute(("numerics",), "the length of each vector, the absolute value of each number")},
    resolve=length_of("input", "magnitude"),
)
def magnitude(db: Database) -> None:
    """Give the length of a vector."""
    value, kind = db.inputs.input, db.input_type("input")
    if not hasattr(value, "dtype") or (value.ndim == 1 and kind is not None and kind.endswith("[]")):
        db.outputs.magnitude = changed(db, abs, value, settled(db, "magnitude"))
    elif kind is None or not str(kind).endswith("[]"):
        db.outputs.magnitude = math.hypot(*map(float, value.flat))
    else:
        import numpy as np

        db.outputs.magnitude = np.linalg.norm(value.astype(float), axis=-1)


@node_type(
    "omni.graph.nodes.DotProduct",
    version=1,
    inputs={
        "a": Attribute(("numerics",), "a vector, or an array of them"),
        "b": Attribute(("numerics",), "one of the same size"),
    },
    outputs={"product": Attribute(("numerics",), "a . b, one for each pair")},
    resolve=product_of("product"),
)
def dot_product(db: Database) -> None:
    """Compute the dot product of vectors."""
    import numpy as np

    a, b = aligned(db, "ab", None)
    kind = settled(db, "product")
    if kind is not None and kind.storage in INTEGER_RANGES:
        a, b = widened([a, b], bound(a) * bound(b) * a.shape[-1])
    product = fitting(db, quietly(lambda: np.asarray((a * b).sum(axis=-1))), kind)
    db.outputs.product = product if product.ndim else product.item()


@node_type(
    "omni.graph.nodes.CrossProduct",
    version=1,
    inputs={
        "a": Attribute(VECTORS3, "a vector of three, or an array of them"),
        "b": Attribute(VECTORS3, "a vector of three, or an array of them"),
    },
    outputs={"product": Attribute(VECTORS3, "a x b, at right angles to both")},
    resolve=promoted("product"),
)
def cross_product(db: Database) -> None:
    """Compute the cross product of vectors of three."""
    import numpy as np

    db.outputs.product = np.cross(*aligned(db, "ab", settled(db, "product")))


@node_type(
    "omni.graph.nodes.Normalize",
    version=1,
    inputs={"vector": Attribute(VECTORS, "a vector, or an array of them")},
    outputs={"result": Attribute(VECTORS, "the vectors of length 1 in the same direction")},
    resolve=same_type("vector", "result"),
)
def normalize(db: Database) -> None:
    """Scale vectors to length 1; a vector of length 0 stays unchanged."""
    import numpy as np

    vector = db.inputs.vector
    length = np.linalg.norm(vector.astype(float), axis=-1, keepdims=True)
    db.outputs.result = (vector / np.where(length == 0, 1, length)).astype(vector.dtype)


POINTS3 = tuple(f"point{kind}[3]{many}" for kind in "dfh" for many in ("", "[]"))


def _distance_type(known: KnownTypes) -> Any:
    """A number in the higher precision of both points, an array if one of them is."""
    common = promoted("distance", "a", "b")(known)
    return {name: length.component.array_of() if length.array else length.component for name, length in common.items()}


@node_type(
    "omni.graph.nodes.Distance3D",
    version=1,
    inputs={
        "a": Attribute(POINTS3, "a point, or an array of them"),
        "b": Attribute(POINTS3, "a point, or an array of them"),
    },
    outputs={
        "distance": Attribute(
            ("double", "double[]", "float", "float[]", "half", "half[]"), "how far they are apart", unit="stage units"
        )
    },
    resolve=_distance_type,
)
def distance_3d(db: Database) -> None:
    """Give the distance between points; of two arrays, row by row."""
    import numpy as np

    from graph.values.coercion import dtype_of

    result = settled(db, "distance")
    a, b = aligned(db, "ab", None)
    distance = np.linalg.norm(np.asarray(a, float) - np.asarray(b, float), axis=-1)
    distance = distance if result is None or not distance.ndim else distance.astype(dtype_of(result))
    db.outputs.distance = distance if distance.ndim else float(distance)
