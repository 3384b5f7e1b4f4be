"""Textures: what an image gives at a place, as UsdUVTexture has it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .image_files import Image

WRAPS = ("repeat", "clamp", "mirror", "black")
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

    def at(self, st: np.ndarray) -> np.ndarray:
        """(k, 4) float32 linear, between the four nearest pixels; st: (k, 2), (0, 0) is below on the left."""
        out = np.empty((len(st), 4), np.float32)
        for first in range(0, len(st), CHUNK):
            out[first : first + CHUNK] = self._between(st[first : first + CHUNK])
        return np.asarray(out * self.scale + self.bias)

    def _between(self, st: np.ndarray) -> np.ndarray:
        height, width = self.image.pixels.shape[:2]
        with np.errstate(invalid="ignore", over="ignore"):
            places = np.stack([st[:, 0] * width - 0.5, (1 - st[:, 1]) * height - 0.5])
        places = np.where(np.abs(places) < 2**30, places, 0.0)
        low = np.floor(places)
        share = (places - low).astype(np.float32)
        low = low.astype(np.int64)
        total = np.zeros((len(st), 4), np.float32)
        for right in (0, 1):
            columns, wide = _wrapped(low[0] + right, width, self.wraps[0])
            weight = wide * (share[0] if right else 1 - share[0])
            for down in (0, 1):
                rows, tall = _wrapped(low[1] + down, height, self.wraps[1])
                found = self.linear(self.image.pixels[rows, columns])
                total += found * (weight * tall * (share[1] if down else 1 - share[1]))[:, None]
        return total

    def linear(self, numbers: np.ndarray) -> np.ndarray:
        """Pixels (k, channels) as linear red, green, blue, alpha."""
        out = np.ones((len(numbers), 4), np.float32)
        channels = numbers.shape[1]
        if self.image.rgbe:
            exponent = numbers[:, 3:].astype(np.int32) - 136
            out[:, :3] = np.where(numbers[:, 3:] > 0, np.ldexp(numbers[:, :3].astype(np.float32), exponent), 0)
            return out
        out[:, :3] = np.take(self.table, numbers[:, :3] if channels >= 3 else numbers[:, :1])
        if channels in (2, 4):
            out[:, 3] = numbers[:, -1] / np.float32(len(self.table) - 1)
        return out


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
