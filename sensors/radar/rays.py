"""The rays of a radar: a fan over its field of view, and finer ones over what is small in it."""

from __future__ import annotations

from dataclasses import dataclass, fields

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

    directions: (3, n) float64 unit. azimuth, elevation: (n,) sines of the angles. width, height: (n,) angles across and
    up [rad]. solid: (n,) solid angles [sr]. sends, hears: (n,) gains of the antennas along the rays. weight: (n,)
    solid x sends x hears. wide: (n,) how many tubes across, and up, each stands for once it was reflected; 0 of those
    that are not followed. All but the directions are float32.
    """

    directions: np.ndarray
    azimuth: np.ndarray
    elevation: np.ndarray
    width: np.ndarray
    height: np.ndarray
    solid: np.ndarray
    sends: np.ndarray
    hears: np.ndarray
    weight: np.ndarray
    wide: np.ndarray

    def __len__(self) -> int:
        return len(self.solid)

    def with_room(self, more: int) -> Tubes:
        """The same at the begin of arrays with room for more."""
        columns = (getattr(self, each.name) for each in fields(self))
        return Tubes(*(np.concatenate((one, np.empty((*one.shape[:-1], more), one.dtype)), -1) for one in columns))

    def and_more(self, count: int, more: Tubes) -> Tubes:
        """The first `count`, and more after them, in the room of these."""
        whole = {}
        for each in fields(self):
            column = getattr(self, each.name)[..., : count + len(more)]
            column[..., count:] = getattr(more, each.name)
            whole[each.name] = column
        return Tubes(**whole)

    def tangential(self, rows: np.ndarray, vectors: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The components (k,) of vectors (3, k) in the sensor frame across (growing azimuth) and up of some rays."""
        x, y, z = (np.take(column, rows) for column in self.directions)
        level = np.sqrt(1.0 - z * z)
        across = (x * vectors[1] - y * vectors[0]) / level
        up = vectors[2] * level - (x * vectors[0] + y * vectors[1]) * (z / level)
        return across, up


def grid(
    azimuth: tuple[float, float],
    elevation: tuple[float, float],
    across: int,
    up: int,
    antenna: Antenna,
    *,
    stride: int = 1,
) -> Tubes:
    """Equal steps of azimuth and elevation [rad] between two ends; the middle of each is a ray.

    stride: every so many are followed after a reflection, across and up.
    """
    da, de = (azimuth[1] - azimuth[0]) / across, (elevation[1] - elevation[0]) / up
    a = azimuth[0] + (np.arange(across) + 0.5) * da
    e = elevation[0] + (np.arange(up) + 0.5) * de
    level, sine = np.cos(e), np.sin(a)
    directions = np.empty((3, up, across))
    np.multiply(level[:, None], np.cos(a), out=directions[0])
    np.multiply(level[:, None], sine, out=directions[1])
    directions[2] = np.sin(e)[:, None]
    flat = directions.reshape(3, up * across)
    followed = (np.arange(up) % stride == 0)[:, None] & (np.arange(across) % stride == 0)
    solid = _rows(da * (np.sin(e + de / 2) - np.sin(e - de / 2)), across)
    sends, hears = (np.asarray(gain(flat), np.float32) for gain in (antenna.sends, antenna.hears))
    return Tubes(
        flat,
        np.tile(sine.astype(np.float32), up),
        _rows(np.sin(e), across),
        _rows(da * level, across),
        np.full(up * across, de, np.float32),
        solid,
        sends,
        hears,
        solid * sends * hears,
        np.where(followed, np.float32(stride), np.float32(0)).ravel(),
    )


def _rows(values: np.ndarray, across: int) -> np.ndarray:
    return np.repeat(values.astype(np.float32), across)


def joined(parts: list[Tubes]) -> Tubes:
    """Several as one."""
    return Tubes(*(np.concatenate([getattr(part, each.name) for part in parts], -1) for each in fields(Tubes)))


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
) -> tuple[Tubes, np.ndarray] | None:
    """A grid over each window, of square steps as far as whole numbers of them allow, and the numbers (n,) int32 of
    the windows of its rays; None for no window.

    rays: of the fan. Windows beyond their `SHARE` are left out, and keep the rays of the fan.
    """
    budget = rays // SHARE
    found = found[: max(0, budget // LEAST_EACH)]
    if not found:
        return None
    each = min(MOST_EACH, budget // len(found))
    parts = []
    for _, azimuth, elevation in found:
        wide, tall = azimuth[1] - azimuth[0], elevation[1] - elevation[0]
        across = int(np.clip(round(float(np.sqrt(each * wide / tall))), 1, each))
        parts.append(grid(azimuth, elevation, across, max(1, each // across), antenna))
    owner = np.repeat(np.array([number for number, *_ in found], np.int32), [len(part) for part in parts])
    return joined(parts), owner
