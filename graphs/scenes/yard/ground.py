"""The ground: asphalt inside the fence, grassy mounds outside it, kerbs and a planting island."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from pxr import Usd

from .mesh import Mesh

HALF_LENGTH, HALF_WIDTH = 30.0, 20.0
"""Half the fenced yard along x and y [m]; it is flat at z = 0."""

MARGIN = 15.0
CELLS = 160
KERB = np.array([(-0.09, 0.0), (-0.08, 0.10), (-0.06, 0.13), (-0.03, 0.15), (0.03, 0.15), (0.06, 0.14), (0.09, 0.0)])
"""Kerb profile: across, up [m]."""


def build_ground(stage: Usd.Stage, root: str, looks: dict[str, str]) -> None:
    """Write the terrain (51,200 triangles), the kerbs and the island below `root`."""
    asphalt, grass = Mesh(), Mesh()
    points = terrain()
    inside = (np.abs(points[..., 0]) <= HALF_LENGTH + 1) & (np.abs(points[..., 1]) <= HALF_WIDTH + 1)
    for row in range(CELLS):
        for part in _runs(inside[row, :-1]):
            patch = points[row : row + 2, part.start : part.stop + 1]
            (asphalt if inside[row, part.start] else grass).add_grid(patch)
    asphalt.define(stage, f"{root}/Asphalt", looks["asphalt"])
    grass.define(stage, f"{root}/Mounds", looks["grass"])

    kerbs = Mesh()
    kerbs.add_sweep(KERB, _line((-13, 11.2), (13, 11.2), 27))
    kerbs.add_sweep(KERB, island_outline())
    kerbs.define(stage, f"{root}/Kerbs", looks["concrete"])
    Mesh().add_grid(_island_top()).define(stage, f"{root}/Island", looks["grass"])


def terrain() -> NDArray[np.float64]:
    """Ground points (CELLS + 1, CELLS + 1, 3): flat in the yard, rolling up to about 3 m at the edge."""
    x = np.linspace(-HALF_LENGTH - MARGIN, HALF_LENGTH + MARGIN, CELLS + 1)
    y = np.linspace(-HALF_WIDTH - MARGIN, HALF_WIDTH + MARGIN, CELLS + 1)
    grid_y, grid_x = np.meshgrid(y, x)
    outside = np.maximum(np.abs(grid_x) - HALF_LENGTH - 1.5, np.abs(grid_y) - HALF_WIDTH - 1.5)
    rise = np.clip(outside / (MARGIN - 1.5), 0, 1)
    rolling = 1.6 + 0.7 * np.sin(0.31 * grid_x + 0.17 * grid_y) + 0.5 * np.sin(0.12 * grid_x - 0.43 * grid_y)
    tufts = 0.06 * np.sin(2.3 * grid_x + 1.1) * np.sin(2.7 * grid_y) + 0.03 * np.sin(5.1 * grid_x - 3.7 * grid_y)
    height = rise**2 * (3 - 2 * rise) * rolling + np.clip(outside, 0, 1) * tufts
    return np.stack([grid_x, grid_y, height], axis=-1)


def island_outline() -> NDArray[np.float64]:
    """The island's kerb line (K, 3), a rounded rectangle counter-clockwise."""
    corners = [((12.0, -11.0), 0), ((5.0, -11.0), 90), ((5.0, -13.0), 180), ((12.0, -13.0), 270)]
    points = [
        (centre[0] + np.cos(angle), centre[1] + np.sin(angle), 0.0)
        for centre, start in corners
        for angle in np.radians(start + np.linspace(0, 90, 10))
    ]
    return np.array([*points, points[0]])


def _island_top() -> NDArray[np.float64]:
    outline = island_outline()
    centre = outline[:-1].mean(axis=0)
    rings = [centre + (outline - centre) * share for share in (0.05, 0.4, 0.75, 1.0)]
    return np.stack([ring + (0, 0, height) for ring, height in zip(rings, (0.32, 0.28, 0.2, 0.12), strict=True)])


def _line(start: tuple[float, float], end: tuple[float, float], points: int) -> NDArray[np.float64]:
    return np.linspace((*start, 0.0), (*end, 0.0), points)


def _runs(flags: NDArray[np.bool_]) -> list[slice]:
    """The longest stretches of equal flags."""
    edges = [0, *(np.flatnonzero(np.diff(flags)) + 1), len(flags)]
    return [slice(start, stop) for start, stop in pairwise(edges)]
