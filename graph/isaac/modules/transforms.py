"""Rotations: `isaacsim.core.experimental.utils.transform`, `isaacsim.core.utils.rotations` and `.numpy.rotations`.

Quaternions are w, x, y, z.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from graph.isaac.results import Result, result
from graph.sim.transforms import quaternion, rotation_matrices

__all__ = [
    "compute_relative_transform",
    "deg2rad",
    "euler_angles_to_quat",
    "euler_angles_to_quaternion",
    "euler_angles_to_quats",
    "euler_angles_to_rotation_matrix",
    "euler_to_rot_matrix",
    "gf_quat_to_np_array",
    "gf_quat_to_tensor",
    "gf_rotation_to_np_array",
    "look_at_matrix",
    "look_at_quaternion",
    "lookat_to_quatf",
    "matrix_to_euler_angles",
    "quat_to_euler_angles",
    "quat_to_rot_matrices",
    "quat_to_rot_matrix",
    "quaternion_conjugate",
    "quaternion_multiplication",
    "quaternion_to_euler_angles",
    "quaternion_to_rotation_matrix",
    "quats_to_euler_angles",
    "quats_to_rot_matrices",
    "quats_to_rotvecs",
    "rad2deg",
    "rot_matrices_to_quats",
    "rot_matrix_to_quat",
    "rotation_matrix_to_quaternion",
    "rotvecs_to_quats",
    "wxyz2xyzw",
    "xyzw2wxyz",
]


def _array(values: Any) -> np.ndarray:
    return np.asarray(values.numpy() if hasattr(values, "numpy") else values, np.float64)


def _matrices(angles: np.ndarray, extrinsic: bool) -> np.ndarray:
    """(n, 3, 3) turns by angles [rad] about X, Y, Z: of the fixed axes, or of those that turn along."""
    out = np.tile(np.eye(3), (len(angles), 1, 1))
    for axis in range(3):
        c, s = np.cos(angles[:, axis]), np.sin(angles[:, axis])
        turn = np.tile(np.eye(3), (len(angles), 1, 1))
        i, j = ((1, 2), (2, 0), (0, 1))[axis]
        turn[:, i, i], turn[:, j, j], turn[:, j, i], turn[:, i, j] = c, c, s, -s
        out = turn @ out if extrinsic else out @ turn
    return out


def _turns(angles: Any, degrees: bool, extrinsic: bool) -> tuple[np.ndarray, bool]:
    given = _array(angles)
    single = given.ndim == 1
    rows = given.reshape(-1, 3)
    return _matrices(np.radians(rows) if degrees else rows, extrinsic), single


def _angles(matrices: np.ndarray, extrinsic: bool) -> np.ndarray:
    """The inverse of `_matrices`."""
    m = matrices if extrinsic else np.swapaxes(matrices, 1, 2)
    y = np.arcsin(np.clip(-m[:, 2, 0], -1, 1))
    x, z = np.arctan2(m[:, 2, 1], m[:, 2, 2]), np.arctan2(m[:, 1, 0], m[:, 0, 0])
    locked = np.abs(m[:, 2, 0]) > 1 - 1e-7  # X and Z turn about one axis: X has it all
    x, z = np.where(locked, np.arctan2(-m[:, 1, 2], m[:, 1, 1]), x), np.where(locked, 0.0, z)
    out = np.stack([x, y, z], axis=1)
    return out if extrinsic else -out


def _quaternions(matrices: np.ndarray) -> np.ndarray:
    return np.array([quaternion(one) for one in matrices])


def euler_angles_to_rotation_matrix(
    euler_angles: Any, *, degrees: bool = False, extrinsic: bool = True, dtype: Any = None, device: Any = None
) -> Result:
    matrices, single = _turns(euler_angles, degrees, extrinsic)
    return result(matrices[0] if single else matrices)


def euler_angles_to_quaternion(
    euler_angles: Any, *, degrees: bool = False, extrinsic: bool = True, dtype: Any = None, device: Any = None
) -> Result:
    matrices, single = _turns(euler_angles, degrees, extrinsic)
    out = _quaternions(matrices)
    return result(out[0] if single else out)


def quaternion_to_rotation_matrix(quaternion: Any, *, dtype: Any = None, device: Any = None) -> Result:
    given = _array(quaternion)
    out = rotation_matrices(given.reshape(-1, 4))
    return result(out[0] if given.ndim == 1 else out)


def rotation_matrix_to_quaternion(rotation_matrix: Any, *, dtype: Any = None, device: Any = None) -> Result:
    given = _array(rotation_matrix)
    out = _quaternions(given.reshape(-1, 3, 3))
    return result(out[0] if given.ndim == 2 else out)


def quaternion_to_euler_angles(
    quaternion: Any, *, degrees: bool = False, extrinsic: bool = True, dtype: Any = None, device: Any = None
) -> Result:
    given = _array(quaternion)
    flat = given.reshape(-1, 4)
    out = _angles(rotation_matrices(flat / np.linalg.norm(flat, axis=1, keepdims=True)), extrinsic)
    out = np.degrees(out) if degrees else out
    return result(out[0] if given.ndim == 1 else out)


def quaternion_multiplication(
    first_quaternion: Any, second_quaternion: Any, *, dtype: Any = None, device: Any = None
) -> Result:
    a, b = _array(first_quaternion), _array(second_quaternion)
    (w, x, y, z), (s, i, j, k) = np.moveaxis(a, -1, 0), np.moveaxis(b, -1, 0)
    parts = (
        w * s - x * i - y * j - z * k,
        w * i + x * s + y * k - z * j,
        w * j - x * k + y * s + z * i,
        w * k + x * j - y * i + z * s,
    )
    return result(np.stack(parts, axis=-1))


def quaternion_conjugate(quaternion: Any, *, dtype: Any = None, device: Any = None) -> Result:
    return result(_array(quaternion) * np.array([1, -1, -1, -1]))


def look_at_matrix(eye: Any, target: Any, up: Any = None, *, epsilon: float = 1e-5) -> Any:
    """Gf.Matrix4d, the pose of a camera, which looks along its -Z, with +Y up."""
    from graph.sim.usd import Gf

    place, aim, above = (_array((0, 0, 1) if one is None else one) for one in (eye, target, up))
    if np.linalg.norm(np.cross(above, aim - place)) < epsilon:
        above = np.array([0.0, 1.0, 0.0]) if abs(above[1]) < 0.9 * np.linalg.norm(above) else np.array([1.0, 0.0, 0.0])
    vectors = (Gf.Vec3d(*map(float, one)) for one in (place, aim, above))
    return Gf.Matrix4d(1).SetLookAt(*vectors).GetInverse()


def look_at_quaternion(eye: Any, target: Any, up: Any = None, *, dtype: Any = None, device: Any = None) -> Result:
    places, aims = _array(eye), _array(target)
    if places.shape != aims.shape:
        raise ValueError(f"eye has shape {places.shape}, target {aims.shape}; give both the same")
    pairs = zip(places.reshape(-1, 3), aims.reshape(-1, 3), strict=True)
    turns = [quaternion(np.array(look_at_matrix(one, aim, up)).T[:3, :3]) for one, aim in pairs]
    return result(np.reshape(turns, (*places.shape[:-1], 4)))


def rotation_order(op: Any) -> str:
    """The axes of an op that rotates about three, first to last: "XYZ"; "" for another."""
    name = str(op.GetOpName()).split(":")[1]
    return name.removeprefix("rotate") if name.startswith("rotate") and len(name) == len("rotateXYZ") else ""


def compute_relative_transform(source_to_world: Any, target_to_world: Any) -> np.ndarray:
    """(4, 4) column-vector pose of the source in the target, of USD's row-vector matrices."""
    out: np.ndarray = (_array(source_to_world) @ np.linalg.inv(_array(target_to_world))).T
    return out


