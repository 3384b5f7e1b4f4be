"""Lengths, products and directions of vectors; arrays of vectors row by row."""

from __future__ import annotations

import math
from typing import Any

from graph.node import Attribute, Database, KnownTypes, node_type
from graph.values.types import INTEGER_RANGES

from .like_inputs import length_of, product_of, same_type
from .numbers import aligned, bound, changed, fitting, quietly, settled, widened
from .promotion import promoted

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
