"""Light that comes from what pixels show, and what becomes of it in an image.

L = emitted + base / pi (sum of E + pi sky): diffuse surfaces, lit from the side of the camera; one shadow ray for each
light. Not modelled: light from other surfaces, mirrors, glass, the sky's shadows, holes in shadows, blur.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from sensors.compiled import compiled
from sensors.raycast.rays import COMMON
from sensors.raycast.shadows import Shadows

from .lights import Lighting, irradiance
from .looks import Looks
from .view import View

CHUNK = 1 << 16
"""Pixels that are worked on at a time."""

BEYOND_WHITE = 1e6
"""Light beyond which the tone curve keeps still."""

SHADE_LEVELS = 1 << 18
"""Steps of the table from light to sRGB: the darkest step of an image has more than ten."""


def radiance(view: View, looks: Looks, lighting: Lighting, shadows: Shadows, state: Any) -> np.ndarray:
    """(n, 3) float32 [nit], what comes from what each ray met; the sky's where it met nothing."""
    out = np.empty((len(view.depth), 3), np.float32)
    there = np.isfinite(view.hits.distance)
    hit, missed = np.flatnonzero(there), np.flatnonzero(~there)
    out[missed] = lighting.sky
    if lighting.skies:
        directions = np.take(view.bundle.directions, missed, axis=1)
        for sky in lighting.skies:
            out[missed] += sky.radiance(directions)
    for first in range(0, len(hit), CHUNK):
        _shade(out, hit[first : first + CHUNK], view, looks, lighting, shadows, state)
    return out


def _shade(
    out: np.ndarray, rows: np.ndarray, view: View, looks: Looks, lighting: Lighting, shadows: Shadows, state: Any
) -> None:
    """Writes what comes from surfaces into the `rows` (k,) of `out` (n, 3)."""
    points, facing, above = _places(view, rows)
    lit = np.empty((3, len(rows)), np.float32)
    lit[:] = np.float32(np.pi) * lighting.sky[:, None]
    for sky in lighting.skies:
        lit += sky.irradiance(facing)
    for light in lighting.lights:
        light_there, place = irradiance(light, points, facing)
        if light.color.any():
            if light.shadows:
                towards = np.flatnonzero((light_there > 0).any(axis=0))
                ways = place if light.far else np.subtract(place, above)
                dark = shadows.blocked(view.bundle.origin, above, ways, towards, state, far=light.far)
                light_there[:, towards[dark]] = 0
            for axis in range(3):
                lit[axis] += light.color[axis] * light_there[axis % len(light_there)]

    def world_points(some: np.ndarray) -> np.ndarray:
        return view.rays.points(view.bundle, some, view.hits.distance[some])

    surfaces = view.hits.surfaces(rows)
    _reflect(out, rows, looks.base_of(view.hits, rows, surfaces, world_points), lit)
    if looks.emits:
        out[rows] += looks.emitted_of(view.hits, rows, surfaces)


def _places(view: View, rows: np.ndarray) -> np.ndarray:
    """(3, 3, k) float32 of what rays met: the points [m, from the origin of the rays], the normals, and the points from
    which shadow rays begin: float32 is off by so much at this distance.
    """
    found = np.empty((3, 3, len(rows)), np.float32)
    bundle, lift = view.bundle, view.lift
    _raise(
        rows,
        view.hits.distance,
        bundle.directions,
        COMMON if bundle.offsets is None else bundle.offsets,
        view.facing_normals(),
        _FLAT if lift is None else lift,
        found,
    )
    return found


_FLAT = np.zeros(1, np.float32)
"""The lift of all rays, where no surface is smooth."""


@compiled
def _raise(
    rows: np.ndarray,
    distance: np.ndarray,
    ways: np.ndarray,
    offsets: np.ndarray,
    normals: np.ndarray,
    lift: np.ndarray,
    out: np.ndarray,
) -> None:
    """ways: (3, n); offsets: (n, 3), lift: (n,), or one row for all rays; out: (3, 3, k) as of `_places`."""
    for at, ray in enumerate(rows):
        own = min(ray, len(offsets) - 1)
        height = np.float32(2e-4) + np.float32(2e-6) * distance[ray] + lift[min(ray, len(lift) - 1)]
        for axis in range(3):
            point = ways[axis, ray] * distance[ray] + offsets[own, axis]
            out[0, axis, at], out[1, axis, at] = point, normals[ray, axis]
            out[2, axis, at] = point + normals[ray, axis] * height


@compiled
def _reflect(out: np.ndarray, rows: np.ndarray, base: np.ndarray, lit: np.ndarray) -> None:
    """base / pi times the light (3, k) that falls there, into rows of `out` (n, 3); base: (k, 3)."""
    for at, row in enumerate(rows):
        for axis in range(3):
            out[row, axis] = base[at, axis] * (lit[axis, at] * np.float32(1 / np.pi))


def aces_curve(light: np.ndarray) -> np.ndarray:
    """Linear light bent from its darks to its highlights, 0 to 1: Narkowicz's fit to the ACES reference (2015)."""
    x = np.clip(np.nan_to_num(light), np.float32(0), np.float32(BEYOND_WHITE))
    return np.asarray(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), np.float32)


def srgb(light: np.ndarray) -> np.ndarray:
    """Linear light as bytes of sRGB (IEC 61966-2-1): 0 and below is 0, 1 and above 255."""
    out = np.empty(light.shape, np.uint8)
    _encode(np.ravel(light), SRGB, out.reshape(-1))
    return out


@compiled
def _encode(light: np.ndarray, table: np.ndarray, out: np.ndarray) -> None:
    for at in range(len(light)):
        share = min(light[at], np.float32(1)) if light[at] > 0 else np.float32(0)  # not a number: 0
        out[at] = table[int(share * np.float32(len(table) - 1) + np.float32(0.5))]


def _table() -> np.ndarray:
    x = np.arange(SHADE_LEVELS) / (SHADE_LEVELS - 1)
    curve = np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)
    return np.floor(255 * curve + 0.5).astype(np.uint8)


SRGB = _table()
"""(SHADE_LEVELS,) uint8, sRGB of light from 0 to 1."""
