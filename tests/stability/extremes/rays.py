"""Rays: near, far, grazing, along edges; surfaces that are degenerate; a sensor inside of what it sees."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from graph.cli.extreme_cases import WEIGHTLESS, Case, along_x, beams, body, channel, cube, ranges, seen, wall, worst
from graph.sim.scene.stage import open_stage
from graph.sim.usd import UsdGeom, UsdPhysics, Vt
from tests.stability.extremes.worlds import directions, mesh

AREA = "rays"
FAN = np.linspace(-60.0, 60.0, 25)
ROUND = np.linspace(-180.0, 180.0, 72, endpoint=False)
"""Azimuths [deg]."""

CORNERS = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
FACES = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
"""The unit cube as a mesh whose faces turn outwards."""


def in_units(metre: float) -> float:
    """A wall in 5 m where a unit of the stage is 1 / `metre` m: relative error."""
    frame = seen("OmniLidar", {"/Wall": cube(2 * metre, (6 * metre, 0, 0))}, "distance", metre=metre, config=beams(0.0))
    return worst(channel(frame, "distance") / 5, 1.0)


def scaled(scale: float) -> float:
    """A sphere whose radius of 1 m is that of the prim times a scale, from 5 m: relative error."""
    ball = {"type": "Sphere", "radius": 1 / scale, "scale": [scale] * 3, "translate": [6, 0, 0]}
    return worst(ranges({"/Ball": ball}, 0.0) / 5, 1.0)


def grazing(degrees: float) -> float:
    """The error of a ray's angle [rad] that explains the error of its range on a floor 1 m below."""
    floor = mesh([[-1e4, -1e4, -1], [1e4, -1e4, -1], [1e4, 1e4, -1], [-1e4, 1e4, -1]], [range(4)])
    angle = np.radians(np.float64(np.float32(degrees)))
    return worst(ranges({"/Floor": floor}, FAN, -degrees) * np.sin(angle), 1.0) * float(np.tan(angle))


def leaks(turn: float) -> float:
    """The share of rays that leave a closed, turned box through its edges and the diagonals of its faces."""
    cosine, sine = math.cos(turn), math.sin(turn)
    about_z = np.array([[cosine, sine, 0], [-sine, cosine, 0], [0, 0, 1]])
    corners = (CORNERS * 4 - 2) @ about_z @ np.roll(about_z, 1, (0, 1))
    ends = [(face[a], face[b]) for face in FACES for a in range(4) for b in range(a)]
    ways = np.array([corners[a] + (corners[b] - corners[a]) * share for a, b in ends for share in (0.3, 0.5, 0.6)])
    azimuth = np.degrees(np.arctan2(ways[:, 1], ways[:, 0]))
    elevation = np.degrees(np.arctan2(ways[:, 2], np.hypot(ways[:, 0], ways[:, 1])))
    wanted = np.linalg.norm(ways, axis=1)
    found = ranges({"/Box": mesh(corners, FACES)}, azimuth, elevation)
    return float((~(np.abs(found - wanted) < 1e-5)).mean())


def edge_on(_: object) -> float:
    """Rays in the plane of a square: how far from its near edge or the wall behind it [m]."""
    prims = {"/Square": mesh([[3, -1, 0], [5, -1, 0], [5, 1, 0], [3, 1, 0]], [range(4)]), "/Wall": wall(10.0, 5.0)}
    found = along_x(ranges(prims, FAN / 6), FAN / 6)
    return float(np.minimum(np.abs(found - 3), np.abs(found - 10)).max())


def coincident(_: object) -> float:
    """Two walls at one place [m]."""
    return worst(along_x(ranges({"/A": wall(5.0), "/B": wall(5.0)}, FAN / 6), FAN / 6), 5.0)


def three_at_an_edge(_: object) -> float:
    """Three squares that share an edge, two of them on y = x - 4 and y = 4 - x: the nearest counts [m]."""
    points = [[4, 0, z] for z in (-1, 1)] + [[x, y, z] for x, y in ((6, 2), (6, -2), (8, 0)) for z in (-1, 1)]
    azimuth = np.array([-8.0, -4, 4, 8])
    wanted = 4 / (1 - np.tan(np.radians(np.abs(azimuth))))
    found = ranges({"/Fan": mesh(points, [[0, 1, 3, 2], [0, 1, 5, 4], [0, 1, 7, 6]])}, azimuth)
    return worst(along_x(found, azimuth), wanted)


def inside_out(_: object) -> float:
    """A box whose faces turn inwards: ranges [m], and how far normals are from facing the sensor."""
    box = mesh(CORNERS + np.array([4, -0.5, -0.5]), [face[::-1] for face in FACES])
    frame = seen("OmniLidar", {"/Box": box}, "distance hitNormals", config=beams(FAN / 30))
    normals = worst(channel(frame, "hitNormals"), np.array([-1, 0, 0]))
    return max(normals, worst(along_x(channel(frame, "distance"), FAN / 30), 4.0))


