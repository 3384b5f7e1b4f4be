"""`isaacsim.ros2.bridge`."""

from __future__ import annotations

from .interfaces import read_camera_info

__all__ = ["read_camera_info"]
