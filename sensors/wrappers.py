"""Wrappers between a sensor of any modality and its readers: delay and noise.

After `product.sensor = Delayed(product.sensor, seconds="0.03")` the frames of a render product come 0.03 s later.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from fractions import Fraction

import numpy as np

from graph.base import exact
from graph.sim.renderer.schedule import Tick
from graph.sim.renderer.sensor import Sensor, SensorFrame
from graph.sim.renderer.wrapper import SensorWrapper

from .errors import SensorValueError
from .frame import Frame
from .prim import path_number

Corruptor = Callable[[np.ndarray, np.random.Generator], np.ndarray]
"""A channel's array and a random generator -> the array to give instead, of the same dtype and shape."""


class Delayed(SensorWrapper):
    """Gives frames later: in the first update at or after the end of their interval plus the delay.

    Stamps and poses stay those of the measurement. seconds: an exact number (Fraction, text such as "0.03" or "1/30", a
    float as its shortest decimal). ticks: the delay as a number of the sensor's own ticks. At most one frame is given
    in an update. Raises SensorValueError unless exactly one of the two is given and not negative, and for ticks of a
    sensor that renders in every update.
    """

    def __init__(
        self, sensor: Sensor, *, seconds: int | float | str | Fraction | None = None, ticks: int | None = None
    ) -> None:
        super().__init__(sensor)
        if (seconds is None) == (ticks is None):
            raise SensorValueError(f"{sensor.path}: give a delay in seconds or in ticks")
        if ticks is not None and not sensor.rate:
            raise SensorValueError(f"{sensor.path}: it renders in every update; give its delay in seconds")
        try:
            self._delay = Fraction(ticks) / sensor.rate if ticks is not None else exact.rate(seconds or 0)
        except ValueError as error:
            raise SensorValueError(f"{sensor.path}: delay: {error}") from error
        if self._delay < 0:
            raise SensorValueError(f"{sensor.path}: a delay cannot be negative")
        self._ticks = ticks

    @property
    def latency(self) -> Fraction:
        """The delay, on top of the sensor's own [s]; ticks follow changes of the rate."""
        rate = self.sensor.rate
        own = self._ticks / rate if self._ticks is not None and rate else self._delay
        return self.sensor.latency + own


class Corrupted(SensorWrapper):
    """Adds errors to channels of each frame:

    `corruptors` maps a channel to a function of its array and a random generator.

    The random numbers depend on the seed and the sensor's path, and start again with each play: other sensors and
    threads do not change them. A channel that a frame does not hold is skipped.
    """

    def __init__(self, sensor: Sensor, corruptors: Mapping[str, Corruptor], *, seed: int = 0) -> None:
        super().__init__(sensor)
        self._corruptors = dict(corruptors)
        self._seed = (seed, path_number(sensor.path))
        self._generator = np.random.default_rng(self._seed)

    def reset(self) -> None:
        """Restarts the random numbers."""
        super().reset()
        self._generator = np.random.default_rng(self._seed)

    def render(self, tick: Tick) -> SensorFrame | None:
        """The frame of a tick, with errors."""
        frame = super().render(tick)
        if not isinstance(frame, Frame):
            return frame
        arrays = dict(frame.arrays)
        for name, corrupt in self._corruptors.items():
            if name in arrays:
                arrays[name] = self._checked(name, arrays[name], corrupt(arrays[name].copy(), self._generator))
        return replace(frame, arrays=arrays, cache={})

    def _checked(self, name: str, given: np.ndarray, spoilt: np.ndarray) -> np.ndarray:
        spoilt = np.asarray(spoilt, given.dtype)
        if spoilt.shape != given.shape:
            raise SensorValueError(
                f"{self.path}: the corruptor of {name} made shape {spoilt.shape} of {given.shape}; keep the shape"
            )
        return spoilt
