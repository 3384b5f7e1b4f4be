"""Translation, rotation and scale of transformation matrices (row-vector: the translation is the last row)."""

from __future__ import annotations

from typing import Any

from graph.node import Attribute, Database, node_type

from .like_inputs import renamed

MATRIX4 = ("matrixd[4]", "matrixd[4][]")
ORDERS = ("XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX")


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
        "matrix": Attribute(("matrixd[3]", "matrixd[3][]", *MATRIX4), "a transformation, or an array of them"),
        "rotationOrder": Attribute(
            "token", "the axes in the order in which they turn", default="XYZ", allowed_tokens=ORDERS
        ),
    },
    outputs={"rotation": Attribute(("vectord[3]", "vectord[3][]"), "angles about x, y and z", unit="deg")},
    resolve=renamed("matrix", "rotation", "vectord[3]"),
)
def get_matrix4_rotation(db: Database) -> None:
    """Give the rotation of a transformation without its scale, as angles; XYZ turns about x first."""
    order = db.inputs.rotationOrder
    if order not in ORDERS:
        db.fail(f"input rotationOrder is {order!r}; it must be one of {' '.join(ORDERS)}")
    angles = angles_of(rotations_of(db.inputs.matrix)[0], order)
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