def broken_mesh(points: Any, faces: Any) -> Any:
    """A stage with one mesh of 32-bit points and faces of any length, as a file may hold it."""
    stage = open_stage()
    shape = UsdGeom.Mesh.Define(stage, "/Mesh")
    shape.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(np.asarray(points, np.float32)))
    shape.CreateFaceVertexCountsAttr(Vt.IntArray.FromNumpy(np.fromiter(map(len, faces), np.int32)))
    shape.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(np.concatenate(faces).astype(np.int32)))
    return stage


def broken(moves: bool) -> float:
    """A wall behind faces without area, of two corners, with points that do not exist or are not finite [m]."""
    corners = [[5, -1, -1], [5, -1, 1], [5, 1, 1], [5, 1, -1], [3, 0, 0], [np.nan, 0, 0], [3, np.inf, 0], [3, 0, 1]]
    faces = [[0, 1, 2, 3], [4, 4, 4], [4, 7, 4], [0, 5, 1], [2, 6, 3], [4, 7], [0, 1, 99]]
    stage = broken_mesh(corners, faces)
    if moves:
        UsdPhysics.RigidBodyAPI.Apply(stage.GetPrimAtPath("/Mesh"))
    frame = seen("OmniLidar", WEIGHTLESS, "distance", stage=stage, config=beams(FAN / 6))
    return worst(along_x(channel(frame, "distance"), FAN / 6), 5.0)


def enclosed(kind: str) -> float:
    """Ranges from the middle of a solid of 2 m; of a "body", which moves, too [m]."""
    solids = {"Sphere": {"type": "Sphere", "radius": 1.0}, "Cube": cube(2, (0, 0, 0)), "body": body(2, (0, 0, 0))}
    wanted = 1.0 if kind == "Sphere" else 1 / np.abs(directions(ROUND)).max(axis=1)
    return worst(ranges({**WEIGHTLESS, "/Solid": solids[kind]}, ROUND), wanted)


def many(side: int) -> float:
    """A floor of 2 `side`^2 triangles, 1 m below [m]."""
    line = np.linspace(-50, 50, side + 1)
    x, y = np.meshgrid(line, line, indexing="ij")
    corner = (np.arange(side)[:, None] * (side + 1) + np.arange(side)).ravel()
    faces = np.stack([corner, corner + side + 1, corner + side + 2, corner + 1], axis=1)
    stage = broken_mesh(np.stack([x.ravel(), y.ravel(), np.full(x.size, -1.0)], axis=1), faces)
    frame = seen("OmniLidar", {}, "distance", stage=stage, config=beams(ROUND, -5.0))
    return worst(channel(frame, "distance") * np.sin(np.radians(5.0)), 1.0)


CASES = (
    Case(AREA, "a wall where a unit is 1e-6 to 1e6 m", 3e-7, "of the range", "lengths become metres before float32",
         in_units, (1e-6, 1e-3, 1e3, 1e6)),
    Case(AREA, "a sphere scaled by 1e-6 to 1e6", 3e-7, "of the range", "met by formula in its own space", scaled,
         (1e-6, 1e-3, 1e3, 1e6)),
    Case(AREA, "a floor at 45 to 0.01 deg", 3e-7, "rad", "float32 directions; at 0.01 deg 0.2 % of the range", grazing,
         (45.0, 10.0, 1.0, 0.1, 0.01)),
    Case(AREA, "rays along the edges of a closed mesh", 0.0, "lost", "Embree's robust mode; not so at corners",
         leaks, (0.0, 0.1, 0.6)),
    Case(AREA, "rays in the plane of a face", 1e-5, "m", "it is missed, or met at its edge", edge_on),
    Case(AREA, "two walls at one place", 1e-5, "m", "either is met, at that range", coincident),
    Case(AREA, "three faces at one edge", 1e-5, "m", "the nearest counts, closed or not", three_at_an_edge),
    Case(AREA, "a mesh inside out", 1e-5, "m", "both sides are met; normals face the sensor", inside_out),
    Case(AREA, "faces without area, or with NaN and missing points", 1e-5, "m", "left out, with a warning", broken,
         (False, True)),
    Case(AREA, "from within a sphere, a box, a moving box", 1e-5, "m", "both sides are met", enclosed,
         ("Sphere", "Cube", "body")),
    Case(AREA, "1e7 triangles", 1e-5, "m", "the limit scene.triangles; 2.4 GB of memory", many, (2236,), slow=True),
)  # fmt: skip
