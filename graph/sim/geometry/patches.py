"""UsdGeom NURBS patches as triangles."""

from __future__ import annotations

from typing import Any

import numpy as np

from graph.sim.arrays import array_of, number_of
from graph.sim.transforms import Floats
from graph.sim.usd import EARLIEST, UsdGeom

from .nurbs import nurbs_patch
from .polygons import Complain
from .tessellation import Triangles


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
