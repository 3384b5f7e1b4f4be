"""AcousticSensor: an acoustic sensor at work, its render product, annotators and writers."""

from __future__ import annotations

from sensors.sensor import PointSensor

from .authoring import Acoustic
from .runtime import AcousticRuntime


class AcousticSensor(PointSensor[Acoustic, AcousticRuntime]):
    """Renders an acoustic sensor: `AcousticSensor(acoustic_or_path, annotators=["generic-model-output"])`."""

    authored_by = Acoustic

    @property
    def acoustic(self) -> Acoustic:
        """The Acoustic."""
        return self.authoring_object
