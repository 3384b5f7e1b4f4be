"""Acoustic sensors: what mounts hear of the pulses that others of the same sensor send."""

from __future__ import annotations

from typing import TYPE_CHECKING

from graph.base.lazy_names import lazy_names as _lazy_names

if TYPE_CHECKING:
    from .authoring import SUPPORTED_ACOUSTIC_CONFIGS, Acoustic
    from .config import AcousticConfig
    from .sensor import AcousticSensor

_HOMES = {
    "SUPPORTED_ACOUSTIC_CONFIGS": "authoring",
    "Acoustic": "authoring",
    "AcousticConfig": "config",
    "AcousticSensor": "sensor",
}

__all__ = ["SUPPORTED_ACOUSTIC_CONFIGS", "Acoustic", "AcousticConfig", "AcousticSensor"]

__getattr__, __dir__ = _lazy_names(__name__, _HOMES)
