"""`isaacsim.core.experimental.utils.xform` and `isaacsim.core.utils.xforms`."""

from __future__ import annotations

from typing import Any

import numpy as np

from graph.isaac.results import result
from graph.isaac.session import app
from graph.sim.transforms import quaternion, rigid_part
from sensors.xform import local_pose, place

from .prim_utils import usd_prim

__all__ = [
    "clear_xform_ops",
    "get_local_pose",
    "get_relative_transform",
    "get_world_pose",
    "reset_and_set_xform_ops",
    "reset_xform_ops",
    "set_local_pose",
    "set_world_pose",
]


def world_parts(path: str) -> tuple[np.ndarray, np.ndarray]:
    """Position [stage units] and orientation of a prim now: where physics has it, if it moves."""
    rigid = rigid_part(app().fabric.world_matrix(path))
    return rigid[:3, 3].copy(), quaternion(rigid[:3, :3])


def get_world_pose(prim: Any, *, device: Any = None) -> tuple[Any, Any]:
    position, orientation = world_parts(str(usd_prim(prim).GetPath()))
    return result(position), result(orientation)


def get_local_pose(prim: Any, *, device: Any = None) -> tuple[Any, Any]:
    translation, orientation = local_pose(usd_prim(prim))
    return result(translation), result(orientation)


def set_world_pose(prim: Any, *, position: Any = None, orientation: Any = None) -> None:
    put(usd_prim(prim), position=position, orientation=orientation)


def set_local_pose(prim: Any, *, translation: Any = None, orientation: Any = None) -> None:
    put(usd_prim(prim), translation=translation, orientation=orientation)


def put(
    prim: Any, *, position: Any = None, translation: Any = None, orientation: Any = None, scale: Any = None
) -> None:
    """Authors a pose; a turn without a place is in the world if the place would be, else local."""
    place(
        prim,
        positions=None if position is None else np.asarray(position, np.float64).reshape(3),
        translations=None if translation is None else np.asarray(translation, np.float64).reshape(3),
        orientations=None if orientation is None else np.asarray(orientation, np.float64).reshape(4),
        scales=None if scale is None else np.asarray(scale, np.float64).reshape(3),
    )


def get_relative_transform(source_prim: Any, target_prim: Any) -> np.ndarray:
    fabric = app().fabric
    source, target = (str(usd_prim(one).GetPath()) for one in (source_prim, target_prim))
    out: np.ndarray = np.linalg.inv(fabric.world_matrix(target)) @ fabric.world_matrix(source)
    return out


def clear_xform_ops(prim: Any) -> None:
    from graph.sim.usd import UsdGeom

    UsdGeom.Xformable(prim).ClearXformOpOrder()


def reset_xform_ops(prim: Any) -> None:
    put(prim, translation=(0, 0, 0), orientation=(1, 0, 0, 0), scale=(1, 1, 1))


def reset_and_set_xform_ops(prim: Any, translation: Any, orientation: Any, scale: Any = (1, 1, 1)) -> None:
    quat = (orientation.GetReal(), *orientation.GetImaginary()) if hasattr(orientation, "GetReal") else orientation
    put(prim, translation=translation, orientation=quat, scale=scale)
