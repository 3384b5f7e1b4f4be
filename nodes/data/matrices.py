"""Multiplies, inverts and transposes matrices, splits them into rows and makes them from rows."""

from __future__ import annotations

from collections.abc import Mapping

from graph.node import Attribute, Database, KnownTypes, node_type
from graph.values.types import TYPES, Type, concrete_type

from .like_inputs import same_type
from .numbers import check_lengths, input_type, settled
from .promotion import common_storage, input_types

MATRICES = tuple(f"matrixd[{size}]{many}" for size in (2, 3, 4) for many in ("", "[]"))
_ROLES = ("colord", "colorf", "colorh", "normald", "normalf", "normalh", "pointd", "pointf", "pointh")
VECTORS = (
    *(f"{kind}[{size}]{many}" for kind in ("double", "float", "half") for size in (2, 3, 4) for many in ("", "[]")),
    *(f"{role}[3]" for role in _ROLES),
    *(f"color{kind}[4]" for kind in "dfh"),
    *(f"quat{kind}[4]" for kind in "dfh"),
    *(f"texcoord{kind}[{size}]" for kind in "dfh" for size in (2, 3)),
    *(f"vector{kind}[3]" for kind in "dfh"),
)
FACTORS = (*VECTORS, *MATRICES, "frame[4]")
PRODUCTS = (*FACTORS, *(f"{kind}{many}" for kind in ("double", "float", "half") for many in ("", "[]")))
FLOAT_MAX = 3.4028234663852886e38


def _product_type(known: KnownTypes) -> Mapping[str, Type]:
    """A matrix for two matrices, the vector's type for a vector and a matrix, a number for two vectors."""
    a, b = known["inputs:a"], known["inputs:b"]
    if a is None or b is None:
        return {}
    if a.count != b.count:
        raise ValueError(f"{known.end('a')} and {known.end('b')} differ in size; give it two of one size")
    if a.square and b.square:
        element = a.element if a.element is b.element else TYPES[f"matrixd[{a.count}]"]
    elif a.square or b.square:
        element = (b if a.square else a).element
    else:
        element = TYPES[common_storage([a.storage, b.storage])]
    return {"outputs:output": element.array_of() if a.array or b.array else element}


@node_type(
    "omni.graph.nodes.MatrixMultiply",
    version=1,
    inputs={
        "a": Attribute(FACTORS, "a matrix, or a row vector"),
        "b": Attribute(FACTORS, "a matrix, or a column vector"),
    },
    outputs={"output": Attribute(PRODUCTS, "a x b: matrix, vector, or the number that two vectors make")},
    resolve=_product_type,
)
def matrix_multiply(db: Database) -> None:
    """Multiply matrices: of two transformations a is applied first, since vectors are rows.

    Arrays go element by element.
    """
    import numpy as np

    from graph.values.coercion import dtype_of

    factors = [db.inputs.a, db.inputs.b]
    kinds = [input_type(db, name) for name in "ab"]
    check_lengths(db, [one for one, kind in zip(factors, kinds, strict=True) if kind is not None and kind.array])
    a, b = (np.asarray(one, float) for one in factors)
    square = [kind is not None and kind.square for kind in kinds]
    a = a if square[0] else a[..., None, :]
    b = b if square[1] else b[..., :, None]
    product = a @ b
    if not square[0]:
        product = product[..., 0, :]
    if not square[1]:
        product = product[..., 0]
    result = settled(db, "output")
    product = product if result is None else product.astype(dtype_of(result.component))
    db.outputs.output = product if product.ndim else product.item()


@node_type(
    "omni.graph.nodes.OgnInvertMatrix",
    version=1,
    inputs={"matrix": Attribute(MATRICES, "a matrix, or an array of them")},
    outputs={"invertedMatrix": Attribute(MATRICES, "the matrices that undo them")},
    resolve=same_type("matrix", "invertedMatrix"),
)
def invert_matrix(db: Database) -> None:
    """Invert matrices; a singular one gives the largest float times the identity."""
    import numpy as np

    given = db.inputs.matrix
    size = given.shape[-1]
    flat = given.reshape(-1, size, size)
    regular = np.linalg.det(flat) != 0
    inverted = np.tile(np.eye(size) * FLOAT_MAX, (len(flat), 1, 1))
    inverted[regular] = np.linalg.inv(flat[regular])
    db.outputs.invertedMatrix = inverted.reshape(given.shape)


