"""Textures: what an image gives at a place, as UsdUVTexture has it."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from graph.base.records import dataclass

from .image_files import Image

WRAPS = ("repeat", "clamp", "mirror", "black")
HALF = np.float32(0.5)
FARTHEST = 2.0**30
"""Places beyond so many pixels count as 0."""

CHUNK = 1 << 14
"""Places that are looked up at a time: as many as fit into the caches."""


@dataclass(frozen=True, eq=False)
class Texture:
    """An image with its way of being looked up.

    table: from a pixel's number to linear light, (256,) or (65536,) float32; alpha is linear always. wraps: beyond the
    image along s and t, of `WRAPS`. scale, bias: (4,) float32, of red, green, blue and alpha.
    """

    image: Image
    table: np.ndarray
    wraps: tuple[str, str]
    scale: np.ndarray
    bias: np.ndarray

    def at(self, st: np.ndarray, channels: Sequence[int] = range(4)) -> np.ndarray:
        """(k, n) float32 linear, between the four nearest pixels, of some channels: red, green, blue, alpha.

        st: (2, k); (0, 0) is below on the left.
        """
        out = np.empty((st.shape[1], len(channels)), np.float32)
        for first in range(0, len(out), CHUNK):
            rows = slice(first, first + CHUNK)
            four = self._four(st[:, rows])
            for channel in set(channels):
                index, weight = four[0]
                found = self.linear(index, channel) * weight
                for index, weight in four[1:]:
                    found += self.linear(index, channel) * weight
                found = found * self.scale[channel] + self.bias[channel]
                for column in (number for number, each in enumerate(channels) if each == channel):
                    out[rows, column] = found
        return out

    def mean(self, channels: Sequence[int]) -> tuple[float, ...]:
        """The mean of some channels over the image."""
        every = np.arange(self._planes.shape[1])
        found = [self.linear(every, each).mean() * self.scale[each] + self.bias[each] for each in channels]
        return tuple(map(float, found))

    def linear(self, index: np.ndarray, channel: int) -> np.ndarray:
        """(k,) float32, a channel of the pixels `index` (k,), counted row by row; without scale and bias."""
        planes = self._planes
        if channel == 3:
            if len(planes) not in (2, 4) or self.image.rgbe:
                return np.ones(len(index), np.float32)
            return np.asarray(np.take(planes[-1], index) / np.float32(len(self.table) - 1))
        numbers = np.take(planes[channel if len(planes) >= 3 else 0], index)
        if not self.image.rgbe:
            return np.asarray(np.take(self.table, numbers))
        exponent = np.take(planes[3], index)
        return np.where(exponent > 0, np.ldexp(numbers.astype(np.float32), exponent.astype(np.int32) - 136), 0)

    @cached_property
    def _planes(self) -> np.ndarray:
        return self.image.pixels.reshape(len(self.image.pixels), -1)

    def _four(self, st: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
        """The four nearest pixels of each place and their shares."""
        height, width = self.image.pixels.shape[1:]
        with np.errstate(invalid="ignore", over="ignore"):
            across, down = st[0] * np.float32(width) - HALF, (1 - st[1]) * np.float32(height) - HALF
        columns, rows = _pair(across, width, self.wraps[0]), _pair(down, height, self.wraps[1])
        return [(row * width + column, wide * tall) for row, tall in rows for column, wide in columns]


def _pair(places: np.ndarray, size: int, wrap: str) -> list[tuple[np.ndarray, np.ndarray]]:
    """Along an axis of `size` pixels, the two about each place and their shares."""
    places = np.where(np.abs(places) < FARTHEST, places, np.float32(0))
    low = np.floor(places)
    share = places - low
    low = low.astype(np.int64)
    found = []
    for index, part in ((low, 1 - share), (low + 1, share)):
        inside, counts = _wrapped(index, size, wrap)
        found.append((inside, part * counts))
    return found


def _wrapped(index: np.ndarray, size: int, wrap: str) -> tuple[np.ndarray, np.ndarray | np.float32]:
    """Indices within an axis of `size`, and how much each counts: 0 beyond the image for "black"."""
    if wrap == "clamp":
        return np.clip(index, 0, size - 1), np.float32(1)
    if wrap == "mirror":
        index = index % (2 * size)
        return np.where(index < size, index, 2 * size - 1 - index), np.float32(1)
    if wrap == "black":
        return np.clip(index, 0, size - 1), ((index >= 0) & (index < size)).astype(np.float32)
    return index % size, np.float32(1)


def linear_table(image: Image, space: str) -> np.ndarray:
    """From pixel numbers to linear light; space: "sRGB", "raw" or "auto" (sRGB for colours of 8 bits)."""
    count = 256 if image.pixels.dtype == np.uint8 else 65536
    x = np.arange(count) / (count - 1)
    if space == "sRGB" or (space != "raw" and image.colours):
        x = np.where(x <= 0.04045, x / 12.92, ((x + 0.055) / 1.055) ** 2.4)
    return x.astype(np.float32)
