"""Pictures of clouds from above."""

from __future__ import annotations

from typing import Any

import numpy as np

from graph.sim.transforms import Floats
from sensors.writers.palette import indices, widened
from sensors.writers.scale import draw_labels, draw_mark, draw_rings, with_bar

from .colours import picture

SIZE = 700
"""Pixels of the longer side."""

MARGIN = 0.04
"""What is shown beyond the outermost points, as a share of the longer side."""

DOTS = 2_000
"""Pixels that the points of a sparse cloud fill about, so that a radar's thirty detections can be seen."""

LARGEST_DOT = 7
"""Pixels of a point's side at most."""


def top_view(places: Floats, low: Floats, high: Floats, pose: Floats | None = None) -> Any:
    """x to the right, y up, the highest point of each pixel by its height; low, high (3,): what the picture spans.

    pose: (4, 4) of the sensor, which then has rings of equal range about it and its mark.
    A point is a square of pixels, the larger the fewer there are.
    """
    heights = widened(float(low[2]), float(high[2]))
    margin = max(MARGIN * float(np.max(high[:2] - low[:2])), 1e-6)  # nothing lies on the very edge
    low, high = low[:2] - margin, high[:2] + margin
    span = high - low
    step = max(span[0], span[1]) / SIZE
    width, height = (max(1, int(np.ceil(span[axis] / step))) for axis in (0, 1))
    column = np.clip(((places[:, 0] - low[0]) / step).astype(np.int64), 0, width - 1)
    row = np.clip(((high[1] - places[:, 1]) / step).astype(np.int64), 0, height - 1)
    side = int(np.clip(np.sqrt(DOTS / max(1, len(places))), 1, LARGEST_DOT))
    image = np.full(width * height, -np.inf)
    for down in range(side):
        for right in range(side):
            rows = np.clip(row + down - side // 2, 0, height - 1)
            columns = np.clip(column + right - side // 2, 0, width - 1)
            np.maximum.at(image, rows * width + columns, places[:, 2])
    drawn = picture(indices(image.reshape(height, width), *heights))
    if pose is None:
        return drawn
    middle = (float(pose[0, 3] - low[0]) / step, float(high[1] - pose[1, 3]) / step)
    drawn = drawn.convert("RGB")
    draw_rings(drawn, middle, 1 / step)
    draw_labels(drawn, middle, 1 / step)
    draw_mark(drawn, middle, (float(pose[0, 0]), float(-pose[1, 0])))
    return with_bar(drawn, *heights, "height [m]")
