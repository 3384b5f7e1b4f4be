"""Light that comes from what pixels show, and what becomes of it in an image.

L = emitted + base / pi (sum of E + pi sky): diffuse surfaces, lit from the side of the camera; one shadow ray for each
light. Not modelled: light from other surfaces, mirrors, glass, the sky's shadows, holes in shadows, blur.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from sensors.raycast.shadows import Shadows

from .lights import Light, Lighting, irradiance
from .materials import Looks
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
    out[:] = lighting.sky
    there = np.isfinite(view.hits.distance)
    if lighting.skies:
        missed = np.flatnonzero(~there)
        directions = np.take(view.bundle.directions, missed, axis=1)
        for sky in lighting.skies:
            out[missed] += sky.radiance(directions)
    hit = np.flatnonzero(there)
    normals = view.facing_normals()
    for first in range(0, len(hit), CHUNK):
        rows = hit[first : first + CHUNK]
        out[rows] = _reflected(view, rows, normals[rows], looks, lighting, shadows, state)
    return out


def _reflected(
    view: View,
    rows: np.ndarray,
    normals: np.ndarray,
    looks: Looks,
    lighting: Lighting,
    shadows: Shadows,
    state: Any,
) -> np.ndarray:
    surfaces = view.hits.surfaces(rows)
    facing = np.ascontiguousarray(normals.T)
    points = view.rays.offsets(view.bundle, rows, view.hits.distance[rows])
    # Shadow rays begin a little above the surface: float32 is off by that much at this distance.
    height = np.float32(2e-4) + np.float32(2e-6) * view.hits.distance[rows]
    above = points + facing * (height if view.lift is None else height + view.lift[rows])
    lit = np.empty((3, len(rows)), np.float32)
    lit[:] = np.float32(np.pi) * lighting.sky[:, None]
    for sky in lighting.skies:
        lit += sky.irradiance(facing)
    for light in lighting.lights:
        light_there, place = irradiance(light, points, facing)
        if light.color.any():
            if light.shadows:
                towards = np.flatnonzero((light_there > 0).any(axis=0))
                from_there = place if place.shape[1] == 1 else place[:, towards]
                dark = _blocked(light, from_there, above[:, towards], shadows, view.bundle.origin, state)
                light_there[:, towards[dark]] = 0
            for axis in range(3):
                lit[axis] += light.color[axis] * light_there[axis % len(light_there)]

    def places(some: np.ndarray) -> np.ndarray:
        return view.rays.points(view.bundle, some, view.hits.distance[some])

    found = looks.base_of(view.hits, rows, surfaces, places) * (lit.T * np.float32(1 / np.pi))
    return found + looks.emitted_of(view.hits, rows, surfaces) if looks.emits else np.asarray(found)


def _blocked(
    light: Light, place: np.ndarray, points: np.ndarray, shadows: Shadows, origin: np.ndarray, state: Any
) -> np.ndarray:
    ways = np.empty(points.T.shape, np.float32)
    ways[:] = (place if light.far else place - points).T
    return shadows.blocked(origin, np.ascontiguousarray(points.T), ways, state, far=light.far)


def aces_curve(light: np.ndarray) -> np.ndarray:
    """Linear light bent from its darks to its highlights, 0 to 1: Narkowicz's fit to the ACES reference (2015)."""
    x = np.clip(np.nan_to_num(light), np.float32(0), np.float32(BEYOND_WHITE))
    return np.asarray(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), np.float32)


def srgb(light: np.ndarray) -> np.ndarray:
    """Linear light as bytes of sRGB (IEC 61966-2-1): 0 and below is 0, 1 and above 255."""
    steps = np.fmin(np.fmax(light, np.float32(0)), np.float32(1))  # values that are not numbers become 0
    steps *= np.float32(SHADE_LEVELS - 1)
    steps += np.float32(0.5)
    return np.asarray(np.take(_TABLE, steps.astype(np.int32)))


def _table() -> np.ndarray:
    x = np.arange(SHADE_LEVELS) / (SHADE_LEVELS - 1)
    curve = np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)
    return np.floor(255 * curve + 0.5).astype(np.uint8)


_TABLE = _table()
