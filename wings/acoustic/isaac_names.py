"""The acoustic sensors of `isaacsim.sensors.experimental.rtx`."""

from __future__ import annotations

from typing import Any

from graph.isaac.modules.sensors_rtx import Product, Wrapping, data_of

from .authoring import SUPPORTED_ACOUSTIC_CONFIGS
from .authoring import Acoustic as OurAcoustic
from .sensor import AcousticSensor as OurAcousticSensor

__all__ = ["SUPPORTED_ACOUSTIC_CONFIGS", "Acoustic", "AcousticSensor"]


class Acoustic(Wrapping, OurAcoustic): ...


class AcousticSensor(Product, OurAcousticSensor):
    def __init__(self, path: Any, **options: Any) -> None:
        super().__init__(Acoustic(path) if isinstance(path, str) else path, **options)

    def get_data(self, annotator: str, device: str | None = None, *, out: Any = None) -> Any:
        return data_of(super().get_data(annotator, device), out)
