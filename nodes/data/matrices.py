"""Multiplies, inverts and transposes matrices, splits them into rows and makes them from rows."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

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


def _rows(db: Database, count: int, width: int) -> None:
    """Writes the rows of the input, truncated to `width` numbers."""
    matrix = db.inputs.matrix
    for number, axis in enumerate(AXES[:count]):
        setattr(db.outputs, axis, matrix[..., number, :width].copy())


def _row_types(count: int) -> Any:
    def resolve(known: KnownTypes) -> Mapping[str, Type]:
        given = known["inputs:matrix"]
        if given is None:
            return {}
        name = known.value("outputType") if count == 4 else f"double[{count}]"
        row = concrete_type(name + "[]" * given.array)
        return {f"outputs:{axis}": row for axis in AXES[:count]}

    return resolve


def _row_outputs(count: int, types: tuple[str, ...]) -> dict[str, Attribute]:
    return {axis: Attribute(types, f"row {number} of it") for number, axis in enumerate(AXES[:count])}


def _given(size: int) -> Attribute:
    return Attribute((f"matrixd[{size}]", f"matrixd[{size}][]"), "a matrix, or an array of them")


def _both(*names: str) -> tuple[str, ...]:
    return tuple(f"{name}{many}" for name in names for many in ("", "[]"))


@node_type(
    "omni.graph.nodes.BreakMatrix2",
    version=1,
    inputs={"matrix": _given(2)},
    outputs=_row_outputs(2, _both("double[2]")),
    resolve=_row_types(2),
)
def break_matrix2(db: Database) -> None:
    """Split a 2 x 2 matrix into its rows."""
    _rows(db, 2, 2)


@node_type(
    "omni.graph.nodes.BreakMatrix3",
    version=1,
    inputs={"matrix": _given(3)},
    outputs=_row_outputs(3, _both("double[3]")),
    resolve=_row_types(3),
)
def break_matrix3(db: Database) -> None:
    """Split a 3 x 3 matrix into its rows."""
    _rows(db, 3, 3)


@node_type(
    "omni.graph.nodes.BreakMatrix4",
    version=1,
    inputs={
        "matrix": _given(4),
        "outputType": Attribute(
            "token",
            "whole rows, or without the last column",
            default="double[4]",
            literal_only=True,
            allowed_tokens=WIDTHS,
        ),
    },
    outputs=_row_outputs(4, _both(*WIDTHS)),
    resolve=_row_types(4),
)
def break_matrix4(db: Database) -> None:
    """Split a 4 x 4 matrix into its rows; of a transformation w is the translation."""
    _rows(db, 4, 3 if db.inputs.outputType == "double[3]" else 4)


def _matrix_of_rows(count: int) -> Any:
    def resolve(known: KnownTypes) -> Mapping[str, Type]:
        rows = input_types(known, *AXES[:count])
        if not rows:
            return {}
        matrix = TYPES[f"matrixd[{count}]"]
        return {"outputs:matrix": matrix.array_of() if any(row.array for row in rows) else matrix}

    return resolve


def _make(count: int) -> Any:
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

    return compute


_make2, _make3, _make4 = _make(2), _make(3), _make(4)


def _row_inputs(count: int, types: tuple[str, ...]) -> dict[str, Attribute]:
    return {axis: Attribute(types, f"row {number}, or an array of them") for number, axis in enumerate(AXES[:count])}


def _made(size: int) -> dict[str, Attribute]:
    return {"matrix": Attribute((f"matrixd[{size}]", f"matrixd[{size}][]"), "the matrix of these rows")}


@node_type(
    "omni.graph.nodes.MakeMatrix2",
    version=1,
    inputs=_row_inputs(2, _both("double[2]")),
    outputs=_made(2),
    resolve=_matrix_of_rows(2),
)
def make_matrix2(db: Database) -> None:
    """Make a matrix from two rows; arrays give an array of matrices."""
    _make2(db)


@node_type(
    "omni.graph.nodes.MakeMatrix3",
    version=1,
    inputs=_row_inputs(3, _both("double[3]")),
    outputs=_made(3),
    resolve=_matrix_of_rows(3),
)
def make_matrix3(db: Database) -> None:
    """Make a matrix from three rows; arrays give an array of matrices."""
    _make3(db)


@node_type(
    "omni.graph.nodes.MakeMatrix4",
    version=1,
    inputs=_row_inputs(4, _both(*WIDTHS)),
    outputs=_made(4),
    resolve=_matrix_of_rows(4),
)
def make_matrix4(db: Database) -> None:
    """Make a matrix from four rows; rows of three get the last column of a transformation: 0, 0, 0, 1."""
    _make4(db)
