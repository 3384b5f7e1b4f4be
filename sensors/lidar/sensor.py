"""LidarSensor: a lidar with its render product, annotators and writers."""

from __future__ import annotations

from sensors.sensor import PointSensor

from .authoring import Lidar
from .runtime import LidarRuntime


class LidarSensor(PointSensor[Lidar, LidarRuntime]):
    """Renders a lidar: `LidarSensor(lidar_or_path, annotators=["generic-model-output"])`."""

    authored_by = Lidar

    @property
    def lidar(self) -> Lidar:
        """The Lidar."""
        return self.authoring_object
