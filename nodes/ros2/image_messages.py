"""Functions that make ROS 2 image messages: pixels, encoded pixels, camera parameters."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from .messages import header, type_of

IMAGE = "sensor_msgs/msg/Image"
COMPRESSED = "sensor_msgs/msg/CompressedImage"
CAMERA_INFO = "sensor_msgs/msg/CameraInfo"

PIXEL_BYTES = {"rgb8": 3, "rgba8": 4, "bgra8": 4, "32FC1": 4, "32SC1": 4}
"""Bytes of a pixel by encoding."""


def image(nanoseconds: int, frame_id: str, width: int, height: int, encoding: str, data: Any) -> Any:
    """`sensor_msgs/Image`, rows from the top without padding; data: any array of width x height pixels."""
    return type_of(IMAGE)(
        header(nanoseconds, frame_id), height, width, encoding, 0, width * PIXEL_BYTES[encoding], as_bytes(data)
    )


def compressed_image(nanoseconds: int, frame_id: str, encoding: str, data: Any) -> Any:
    """`sensor_msgs/CompressedImage`."""
    return type_of(COMPRESSED)(header(nanoseconds, frame_id), encoding, as_bytes(data))


def camera_info(
    nanoseconds: int,
    frame_id: str,
    size: tuple[int, int],
    distortion: tuple[str, Sequence[float]],
    k: Sequence[float],
    r: Sequence[float],
    p: Sequence[float],
) -> Any:
    """`sensor_msgs/CameraInfo`; size: width, height [px]; distortion: model and coefficients; k, r 3 x 3, p 3 x 4."""
    import numpy as np

    model, coefficients = distortion
    roi = type_of("sensor_msgs/msg/RegionOfInterest")(0, 0, 0, 0, False)
    matrices = (np.array(values, dtype=np.float64) for values in (coefficients, k, r, p))
    return type_of(CAMERA_INFO)(header(nanoseconds, frame_id), size[1], size[0], model, *matrices, 0, 0, roi)


def as_bytes(data: Any) -> Any:
    """(n,) uint8 of bytes or of any array, in memory order."""
    import numpy as np

    if isinstance(data, bytes | bytearray | memoryview):
        return np.frombuffer(bytes(data), dtype=np.uint8)
    return np.ascontiguousarray(data).reshape(-1).view(np.uint8)
