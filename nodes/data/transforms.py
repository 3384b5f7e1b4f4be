"""Transformation matrices: taken apart, made and changed; vectors transformed by them.

Vectors are rows: v M, translation in the last row."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from graph.node import Attribute, Database, KnownTypes, node_type
from graph.values.types import Type

from .like_inputs import renamed, same_type
from .numbers import check_lengths

MATRIX4 = ("matrixd[4]", "matrixd[4][]")
ORDERS = ("XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX")
MATRIX34 = ("matrixd[3]", "matrixd[3][]", *MATRIX4)
VECTOR3 = ("vectord[3]", "vectord[3][]")
VECTORS3 = tuple(f"vector{kind}[3]{many}" for kind in "dfh" for many in ("", "[]"))
QUATERNIONS = tuple(f"quat{kind}[4]{many}" for kind in "dfh" for many in ("", "[]"))
ORDER = Attribute("token", "the axes in the order in which angles turn", default="XYZ", allowed_tokens=ORDERS)


@node_type(
    "omni.graph.nodes.GetMatrix4Translation",
    version=1,
    inputs={"matrix": Attribute(MATRIX4, "a transformation, or an array of them")},
    outputs={"translation": Attribute(("vectord[3]", "vectord[3][]"), "its translation", unit="stage units")},
    resolve=renamed("matrix", "translation", "vectord[3]"),
)
def get_matrix4_translation(db: Database) -> None:
    """Give the translation of a transformation."""
    db.outputs.translation = db.inputs.matrix[..., 3, :3].copy()


@node_type(
    "omni.graph.nodes.GetMatrix4Quaternion",
    version=1,
    inputs={"matrix": Attribute(MATRIX4, "a transformation, or an array of them")},
    outputs={"quaternion": Attribute(("quatd[4]", "quatd[4][]"), "its rotation, quaternion x, y, z, w")},
    resolve=renamed("matrix", "quaternion", "quatd[4]"),
)
def get_matrix4_quaternion(db: Database) -> None:
    """Give the rotation of a transformation without its scale, as a quaternion with w >= 0."""
    from graph.sim.transforms import quaternions, to_xyzw

    rotations = rotations_of(db.inputs.matrix)[0]
    turns = to_xyzw(quaternions(rotations))
    db.outputs.quaternion = turns if db.inputs.matrix.ndim == 3 else turns[0]


@node_type(
    "omni.graph.nodes.GetMatrix4Rotation",
    version=2,
    inputs={
        "matrix": Attribute(MATRIX34, "a transformation, or an array of them"),
        "rotationOrder": Attribute(
            "token", "the axes in the order in which they turn", default="XYZ", allowed_tokens=ORDERS
        ),
    },
    outputs={"rotation": Attribute(("vectord[3]", "vectord[3][]"), "angles about x, y and z", unit="deg")},
    resolve=renamed("matrix", "rotation", "vectord[3]"),
)
def get_matrix4_rotation(db: Database) -> None:
    """Give the rotation of a transformation without its scale, as angles; XYZ turns about x first."""
    angles = angles_of(rotations_of(db.inputs.matrix)[0], _order(db))
    db.outputs.rotation = angles if db.inputs.matrix.ndim == 3 else angles[0]


def angles_of(rotations: Any, order: str) -> Any:
    """Angles about x, y, z [deg], (n, 3), of column-vector rotation matrices (n, 3, 3) that turn in this order.

    Of the two solutions, the one whose middle angle is within 90 degrees; if it is exactly 90, the last angle is 0.
    """
    import numpy as np

    first, second, third = ("XYZ".index(axis) for axis in order)
    sign = 1.0 if order in ("XYZ", "YZX", "ZXY") else -1.0
    # Fixed axes; the first rotation is applied first: R = R(third) R(second) R(first).
    r = rotations
    middle = np.arcsin(np.clip(-sign * r[:, third, first], -1, 1))
    locked = np.abs(r[:, third, first]) > 1 - 1e-12
    angles = np.empty((len(r), 3))
    angles[:, second] = middle
    angles[:, first] = np.arctan2(sign * r[:, third, second], r[:, third, third])
    angles[:, third] = np.arctan2(sign * r[:, second, first], r[:, first, first])
    angles[locked, first] = np.arctan2(-sign * r[locked, second, third], r[locked, second, second])
    angles[locked, third] = 0.0
    return np.degrees(angles)


def rotations_of_angles(angles: Any, order: str) -> Any:
    """Column-vector rotation matrices (n, 3, 3) of angles about x, y, z [deg], (n, 3), that turn in this order."""
    import numpy as np

    sines, cosines = np.sin(np.radians(angles)), np.cos(np.radians(angles))
    whole = np.tile(np.eye(3), (len(angles), 1, 1))
    for name in order:
        axis = "XYZ".index(name)
        one, other = (axis + 1) % 3, (axis + 2) % 3
        turn = np.tile(np.eye(3), (len(angles), 1, 1))
        turn[:, one, one] = turn[:, other, other] = cosines[:, axis]
        turn[:, other, one], turn[:, one, other] = sines[:, axis], -sines[:, axis]
        whole = turn @ whole
    return whole


def rotations_of(matrices: Any) -> tuple[Any, Any]:
    """Column-vector rotation matrices (n, 3, 3) without scale, and scales (n, 3).

    Of row-vector matrices (4, 4), (n, 4, 4) or 3 x 3.
    """
    import numpy as np

    from graph.sim.transforms import rotations_and_scales

    given = matrices.reshape(-1, *matrices.shape[-2:])
    columns = np.tile(np.eye(4), (len(given), 1, 1))
    columns[:, :3, :3] = given[:, :3, :3].transpose(0, 2, 1)
    return rotations_and_scales(columns)


@node_type(
    "omni.graph.nodes.MakeTransform",
    version=2,
    inputs={
        "rotationOrder": ORDER,
        "rotationXYZ": Attribute("vectord[3]", "angles about x, y and z", default=[0.0, 0.0, 0.0], unit="deg"),
        "scale": Attribute("vectord[3]", "scale along x, y and z", default=[1.0, 1.0, 1.0]),
        "translation": Attribute("vectord[3]", "the translation", default=[0.0, 0.0, 0.0], unit="stage units"),
    },
    outputs={"transform": Attribute("matrixd[4]", "the transformation that scales, then rotates, then moves")},
)
def make_transform(db: Database) -> None:
    """Make a transformation from translation, rotation and scale."""
    import numpy as np

    inputs = db.inputs
    rotation = rotations_of_angles(inputs.rotationXYZ[None], _order(db))[0]
    transform = np.eye(4)
    transform[:3, :3] = rotation.T * inputs.scale[:, None]
    transform[3, :3] = inputs.translation
    db.outputs.transform = transform


@node_type(
    "omni.graph.nodes.MakeTransformLookAt",
    version=1,
    inputs={
        "center": Attribute("vectord[3]", "the point that is looked at", default=[0.0, 0.0, 0.0], unit="stage units"),
        "eye": Attribute("vectord[3]", "where the look comes from", default=[1.0, 0.0, 0.0], unit="stage units"),
        "up": Attribute("vectord[3]", "which way is up", default=[0.0, 1.0, 0.0]),
    },
    outputs={"transform": Attribute("matrixd[4]", "a place at the eye: -z forward, +y up, +x to the right")},
)
def make_transform_look_at(db: Database) -> None:
    """Make the transformation of an object at the eye that looks at the center."""
    import numpy as np

    inputs = db.inputs
    back = inputs.eye - inputs.center
    right = np.cross(inputs.up, back)
    if not np.linalg.norm(back) or not np.linalg.norm(right):
        db.fail("eye and center are one point, or up points along the look; change one of them")
    back, right = back / np.linalg.norm(back), right / np.linalg.norm(right)
    transform = np.eye(4)
    transform[:3, :3] = right, np.cross(back, right), back
    transform[3, :3] = inputs.eye
    db.outputs.transform = transform


@node_type(
    "omni.graph.nodes.GetMatrix4Scale",
    version=1,
    inputs={"matrix": Attribute(MATRIX34, "a transformation, or an array of them")},
    outputs={"scale": Attribute(VECTOR3, "its scale along x, y and z")},
    resolve=renamed("matrix", "scale", "vectord[3]"),
)
def get_matrix4_scale(db: Database) -> None:
    """Give the scale of a transformation; for a mirrored one the scale along x is negative."""
    given = db.inputs.matrix
    scales = rotations_of(given)[1]
    db.outputs.scale = scales if given.ndim == 3 else scales[0]


@node_type(
    "omni.graph.nodes.SetMatrix4Translation",
    version=1,
    inputs={
        "matrix": Attribute(MATRIX4, "a transformation, or an array of them"),
        "translation": Attribute(VECTOR3, "the translation to have", unit="stage units"),
    },
    outputs={"matrix": Attribute(MATRIX4, "the transformation with that translation")},
    resolve=same_type("matrix", "matrix"),
)
def set_matrix4_translation(db: Database) -> None:
    """Change the translation of a transformation; an array with an array, element by element."""
    matrix, translation = db.inputs.matrix.copy(), db.inputs.translation
    _check_shapes(db, matrix, translation, "translation")
    matrix[..., 3, :3] = translation
    db.outputs.matrix = matrix


@node_type(
    "omni.graph.nodes.SetMatrix4Scale",
    version=1,
    inputs={
        "matrix": Attribute(MATRIX34, "a transformation, or an array of them"),
        "scale": Attribute(VECTOR3, "the scale to have"),
    },
    outputs={"matrix": Attribute(MATRIX34, "the transformation with that scale")},
    resolve=same_type("matrix", "matrix"),
)
def set_matrix4_scale(db: Database) -> None:
    """Change the scale of a transformation, and keep its rotation and translation."""
    matrix, scale = db.inputs.matrix.copy(), db.inputs.scale
    _check_shapes(db, matrix, scale, "scale")
    turned = rotations_of(matrix)[0].swapaxes(-1, -2).reshape(*matrix.shape[:-2], 3, 3)
    matrix[..., :3, :3] = turned * scale[..., :, None]
    db.outputs.matrix = matrix


@node_type(
    "omni.graph.nodes.SetMatrix4Quaternion",
    version=1,
    inputs={
        "matrix": Attribute(MATRIX4, "a transformation, or an array of them"),
        "quaternion": Attribute(("quatd[4]", "quatd[4][]"), "the rotation to have, quaternion x, y, z, w"),
    },
    outputs={"matrix": Attribute(MATRIX4, "the transformation with that rotation and without scale")},
    resolve=same_type("matrix", "matrix"),
)
def set_matrix4_quaternion(db: Database) -> None:
    """Change the rotation of a transformation; its scale becomes 1, its translation stays."""
    _set_rotation(db, db.inputs.quaternion, "quaternion", "quatd[4]")


@node_type(
    "omni.graph.nodes.SetMatrix4Rotation",
    version=2,
    inputs={
        "fixedRotationAxis": Attribute(
            "token", "the axis that an angle turns about", default="Y", allowed_tokens=("X", "Y", "Z", "Custom")
        ),
        "matrix": Attribute(MATRIX4, "a transformation, or an array of them"),
        "rotationAngle": Attribute(
            ("double", "double[]", "matrixd[3]", "matrixd[3][]", "quatd[4]", "quatd[4][]", *VECTOR3),
            "the rotation: an angle about the axis, angles about x, y and z, a quaternion x, y, z, w, or a matrix",
            unit="deg",
        ),
        "rotationAxis": Attribute("vectord[3]", "the axis where fixedRotationAxis is Custom", default=[0.0, 1.0, 0.0]),
        "rotationOrder": ORDER,
    },
    outputs={"matrix": Attribute(MATRIX4, "the transformation with that rotation and without scale")},
    resolve=same_type("matrix", "matrix"),
)
def set_matrix4_rotation(db: Database) -> None:
    """Change the rotation of a transformation; its scale becomes 1, its translation stays."""
    _set_rotation(db, db.inputs.rotationAngle, "rotationAngle", str(db.input_type("rotationAngle")))


@node_type(
    "omni.graph.nodes.RotateVector",
    version=1,
    inputs={
        "rotation": Attribute(
            (*MATRIX34, *QUATERNIONS, *VECTORS3),
            "the rotation: a matrix, a quaternion x, y, z, w, or angles about x, y and z [deg]",
        ),
        "rotationOrder": ORDER,
        "vector": Attribute(VECTORS3, "the vector, or an array of them"),
    },
    outputs={"result": Attribute(VECTORS3, "the vectors turned")},
    resolve=lambda known: _like_vector(known, "rotation"),
)
def rotate_vector(db: Database) -> None:
    """Rotate vectors; the scale of a matrix counts, its translation does not."""
    import numpy as np

    vector, rotation = db.inputs.vector, db.inputs.rotation
    kind = str(db.input_type("rotation"))
    linear = np.asarray(rotation, float)[..., :3, :3] if kind.startswith("matrix") else _turned(db, rotation, kind)
    _check_pair(db, vector, linear)
    db.outputs.result = (vector[..., None, :].astype(float) @ linear)[..., 0, :].astype(vector.dtype)


@node_type(
    "omni.graph.nodes.TransformVector",
    version=1,
    inputs={
        "matrix": Attribute(MATRIX34, "a transformation, or an array of them"),
        "vector": Attribute(VECTORS3, "the point, or an array of them"),
    },
    outputs={"result": Attribute(VECTORS3, "vector x matrix")},
    resolve=lambda known: _like_vector(known, "matrix"),
)
def transform_vector(db: Database) -> None:
    """Transform points; the translation of a 4 x 4 matrix counts."""
    import numpy as np

    vector, matrix = db.inputs.vector, db.inputs.matrix
    _check_pair(db, vector, matrix)
    row = vector[..., None, :].astype(float)
    if matrix.shape[-1] == 3:
        result = (row @ matrix)[..., 0, :]
    else:
        whole = (row @ matrix[..., :3, :])[..., 0, :] + matrix[..., 3, :]
        weight = whole[..., 3:]
        result = whole[..., :3] / np.where(weight == 0, 1, weight)
    db.outputs.result = result.astype(vector.dtype)


def _order(db: Database) -> str:
    order: str = db.inputs.rotationOrder
    if order not in ORDERS:
        db.fail(f"input rotationOrder is {order!r}; it must be one of {' '.join(ORDERS)}")
    return order


def _like_vector(known: KnownTypes, other: str) -> Mapping[str, Type]:
    """The result has the type of the vector, an array if either input is one."""
    vector, with_it = known["inputs:vector"], known[f"inputs:{other}"]
    if vector is None or with_it is None:
        return {}
    return {"outputs:result": vector.element.array_of() if vector.array or with_it.array else vector}


def _check_pair(db: Database, vector: Any, matrix: Any) -> None:
    if vector.ndim == 2 and matrix.ndim == 3:
        check_lengths(db, [vector, matrix])


def _check_shapes(db: Database, matrix: Any, value: Any, name: str, *, axes: int = 1) -> None:
    """Fails the node if values of `axes` axes are an array of another length than that of the matrices."""
    if value.ndim > axes and (matrix.ndim == 2 or len(value) != len(matrix)):
        db.fail(f"input {name} has {len(value)} elements; give it one, or as many as there are matrices")


def _set_rotation(db: Database, value: Any, name: str, kind: str) -> None:
    matrix = db.inputs.matrix.copy()
    rows = _turned(db, value, kind)
    _check_shapes(db, matrix, rows, name, axes=2)
    matrix[..., :3, :3] = rows
    db.outputs.matrix = matrix


def _turned(db: Database, value: Any, kind: str) -> Any:
    """Row-vector rotation matrices (3, 3) or (n, 3, 3) of an angle, angles, quaternions or matrices."""
    import numpy as np

    from graph.sim.transforms import from_xyzw, rotation_matrices

    if kind.startswith("matrix"):
        return np.asarray(value, float)
    if kind.startswith("quat"):
        given = np.asarray(value, float)
        length = np.linalg.norm(given, axis=-1, keepdims=True)
        if not length.all():
            db.fail("a quaternion of length 0 is not a rotation; give it 0, 0, 0, 1 for none")
        columns = rotation_matrices(from_xyzw(given / length))
    elif kind.startswith("vector"):
        given = np.asarray(value, float)
        columns = rotations_of_angles(given.reshape(-1, 3), _order(db)).reshape(*given.shape[:-1], 3, 3)
    else:
        columns = _about_axis(db, np.radians(np.asarray(value, float)))
    return columns.swapaxes(-1, -2)


def _about_axis(db: Database, angle: Any) -> Any:
    """Column-vector rotations by angles [rad] about the axis that the inputs name."""
    import numpy as np

    name = db.inputs.fixedRotationAxis
    if name not in ("X", "Y", "Z", "Custom"):
        db.fail(f"input fixedRotationAxis is {name!r}; it must be X, Y, Z or Custom")
    axis = db.inputs.rotationAxis if name == "Custom" else np.eye(3)["XYZ".index(name)]
    length = math.hypot(*axis)
    if not length:
        db.fail("input rotationAxis has length 0; give it a direction")
    x, y, z = (float(one) / length for one in axis)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    sine, rest = np.sin(angle)[..., None, None], 1 - np.cos(angle)[..., None, None]
    return np.eye(3) + sine * cross + rest * (cross @ cross)
