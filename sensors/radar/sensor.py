"""RadarSensor: a radar at work, its render product, annotators and writers."""

from __future__ import annotations

from sensors.sensor import PointSensor

from .authoring import Radar
from .runtime import RadarRuntime


class RadarSensor(PointSensor[Radar, RadarRuntime]):
    """Renders a radar: `RadarSensor(radar_or_path, annotators=["generic-model-output"])`."""

    authored_by = Radar

    @property
    def radar(self) -> Radar:
        """The Radar."""
        return self.authoring_object
