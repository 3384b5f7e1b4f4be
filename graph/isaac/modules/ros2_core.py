"""`isaacsim.ros2.core`: namespaces of sensors, the CameraInfo of a render product, poses of stereo pairs."""

from __future__ import annotations

from typing import Any

import numpy as np

from graph.isaac.session import app

from .ros2_bridge import read_camera_info
from .viewport_manager import ViewportManager
from .xforms import get_relative_transform

__all__ = ["BRIDGE_NAME", "BRIDGE_PREFIX", "collect_namespace", "compute_relative_pose", "read_camera_info"]
BRIDGE_NAME, BRIDGE_PREFIX = "isaacsim.ros2.core", "ROS2"


def collect_namespace(namespace_input: str, render_product_path: str) -> str:
    """The namespace given, or `isaac:namespace` of the product's camera and of the prims above it, joined with /."""
    from nodes.ros2.publishing import collect_namespace as collected

    if namespace_input or not render_product_path:
        return namespace_input
    return collected(app().stage, str(ViewportManager.get_camera(render_product_path).GetPath()))


def compute_relative_pose(left_camera_prim: Any, right_camera_prim: Any) -> tuple[np.ndarray, np.ndarray]:
    """Where the left camera is in the right one: (3,) in stage units, and the rotation (3, 3)."""
    relative = np.asarray(get_relative_transform(left_camera_prim, right_camera_prim), float)
    rotation = relative[:3, :3] / np.linalg.norm(relative[:3, :3], axis=0)
    return relative[:3, 3].copy(), rotation
