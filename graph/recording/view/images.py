"""Camera images for the page: colours as they are, distances and numbers by the palette."""

from __future__ import annotations

from typing import Any

import numpy as np

from graph.recording.export.images import pixels
from sensors.writers.palette import NEAR, indices, spread

from .colours import picture

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
