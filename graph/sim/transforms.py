"""Poses as float64 arrays: the only module that converts matrices to quaternions and back.

Quaternions are w, x, y, z and of unit length; `to_xyzw` and `from_xyzw` convert to the order of ROS, OmniGraph and
USD's arrays. Matrices are for column vectors: p_parent = M @ [p_child, 1]; USD's are their transposes. `...` in a shape
is any number of leading axes. Lengths keep their unit.
"""

from __future__ import annotations

from math import sqrt
from typing import Any, Literal

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


def rigid(rotation: Floats, position: Floats) -> Floats:
    """The (4, 4) pose of a (3, 3) rotation and a (3,) position."""
    out = np.eye(4)
    out[:3, :3], out[:3, 3] = rotation, position
    return out


def pose_matrices(positions: Floats, quaternions: Floats) -> Floats:
    """(..., 3) positions and (..., 4) quaternions to (..., 4, 4) matrices."""
    out = np.zeros((*positions.shape[:-1], 4, 4))
    out[..., :3, :3] = rotation_matrices(quaternions)
    out[..., :3, 3] = positions
    out[..., 3, 3] = 1
    return out


def quaternion(rotation: Floats) -> Floats:
    """(3, 3) rotation to (4,) quaternion, w >= 0: `quaternions` of a single one, on plain floats."""
    (a, b, c), (d, e, f), (g, h, i) = rotation.tolist()  # nine numbers: plain floats are ten times as fast
    squares = 1 + a + e + i, 1 + a - e - i, 1 - a + e - i, 1 - a - e + i
    largest = squares.index(max(squares))
    if largest == 0:
        w, x, y, z = squares[0], h - f, c - g, d - b
    elif largest == 1:
        w, x, y, z = h - f, squares[1], b + d, c + g
    elif largest == 2:
        w, x, y, z = c - g, b + d, squares[2], f + h
    else:
        w, x, y, z = d - b, c + g, f + h, squares[3]
    length = sqrt(w * w + x * x + y * y + z * z)  # not `sum`, which rounds differently from Python 3.12 on
    return np.array((w, x, y, z)) / (-length if w < 0 else length)


def quaternions(rotations: Floats) -> Floats:
    """(..., 3, 3) rotations to (..., 4) quaternions, w >= 0.

    Shepperd, "Quaternion from rotation matrix" (1978): 4 q q^T is linear in the matrix; its row with the largest
    diagonal element is q times q's largest component, so that nothing cancels.
    """
    m = np.asarray(rotations, np.float64).reshape(-1, 9).T
    xx, xy, xz, yx, yy, yz, zx, zy, zz = m
    rows = np.empty((4, 4, m.shape[1]))
    rows[0, 0], rows[1, 1] = 1 + xx + yy + zz, 1 + xx - yy - zz
    rows[2, 2], rows[3, 3] = 1 - xx + yy - zz, 1 - xx - yy + zz
    rows[0, 1] = rows[1, 0] = zy - yz
    rows[0, 2] = rows[2, 0] = xz - zx
    rows[0, 3] = rows[3, 0] = yx - xy
    rows[1, 2] = rows[2, 1] = xy + yx
    rows[1, 3] = rows[3, 1] = xz + zx
    rows[2, 3] = rows[3, 2] = yz + zy
    largest = np.argmax(rows[(0, 1, 2, 3), (0, 1, 2, 3)], axis=0)
    q = rows[largest, :, np.arange(m.shape[1])]
    squares = q * q
    length = np.sqrt(squares[:, 0] + squares[:, 1] + squares[:, 2] + squares[:, 3])
    q /= np.where(q[:, 0] < 0, -length, length)[:, None]
    out: Floats = q.reshape(*rotations.shape[:-2], 4)
    return out


def to_xyzw(quaternions: Floats) -> Floats:
    """(..., 4) w, x, y, z to x, y, z, w."""
    return np.concatenate((quaternions[..., 1:], quaternions[..., :1]), axis=-1)


def from_xyzw(quaternions: Floats) -> Floats:
    """(..., 4) x, y, z, w to w, x, y, z."""
    return np.concatenate((quaternions[..., 3:], quaternions[..., :3]), axis=-1)


def slerp(first: Floats, second: Floats, share: Floats | float) -> Floats:
    """(..., 4) quaternions at the fraction `share` (...), 0 to 1, from `first` to `second` (..., 4), on the shorter
    arc.

    Any order of components. Shoemake, "Animating rotation with quaternion curves" (1985). (Nearly) equal quaternions
    are interpolated linearly and normalised, which differs by less than 1e-14.
    """
    first, second = np.asarray(first, np.float64), np.asarray(second, np.float64)
    share = np.asarray(share, np.float64)
    cosine = np.einsum("...j,...j->...", first, second)
    second = np.where(cosine[..., None] < 0, -second, second)
    angle = np.arccos(np.minimum(np.abs(cosine), 1.0))
    sine = np.sin(angle)
    close = sine < 1e-6
    scale = np.where(close, 1.0, sine)
    one = np.where(close, 1.0 - share, np.sin((1.0 - share) * angle) / scale)
    two = np.where(close, share, np.sin(share * angle) / scale)
    out = one[..., None] * first + two[..., None] * second
    return np.asarray(out / np.sqrt(np.einsum("...j,...j->...", out, out))[..., None])


