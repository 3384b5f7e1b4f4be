"""ROS 2 messages as Rerun's own archetypes: points, images, cameras, transforms, texts, and numbers as time series.

Entities have the topic as path. Frames of messages are Rerun's named frames, which transforms connect as TF does.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from graph.sim.messages.ros_fields import NUMBERS, leaves, unpack

Logged = Iterator[tuple[str, Any]]
"""Entity paths and what to log there."""

_MOST_SERIES = 64
"""The longest list of numbers that becomes time series."""
_POINT_FORMATS = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 8: "f8"}
_COLOURS = {"rgb8": ("RGB", 3), "bgr8": ("BGR", 3), "rgba8": ("RGBA", 4), "bgra8": ("BGRA", 4), "mono8": ("L", 1)}
_DEPTHS = {"32FC1": ("f4", 1.0), "16UC1": ("u2", 1000.0)}
"""Depth encodings: NumPy format, counts per metre (REP-118)."""
_PICTURES = {"jpeg": "image/jpeg", "jpg": "image/jpeg", "png": "image/png"}


def archetypes(rerun: Any, topic: str, type_name: str, message: Any) -> Logged:
    """What to log for a message; `rerun` is the library. Other types give their numbers, each a time series."""
    made = _MAKERS.get(type_name)
    if made is None:
        yield from _numbers(rerun, topic, type_name, message)
        return
    yield from made(rerun, topic, message)
    header = getattr(message, "header", None)
    if header is not None and header.frame_id:
        yield topic, rerun.CoordinateFrame(header.frame_id)


def points(message: Any) -> np.ndarray[Any, np.dtype[np.float32]]:
    """The (n, 3) float32 x, y, z [m] of a `sensor_msgs/PointCloud2`; zeros for a missing coordinate."""
    order = ">" if message.is_bigendian else "<"
    named = {field.name: field for field in message.fields if field.name in ("x", "y", "z")}
    layout = np.dtype(
        {
            "names": list(named),
            "formats": [order + _POINT_FORMATS[field.datatype] for field in named.values()],
            "offsets": [field.offset for field in named.values()],
            "itemsize": message.point_step,
        }
    )
    count = message.width * message.height
    cloud = np.frombuffer(message.data, layout, count)
    found = np.zeros((count, 3), np.float32)
    for column, name in enumerate(("x", "y", "z")):
        if name in named:
            found[:, column] = cloud[name]
    return found


def _cloud(rerun: Any, topic: str, message: Any) -> Logged:
    yield topic, rerun.Points3D(points(message))


def _scan(rerun: Any, topic: str, message: Any) -> Logged:
    ranges = np.asarray(message.ranges, np.float64)
    angles = message.angle_min + message.angle_increment * np.arange(len(ranges))
    hit = np.isfinite(ranges) & (ranges >= message.range_min) & (ranges <= message.range_max)
    flat = [ranges * np.cos(angles), ranges * np.sin(angles), np.zeros(len(ranges))]
    yield topic, rerun.Points3D(np.stack(flat, axis=1)[hit].astype(np.float32))


def _image(rerun: Any, topic: str, message: Any) -> Logged:
    height, width = message.height, message.width
    rows = np.asarray(message.data, np.uint8).reshape(height, message.step)
    if message.encoding in _COLOURS:
        model, channels = _COLOURS[message.encoding]
        data = rows[:, : width * channels].tobytes()
        yield topic, rerun.Image(bytes=data, width=width, height=height, color_model=model, datatype="u8")
    elif message.encoding in _DEPTHS:
        form, metre = _DEPTHS[message.encoding]
        pixels = rows[:, : width * np.dtype(form).itemsize].copy().view(f"<{form}")
        yield topic, rerun.DepthImage(pixels, meter=metre)
    elif message.encoding == "32SC1":
        labels = rows[:, : width * 4].copy().view("<i4")
        yield topic, rerun.SegmentationImage(labels.astype(np.uint16))


def _picture(rerun: Any, topic: str, message: Any) -> Logged:
    kind = next((_PICTURES[word] for word in message.format.lower().split() if word in _PICTURES), None)
    if kind is not None:
        yield topic, rerun.EncodedImage(contents=bytes(message.data), media_type=kind)


def _camera(rerun: Any, topic: str, message: Any) -> Logged:
    matrix = np.asarray(message.k, np.float64).reshape(3, 3)
    if matrix[0, 0] > 0:
        yield topic, rerun.Pinhole(image_from_camera=matrix, width=message.width, height=message.height)


def _transforms(rerun: Any, topic: str, message: Any) -> Logged:
    for one in message.transforms:
        move, turn = one.transform.translation, one.transform.rotation
        yield (
            f"{topic}/{one.child_frame_id}",
            rerun.Transform3D(
                translation=[move.x, move.y, move.z],
                quaternion=rerun.Quaternion(xyzw=[turn.x, turn.y, turn.z, turn.w]),
                parent_frame=one.header.frame_id,
                child_frame=one.child_frame_id,
            ),
        )


def _text(rerun: Any, topic: str, message: Any) -> Logged:
    yield topic, rerun.TextLog(message.data)


def _nothing(rerun: Any, topic: str, message: Any) -> Logged:
    yield from ()


def _numbers(rerun: Any, topic: str, type_name: str, message: Any) -> Logged:
    for leaf, value in zip(leaves(type_name), unpack(type_name, message), strict=True):
        kind, _, listed = leaf.type.partition("[")
        if kind not in _SERIES or leaf.name.startswith("header:") or leaf.name.endswith("covariance"):
            continue
        if not listed:
            yield f"{topic}/{leaf.name.replace(':', '/')}", rerun.Scalars(float(value))
        elif 0 < len(value) <= _MOST_SERIES:
            yield f"{topic}/{leaf.name.replace(':', '/')}", rerun.Scalars(np.asarray(value, np.float64))


_SERIES = {ogn for ogn, _ in NUMBERS.values()}
_MAKERS: dict[str, Callable[[Any, str, Any], Logged]] = {
    "sensor_msgs/msg/PointCloud2": _cloud,
    "sensor_msgs/msg/LaserScan": _scan,
    "sensor_msgs/msg/Image": _image,
    "sensor_msgs/msg/CompressedImage": _picture,
    "sensor_msgs/msg/CameraInfo": _camera,
    "tf2_msgs/msg/TFMessage": _transforms,
    "std_msgs/msg/String": _text,
    "rosgraph_msgs/msg/Clock": _nothing,  # the time line itself
}
