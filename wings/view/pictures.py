"""Pictures of the page: camera images, range images and clouds from above; numbers by the palette."""

from __future__ import annotations

import base64
from io import BytesIO
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graph.recording.contents.images import pixels
from graph.recording.contents.scans import Scan
from graph.sim.transforms import Floats
from sensors.writers.palette import NEAR, indices, palette, spread, widened
from sensors.writers.scale import draw_labels, draw_mark, draw_rings, with_bar


def picture(numbers: NDArray[np.uint8]) -> Any:
    """The image of an array (height, width) of palette numbers."""
    from PIL import Image

    image = Image.fromarray(numbers, "P")
    image.putpalette(palette().reshape(-1).tobytes())
    return image


def source(image: Any, form: str) -> str:
    """An image as the address that a page shows: PNG or JPEG as base64."""
    stream = BytesIO()
    image.save(stream, form, **({"quality": 82} if form == "JPEG" else {"optimize": True}))
    return f"data:image/{form.lower()};base64,{base64.b64encode(stream.getvalue()).decode()}"


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


WIDEST = 480
"""Pixels of a picture in the page; wider images are made smaller."""
MIXER = 2654435761
"""Knuth's multiplicative hash: neighbouring labels get different colours."""


def image_of(message: Any) -> tuple[Any, str, tuple[float, float] | None]:
    """The picture of a `sensor_msgs/Image` in its own size, and the format that fits it (JPEG, PNG).

    Of distances also those [m] of the first and the last colour: the nearest, and nearly the farthest.
    Raises ValueError for an image that cannot be read.
    """
    from PIL import Image

    found, encoding = pixels(message), message.encoding
    if found.size == 0:
        raise ValueError("the image is empty")
    if encoding in ("bgr8", "bgra8"):
        found = found[:, :, [2, 1, 0, 3][: found.shape[2]]]
    if found.ndim == 3:
        return Image.fromarray(np.ascontiguousarray(found[:, :, :3])), "JPEG", None
    if encoding in ("32SC1", "8UC1"):  # labels
        mixed = (found.astype(np.int64) * MIXER >> 7) % 255 + 1
        return picture(np.where(found == 0, 0, mixed).astype(np.uint8)), "PNG", None
    if encoding == "mono8":
        return Image.fromarray(np.ascontiguousarray(found)), "PNG", None
    values = found.astype(np.float64)
    values = np.where(values > 0, values, np.nan) if encoding != "mono16" else values
    low, high = spread(values, NEAR)
    metres = (low, high) if encoding == "32FC1" else (low / 1000, high / 1000) if encoding == "16UC1" else None
    return picture(indices(values, low, high)), "PNG", metres


def small(image: Any) -> Any:
    """The image, at most `WIDEST` pixels wide."""
    if image.width <= WIDEST:
        return image
    from PIL import Image

    how = Image.Resampling.NEAREST if image.mode == "P" else Image.Resampling.BILINEAR
    return image.resize((WIDEST, max(1, round(image.height * WIDEST / image.width))), how)


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
