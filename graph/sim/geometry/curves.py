"""UsdGeom's curves as tubes: centre lines sampled to a tolerance, and rings of the curve's width around them.

A cubic segment with control points p0..p3 (Bezier) bends by at most 6 max(|p0 - 2 p1 + p2|, |p1 - 2 p2 + p3|); n equal
parts of a curve with second derivative c lie within c / (8 n^2) of it.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graph.sim.attributes import array_of
from graph.sim.transforms import Floats
from graph.sim.usd import EARLIEST, UsdGeom

from .nurbs import nurbs_curve
from .polygons import Complain
from .tessellation import Triangles, circle_parts

Integers = NDArray[np.int64]

MOST_PARTS = 64
"""Parts that a segment of a curve is cut into at most."""

_TO_BEZIER = {
    "bezier": np.eye(4),
    "bspline": np.array([[1, 4, 1, 0], [0, 4, 2, 0], [0, 2, 4, 0], [0, 1, 4, 1]]) / 6,
    "catmullRom": np.array([[0, 6, 0, 0], [-1, 6, 1, 0], [0, 1, 6, -1], [0, 0, 6, 0]]) / 6,
}


def curves(prim: Any, tolerance: float, time: Any, complain: Complain) -> tuple[Floats, Triangles] | None:
    """Tubes of a BasisCurves, HermiteCurves or NurbsCurves with widths, closed by flat ends; None without a surface.

    Authored normals, which make ribbons of them, are not used. Curves whose points, widths or counts do not fit are
    left out and told to `complain`.
    """
    schema = UsdGeom.Curves(prim)
    points = array_of(schema.GetPointsAttr(), np.float64, 3, time)
    counts = array_of(schema.GetCurveVertexCountsAttr(), np.int64, time=time)
    widths = array_of(schema.GetWidthsAttr(), np.float64, time=time)
    if not len(points) or not len(counts):
        complain("the curves have no points or no counts; nothing can hit them")
        return None
    if not len(widths) or not (widths > 0).any():
        complain("the curves have no widths, so they have no surface; nothing can hit them")
        return None
    if (counts < 0).any() or counts.sum() > len(points):
        complain(f"curveVertexCounts asks for {int(counts.sum())} points, there are {len(points)}; it is left out")
        return None
    lines = _Lines(prim, schema, points, counts, widths, tolerance, time).sampled()
    wrong = sum(line is None for line in lines)
    if wrong:
        complain(f"{wrong} curves have too few points, points that are not finite or widths that do not fit")
    found = [line for line in lines if line is not None]
    return _tubes(found, tolerance) if found else None


class _Lines:
    """The centre lines of a prim's curves: for each its points (n, 3), radii (n,) and whether it is a ring."""

    def __init__(
        self,
        prim: Any,
        schema: Any,
        points: Floats,
        counts: Integers,
        widths: Floats,
        tolerance: float,
        time: Any,
    ) -> None:
        self.prim, self.points, self.counts, self.widths = prim, points, counts, widths
        self.tolerance, self.time = tolerance, time
        self.interpolation = str(schema.GetWidthsInterpolation())
        self.starts = np.cumsum(counts) - counts
        self.kind = str(prim.GetTypeName())
        self.cubic, self.basis, self.wrap = True, "bezier", "nonperiodic"
        if prim.IsA(UsdGeom.BasisCurves):
            basis = UsdGeom.BasisCurves(prim)
            self.cubic = basis.GetTypeAttr().Get(EARLIEST) == UsdGeom.Tokens.cubic
            self.basis = str(basis.GetBasisAttr().Get(EARLIEST))
            self.wrap = str(basis.GetWrapAttr().Get(EARLIEST))

    def sampled(self) -> list[tuple[Floats, Floats, bool] | None]:
        if self.kind == "NurbsCurves":
            order = array_of(UsdGeom.NurbsCurves(self.prim).GetOrderAttr(), np.int64, time=self.time)
            knots = array_of(UsdGeom.NurbsCurves(self.prim).GetKnotsAttr(), np.float64, time=self.time)
            first = np.cumsum(self.counts + np.resize(order, len(self.counts))) if len(order) else self.starts
        out: list[tuple[Floats, Floats, bool] | None] = []
        passed = 0
        for number, (start, count) in enumerate(zip(self.starts, self.counts, strict=True)):
            points = self.points[start : start + count]
            if not np.isfinite(points).all() or count < 2:
                out.append(None)
                continue
            if self.kind == "NurbsCurves":
                mine = knots[first[number - 1] if number else 0 : first[number]] if len(order) else knots[:0]
                line = nurbs_curve(points, mine, int(np.resize(order, len(self.counts))[number]), self.tolerance)
                steps = np.linspace(0, 1, len(line)) if line is not None else None
            elif self.kind == "HermiteCurves":
                line, steps = self._hermite(points, start)
            elif not self.cubic:
                ring = self.wrap == "periodic"
                line = np.concatenate([points, points[:1]]) if ring else points
                steps = np.linspace(0, 1, len(line))
            else:
                line, steps = self._basis(points)
            segments = self._segments(int(count))
            radii = None if line is None else self._radii(number, int(start), int(count), passed, segments, steps)
            passed += segments + (0 if self.wrap == "periodic" else 1)
            good = line is not None and radii is not None and np.isfinite(radii).all() and (radii > 0).any()
            out.append((line, radii, self.wrap == "periodic") if good else None)  # type: ignore[arg-type]
        return out

    def _segments(self, count: int) -> int:
        periodic = self.wrap == "periodic"
        if self.kind != "BasisCurves" or not self.cubic:
            return count if periodic else count - 1
        if self.basis == "bezier":
            return count // 3 if periodic else max((count - 1) // 3, 0)
        return count if periodic else (count - 1 if self.wrap == "pinned" else count - 3)

    def _basis(self, points: Floats) -> tuple[Floats | None, Floats | None]:
        count = len(points)
        if self.basis not in _TO_BEZIER:
            return None, None
        step = 3 if self.basis == "bezier" else 1
        if self.wrap == "pinned" and step == 1:
            points = np.concatenate([2 * points[:1] - points[1:2], points, 2 * points[-1:] - points[-2:-1]])
        segments = self._segments(count)
        if segments < 1 or (self.wrap != "periodic" and len(points) < 4):
            return None, None
        index = (np.arange(segments)[:, None] * step + np.arange(4)) % len(points)
        return self._cubics(np.einsum("ij,sjk->sik", _TO_BEZIER[self.basis], points[index]))

    def _hermite(self, points: Floats, start: int) -> tuple[Floats | None, Floats | None]:
        tangents = array_of(UsdGeom.HermiteCurves(self.prim).GetTangentsAttr(), np.float64, 3, self.time)
        mine = tangents[start : start + len(points)]
        if len(mine) != len(points) or not np.isfinite(mine).all():
            return None, None
        p, t = points, mine / 3
        return self._cubics(np.stack([p[:-1], p[:-1] + t[:-1], p[1:] - t[1:], p[1:]], axis=1))

    def _cubics(self, control: Floats) -> tuple[Floats, Floats]:
        """Bezier segments (s, 4, 3) as points (n, 3), and each point's place from 0 to 1."""
        bends = 6 * np.abs(np.diff(control, n=2, axis=1)).max() * math.sqrt(3)
        parts = min(max(math.ceil(math.sqrt(bends / (8 * self.tolerance))), 1), MOST_PARTS)
        t = np.linspace(0, 1, parts + 1)[:-1, None]
        weights = np.concatenate([(1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t * t * (1 - t), t**3], axis=1)
        line = np.einsum("pj,sjk->spk", weights, control).reshape(-1, 3)
        line = np.concatenate([line, control[-1:, 3]])
        return line, np.linspace(0, 1, len(line))

    def _radii(
        self, number: int, start: int, count: int, passed: int, segments: int, steps: Floats | None
    ) -> Floats | None:
        assert steps is not None
        size = len(self.widths)
        if size == 1:
            mine = self.widths
        elif self.interpolation == "uniform" and size == len(self.counts):
            mine = self.widths[number : number + 1]
        elif size == len(self.points):
            mine = self.widths[start : start + count]
        elif self.interpolation in ("varying", "vertex") and passed + segments < size + (self.wrap == "periodic"):
            mine = self.widths[passed : passed + segments + (0 if self.wrap == "periodic" else 1)]
        else:
            return None
        if self.wrap == "periodic" and len(mine) > 1:
            mine = np.concatenate([mine, mine[:1]])
        return np.asarray(np.interp(steps, np.linspace(0, 1, len(mine)), mine) / 2)


def _tubes(lines: list[tuple[Floats, Floats, bool]], tolerance: float) -> tuple[Floats, Triangles]:
    """Rings of one number of parts around each point of the lines, joined along them."""
    widest = max(float(radii.max()) for _, radii, _ in lines)
    parts = circle_parts(widest, tolerance)
    angles = np.arange(parts) * (2 * math.pi / parts)
    circle = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    vertices, triangles, first = [], [], 0
    groups: dict[tuple[int, bool], list[tuple[Floats, Floats]]] = {}
    for points, radii, ring in lines:
        groups.setdefault((len(points), ring), []).append((points, radii))
    for (size, ring), members in groups.items():
        centres = np.stack([points for points, _ in members])
        radii = np.stack([each for _, each in members])
        sides = _sides(centres, ring)
        rings = centres[:, :, None, :] + radii[..., None, None] * (circle @ sides)
        kept = rings[:, :-1] if ring else rings
        pattern = _tube_triangles(size - 1 if ring else size, parts, ring)
        each = kept.shape[1] * parts
        vertices.append(kept.reshape(-1, 3))
        triangles.append((pattern[None] + first + each * np.arange(len(members))[:, None, None]).reshape(-1, 3))
        first += each * len(members)
    return np.concatenate(vertices), np.concatenate(triangles).astype(np.uint32)


def _sides(centres: Floats, ring: bool) -> Floats:
    """(c, n, 2, 3): at every point two unit vectors across the line, carried along it with as little turn as may be."""
    along = np.gradient(centres, axis=1)
    if ring:
        along[:, 0] = along[:, -1] = centres[:, 1] - centres[:, -2]
    along /= np.maximum(np.linalg.norm(along, axis=2, keepdims=True), 1e-300)
    count, size = centres.shape[:2]
    out = np.empty((count, size, 2, 3))
    side = np.eye(3)[np.argmin(np.abs(along[:, 0]), axis=1)]
    for place in range(size):
        tangent = along[:, place]
        across = side - tangent * (side * tangent).sum(axis=1, keepdims=True)
        length = np.linalg.norm(across, axis=1, keepdims=True)
        lost = length[:, 0] < 1e-9  # the line turned by a right angle just there
        if lost.any():
            other = np.eye(3)[np.argmin(np.abs(tangent[lost]), axis=1)]
            across[lost] = other - tangent[lost] * (other * tangent[lost]).sum(axis=1, keepdims=True)
            length = np.linalg.norm(across, axis=1, keepdims=True)
        side = across / length
        out[:, place, 0] = side
        out[:, place, 1] = np.cross(tangent, side)
    return out


def _tube_triangles(rings: int, parts: int, closed: bool) -> Integers:
    here = np.arange(parts)
    there = (here + 1) % parts
    low = np.arange(rings if closed else rings - 1)[:, None] * parts
    high = (low + parts) % (rings * parts)
    walls = [
        np.stack([low + here, low + there, high + there], axis=2).reshape(-1, 3),
        np.stack([low + here, high + there, high + here], axis=2).reshape(-1, 3),
    ]
    if not closed:
        fan = np.arange(1, parts - 1)
        last = (rings - 1) * parts
        walls.append(np.stack([np.zeros_like(fan), fan + 1, fan], axis=1))
        walls.append(np.stack([np.full_like(fan, last), last + fan, last + fan + 1], axis=1))
    return np.concatenate(walls)
