"""Poses as arrays: quaternions w, x, y, z; matrices (4, 4) float64 for column vectors (p_world = M @ [p, 1])."""

from __future__ import annotations

from math import sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def from_usd(matrix: Any) -> Floats:
    """A `Gf.Matrix4d` (row vectors) as a column-vector matrix."""
    return np.array(matrix, dtype=np.float64).T


def rotation_matrices(quaternions: Floats) -> Floats:
    """(..., 4) unit quaternions to (..., 3, 3) rotations."""
    w, x, y, z = np.moveaxis(quaternions, -1, 0)
    out = np.empty((*quaternions.shape[:-1], 3, 3))
    out[..., 0, 0] = 1 - 2 * (y * y + z * z)
    out[..., 0, 1] = 2 * (x * y - w * z)
    out[..., 0, 2] = 2 * (x * z + w * y)
    out[..., 1, 0] = 2 * (x * y + w * z)
    out[..., 1, 1] = 1 - 2 * (x * x + z * z)
    out[..., 1, 2] = 2 * (y * z - w * x)
    out[..., 2, 0] = 2 * (x * z - w * y)
    out[..., 2, 1] = 2 * (y * z + w * x)
    out[..., 2, 2] = 1 - 2 * (x * x + y * y)
    return out


def pose_matrices(positions: Floats, quaternions: Floats) -> Floats:
    """(..., 3) positions and (..., 4) quaternions to (..., 4, 4) matrices."""
    out = np.zeros((*positions.shape[:-1], 4, 4))
    out[..., :3, :3] = rotation_matrices(quaternions)
    out[..., :3, 3] = positions
    out[..., 3, 3] = 1
    return out


def quaternion(rotation: Floats) -> Floats:
    """(3, 3) rotation to (4,) quaternion with w >= 0 (Shepperd: divides by the largest component)."""
    (a, b, c), (d, e, f), (g, h, i) = rotation.tolist()  # nine numbers: plain floats are ten times as fast
    squares = 1 + a + e + i, 1 + a - e - i, 1 - a + e - i, 1 - a - e + i
    largest = squares.index(max(squares))
    if largest == 0:
        q = (squares[0], h - f, c - g, d - b)
    elif largest == 1:
        q = (h - f, squares[1], b + d, c + g)
    elif largest == 2:
        q = (c - g, b + d, squares[2], f + h)
    else:
        q = (d - b, c + g, f + h, squares[3])
    length = sqrt(sum(x * x for x in q))
    return np.array(q) / (-length if q[0] < 0 else length)


def rigid_part(matrix: Floats) -> Floats:
    """The rotation and translation of an affine (4, 4) matrix, without its scale and shear.

    The rotation is the nearest one (polar decomposition); for translate-rotate-scale it is exactly the rotate part.
    A reflection is left to the rest, `np.linalg.inv(rigid) @ matrix`.
    """
    (a, b, c, x), (d, e, f, y), (g, h, i, z) = matrix[:3].tolist()  # nine numbers: plain floats are ten times as fast
    lengths = sqrt(a * a + d * d + g * g), sqrt(b * b + e * e + h * h), sqrt(c * c + f * f + i * i)
    if min(lengths) > 0:
        p, q, r = lengths
        a, d, g, b, e, h, c, f, i = a / p, d / p, g / p, b / q, e / q, h / q, c / r, f / r, i / r
        skew = max(abs(a * b + d * e + g * h), abs(b * c + e * f + h * i), abs(a * c + d * f + g * i))
        if skew < 1e-9 and a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g) > 0:
            return np.array([[a, b, c, x], [d, e, f, y], [g, h, i, z], [0.0, 0.0, 0.0, 1.0]])
    out = np.eye(4)
    out[:3, 3] = matrix[:3, 3]
    u, _, vt = np.linalg.svd(matrix[:3, :3])
    u[:, 2] *= np.sign(np.linalg.det(u @ vt)) or 1.0
    out[:3, :3] = u @ vt
    return out


def rigid_parts(matrices: Floats) -> Floats:
    """`rigid_part` of (n, 4, 4) matrices."""
    linear = matrices[:, :3, :3]
    lengths = np.sqrt((linear * linear).sum(axis=1))
    with np.errstate(all="ignore"):
        axes = linear / lengths[:, None, :]
        skewed = np.abs(np.swapaxes(axes, 1, 2) @ axes - np.eye(3)).max(axis=(1, 2))
        plain = (skewed < 1e-9) & (np.linalg.det(axes) > 0)
    out = np.zeros_like(matrices)
    out[:, :3, :3], out[:, :3, 3], out[:, 3, 3] = axes, matrices[:, :3, 3], 1
    for number in np.flatnonzero(~plain):
        out[number] = rigid_part(matrices[number])
    return out


def rotation_vectors(rotations: Floats) -> Floats:
    """(n, 3, 3) rotations to (n, 3): axis times angle [rad], for angles well below half a turn."""
    skew = np.stack(
        [
            rotations[:, 2, 1] - rotations[:, 1, 2],
            rotations[:, 0, 2] - rotations[:, 2, 0],
            rotations[:, 1, 0] - rotations[:, 0, 1],
        ],
        axis=1,
    )
    sine = np.linalg.norm(skew, axis=1) / 2
    angle = np.arctan2(sine, (np.trace(rotations, axis1=1, axis2=2) - 1) / 2)
    factor = np.divide(angle, 2 * sine, out=np.full_like(sine, 0.5), where=sine > 1e-12)
    return np.asarray(skew * factor[:, None])


def inverse_rigid(matrix: Floats) -> Floats:
    """The inverse of (..., 4, 4) rigid matrices."""
    out = np.zeros_like(matrix)
    turned = np.swapaxes(matrix[..., :3, :3], -1, -2)
    out[..., :3, :3] = turned
    out[..., :3, 3] = -(turned @ matrix[..., :3, 3:])[..., 0]
    out[..., 3, 3] = 1
    return out


def transformed(matrix: Floats, points: Floats) -> Floats:
    """(n, 3) points through a (4, 4) matrix."""
    return points @ matrix[:3, :3].T + matrix[:3, 3]


FLAT = 1e-300
"""A matrix with a determinant below is taken for flat."""


def usable(matrix: Floats) -> bool:
    """Whether a matrix is affine, has neither NaN nor infinity and is not flat."""
    return bool(all_usable(matrix[None])[0])


def all_usable(matrices: Floats) -> NDArray[np.bool_]:
    """(n,): `usable` of (n, 4, 4) matrices."""
    with np.errstate(all="ignore"):
        flat = np.abs(np.linalg.det(matrices[:, :3, :3])) <= FLAT
        affine = (np.abs(matrices[:, 3] - [0, 0, 0, 1]) <= 1e-9).all(axis=1)
    return np.asarray(np.isfinite(matrices).all(axis=(1, 2)) & affine & ~flat)
