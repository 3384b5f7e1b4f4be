"""Curved shapes as triangles, within a stated error.

Every vertex lies on the true surface and every triangle inside it (convex shapes), so a range can only be too long. The
error of a circle of radius r in n parts is its sagitta r (1 - cos(pi / n)). For a sphere in bands and sectors of equal
angle d, the four corners of a patch lie on a circle of radius at most r sqrt(2) sin(d / 2), so their plane is at least
r sqrt(cos d) from the centre: the error is r (1 - sqrt(cos d)).
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from graph.sim.transforms import Floats

Triangles = NDArray[np.uint32]

FEWEST_PARTS = 12
"""A circle has at least this many parts. Radars take faces for one curved surface if their normals differ by less than
40 deg; a pole of 6 mm, within `mesh.tolerance` with six faces, would glint like a prism.
"""

MOST_PARTS = 1024
"""A circle has at most this many parts, whatever the tolerance (a sphere then has a million triangles)."""

_AXIS_ORDER = {"X": (2, 0, 1), "Y": (1, 2, 0), "Z": (0, 1, 2)}


def circle_parts(radius: float, tolerance: float) -> int:
    """Parts of a circle whose chords stay within `tolerance` of it."""
    if tolerance >= radius:
        return FEWEST_PARTS
    angle = math.acos(1 - tolerance / radius)
    return _clamp(math.ceil(math.pi / angle)) if angle else MOST_PARTS


def sphere_parts(radius: float, tolerance: float) -> int:
    """Parts of the equator (even; half as many bands) with which a sphere stays within `tolerance`."""
    if tolerance >= radius:
        return FEWEST_PARTS
    angle = math.acos((1 - tolerance / radius) ** 2)
    return _clamp(2 * math.ceil(math.pi / angle)) if angle else MOST_PARTS


def _clamp(parts: int) -> int:
    return max(FEWEST_PARTS, min(MOST_PARTS, parts))


def cube(size: float) -> tuple[Floats, Triangles]:
    """A cube about the origin: 8 vertices, 12 triangles facing out."""
    corners = np.array([[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)], dtype=np.float64)
    quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    triangles = [(a, b, c) for a, b, c, _ in quads] + [(a, c, d) for a, _, c, d in quads]
    return corners * (size / 2), np.array(triangles, dtype=np.uint32)


def sphere(radius: float, parts: int) -> tuple[Floats, Triangles]:
    """A sphere about the origin, poles on Z."""
    angles = np.linspace(-math.pi / 2, math.pi / 2, parts // 2 + 1)
    return _lathe(radius * np.cos(angles), radius * np.sin(angles), parts)


def capsule(bottom: float, top: float, height: float, axis: str, parts: int) -> tuple[Floats, Triangles]:
    """A cylinder of `height`, or a frustum, between two half spheres of these radii; one radius may be 0."""
    quarter = np.linspace(0, math.pi / 2, -(-parts // 4) + 1)
    low = np.stack([np.cos(quarter[::-1]) * bottom, -np.sin(quarter[::-1]) * bottom - height / 2])
    high = np.stack([np.cos(quarter) * top, np.sin(quarter) * top + height / 2])
    if not (bottom and top):  # the tip is one point, not a ring of size 0
        low, high = (low if bottom else low[:, -1:] * [[0.0], [1.0]]), (high if top else high[:, :1] * [[0.0], [1.0]])
    radii, heights = np.concatenate([low, high], axis=1)
    vertices, triangles = _lathe(radii, heights, parts)
    return vertices[:, _AXIS_ORDER[axis]], triangles


def cylinder(bottom: float, top: float, height: float, axis: str, parts: int) -> tuple[Floats, Triangles]:
    """A closed cylinder, or a cone (`top` 0) or its frustum; the origin at half height."""
    r, z = [0, bottom, top, 0], [-height / 2, -height / 2, height / 2, height / 2]
    if top == 0:
        r, z = r[:3], z[:3]
    vertices, triangles = _lathe(np.array(r, dtype=np.float64), np.array(z, dtype=np.float64), parts)
    return vertices[:, _AXIS_ORDER[axis]], triangles


def rectangle(width: float, length: float, axis: str) -> tuple[Floats, Triangles]:
    """A flat rectangle about the origin whose normal is `axis`, as UsdGeomPlane lays out width and length."""
    sides = {"X": (0, length, width), "Y": (width, 0, length), "Z": (width, length, 0)}[axis]
    u, v = {"X": (1, 2), "Y": (2, 0), "Z": (0, 1)}[axis]
    vertices = np.zeros((4, 3))
    vertices[:, u] = np.array([-1, 1, 1, -1]) * sides[u] / 2
    vertices[:, v] = np.array([-1, -1, 1, 1]) * sides[v] / 2
    return vertices, np.array([[0, 1, 2], [0, 2, 3]], dtype=np.uint32)


def axis_vector(axis: str) -> Floats:
    """The unit vector of X, Y or Z; of Z for any other text."""
    vector: Floats = np.eye(3)["XYZ".index(axis) if axis in ("X", "Y", "Z") else 2]
    return vector


def _lathe(radii: Floats, heights: Floats, parts: int) -> tuple[Floats, Triangles]:
    """A profile, from the bottom pole up, rotated about Z. An end of radius 0 is one point."""
    angles = np.arange(parts) * (2 * math.pi / parts)
    rings = slice(1, None if radii[-1] > 1e-12 * radii.max() else -1)
    r, z = radii[rings], heights[rings]
    ring_vertices = np.empty((len(r), parts, 3))
    ring_vertices[..., 0] = r[:, None] * np.cos(angles)
    ring_vertices[..., 1] = r[:, None] * np.sin(angles)
    ring_vertices[..., 2] = z[:, None]
    poles = [[0, 0, heights[0]], [0, 0, heights[-1]]]
    return np.concatenate([poles, ring_vertices.reshape(-1, 3)]), _lathe_triangles(len(r), parts)


@lru_cache(maxsize=64)
def _lathe_triangles(rings: int, parts: int) -> Triangles:
    """Vertex 0 is the bottom pole, 1 the top pole, then ring after ring upwards."""
    here = np.arange(parts)
    there = (here + 1) % parts
    first, last = 2, 2 + (rings - 1) * parts
    out = [np.stack([np.zeros_like(here), first + there, first + here], axis=1)]
    for ring in range(rings - 1):
        low, high = 2 + ring * parts, 2 + (ring + 1) * parts
        out.append(np.stack([low + here, low + there, high + there], axis=1))
        out.append(np.stack([low + here, high + there, high + here], axis=1))
    out.append(np.stack([np.ones_like(here), last + here, last + there], axis=1))
    triangles = np.concatenate(out).astype(np.uint32)
    triangles.setflags(write=False)
    return triangles
