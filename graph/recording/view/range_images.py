"""Range images of lidar scans: rows are rings or elevations, columns azimuths, colours the nearest range."""

from __future__ import annotations

from typing import Any

import numpy as np

from graph.recording.export.scans import Scan
from sensors.writers.palette import indices

from .colours import picture

COLUMNS = 900
ROWS = 64
"""Of a cloud without rings."""
LEAST_DEG = 2.0
"""Elevations that a cloud has to span; a planar scan has no range image."""


def range_image(scan: Scan) -> tuple[Any, float] | None:
    """The picture (columns from azimuth 180 at the left to -180 deg at the right, upper row on top) as the sensor looks
    ahead in the middle, and the range [m] of its last colour; None for a planar or empty scan.
    """
    x, y, z = (scan.points[axis].astype(np.float64) for axis in "xyz")
    distance = np.sqrt(x * x + y * y + z * z)
    good = np.isfinite(distance) & (distance > 0)
    if good.sum() < COLUMNS:
        return None
    x, y, z, distance = x[good], y[good], z[good], distance[good]
    elevation = np.degrees(np.arcsin(z / distance))
    low, high = np.percentile(elevation, (0.5, 99.5))
    if high - low < LEAST_DEG:
        return None
    if "ring" in (scan.points.dtype.names or ()):
        rings, row = np.unique(scan.points["ring"][good], return_inverse=True)
        mean = np.bincount(row, elevation) / np.bincount(row)
        place = np.empty(len(rings), np.int64)
        place[np.argsort(-mean, kind="stable")] = np.arange(len(rings))
        row, rows = place[row], len(rings)
    else:
        rows = ROWS
        row = np.clip(((high - elevation) / (high - low) * rows).astype(np.int64), 0, rows - 1)
    column = np.clip(((np.pi - np.arctan2(y, x)) / (2 * np.pi) * COLUMNS).astype(np.int64), 0, COLUMNS - 1)
    image = np.full(rows * COLUMNS, np.inf)
    np.minimum.at(image, row * COLUMNS + column, distance)
    far = float(np.percentile(distance, 98))
    tall = max(1, round(160 / rows))  # rows as wide as a reader sees them
    return picture(np.repeat(indices(image.reshape(rows, COLUMNS), 0.0, far), tall, axis=0)), far
