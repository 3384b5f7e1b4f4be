"""`isaacsim.core.utils.xforms`, `.transformations` and `.physics`: poses by path, matrices, rigid bodies."""

from __future__ import annotations

from typing import Any

import numpy as np

from graph.isaac.session import app
from graph.sim.transforms import pose_matrices, quaternion
from graph.sim.usd import UsdPhysics
from sensors.inertial import attribute_of

from . import xforms
from .xforms import clear_xform_ops, get_relative_transform, reset_and_set_xform_ops, reset_xform_ops

__all__ = [
    "clear_xform_ops",
    "get_local_pose",
    "get_relative_transform",
    "get_rigid_body_enabled",
    "get_transform_with_normalized_rotation",
    "get_translation_from_target",
    "get_world_pose",
    "get_world_pose_from_relative",
    "pose_from_tf_matrix",
    "reset_and_set_xform_ops",
    "reset_xform_ops",
    "set_rigid_body_enabled",
    "tf_matrices_from_poses",
    "tf_matrix_from_pose",
]


def get_world_pose(prim_path: str, fabric: bool = False) -> tuple[np.ndarray, np.ndarray]:
    return tuple(one.numpy() for one in xforms.get_world_pose(prim_path))


def get_local_pose(prim_path: str) -> tuple[np.ndarray, np.ndarray]:
    return tuple(one.numpy() for one in xforms.get_local_pose(prim_path))


def tf_matrix_from_pose(translation: Any, orientation: Any) -> np.ndarray:
    return np.asarray(tf_matrices_from_poses([translation], [orientation])[0])


def tf_matrices_from_poses(translations: Any, orientations: Any) -> np.ndarray:
    return np.asarray(pose_matrices(np.asarray(translations, float), np.asarray(orientations, float)))


def pose_from_tf_matrix(transformation: Any) -> tuple[np.ndarray, np.ndarray]:
    matrix = get_transform_with_normalized_rotation(transformation)
    return matrix[:3, 3], quaternion(matrix[:3, :3])


def get_transform_with_normalized_rotation(transform: Any) -> np.ndarray:
    out = np.array(transform, float)
    out[:3, :3] /= np.linalg.norm(out[:3, :3], axis=0)
    return out


def get_translation_from_target(translation_from_source: Any, source_prim: Any, target_prim: Any) -> np.ndarray:
    relative = get_relative_transform(source_prim, target_prim)
    return np.asarray(relative @ np.append(np.asarray(translation_from_source, float), 1.0))[:3]


def get_world_pose_from_relative(
    coord_prim: Any, relative_translation: Any, relative_orientation: Any
) -> tuple[np.ndarray, np.ndarray]:
    world = app().fabric.world_matrix(str(coord_prim.GetPath()))
    return pose_from_tf_matrix(world @ tf_matrix_from_pose(relative_translation, relative_orientation))


def get_rigid_body_enabled(prim_path: str) -> bool | None:
    prim = app().stage.GetPrimAtPath(prim_path)
    has = prim and prim.HasAPI(UsdPhysics.RigidBodyAPI)
    return bool(attribute_of(prim, "physics:rigidBodyEnabled", True)) if has else None


def set_rigid_body_enabled(_value: bool, prim_path: str) -> None:
    prim = app().stage.GetPrimAtPath(prim_path)
    UsdPhysics.RigidBodyAPI.Apply(prim).CreateRigidBodyEnabledAttr().Set(bool(_value))
