"""Point clouds and rays as PNG pictures of the world, without perspective. Only this file imports Pillow."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from graph.base.errors import RunError
from graph.base.outputs import make_folder, replacing
from graph.base.suggest import did_you_mean
from graph.sim.transforms import apply, transformed
from sensors.frame import Frame

VIEWS = {
    "top": ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0)),
    "front": ((0.0, -1.0, 0.0), (0.0, 0.0, 1.0)),
    "side": ((1.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
    "oblique": ((0.5**0.5, -(0.5**0.5), 0.0), (0.5, 0.5, 0.5**0.5)),
}
"""View -> the world axes that point right and up in the picture: from above, along +x, along +y, from behind on the
right, 45 deg down.
"""

BACKGROUND = np.array([8, 8, 12], np.float64)
GRID = np.array([32, 32, 40], np.uint8)
SENSOR = np.array([255, 96, 64], np.uint8)
KEPT = 0.01
"""Fraction of the points at each end that the first picture may leave outside."""

MOST_PIXELS = 15
"""Largest side of a point's square."""


class Drawing:
    """Pictures of the world from one side, all of the same part of it.

    view: one of `VIEWS`, without perspective. resolution: width, height [px]. center (x, y, z) [m] and span [m], the
    width of the pictures; by default they fit what the first picture with anything on it shows, and stay. Grey lines
    are 1, 10 or 100 m apart. Raises ValueError for wrong arguments.
    """

    def __init__(
        self,
        output_dir: str | Path,
        view: str = "top",
        resolution: Sequence[int] = (960, 720),
        center: Sequence[float] | None = None,
        span: float | None = None,
    ) -> None:
        if view not in VIEWS:
            hint = did_you_mean(str(view), VIEWS, f"there are {', '.join(VIEWS)}")
            raise ValueError(f"there is no view {view!r}{hint}")
        if span is not None and not (np.isfinite(span) and span > 0):
            raise ValueError("span is a length above 0 m")
        if len(resolution) != 2 or not all(1 <= int(side) <= 8192 for side in resolution):
            raise ValueError(f"resolution {resolution!r} is not width and height from 1 to 8192")
        if center is not None and len(center) != 3:
            raise ValueError(f"center {center!r} is not x, y, z")
        self.folder = Path(output_dir)
        self._axes = np.array(VIEWS[view])
        self._pixels = int(resolution[0]), int(resolution[1])
        self._center = None if center is None else self._axes @ np.asarray(center, np.float64)
        self._scale = None if span is None else self._pixels[0] / float(span)

    def _begun(self, places: np.ndarray, middle: np.ndarray) -> np.ndarray:
        """A picture with its grid, (height, width, 3) uint8, of these places (n, 2), or about `middle` (2,) if none."""
        self._fit(places, middle)
        width, height = self._pixels
        picture = np.empty((height, width, 3), np.uint8)
        picture[0] = np.rint(BACKGROUND).astype(np.uint8)
        picture[1:] = picture[0]  # by rows: by pixels it takes thirty times as long
        self._lines(picture)
        return picture

    def _wide(self, metres: float) -> int:
        """A length in pixels, 1 to `MOST_PIXELS`."""
        return max(1, min(MOST_PIXELS, round(metres * self._view()[1])))

    def _fit(self, places: np.ndarray, sensor: np.ndarray) -> None:
        """Chooses the range of the pictures at the first frame with points."""
        if self._center is not None and self._scale is not None:
            return
        if not len(places):
            self._shown = (sensor if self._center is None else self._center, self._scale or self._pixels[0] / 20.0)
            return
        low, high = np.quantile(places, (KEPT, 1.0 - KEPT), axis=0)
        low, high = np.minimum(low, sensor), np.maximum(high, sensor)
        if self._center is None:
            self._center = (low + high) / 2
        if self._scale is None:
            reach = np.maximum(np.maximum(high - self._center, self._center - low), 0.5) * 2.2
            self._scale = float((np.array(self._pixels) / reach).min())

    def _view(self) -> tuple[np.ndarray, float]:
        if self._center is not None and self._scale is not None:
            return self._center, self._scale
        return self._shown

    def _pixel(self, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        center, scale = self._view()
        width, height = self._pixels
        flat = np.clip((places - center) * scale, -1e6, 1e6)
        return (
            np.floor(height / 2 - flat[:, 1]).astype(np.int64),
            np.floor(width / 2 + flat[:, 0]).astype(np.int64),
        )

    def _squares(self, picture: np.ndarray, places: np.ndarray, side: int, color: np.ndarray) -> None:
        """Paints places (n, 2) as squares of `side` pixels; color: (3,) of all, or (n, 3)."""
        rows, columns = self._pixel(places)
        width, height = self._pixels
        first = -(side // 2)
        for down in range(first, first + side):
            for right in range(first, first + side):
                inside = (
                    (rows + down >= 0) & (rows + down < height) & (columns + right >= 0) & (columns + right < width)
                )
                shown = color[inside] if color.ndim > 1 else color
                picture[rows[inside] + down, columns[inside] + right] = shown

    def _lines(self, picture: np.ndarray) -> None:
        center, scale = self._view()
        step = next(step for step in (1.0, 10.0, 100.0, 1e3, 1e9) if step * scale >= 12)
        for axis, side in ((0, self._pixels[0]), (1, self._pixels[1])):
            low, high = center[axis] - side / 2 / scale, center[axis] + side / 2 / scale
            at = np.arange(np.ceil(low / step), np.floor(high / step) + 1) * step
            place = np.floor(side / 2 + (at - center[axis]) * scale * (1 if axis == 0 else -1)).astype(np.int64)
            place = place[(place >= 0) & (place < side)]
            if axis == 0:
                picture[:, place] = GRID
            else:
                picture[place] = GRID


class PointCloudDrawing(Drawing):
    """Writes `<output_dir>/<sensor>_<frame>.png` for each frame it is called with; equal frames give equal bytes.

    <sensor> is the prim's path with _ for each / and __ for each _, so that no two sensors share a picture.

    size: side of a point's square [m], at least a pixel. color: r, g, b, a from 0 to 1. doTransform: draw points in the
    world instead of the sensor's frame (points in world axes stay unchanged). testMode: draw, but write no file. The
    cross is the sensor. The other arguments: see `Drawing`. Raises ValueError for wrong arguments.
    """

    def __init__(
        self,
        *,
        size: float = 0.02,
        color: Sequence[float] = (0.75, 0.75, 1.0, 1.0),
        doTransform: bool = True,
        testMode: bool = False,
        output_dir: str | Path = "point_clouds",
        view: str = "top",
        resolution: Sequence[int] = (960, 720),
        center: Sequence[float] | None = None,
        span: float | None = None,
    ) -> None:
        super().__init__(output_dir, view, resolution, center, span)
        if not (np.isfinite(size) and size > 0):
            raise ValueError("size is a length above 0 m")
        self._size, self._transform, self._writes = float(size), bool(doTransform), not testMode
        self._color = blended(color)

    def __call__(self, frame: Frame) -> Path:
        """Draws a frame; returns the path of its picture. Raises RunError if it cannot be written."""
        picture = self.draw(frame)
        file = self.folder / f"{file_stem(frame.sensor_path, 'cloud')}_{frame.frame_id:06d}.png"
        if self._writes:
            write_png(picture, file, "draw-point-cloud", "an output_dir")
        return file

    def draw(self, frame: Frame) -> np.ndarray:
        """The picture of a frame, (height, width, 3) uint8."""
        points = frame.xyz.astype(np.float64)
        pose = frame.end.world_sensor
        here = pose[:3, 3]
        if self._transform and frame.frame_of_reference != "WORLD":
            points = transformed(pose, points)
        elif frame.frame_of_reference != "WORLD":
            here = np.zeros(3)
        places = apply(self._axes, points)
        picture = self._begun(places, self._axes @ here)
        self._squares(picture, places, self._wide(self._size), self._color)
        width, height = self._pixels
        arms = np.arange(-4, 5)
        row, column = self._pixel((self._axes @ here)[None])
        for rows, columns in ((row + arms, column + 0 * arms), (row + 0 * arms, column + arms)):
            inside = (rows >= 0) & (rows < height) & (columns >= 0) & (columns < width)
            picture[rows[inside], columns[inside]] = SENSOR
        return picture


class RayDrawing(Drawing):
    """Writes `<output_dir>/<name>_<number>.png` for each call, the number counting from 0: rays as straight lines.

    name: a path, written as `PointCloudDrawing` does. options: see `Drawing`.
    """

    def __init__(self, name: str, output_dir: str | Path, **options: Any) -> None:
        super().__init__(output_dir, **options)
        self._name, self._count = file_stem(name, "rays"), 0

    def __call__(self, starts: np.ndarray, ends: np.ndarray, color: Sequence[float], width: float) -> Path:
        """Draws rays as `draw` does; returns the path of the picture. Raises RunError if it cannot be written."""
        file = self.folder / f"{self._name}_{self._count:06d}.png"
        self._count += 1
        write_png(self.draw(starts, ends, color, width), file, "draw-rays", "an output_dir")
        return file

    def draw(self, starts: np.ndarray, ends: np.ndarray, color: Sequence[float], width: float) -> np.ndarray:
        """The picture of rays from starts to ends, (n, 3) each, world [m]; (height, width, 3) uint8.

        color: r, g, b, a from 0 to 1. width: of a ray [m], at least a pixel. Rays that are not finite are left out.
        Raises ValueError for another color or width.
        """
        from PIL import Image, ImageDraw

        if not (np.isfinite(width) and width >= 0):
            raise ValueError("width is a length of 0 m or more")
        usable = np.isfinite(starts).all(axis=1) & np.isfinite(ends).all(axis=1)
        first, last = (apply(self._axes, side[usable].astype(np.float64)) for side in (starts, ends))
        image = Image.fromarray(self._begun(np.concatenate([first, last]), np.zeros(2)))
        pen, painted, wide = ImageDraw.Draw(image), tuple(blended(color).tolist()), self._wide(width)
        for line in np.stack([*self._pixel(first)[::-1], *self._pixel(last)[::-1]], axis=1).tolist():
            pen.line(line, fill=painted, width=wide)
        return np.asarray(image)


def write_png(picture: np.ndarray, file: Path, who: str, what: str) -> None:
    """Writes a picture, (height, width, 3) uint8. Raises RunError that names who draws, and what is to be changed."""
    from PIL import Image

    try:
        make_folder(file.parent)
        with replacing(file) as stream:
            Image.fromarray(picture).save(stream, format="PNG", compress_level=3)
    except OSError as error:
        reason = error.strerror or error
        raise RunError(f"{who}: {file}: {reason}; give {what} that can be written") from error


def file_stem(path: str, otherwise: str) -> str:
    """A prim path as the name of a file: _ for each / and __ for each _; `otherwise` for an empty path."""
    return path.strip("/").replace("_", "__").replace("/", "_") or otherwise


def blended(color: Sequence[float]) -> np.ndarray:
    """A color over the background, (3,) uint8. Raises ValueError unless it is r, g, b, a from 0 to 1."""
    if len(color) != 4 or not all(0 <= part <= 1 for part in color):
        raise ValueError(f"color {color!r} is not r, g, b, a from 0 to 1")
    alpha = float(color[3])
    mixed = np.asarray(color[:3], np.float64) * 255.0 * alpha + BACKGROUND * (1.0 - alpha)
    return np.rint(mixed).astype(np.uint8)
