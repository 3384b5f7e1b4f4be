"""Render products: what joins a sensor's runtime, its schedule and its frames."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from typing import Any, Protocol

from .schedule import EveryUpdate, Tick, TickSchedule


class SensorRuntime(Protocol):
    """What the scheduler asks of a sensor.

    A runtime with `wants_updates` also has `advance(start, end, poses)`: it is called in every update in which the
    external time moved, before a tick of that update is rendered. `reset()` forgets frames and unfinished scans.
    """

    schedule: TickSchedule | EveryUpdate
    wants_updates: bool

    @property
    def rate(self) -> Fraction:
        """The tick rate [Hz]; 0 renders every update."""

    def render(self, tick: Tick) -> Any:
        """The frame of a tick, or None if there is nothing to deliver."""

    def reset(self) -> None:
        """Forgets everything measured so far."""


class RenderProduct:
    """One sensor's output at one size; exists from external time `created_at` [s]."""

    def __init__(
        self,
        path: str,
        camera_path: str,
        resolution: tuple[int, int],
        sensor: SensorRuntime,
        created_at: Fraction | None = None,
    ) -> None:
        self.path = path
        self.camera_path = camera_path
        self.resolution = resolution
        self.sensor = sensor
        self.created_at = created_at
        self.writers: list[Callable[[Any], object]] = []
        """Called with each new frame, in order, before the post-render graphs."""
        self.on_enabled: Callable[[RenderProduct], None] = lambda product: None
        self._enabled = True
        self.advanced_to = Fraction(0)
        """External time [s] up to which a sensor that wants updates has been advanced."""
        self.capture: Any = None
        self.capture_index = 0
        self.clear()

    def clear(self) -> None:
        """Forgets frames and counts."""
        self.frame: Any = None
        self.new_frame = False
        self.frames = 0
        self.elements = 0
        self.first_frame_ns: int | None = None
        self.last_frame_ns: int | None = None
        self._missed_before = 0

    @property
    def enabled(self) -> bool:
        """A disabled product renders nothing; enabling it again counts as creating it."""
        return self._enabled

    @enabled.setter
    def enabled(self, enabled: bool) -> None:
        if enabled != self._enabled:
            self._enabled = enabled
            self.on_enabled(self)

    @property
    def missed(self) -> int:
        """Grid times passed over because an update rendered a newer one."""
        return self._missed_before + self.sensor.schedule.missed

    @property
    def due(self) -> int:
        """Ticks that fell due: frames delivered and ticks missed."""
        return self.frames + self.missed

    @property
    def is_frozen(self) -> bool:
        """Whether a tick looks at the captured state of its own grid time."""
        return self.sensor.schedule.accumulates and not self.sensor.wants_updates

    def restart(self, moment: Fraction) -> None:
        """Begins the schedule anew at external time `moment`; what was counted stays."""
        self._missed_before = self.missed
        self.created_at = self.advanced_to = moment
        self.sensor.schedule.restart(moment)
        self.capture, self.capture_index = None, 0

    def deliver(self, frame: Any) -> None:
        """Takes a new frame; counts it by its `count` and `timestamp_ns`, where it has them."""
        self.frame = frame
        self.new_frame = True
        self.frames += 1
        self.elements += getattr(frame, "count", 0)
        stamp = getattr(frame, "timestamp_ns", None)
        if stamp is not None:
            self.last_frame_ns = stamp
            if self.first_frame_ns is None:
                self.first_frame_ns = stamp
