"""The rays of a radar: a fan over its field of view, and finer ones over what is small in it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from .antenna import Antenna

FEW = 400
"""A mesh that fewer rays of the fan may meet gets rays of its own."""

MOST_EACH = 16_384
LEAST_EACH = 64
SHARE = 4
"""All meshes together get at most one ray for so many of the fan."""


@dataclass(frozen=True, slots=True)
class Tubes:
    """Rays as tubes that fill a solid angle, in the sensor frame; n of them.

    directions: (3, n) float64 unit. azimuth: (n,) sines of their azimuths. width, height: (n,) angles across and up
    [rad]. solid: (n,) solid angles [sr]. owner: (n,) int32, the only surface whose hits count, or -1 for all. leads:
    (n,) bool, the rays that are followed on after a reflection, each for `stride` x `stride` of them. sends, hears:
    (n,) gains of the antennas along the rays.
    """

    directions: np.ndarray
    azimuth: np.ndarray
    width: np.ndarray
    height: np.ndarray
    solid: np.ndarray
    owner: np.ndarray
    leads: np.ndarray
    sends: np.ndarray
    hears: np.ndarray
    stride: int = 1

    def thinned(self) -> Tubes:
        """The tubes of the rays that lead, as wide as what each stands for; numbered as all are."""
        if self.stride == 1:
            return self
        wide = self.stride
        width, height, solid = self.width * wide, self.height * wide, self.solid * wide**2
        return replace(self, width=width, height=height, solid=solid, stride=1)

    def tangents(self, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Unit vectors (3, k) across (growing azimuth) and up of some rays."""
        x, y, z = self.directions[:, rows]
        level = np.hypot(x, y)
        zero = np.zeros_like(level)
        return np.stack((-y / level, x / level, zero)), np.stack((-z * x / level, -z * y / level, level))


def grid(
    azimuth: tuple[float, float],
    elevation: tuple[float, float],
    across: int,
    up: int,
    antenna: Antenna,
    *,
    owner: int = -1,
    stride: int = 1,
) -> Tubes:
    """Equal steps of azimuth and elevation [rad] between two ends; the middle of each is a ray."""
    da, de = (azimuth[1] - azimuth[0]) / across, (elevation[1] - elevation[0]) / up
    a = azimuth[0] + (np.arange(across) + 0.5) * da
    e = elevation[0] + (np.arange(up) + 0.5) * de
    level, sine = np.cos(e), np.sin(a)
    directions = np.empty((3, up, across))
    np.multiply(level[:, None], np.cos(a), out=directions[0])
    np.multiply(level[:, None], sine, out=directions[1])
    directions[2] = np.sin(e)[:, None]
    count = across * up
    flat = directions.reshape(3, count)
    return Tubes(
        flat,
        np.tile(sine, up),
        np.repeat(da * level, across),
        np.full(count, de),
        np.repeat(da * (np.sin(e + de / 2) - np.sin(e - de / 2)), across),
        np.full(count, owner, np.int32),
        ((np.arange(up) % stride == 0)[:, None] & (np.arange(across) % stride == 0)).ravel(),
        antenna.sends(flat),
        antenna.hears(flat),
        stride,
    )


def joined(parts: list[Tubes]) -> Tubes:
    """Several bundles as one."""
    names = ("directions", "azimuth", "width", "height", "solid", "owner", "leads", "sends", "hears")
    found: dict[str, Any] = {name: np.concatenate([getattr(part, name) for part in parts], axis=-1) for name in names}
    return Tubes(**found)


def windows(
    corners: np.ndarray, azimuth_limit: float, elevations: tuple[float, float], step: float, reach: float
) -> list[tuple[int, tuple[float, float], tuple[float, float]]]:
    """(number, azimuths, elevations) of the boxes that few rays of a fan meet, nearest first.

    corners: (s, 8, 3) float64 in the sensor frame [m]; NaN for what has no box. step: the fan's [rad].
    """
    x, y, z = np.moveaxis(corners, 2, 0)
    level = np.hypot(x, y)
    with np.errstate(invalid="ignore"):
        azimuth, elevation = np.arctan2(y, x), np.arctan2(z, level)
        ahead = (x.min(axis=1) > 0) & (level.min(axis=1) > 0)
        near = np.sqrt((corners.mean(axis=1) ** 2).sum(axis=1))
    low_a, high_a = (np.clip(f(azimuth, axis=1), -azimuth_limit, azimuth_limit) for f in (np.min, np.max))
    low_e, high_e = (np.clip(f(elevation, axis=1), *elevations) for f in (np.min, np.max))
    wide, tall = high_a - low_a, high_e - low_e
    chosen = ahead & (wide > 0) & (tall > 0) & (wide * tall < FEW * step**2) & (near < reach)
    order = np.flatnonzero(chosen)
    order = order[np.argsort(near[order], kind="stable")]
    return [(int(i), (float(low_a[i]), float(high_a[i])), (float(low_e[i]), float(high_e[i]))) for i in order]


def finer(
    found: list[tuple[int, tuple[float, float], tuple[float, float]]], rays: int, antenna: Antenna
) -> Tubes | None:
    """A grid over each window, of square steps as far as whole numbers of them allow; None for no window.

    rays: of the fan. Windows beyond their `SHARE` are left out, and keep the rays of the fan.
    """
    budget = rays // SHARE
    found = found[: max(0, budget // LEAST_EACH)]
    if not found:
        return None
    each = min(MOST_EACH, budget // len(found))
    parts = []
    for number, azimuth, elevation in found:
        wide, tall = azimuth[1] - azimuth[0], elevation[1] - elevation[0]
        across = int(np.clip(round(float(np.sqrt(each * wide / tall))), 1, each))
        parts.append(grid(azimuth, elevation, across, max(1, each // across), antenna, owner=number))
    return joined(parts)
