"""Seeded noise of a radar: the same in every run, of its own for each frame and each kind."""

from __future__ import annotations

import numpy as np

from sensors.prim import path_number

_STREAMS = ("cells", "angles", "range", "velocity", "azimuth", "elevation", "rcs")


class Noise:
    """The noise of one frame: it follows from the App's seed, the radar's path and the frame's number alone."""

    def __init__(self, seed: int, path: str, frame: int) -> None:
        self._entropy = [seed & (2**64 - 1), path_number(path), frame]

    def normal(self, stream: str, count: int, mean: float, deviation: float) -> np.ndarray:
        """(count,) float64 normal numbers; of deviation 0 all are the mean."""
        if not deviation:
            return np.full(count, mean)
        return np.asarray(mean + deviation * self._generator(stream).standard_normal(count))

    def uniform(self, stream: str, count: int) -> np.ndarray:
        """(count,) float64 numbers from 0 to 1."""
        return self._generator(stream).random(count)

    def power(self, stream: str, shape: tuple[int, ...], mean: float, deviation: float) -> np.ndarray | None:
        """Noise power [W] of this shape, gamma distributed; None where both are 0.

        A deviation equal to the mean is that of a square-law detector: exponential. Of mean 0 it is the magnitude of a
        normal number, as power is not negative.
        """
        if not mean and not deviation:
            return None
        if not mean:
            return np.abs(deviation * self._generator(stream).standard_normal(shape))
        if not deviation:
            return np.full(shape, mean)
        return np.asarray(self._generator(stream).gamma((mean / deviation) ** 2, deviation**2 / mean, shape))

    def _generator(self, stream: str) -> np.random.Generator:
        return np.random.Generator(np.random.SFC64(np.random.SeedSequence([*self._entropy, _STREAMS.index(stream)])))
