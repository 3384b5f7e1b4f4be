"""`camera.noise` on: what an imager makes of light, in whole electrons.

A pixel holds e = full well x signal electrons, where a signal of 1 is white. They vary by shot noise (variance e) and
by reading them out; pixels differ in gain and offset, always in the same way (EMVA 1288).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from graph.base.errors import UserError
from graph.base.records import dataclass
from sensors.prim import path_number

from .names import numbers_of

if TYPE_CHECKING:
    from pxr import Usd

PREFIX = "tickgraph:noise:"
FRAME, PATTERN = 0, 1
"""Random streams: of each frame; of the camera."""


@dataclass(frozen=True, slots=True)
class ImageNoise:
    """full_well: electrons in a white pixel. read: standard deviation of reading out [electrons]. gain, offset: their
    standard deviations from pixel to pixel, relative and in electrons.
    """

    full_well: float = 10_000.0
    read: float = 5.0
    gain: float = 0.0
    offset: float = 0.0

    def applied(self, signal: np.ndarray, seed: int, path: str, frame: int) -> np.ndarray:
        """The signal (n, 3) float32, 1 is white, as read from the imager of a camera in its frame number `frame`."""
        electrons = np.clip(np.nan_to_num(signal), 0.0, 1.0) * np.float32(self.full_well)
        deviation = np.sqrt(electrons + np.float32(self.read**2))
        if self.gain or self.offset:
            pattern = _generator(seed, path, PATTERN)
            electrons *= 1 + np.float32(self.gain) * pattern.standard_normal(signal.shape, np.float32)
            electrons += np.float32(self.offset) * pattern.standard_normal(signal.shape, np.float32)
        electrons += deviation * _generator(seed, path, FRAME, frame).standard_normal(signal.shape, np.float32)
        np.rint(electrons, out=electrons)
        np.clip(electrons, 0.0, self.full_well, out=electrons)
        return np.asarray(electrons / np.float32(self.full_well))


ATTRIBUTES = {f"{PREFIX}{name}": "float" for name in ("fullWell", "readNoise", "gainDeviation", "offsetDeviation")}
"""Attributes of Camera prims that hold the fields of `ImageNoise`."""


def read_noise(prim: Usd.Prim) -> ImageNoise:
    """The noise by a camera's attributes; unset ones have the defaults. Raises UserError for wrong numbers."""
    found = []
    for name, default in zip(ATTRIBUTES, (10_000.0, 5.0, 0.0, 0.0), strict=True):
        attribute = prim.GetAttribute(name)
        value = attribute.Get() if attribute else None
        numbers = (default,) if value is None else numbers_of(value, 1)
        least = 1.0 if name.endswith("fullWell") else 0.0
        if numbers is None or not least <= numbers[0] <= 1e9:
            raise UserError(f"{prim.GetPath()}.{name} is {value}; give a number from {least:g} to 1e9")
        found.append(numbers[0])
    return ImageNoise(*found)


def _generator(seed: int, path: str, *stream: int) -> np.random.Generator:
    """Random numbers that follow from the App's seed, the camera's path and the stream alone."""
    return np.random.default_rng([seed & (2**64 - 1), path_number(path), *stream])
