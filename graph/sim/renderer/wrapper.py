"""Wraps a sensor, to observe, delay or corrupt its frames. Methods are documented in `Sensor`."""

# ruff: noqa: D102

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from enum import IntEnum
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from .schedule import Tick
from .sensor import Schedule, Sensor, SensorFrame

if TYPE_CHECKING:
    import numpy as np

    from .view import WorldView


class SensorWrapper:
    """Forwards everything to the wrapped sensor; a subclass overrides some methods."""

    def __init__(self, sensor: Sensor) -> None:
        self.sensor = sensor

    @property
    def path(self) -> str:
        return self.sensor.path

    @property
    def type_name(self) -> str:
        return self.sensor.type_name

    @property
    def schedule(self) -> Schedule:
        return self.sensor.schedule

    @property
    def rate(self) -> Fraction:
        return self.sensor.rate

    @property
    def rule(self) -> str:
        return self.sensor.rule

    @property
    def wants_updates(self) -> bool:
        return self.sensor.wants_updates

    @property
    def latency(self) -> Fraction:
        return self.sensor.latency

    def interval(self, tick: Tick) -> tuple[Fraction, Fraction]:
        return self.sensor.interval(tick)

    @property
    def aux_level(self) -> IntEnum:
        return self.sensor.aux_level

    @property
    def coords(self) -> str:
        return self.sensor.coords

    def require(
        self, owner: object, channels: Iterable[str], *, optional: Iterable[str] = (), ignore_aux: bool = False
    ) -> None:
        self.sensor.require(owner, channels, optional=optional, ignore_aux=ignore_aux)

    def release(self, owner: object) -> None:
        self.sensor.release(owner)

    def channels(self) -> frozenset[str]:
        return self.sensor.channels()

    def consumers(self) -> Mapping[str, Sequence[str]]:
        return self.sensor.consumers()

    def refresh(self) -> bool:
        return self.sensor.refresh()

    def reset(self) -> None:
        self.sensor.reset()

    def advance(self, start: Fraction, end: Fraction, scene: WorldView) -> None:
        self.sensor.advance(start, end, scene)

    def render(self, tick: Tick) -> SensorFrame | None:
        return self.sensor.render(tick)

    def pose(self, poses: Any = None) -> np.ndarray:
        return self.sensor.pose(poses)

    def has_stable_ids(self) -> bool:
        return self.sensor.has_stable_ids()

    def object_ids(self, *, resolve_all: bool = False) -> dict[int, str]:
        return self.sensor.object_ids(resolve_all=resolve_all)

    def packed_object_ids(self) -> np.ndarray | None:
        return self.sensor.packed_object_ids()

    def class_labels(self) -> dict[int, dict[str, str]]:
        return self.sensor.class_labels()


def unwrapped(sensor: Sensor) -> Sensor:
    """The innermost sensor."""
    while isinstance(sensor, SensorWrapper):
        sensor = sensor.sensor
    return sensor
