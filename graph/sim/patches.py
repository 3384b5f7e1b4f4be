"""UsdGeom NURBS patches as triangles."""

from __future__ import annotations

from typing import Any

import numpy as np

from .nurbs import nurbs_patch
from .polygons import Complain
from .tessellation import Triangles
from .transforms import Floats
from .usd import EARLIEST, UsdGeom


def patch(prim: Any, tolerance: float, time: Any, complain: Complain) -> tuple[Floats, Triangles] | None:
    """A NurbsPatch as a grid of triangles; its trim curves are not applied (told to `complain`)."""
    schema = UsdGeom.NurbsPatch(prim)
    columns, rows = (
        int(_value(each, time, 0)) for each in (schema.GetUVertexCountAttr(), schema.GetVVertexCountAttr())
    )
    points = _array(schema.GetPointsAttr(), time).reshape(-1, 3)
    weights = _array(schema.GetPointWeightsAttr(), time)
    fits = columns > 0 and rows > 0 and columns * rows == len(points) and len(weights) in (0, len(points))
    grid = None
    if fits and np.isfinite(points).all() and (weights > 0).all():
        orders = tuple(int(_value(each, time, 0)) for each in (schema.GetUOrderAttr(), schema.GetVOrderAttr()))
        knots = _array(schema.GetUKnotsAttr(), time), _array(schema.GetVKnotsAttr(), time)
        grid = nurbs_patch(
            points.reshape(rows, columns, 3),
            knots,
            (orders[0], orders[1]),
            tolerance,
            weights.reshape(rows, columns) if len(weights) else None,
        )
    if grid is None:
        complain("its points, weights, orders and knots do not fit together; nothing can hit it.")
        return None
    if len(_array(schema.GetTrimCurveCountsAttr(), time)):
        complain("its trim curves are not applied; rays meet the whole patch.")
    height, width = grid.shape[:2]
    corner = (np.arange(height - 1)[:, None] * width + np.arange(width - 1)).ravel()
    quads = np.stack([corner, corner + 1, corner + width + 1, corner + width], axis=1)
    triangles = quads[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3).astype(np.uint32)
    if schema.GetOrientationAttr().Get(EARLIEST) == UsdGeom.Tokens.leftHanded:
        triangles = np.ascontiguousarray(triangles[:, ::-1])
    return grid.reshape(-1, 3), triangles


def _value(attribute: Any, time: Any, default: Any) -> Any:
    value = attribute.Get(time)
    return default if value is None else value


def _array(attribute: Any, time: Any) -> Floats:
    value = attribute.Get(time)
    return np.zeros(0) if value is None else np.asarray(value).astype(np.float64)