def rotations_and_scales(matrices: Floats) -> tuple[Floats, Floats]:
    """Rotations (n, 3, 3) and scales (n, 3) of translate-rotate-scale matrices (n, 4, 4).

    A mirrored one gets a negative x scale; an axis of scale 0 gives the rotation as if the scale were 1.
    """
    linear = matrices[:, :3, :3]
    scales = np.sqrt((linear * linear).sum(axis=1))
    scales[np.linalg.det(linear) < 0, 0] *= -1
    return linear / np.where(scales == 0, 1.0, scales)[:, None, :], scales


def rigid_part(matrix: Floats, side: int = 1) -> Floats:
    """The rotation and translation of an affine (4, 4) matrix, without its scale and shear.

    The rotation is the nearest one (polar decomposition); for translate-rotate-scale it is exactly the rotate part. A
    reflection stays in the rest, `np.linalg.inv(rigid) @ matrix`: the axis `side` (0 to 2) is reversed, and the two
    others keep their directions.
    """
    (a, b, c, x), (d, e, f, y), (g, h, i, z) = matrix[:3].tolist()  # nine numbers: plain floats are ten times as fast
    lengths = sqrt(a * a + d * d + g * g), sqrt(b * b + e * e + h * h), sqrt(c * c + f * f + i * i)
    if min(lengths) > 0:
        p, q, r = lengths
        a, d, g, b, e, h, c, f, i = a / p, d / p, g / p, b / q, e / q, h / q, c / r, f / r, i / r
        skew = max(abs(a * b + d * e + g * h), abs(b * c + e * f + h * i), abs(a * c + d * f + g * i))
        if skew < 1e-9:
            rigid = np.array([[a, b, c, x], [d, e, f, y], [g, h, i, z], [0.0, 0.0, 0.0, 1.0]])
            if a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g) < 0:
                rigid[:3, side] *= -1.0
            return rigid
    out = np.eye(4)
    out[:3, 3] = matrix[:3, 3]
    if not np.isfinite(
        matrix
    ).all():  # there is no nearest rotation; readers of transforms report that it is not finite
        return np.full((4, 4), np.nan)
    u, _, vt = np.linalg.svd(matrix[:3, :3])
    if np.linalg.det(u @ vt) < 0:
        out[:3, :3] = u @ vt
        out[:3, side] *= -1.0
        return out
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


def apply(matrix: NDArray[Any], vectors: NDArray[Any], *, axis: Literal[0, -1] = -1) -> NDArray[Any]:
    """A (k, m) matrix times many vectors, whose m components lie along `axis`; there the result has k.

    One pass a component: a product of a tall array would go to BLAS, whose idle threads take another processor.
    """
    last = axis == -1
    shape = (*vectors.shape[:-1], len(matrix)) if last else (len(matrix), *vectors.shape[1:])
    out = np.empty(shape, np.result_type(matrix, vectors))
    parts = [vectors[..., number] if last else vectors[number] for number in range(matrix.shape[1])]
    for number, factors in enumerate(matrix):
        one = out[..., number] if last else out[number, ...]  # an array even where there is one vector
        np.multiply(parts[0], factors[0], out=one)
        for part, factor in zip(parts[1:], factors[1:], strict=True):
            one += part * factor
    return out


def transformed(matrix: Floats, points: Floats) -> Floats:
    """(n, 3) points through a (4, 4) matrix; those that are not finite stay so."""
    with np.errstate(invalid="ignore"):
        return apply(matrix[:3, :3], points) + matrix[:3, 3]


FLAT = 1e-300
"""A matrix with a smaller determinant counts as flat."""


def usable(matrix: Floats) -> bool:
    """Whether a matrix is affine, finite and not flat."""
    return bool(all_usable(matrix[None])[0])


def all_usable(matrices: Floats) -> NDArray[np.bool_]:
    """(n,): `usable` of (n, 4, 4) matrices."""
    with np.errstate(all="ignore"):
        flat = np.abs(np.linalg.det(matrices[:, :3, :3])) <= FLAT
        affine = (np.abs(matrices[:, 3] - [0, 0, 0, 1]) <= 1e-9).all(axis=1)
    return np.asarray(np.isfinite(matrices).all(axis=(1, 2)) & affine & ~flat)
