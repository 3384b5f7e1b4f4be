"""Points of recorded messages as structured arrays, one named column for each field."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from graph.base.exact import NANOSECONDS

Points = NDArray[np.void]

CLOUD = "sensor_msgs/msg/PointCloud2"
SCAN = "sensor_msgs/msg/LaserScan"
TYPES = (CLOUD, SCAN)
"""Message types that hold points."""
_FORMATS = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 8: "f8"}
"""NumPy formats of sensor_msgs/PointField datatypes."""


def points_of(message: Any, type_name: str) -> Points:
    """The points (n,) of a cloud or a laser scan, packed, little-endian, with the columns x, y, z [m] and the others.

    A field of several values becomes name_0, name_1, ... Raises ValueError for a message whose layout contradicts
    itself or has no x, y, z.
    """
    return _of_cloud(message) if type_name == CLOUD else _of_scan(message)


def _of_cloud(message: Any) -> Points:
    order = ">" if message.is_bigendian else "<"
    layout: dict[str, tuple[str, int]] = {}
    for one in message.fields:
        if one.datatype not in _FORMATS:
            raise ValueError(f"field {one.name} has the unknown datatype {one.datatype}")
        form = np.dtype(order + _FORMATS[one.datatype])
        for place in range(min(max(1, one.count), 1000)):
            name = one.name if one.count <= 1 else f"{one.name}_{place}"
            offset = one.offset + place * form.itemsize
            if name in layout or offset + form.itemsize > message.point_step:
                raise ValueError(
                    f"field {name} is there twice, or does not fit into a point of {message.point_step} bytes"
                )
            layout[name] = form.str, offset
    if missing := {"x", "y", "z"} - layout.keys():
        raise ValueError(f"the cloud has no field {', '.join(sorted(missing))}")
    packed = np.dtype([(name, np.dtype(form).newbyteorder("<")) for name, (form, _) in layout.items()])
    data = np.asarray(message.data, np.uint8)
    if message.point_step >= 2**31:
        raise ValueError(f"a point of {message.point_step} bytes is beyond what an array can have")
    used = message.width * message.point_step
    if (message.height > 1 and message.row_step < used) or data.size < message.height * used:
        raise ValueError(f"{data.size} bytes of data are too few for {message.height} x {message.width} points")
    if message.height > 1 and message.row_step > used:  # rows with a filling at their ends
        rows = data[: message.height * message.row_step].reshape(message.height, message.row_step)
        data = np.ascontiguousarray(rows[:, :used]).reshape(-1)
    names, forms, offsets = zip(*((name, form, offset) for name, (form, offset) in layout.items()), strict=True)
    stated = np.dtype(
        {"names": list(names), "formats": list(forms), "offsets": list(offsets), "itemsize": message.point_step}
    )
    found = data[: message.height * used].view(stated)
    return found.astype(packed)


def _of_scan(message: Any) -> Points:
    """x, y, z, intensity, time [s after the header]; without the beams that have no return."""
    ranges = np.asarray(message.ranges, np.float64)
    strong = np.asarray(message.intensities, np.float32)
    valid = np.isfinite(ranges) & (ranges >= message.range_min) & (ranges <= message.range_max)
    (beams,) = np.nonzero(valid)
    angles = message.angle_min + beams * float(message.angle_increment)
    columns = np.dtype([("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("intensity", "<f4"), ("time", "<f4")])
    found = np.zeros(len(beams), columns)
    found["x"], found["y"] = ranges[valid] * np.cos(angles), ranges[valid] * np.sin(angles)
    if len(strong) == len(ranges):
        found["intensity"] = strong[valid]
    found["time"] = beams * float(message.time_increment)
    return found


def times_of(points: Points, stamp_ns: int) -> NDArray[np.int64] | None:
    """(n,) time of each point [ns]; None if the cloud has neither of the fields timestamp_0 and _1, time, t."""
    names = points.dtype.names or ()
    found: NDArray[np.int64] | None = None
    if "timestamp_0" in names and "timestamp_1" in names:
        high = points["timestamp_1"].astype(np.uint64) << np.uint64(32)
        found = (high | points["timestamp_0"]).astype(np.int64)
    elif "time" in names:
        found = stamp_ns + np.round(points["time"].astype(np.float64) * NANOSECONDS).astype(np.int64)
    elif "t" in names:  # Ouster: nanoseconds after the header
        found = stamp_ns + points["t"].astype(np.int64)
    return found


def xyz(points: Points) -> NDArray[np.float64]:
    """(n, 3) the coordinates [m]."""
    return np.stack([points["x"], points["y"], points["z"]], axis=1).astype(np.float64)


def intensity(points: Points) -> NDArray[np.float32]:
    """(n,) the field intensity; 0 without one."""
    names = points.dtype.names or ()
    found: NDArray[np.float32] = (
        points["intensity"].astype(np.float32) if "intensity" in names else np.zeros(len(points), np.float32)
    )
    return found
