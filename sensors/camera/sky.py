"""Skies with an image: what they show in a direction, and how much light they bring to a surface.

Images are latitude-longitude maps as UsdLux has them: the dome's +Y is on top, its +Z in the middle, +X a quarter to
the left of it. Irradiance is the sum of nine spherical harmonics (Ramamoorthi and Hanrahan, 2001): exact for skies that
vary slowly, on average within a few percent for others; hidden parts of the sky are not taken off.
"""

from __future__ import annotations

import numpy as np

from graph.base.records import dataclass
from graph.sim.transforms import apply

from .textures import Texture

COARSE = 64
"""Rows of the image that stands for the sky where surfaces are lit; twice as many columns."""
SHARES = np.array([np.pi, *[2 * np.pi / 3] * 3, *[np.pi / 4] * 5])
"""How much of each harmonic of radiance is left of it in irradiance."""


@dataclass(frozen=True, eq=False)
class SkyImage:
    """An image about the world, which does not move. harmonics: (9, 3) of its irradiance."""

    texture: Texture
    harmonics: np.ndarray


@dataclass(frozen=True, eq=False)
class Sky:
    """A dome in one state of the world. color: (3,) float32 [nit], times the image. turn: (3, 3), world to dome."""

    image: SkyImage
    color: np.ndarray
    turn: np.ndarray

    def radiance(self, directions: np.ndarray) -> np.ndarray:
        """(k, 3) float32 [nit] from unit directions (3, k), world axes."""
        x, y, z = apply(self.turn.astype(np.float32), directions, axis=0)
        s = 0.5 - np.arctan2(x, z) / np.float32(2 * np.pi)
        t = 1 - np.arccos(np.clip(y, -1, 1)) / np.float32(np.pi)
        return np.asarray(self.image.texture.at(np.stack([s, t]), range(3)) * self.color)

    def irradiance(self, normals: np.ndarray) -> np.ndarray:
        """(3, k) float32 [lux] on surfaces with normals (3, k), world axes."""
        local = apply(self.turn.astype(np.float32), normals, axis=0)
        found = apply(self.image.harmonics.T.astype(np.float32), harmonics(local), axis=0)
        return np.asarray(np.maximum(found, np.float32(0)) * self.color[:, None])


def sky_image(texture: Texture) -> SkyImage:
    """An image of a sky with its harmonics."""
    colors = _pooled(texture)
    rows, columns = colors.shape[:2]
    edges = np.cos(np.linspace(0, np.pi, rows + 1))
    share = (edges[:-1] - edges[1:]) * 2 * np.pi / columns  # solid angle of a pixel of each row
    polar = np.pi * (np.arange(rows) + 0.5) / rows
    azimuth = np.pi * (1 - 2 * (np.arange(columns) + 0.5) / columns)
    ways = np.stack(
        [
            np.outer(np.sin(polar), np.sin(azimuth)),
            np.outer(np.cos(polar), np.ones(columns)),
            np.outer(np.sin(polar), np.cos(azimuth)),
        ]
    )
    weighted = (colors * share[:, None, None]).reshape(-1, 3)
    return SkyImage(texture, SHARES[:, None] * (harmonics(ways.reshape(3, -1)) @ weighted))


def harmonics(ways: np.ndarray) -> np.ndarray:
    """(9, k), the real spherical harmonics of the orders 0, 1 and 2 for unit vectors (3, k)."""
    x, y, z = ways
    third = np.sqrt(15 / (4 * np.pi)).astype(ways.dtype)
    return np.stack(
        [
            np.full_like(x, np.sqrt(1 / (4 * np.pi))),
            *(np.sqrt(3 / (4 * np.pi)).astype(ways.dtype) * each for each in (y, z, x)),
            *(third * each for each in (x * y, y * z, x * z)),
            np.sqrt(5 / (16 * np.pi)).astype(ways.dtype) * (3 * z * z - 1),
            third / 2 * (x * x - y * y),
        ]
    )


def _pooled(texture: Texture) -> np.ndarray:
    """(COARSE, 2 COARSE, 3) float64: means of an image's blocks; the pixels of a smaller one repeat."""
    height, width = texture.image.pixels.shape[1:]
    rows, columns = (_starts(size, most) for size, most in ((height, COARSE), (width, 2 * COARSE)))
    out = np.empty((COARSE, 2 * COARSE, 3))
    counts = np.maximum(np.diff([*columns, width]), 1)
    for number, (first, last) in enumerate(zip(rows, [*rows[1:], height], strict=True)):
        block = np.arange(first * width, max(last, first + 1) * width)
        for channel in range(3):
            line = texture.linear(block, channel).reshape(-1, width).mean(axis=0, dtype=np.float64)
            out[number, :, channel] = np.add.reduceat(line, columns) / counts
    return np.asarray(out * texture.scale[:3] + texture.bias[:3])


def _starts(size: int, most: int) -> np.ndarray:
    """Where each of `most` blocks of an axis begins."""
    return np.arange(most) * size // most
