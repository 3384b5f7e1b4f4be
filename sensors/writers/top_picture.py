"""A frame of points from above, coloured by height or range, with rings of equal range about the sensor."""

from __future__ import annotations

import numpy as np

from graph.sim.transforms import transformed
from sensors.frame import Frame

from .drawing import Drawing
from .palette import indices, palette, spread
from .scale import draw_labels, draw_mark, draw_rings, with_bar

FEW, SMALL_M, LARGE_M = 2000, 0.05, 0.4
"""Points of a cloud of fewer than `FEW` are squares with a side of `LARGE_M`, others of `SMALL_M`."""
FLAT_M = 0.3
"""Heights that points span at most if they are coloured by range."""


class TopPicture(Drawing):
    """Pictures of one sensor, x of the world to the right: all show the same part of the world in the same colours."""

    def __init__(self) -> None:
        super().__init__(".", resolution=(960, 720))
        self._colours: tuple[str, float, float] | None = None

    def draw(self, frame: Frame) -> np.ndarray:
        """The picture of a frame, (height, width, 3) uint8."""
        from PIL import Image

        points, pose = frame.xyz.astype(np.float64), frame.end.world_sensor
        if frame.frame_of_reference != "WORLD":
            points = transformed(pose, points)
        points = points[np.isfinite(points).all(axis=1)]
        ranges = np.linalg.norm(points - pose[:3, 3], axis=1)
        if self._colours is None and len(points):
            self._colours = _colours(points[:, 2], ranges)
        what, low, high = self._colours or ("height [m]", 0.0, 1.0)
        values = ranges if what.startswith("range") else points[:, 2]
        flat = points[:, :2]
        image = Image.fromarray(self._begun(flat, pose[:2, 3]))
        row, column = (float(one[0]) for one in self._pixel(pose[None, :2, 3]))
        pixels = self._view()[1]
        draw_rings(image, (column, row), pixels)
        picture = np.array(image)
        order = np.argsort(points[:, 2], kind="stable")  # what is higher is seen
        side = self._wide(LARGE_M if frame.count < FEW else SMALL_M)
        self._squares(picture, flat[order], side, palette()[indices(values[order], low, high)])
        image = Image.fromarray(picture)
        draw_labels(image, (column, row), pixels)
        draw_mark(image, (column, row), (float(pose[0, 0]), float(-pose[1, 0])))
        return np.asarray(with_bar(image, low, high, what))

    def _lines(self, picture: np.ndarray) -> None:
        """Rings stand for the grid."""


def _colours(heights: np.ndarray, ranges: np.ndarray) -> tuple[str, float, float]:
    """What colours points, and the values of the first and the last colour; the first ones are too dark to be seen."""
    low, high = spread(heights)
    what = "height [m]"
    if high - low < FLAT_M:
        what, (low, high) = "range [m]", (0.0, spread(ranges)[1])
    return what, low - 0.1 * (high - low), high