def euler_angles_to_quat(euler_angles: Any, degrees: bool = False, extrinsic: bool = True) -> np.ndarray:
    return np.asarray(euler_angles_to_quaternion(euler_angles, degrees=degrees, extrinsic=extrinsic), np.float64)


def euler_angles_to_quats(euler_angles: Any, degrees: bool = False, extrinsic: bool = True, device: Any = None) -> Any:
    return euler_angles_to_quat(euler_angles, degrees, extrinsic)


def quat_to_euler_angles(quat: Any, degrees: bool = False, extrinsic: bool = True) -> np.ndarray:
    return np.asarray(quaternion_to_euler_angles(quat, degrees=degrees, extrinsic=extrinsic), np.float64)


def quats_to_euler_angles(
    quaternions: Any, degrees: bool = False, extrinsic: bool = True, device: Any = None
) -> np.ndarray:
    return quat_to_euler_angles(quaternions, degrees, extrinsic)


def quat_to_rot_matrix(quat: Any) -> np.ndarray:
    return np.asarray(rotation_matrices(_array(quat).reshape(1, 4))[0])


def quats_to_rot_matrices(quaternions: Any, device: Any = None) -> np.ndarray:
    return np.asarray(quaternion_to_rotation_matrix(quaternions), np.float64)


quat_to_rot_matrices = quats_to_rot_matrices


