"""NURBS curves and patches as points, by the recursion of Cox and de Boor, and UsdGeom patches as triangles."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from graph.sim.attributes import array_of, number_of
from graph.sim.transforms import Floats
from graph.sim.usd import EARLIEST, UsdGeom

from .polygons import Complain
from .tessellation import Triangles

MOST_PARTS = 64
"""Most parts of a span between two knots."""


def nurbs_curve(points: Floats, knots: Floats, order: int, tolerance: float) -> Floats | None:
    """Points (n, 3) along a curve, within `tolerance` of it; None if order, knots and points do not fit together.

    knots: as many as points + order, ascending; the curve is defined between knot order - 1 and the last but as many.
    """
    if not _fits(len(points), knots, order):
        return None
    return _until(tolerance, lambda parts: basis(_parameters(knots, order, parts), knots, order) @ points, (0,))


def nurbs_patch(
    points: Floats, knots: tuple[Floats, Floats], orders: tuple[int, int], tolerance: float, weights: Floats | None
) -> Floats | None:
    """Points (rows, columns, 3) of a patch within `tolerance`; None if its numbers do not fit together.

    points: (v, u, 3); knots and orders: of u and of v; weights: (v, u), greater than 0, or None.
    """
    rows, columns = points.shape[:2]
    if not _fits(columns, knots[0], orders[0]) or not _fits(rows, knots[1], orders[1]):
        return None

    def surface(parts: int) -> Floats:
        across = basis(_parameters(knots[0], orders[0], parts), knots[0], orders[0])
        up = basis(_parameters(knots[1], orders[1], parts), knots[1], orders[1])
        if weights is None:
            return np.asarray(np.einsum("ai,bj,ijk->abk", up, across, points, optimize=True))
        heavy = np.einsum("ai,bj,ijk->abk", up, across, points * weights[..., None], optimize=True)
        return np.asarray(heavy / (up @ weights @ across.T)[..., None])

    return _until(tolerance, surface, (0, 1))


def basis(parameters: Floats, knots: Floats, order: int) -> Floats:
    """(n, points) values of the B-spline basis functions at the parameters."""
    last = np.searchsorted(knots, knots[len(knots) - order], side="left") - 1
    span = np.minimum(np.searchsorted(knots, parameters, side="right") - 1, last)
    values = np.zeros((len(parameters), len(knots) - 1))
    values[np.arange(len(parameters)), span] = 1
    for degree in range(1, order):
        size = len(knots) - 1 - degree
        low, high = knots[:size], knots[degree + 1 : degree + 1 + size]
        rise, fall = knots[degree : degree + size] - low, high - knots[1 : 1 + size]
        first = np.divide(parameters[:, None] - low, rise, out=np.zeros((len(parameters), size)), where=rise > 0)
        second = np.divide(high - parameters[:, None], fall, out=np.zeros((len(parameters), size)), where=fall > 0)
        values = first * values[:, :size] + second * values[:, 1 : size + 1]
    return values


def _fits(count: int, knots: Floats, order: int) -> bool:
    if order < 2 or count < order or len(knots) != count + order or not np.isfinite(knots).all():
        return False
    return bool((np.diff(knots) >= 0).all() and knots[count] > knots[order - 1])


def _parameters(knots: Floats, order: int, parts: int) -> Floats:
    ends = np.unique(knots[order - 1 : len(knots) - order + 1])
    inner = ends[:-1, None] + np.diff(ends)[:, None] * np.arange(parts) / parts
    return np.append(inner.ravel(), ends[-1])


def _until(tolerance: float, sample: Callable[[int], Floats], axes: tuple[int, ...]) -> Floats:
    """Doubles the parts until the result no longer changes; halving a part leaves a quarter of its error."""
    coarse = sample(1)
    parts = 2
    while True:
        fine = sample(parts)
        between = coarse
        for axis in axes:
            between = _with_middles(between, axis)
        if np.abs(fine - between).max() * 2 / 4 <= tolerance or parts >= MOST_PARTS:
            return fine
        coarse, parts = fine, 2 * parts


def _with_middles(values: Floats, axis: int) -> Floats:
    values = np.moveaxis(values, axis, 0)
    out = np.empty((2 * len(values) - 1, *values.shape[1:]))
    out[::2] = values
    out[1::2] = (values[1:] + values[:-1]) / 2
    return np.moveaxis(out, 0, axis)


def patch(prim: Any, tolerance: float, time: Any, complain: Complain) -> tuple[Floats, Triangles] | None:
    """A NurbsPatch as a grid of triangles; its trim curves are not applied (reported to `complain`)."""
    schema = UsdGeom.NurbsPatch(prim)
    columns, rows = (_count(each, time) for each in (schema.GetUVertexCountAttr(), schema.GetVVertexCountAttr()))
    points = array_of(schema.GetPointsAttr(), np.float64, 3, time)
    weights = array_of(schema.GetPointWeightsAttr(), np.float64, time=time)
    fits = columns > 0 and rows > 0 and columns * rows == len(points) and len(weights) in (0, len(points))
    grid = None
    if fits and np.isfinite(points).all() and (weights > 0).all():
        orders = tuple(_count(each, time) for each in (schema.GetUOrderAttr(), schema.GetVOrderAttr()))
        across, up = schema.GetUKnotsAttr(), schema.GetVKnotsAttr()
        grid = nurbs_patch(
            points.reshape(rows, columns, 3),
            (array_of(across, np.float64, time=time), array_of(up, np.float64, time=time)),
            (orders[0], orders[1]),
            tolerance,
            weights.reshape(rows, columns) if len(weights) else None,
        )
    if grid is None:
        complain("its points, weights, orders and knots do not fit together; nothing can hit it")
        return None
    if len(array_of(schema.GetTrimCurveCountsAttr(), np.int64, time=time)):
        complain("its trim curves are not applied; rays meet the whole patch")
    height, width = grid.shape[:2]
    corner = (np.arange(height - 1)[:, None] * width + np.arange(width - 1)).ravel()
    quads = np.stack([corner, corner + 1, corner + width + 1, corner + width], axis=1)
    triangles = quads[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3).astype(np.uint32)
    if schema.GetOrientationAttr().Get(EARLIEST) == UsdGeom.Tokens.leftHanded:
        triangles = np.ascontiguousarray(triangles[:, ::-1])
    return grid.reshape(-1, 3), triangles


def _count(attribute: Any, time: Any) -> int:
    value = number_of(attribute, time)
    return int(value) if value > 0 else 0
