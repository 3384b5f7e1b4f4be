"""`isaacsim.ros2.bridge`."""

from __future__ import annotations

from typing import Any

import numpy as np

from graph.isaac.session import app
from nodes.ros2.camera_info_helper import IDENTITY, lens_of, projection
from nodes.ros2.camera_messages import PINHOLE, distortion_of, matrix_of

from .rclpy import message_class
from .viewport_manager import ViewportManager

__all__ = ["read_camera_info"]


def read_camera_info(render_product_path: str) -> tuple[Any, Any]:
    """The CameraInfo of a render product's camera, whose k, r and p are arrays, and the camera's prim."""
    camera = ViewportManager.get_camera(render_product_path)
    lens = lens_of(app().rendering.products[str(getattr(render_product_path, "path", render_product_path))])
    info: Any = message_class("sensor_msgs/msg/CameraInfo")()
    k = matrix_of(lens, square=False)
    info.width, info.height = lens.width, lens.height
    info.distortion_model, coefficients = distortion_of(lens) or PINHOLE
    info.d = [float(one) for one in coefficients]
    info.k, info.r, info.p = np.array(k), np.array(IDENTITY), np.array(projection(k))
    return info, camera.GetPrim()
