"""Lights as numbers that kernels and their callers share, without Warp."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from sensors.camera.lights import Light, Lighting

FAR, CARRIED, FLAT, LONG, SPOT, SHADOWS = 1, 2, 4, 8, 16, 32
"""Bits of a light's kind."""

HEADER = 16
"""The bytes before the pixels of a picture."""


def size_of(lighting: Lighting) -> tuple[int, int]:
    """How many lights there are, and how many patches they have in all."""
    return len(lighting.lights), sum(len(light.patches) for light in lighting.lights)


def simple(lighting: Lighting) -> bool:
    """Whether the lights are of the kinds that a device shades with: neither skies with an image, nor projectors."""
    return not lighting.skies and all(light.slide is None for light in lighting.lights)


def write(lighting: Lighting, out: Mapping[str, np.ndarray]) -> None:
    """Writes lights into the arrays of `shade_kernels.Lamps`."""
    lights = lighting.lights
    out["sky"][0] = lighting.sky
    out["first"][:] = np.cumsum([0, *(len(light.patches) for light in lights)])
    for number, light in enumerate(lights):
        out["color"][number], out["place"][number], out["axis"][number] = light.color, light.place, light.axis
        out["cone"][number] = _cone(light)
        out["kind"][number] = _kind(light)
    if lights:
        out["patches"][:] = np.concatenate([light.patches for light in lights])


def _kind(light: Light) -> int:
    chosen = (
        *((light.far, FAR), (light.carried, CARRIED), (light.flat, FLAT), (light.long, LONG)),
        *((light.cone is not None, SPOT), (light.shadows, SHADOWS)),
    )
    return sum(bit for there, bit in chosen if there)


def _cone(light: Light) -> tuple[float, float, float]:
    if light.cone is None:
        return 0.0, 0.0, 0.0
    edge, soft, focus = light.cone
    return edge, math.cos(math.acos(edge) * (1 - soft)), focus