def rot_matrix_to_quat(mat: Any) -> np.ndarray:
    return quaternion(_array(mat))


def rot_matrices_to_quats(rotation_matrices: Any, device: Any = None) -> np.ndarray:
    return np.asarray(rotation_matrix_to_quaternion(rotation_matrices), np.float64)


def matrix_to_euler_angles(mat: Any, degrees: bool = False, extrinsic: bool = True) -> np.ndarray:
    out = _angles(_array(mat).reshape(1, 3, 3), extrinsic)[0]
    return np.asarray(np.degrees(out) if degrees else out)


def euler_to_rot_matrix(euler_angles: Any, degrees: bool = False, extrinsic: bool = True) -> np.ndarray:
    return np.asarray(euler_angles_to_rotation_matrix(euler_angles, degrees=degrees, extrinsic=extrinsic), np.float64)


def rotvecs_to_quats(rotation_vectors: Any, degrees: bool = False, device: Any = None) -> np.ndarray:
    given = _array(rotation_vectors)
    rows = np.radians(given.reshape(-1, 3)) if degrees else given.reshape(-1, 3)
    angle = np.linalg.norm(rows, axis=1, keepdims=True)
    axis = np.divide(rows, angle, out=np.zeros_like(rows), where=angle > 0)
    out = np.concatenate([np.cos(angle / 2), axis * np.sin(angle / 2)], axis=1)
    return out[0] if given.ndim == 1 else out


def quats_to_rotvecs(quaternions: Any, device: Any = None) -> np.ndarray:
    from graph.sim.transforms import rotation_vectors

    given = _array(quaternions)
    out = rotation_vectors(rotation_matrices(given.reshape(-1, 4)))
    return out[0] if given.ndim == 1 else out


def gf_quat_to_np_array(orientation: Any) -> np.ndarray:
    return np.array([orientation.GetReal(), *orientation.GetImaginary()])


def gf_quat_to_tensor(orientation: Any, device: Any = None) -> np.ndarray:
    return gf_quat_to_np_array(orientation)


def gf_rotation_to_np_array(orientation: Any) -> np.ndarray:
    return gf_quat_to_np_array(orientation.GetQuat())


def lookat_to_quatf(camera: Any, target: Any, up: Any) -> Any:
    from graph.sim.usd import Gf

    w, x, y, z = map(float, look_at_quaternion(list(camera), list(target), list(up)).numpy())
    return Gf.Quatf(w, x, y, z)


def deg2rad(degree_value: Any, device: Any = None) -> Any:
    return np.deg2rad(degree_value)


def rad2deg(radian_value: Any, device: Any = None) -> Any:
    return np.rad2deg(radian_value)


def xyzw2wxyz(q: Any, ret_torch: bool = False) -> np.ndarray:
    return np.roll(_array(q), 1, axis=-1)


def wxyz2xyzw(q: Any, ret_torch: bool = False) -> np.ndarray:
    return np.roll(_array(q), -1, axis=-1)
