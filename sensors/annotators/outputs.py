"""The outputs of annotators and nodes for point clouds, as plain functions of a frame."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from sensors.channels import CHANNELS
from sensors.frame import Frame

LABELS = {
    "azimuth": "azimuth",
    "elevation": "elevation",
    "distance": "distance",
    "intensity": "scalar",
    "timestamp": "timeOffsetNs",
    "emitterId": "emitterId",
    "channelId": "channelId",
    "materialId": "matId",
    "tickId": "tickId",
    "hitNormal": "hitNormals",
    "velocity": "velocities",
    "objectId": "objId",
    "echoId": "echoId",
    "tickState": "tickStates",
    "radialVelocityMS": "rv_ms",
}
"""Name of a node output -> its channel; timestamps are absolute, u64 ns."""

SCAN_BUFFER_CHANNELS = {"data": "xyz", **LABELS}
"""Output of IsaacCreateRTXLidarScanBuffer -> the channel it needs; what the sensor does not measure stays empty."""

EXTRACT_CHANNELS = frozenset({"xyz", "azimuth", "elevation", "distance", "scalar", "timeOffsetNs"})
"""The outputs that IsaacExtractRTXSensorPointCloud always gives; auxiliary outputs depend on the frame."""


def channels_of(names: Iterable[str], measures: frozenset[str]) -> frozenset[str]:
    """The channels to request for some outputs of a sensor: points, and of the rest those that it measures."""
    return measures.intersection(SCAN_BUFFER_CHANNELS[name] for name in names) | {"xyz"}


def transform_of(frame: Frame) -> np.ndarray:
    """(4, 4) float64 sensor to world, row-vector convention [m], at the frame's end; also if the frame is WORLD."""
    return np.ascontiguousarray(frame.end.world_sensor.T)


def labelled(frame: Frame, name: str) -> np.ndarray:
    """The array of a node output (see `LABELS`); empty if the frame does not hold it.

    objectId: (N, 16) uint8, little-endian. radialVelocityMS: empty for a lidar.
    """
    if name not in LABELS:
        return empty_outputs((name,))[name]
    array = frame.channel(LABELS[name])
    if name == "timestamp":
        return array.astype(np.uint64) + np.uint64(frame.timestamp_ns)
    return array


def empty_outputs(names: Iterable[str]) -> dict[str, np.ndarray]:
    """Node outputs before the first frame: no elements, each with its own dtype and shape."""
    found = {}
    for name in names:
        if name == "timestamp":
            found[name] = np.empty(0, np.uint64)
        elif name == "data":
            found[name] = CHANNELS["xyz"].empty()
        else:
            found[name] = CHANNELS[LABELS[name]].empty() if name in LABELS else np.empty(0, np.float32)
    return found


def extract_point_cloud(frame: Frame) -> dict[str, np.ndarray]:
    """IsaacExtractRTXSensorPointCloud: `data` points (N, 3) float32 [m], `transform`, and the frame's other quantities.

    azimuth and elevation are in degrees (for a Cartesian frame: x, y, z, as in the original); distance [m].
    Points are not filtered by the VALID flag.
    """
    found = {"data": frame.xyz, "transform": transform_of(frame)}
    found |= {name: labelled(frame, name) for name, channel in LABELS.items() if channel in frame.arrays}
    if frame.coords == "CARTESIAN":
        found |= {name: frame.xyz[:, axis] for axis, name in enumerate(("azimuth", "elevation", "distance"))}
    return found


def cloud_on_device(frame: Frame) -> dict[str, Any]:
    """The arrays of `extract_point_cloud` for a frame on a device, there; `timestamp` counts from the frame's own."""
    arrays: Any = frame.arrays
    names = {"data": "xyz", **LABELS}
    found = {name: arrays.on_device(channel) for name, channel in names.items() if channel in arrays}
    if frame.coords == "CARTESIAN":
        found |= {name: found["data"][:, axis] for axis, name in enumerate(("azimuth", "elevation", "distance"))}
    return found


def scan_buffer(frame: Frame, meters_per_unit: float, names: Iterable[str]) -> dict[str, np.ndarray]:
    """IsaacCreateRTXLidarScanBuffer:

    `data`, `transform`, and the named outputs; one that the frame does not hold is empty.

    `data` (N, 3) float32, distance and the transform's translation are in stage units. The output holds one frame:
    nothing is accumulated here. objectId: (4 N,) uint32, the lowest word of each id first.
    """
    to_stage = np.float32(1.0 / meters_per_unit)
    transform = transform_of(frame)
    transform[3, :3] /= meters_per_unit
    found = {"data": frame.xyz * to_stage if meters_per_unit != 1.0 else frame.xyz, "transform": transform}
    for name in names:
        array = labelled(frame, name)
        if name == "objectId":
            array = np.ascontiguousarray(array).reshape(-1).view("<u4")
        found[name] = array * to_stage if name == "distance" and meters_per_unit != 1.0 else array
    return found