@node_type(
    "omni.graph.nodes.Transpose",
    version=1,
    inputs={"matrix": Attribute(MATRICES, "a matrix, or an array of them")},
    outputs={"result": Attribute(MATRICES, "the matrices with rows for columns")},
    resolve=same_type("matrix", "result"),
)
def transpose(db: Database) -> None:
    """Transpose matrices."""
    db.outputs.result = db.inputs.matrix.swapaxes(-1, -2).copy()


AXES = "xyzw"
WIDTHS = ("double[3]", "double[4]")
_NUMBERS = {2: "two", 3: "three", 4: "four"}


def _both(*names: str) -> tuple[str, ...]:
    return tuple(f"{name}{many}" for name in names for many in ("", "[]"))


def _row_types(count: int) -> tuple[str, ...]:
    return _both(*(WIDTHS if count == 4 else (f"double[{count}]",)))


def _declare_break(count: int, more: str = "") -> None:
    """Declares the node type that splits a matrix of `count` rows; more: what follows in its description."""
    inputs = {"matrix": Attribute(_both(f"matrixd[{count}]"), "a matrix, or an array of them")}
    if count == 4:
        what = "whole rows, or without the last column"
        width = Attribute("token", what, default="double[4]", literal_only=True, allowed_tokens=WIDTHS)
        inputs["outputType"] = width

    def types(known: KnownTypes) -> Mapping[str, Type]:
        given = known["inputs:matrix"]
        if given is None:
            return {}
        name = known.value("outputType") if count == 4 else f"double[{count}]"
        row = concrete_type(name + "[]" * given.array)
        return {f"outputs:{axis}": row for axis in AXES[:count]}

    def compute(db: Database) -> None:
        matrix = db.inputs.matrix
        width = 3 if count == 4 and db.inputs.outputType == "double[3]" else count
        for number, axis in enumerate(AXES[:count]):
            setattr(db.outputs, axis, matrix[..., number, :width].copy())

    compute.__doc__ = f"Split a {count} x {count} matrix into its rows{more}."
    node_type(
        f"omni.graph.nodes.BreakMatrix{count}",
        version=1,
        inputs=inputs,
        outputs={axis: Attribute(_row_types(count), f"row {n} of it") for n, axis in enumerate(AXES[:count])},
        resolve=types,
    )(compute)


def _declare_make(count: int, more: str) -> None:
    """Declares the node type that makes a matrix of `count` rows; more: what follows in its description."""
    matrices = _both(f"matrixd[{count}]")

    def types(known: KnownTypes) -> Mapping[str, Type]:
        rows = input_types(known, *AXES[:count])
        return {"outputs:matrix": TYPES[matrices[any(row.array for row in rows)]]} if rows else {}

    def compute(db: Database) -> None:
        import numpy as np

        rows = [getattr(db.inputs, axis) for axis in AXES[:count]]
        arrays = [row for row in rows if row.ndim == 2]
        check_lengths(db, arrays)
        # A row of three belongs to a transformation: the last column is 0, 0, 0, 1.
        whole = np.zeros((*{len(row) for row in arrays}, count, count))
        whole[..., count - 1, count - 1] = 1
        for number, row in enumerate(rows):
            whole[..., number, : row.shape[-1]] = row
        db.outputs.matrix = whole

    compute.__doc__ = f"Make a matrix from {_NUMBERS[count]} rows; {more}."
    rows = {axis: Attribute(_row_types(count), f"row {n}, or an array of them") for n, axis in enumerate(AXES[:count])}
    node_type(
        f"omni.graph.nodes.MakeMatrix{count}",
        version=1,
        inputs=rows,
        outputs={"matrix": Attribute(matrices, "the matrix of these rows")},
        resolve=types,
    )(compute)


for _count, _more in ((2, ""), (3, ""), (4, "; of a transformation w is the translation")):
    _declare_break(_count, _more)
for _count, _more in (
    (2, "arrays give an array of matrices"),
    (3, "arrays give an array of matrices"),
    (4, "rows of three get the last column of a transformation: 0, 0, 0, 1"),
):
    _declare_make(_count, _more)
