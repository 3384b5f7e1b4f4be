"""Pictures of recorded `sensor_msgs/Image` messages."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graph.base.outputs import replacing

IMAGE = "sensor_msgs/msg/Image"
_LAYOUTS = {
    "rgb8": ("u1", 3), "bgr8": ("u1", 3), "rgba8": ("u1", 4), "bgra8": ("u1", 4), "mono8": ("u1", 1), "8UC1": ("u1", 1),
    "8UC3": ("u1", 3), "mono16": ("u2", 1), "16UC1": ("u2", 1), "32SC1": ("i4", 1), "32FC1": ("f4", 1),
}  # fmt: skip
"""Encoding -> NumPy format and channels."""


def pixels(message: Any) -> NDArray[Any]:
    """(height, width) or (height, width, channels) array of an image, channels in the order of the encoding.

    Raises ValueError for an unknown encoding or too few bytes.
    """
    if message.encoding not in _LAYOUTS:
        raise ValueError(f"images of encoding {message.encoding!r} cannot be exported; known: {', '.join(_LAYOUTS)}")
    if not message.width or not message.height:
        raise ValueError("the image has no pixels")
    form, channels = _LAYOUTS[message.encoding]
    dtype = np.dtype((">" if message.is_bigendian else "<") + form)
    row = message.width * channels * dtype.itemsize
    data = np.asarray(message.data, np.uint8)
    if message.step < row or data.size < message.height * message.step:
        raise ValueError(f"{data.size} bytes are too few for {message.width} x {message.height} pixels")
    lines = data[: message.height * message.step].reshape(message.height, message.step)[:, :row]
    values = np.ascontiguousarray(lines).view(dtype).astype(dtype.newbyteorder("="))
    shape = (message.height, message.width, channels) if channels > 1 else (message.height, message.width)
    return values.reshape(shape)


def write_png(path: Path, message: Any) -> None:
    """A PNG: colours as they are; 16-bit grey for depth (32FC1) in millimetres, 0 without a hit or beyond 65.535 m, and
    for numbers (32SC1) up to 65,535.

    Raises ValueError for numbers above, and as `pixels` does.
    """
    from PIL import Image

    found, encoding = pixels(message), message.encoding
    if encoding in ("bgr8", "bgra8"):
        found = np.ascontiguousarray(found[:, :, [2, 1, 0, 3][: found.shape[2]]])
    elif encoding == "32FC1":
        millimetres = np.round(np.nan_to_num(found, nan=0.0, posinf=0.0, neginf=0.0).astype(np.float64) * 1000)
        found = np.where((millimetres >= 0) & (millimetres < 65536), millimetres, 0).astype(np.uint16)
    elif encoding == "32SC1":
        if found.size and (found.min() < 0 or found.max() > 65535):
            raise ValueError("its numbers go beyond 65,535, which a PNG cannot hold; use --format npz")
        found = found.astype(np.uint16)
    with replacing(path) as stream:
        Image.fromarray(found).save(stream, "PNG", compress_level=4)
