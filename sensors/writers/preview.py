"""Pictures of what the sensors of a run see: at a rate, a PNG of each sensor's latest frame."""

from __future__ import annotations

from collections.abc import Callable, Collection
from contextlib import suppress
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from graph.base.outputs import remove
from graph.base.records import dataclass, field
from graph.sim.transforms import transformed
from sensors.callbacks import on_frame
from sensors.frame import Frame
from sensors.sensor_types import sensor_type

from .drawing import Drawing, file_stem, write_png
from .palette import NEAR, indices, palette, spread
from .scale import draw_labels, draw_mark, draw_rings, with_bar

if TYPE_CHECKING:
    from graph.sim.app import App
    from graph.sim.renderer.products import RenderProduct
    from sensors.frame import Frame


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


LIT, DEPTHS = ("rgb", "HdrColor"), ("distance_to_image_plane", "distance_to_camera")
"""Channels of cameras: colours, which need light, and distances."""
BEFORE_RENDERING = -1000


class Previews:
    """Writes `<folder>/<sensor>_<frame>.png` of every sensor of an App, `rate` times a simulated second.

    Cameras: their colours, or distances where only these are read. Sensors that measure points: those
    points in the world, seen from above, coloured by height; all pictures of a sensor show the same part of the world.
    Other sensors: nothing. A picture shows the first frame at or after its
    time; the sensor computes what the pictures need in every frame until `close`. After a stop frames count on, also of
    a product that is made again. The first picture replaces those of an earlier run. Raises RunError from an update in
    which a picture cannot be written.
    """

    def __init__(self, app: App, folder: Path, rate: Fraction) -> None:
        self.files: list[Path] = []
        """What was written, in order."""
        self._products, self._folder, self._period = app.rendering.products, folder, 1 / rate
        self._followed: dict[str, RenderProduct] = {}
        self._series: dict[str, _Series] = {}
        self._ends: list[Callable[[], None]] = [app.on("render", self._follow_new, BEFORE_RENDERING)]

    def close(self) -> None:
        """Ends the pictures."""
        while self._ends:
            self._ends.pop()()

    def _follow_new(self) -> None:
        for product in self._products.values():
            if self._followed.get(product.path) is not product and product.camera_path:
                self._followed[product.path] = product
                self._follow(product)

    def _follow(self, product: RenderProduct) -> None:
        kind = sensor_type(product.sensor.type_name)
        channel = _drawn(kind.measures if kind else (), product.sensor.consumers())
        if not channel:
            return
        series = self._series.setdefault(product.path, _Series(channel, self._period))

        def draw(frame: Frame) -> None:
            number = series.number(frame)
            if number is None:
                return
            file = self._folder / f"{file_stem(frame.sensor_path, 'sensor')}_{number:06d}.png"
            if not self.files:
                self._remove_earlier()
            write_png(series.picture(frame), file, "preview", "an output folder")
            self.files.append(file)

        self._ends.append(on_frame(product, draw, channels=(channel,)))

    def _remove_earlier(self) -> None:
        for file in self._folder.glob("*_[0-9][0-9][0-9][0-9][0-9][0-9].png"):
            with suppress(OSError):
                remove(file)


def _drawn(measures: Collection[str], consumed: Collection[str]) -> str:
    """The channel that a picture shows of those that a sensor measures; consumed: what is read."""
    if "rgb" not in measures:
        return "xyz" if "xyz" in measures else ""
    depth = next((name for name in DEPTHS if name in consumed and name in measures), "")
    return depth if depth and not any(name in consumed for name in LIT) else "rgb"


def picture_of(frame: Frame) -> np.ndarray | None:
    """The picture of a single frame, (height, width, 3) uint8; None if it holds nothing that previews draw."""
    channel = next((name for name in ("rgb", *DEPTHS) if frame.has(name)), "xyz")
    if channel == "xyz" and not len(frame.xyz):
        return None
    return _Series(channel, Fraction(1)).picture(frame)


@dataclass
class _Series:
    """The pictures at one path, of one product or of several that follow each other."""

    channel: str
    period: Fraction
    _due: Fraction = Fraction(0)
    _earlier: int = 0
    """Frames of earlier plays."""
    _latest: int = -1
    _drawing: TopPicture = field(default_factory=TopPicture)
    _depths: tuple[float, float] | None = None

    def number(self, frame: Frame) -> int | None:
        """The number of a frame, counted on from play to play, if a picture of it is due; else None."""
        if frame.frame_id <= self._latest:  # a stop came between: frames and times begin again
            self._earlier, self._due = self._earlier + self._latest + 1, Fraction(0)
        self._latest = frame.frame_id
        if frame.reference < self._due:
            return None
        self._due = (frame.reference // self.period + 1) * self.period
        return self._earlier + frame.frame_id

    def picture(self, frame: Frame) -> np.ndarray:
        """(height, width, 3) uint8."""
        if self.channel == "rgb":
            return np.asarray(frame.channel("rgb"))[..., :3]
        if self.channel in DEPTHS:
            return self._depth(np.asarray(frame.channel(self.channel), np.float64))
        return self._drawing.draw(frame)

    def _depth(self, depth: np.ndarray) -> np.ndarray:
        """A depth image in the colours of the first one's range, above their bar."""
        from PIL import Image

        depth = depth.reshape(depth.shape[:2])
        if self._depths is None and np.isfinite(depth).any():
            self._depths = spread(depth, NEAR)
        low, high = self._depths or (0.0, 1.0)
        image = Image.fromarray(palette()[indices(depth, low, high)])
        return np.asarray(with_bar(image, low, high, "depth [m]"))
