"""The rays of a transmitter: tubes that fill its field of view."""

from __future__ import annotations

import numpy as np

from graph.base.records import dataclass

EDGE = 0.2
"""The outer part of a fan, on each side, in which the rays fade; a sharp edge would echo like an edge in the world."""


@dataclass(frozen=True, slots=True)
class Fan:
    """Ray tubes in a mount's axes, +x ahead; float32, by axis.

    directions: (3, n) unit; across, up: (3, n), by how much a direction turns from one side of its tube to the other;
    solid: (n,) solid angles [sr], those near the edge faded.
    """

    directions: np.ndarray
    across: np.ndarray
    up: np.ndarray
    solid: np.ndarray


def fan(spans: tuple[float, float], counts: tuple[int, int]) -> Fan:
    """A fan of `spans` (azimuth, elevation) [deg], whole angles, in `counts` (columns, rows) of tubes."""
    steps = [np.deg2rad(span) / count for span, count in zip(spans, counts, strict=True)]
    places = [(np.arange(count) + 0.5) / count - 0.5 for count in counts]
    azimuth, elevation = np.meshgrid(*(np.deg2rad(s) * p for s, p in zip(spans, places, strict=True)), indexing="ij")
    fades = np.meshgrid(*(_fade(place) for place in places), indexing="ij")
    a, e = azimuth.ravel(), elevation.ravel()
    level, zero = np.cos(e), np.zeros_like(a)
    directions = np.stack([level * np.cos(a), level * np.sin(a), np.sin(e)])
    across = np.stack([-level * np.sin(a), level * np.cos(a), zero]) * steps[0]
    up = np.stack([-np.sin(e) * np.cos(a), -np.sin(e) * np.sin(a), level]) * steps[1]
    solid = steps[0] * 2 * np.sin(steps[1] / 2) * level * (fades[0] * fades[1]).ravel()
    return Fan(*(part.astype(np.float32) for part in (directions, across, up, solid)))


def _fade(places: np.ndarray) -> np.ndarray:
    """1 in the middle, sin^2 down to 0 at the edges, for places from -0.5 to 0.5."""
    inside = np.clip((0.5 - np.abs(places)) / EDGE, 0.0, 1.0)
    return np.asarray(np.sin(np.pi / 2 * inside) ** 2)
