"""The annotators that read only lidars: scan buffers and flat scans."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from graph.sim import settings as keys
from graph.sim.renderer.wrapper import unwrapped
from sensors.annotators.outputs import SCAN_BUFFER_CHANNELS, empty_outputs, scan_buffer
from sensors.annotators.types import AnnotatorType, Reading, with_info

from .flat_scan import FLAT_SCAN_CHANNELS, FlatScan, flat_scan, require_2d
from .names import MODALITY

FLAGS = {f"output{name[0].upper()}{name[1:]}": name for name in SCAN_BUFFER_CHANNELS if name != "data"}
"""Option of IsaacCreateRTXLidarScanBuffer -> the output that it adds."""

NO_EFFECT = {
    "keepOnlyPositiveDistance": True,
    "transformPoints": False,
    "accuracyErrorAzimuthDeg": 0.0,
    "accuracyErrorElevationDeg": 0.0,
    "accuracyErrorPosition": (0.0, 0.0, 0.0),
    "enablePerFrameOutput": False,
    "cudaDeviceIndex": -1,
}
"""Options that the original has but does not read."""


def _wanted(options: Mapping[str, Any]) -> list[str]:
    return [name for flag, name in FLAGS.items() if options[flag]]


def _scan_channels(reading: Reading) -> set[str]:
    return {"xyz"}.union(*(SCAN_BUFFER_CHANNELS[name] for name in _wanted(reading.options)))


def _scan_buffer(reading: Reading) -> dict[str, Any]:
    names = _wanted(reading.options)
    if reading.frame is None:
        empty = empty_outputs(("data", *names))
        if "objectId" in empty:
            empty["objectId"] = np.empty(0, np.uint32)
        return with_info(empty, reading)
    return with_info(scan_buffer(reading.frame, reading.app.meters_per_unit, names), reading)


def _flat_scan(reading: Reading) -> dict[str, Any]:
    flat = (
        FlatScan() if reading.frame is None else flat_scan(reading.frame, bins=reading.app.settings.get(keys.SCAN_BINS))
    )
    return {
        "linearDepthData": flat.ranges,
        "intensitiesData": flat.intensities,
        "horizontalFov": flat.horizontal_fov,
        "horizontalResolution": flat.horizontal_resolution,
        "depthRange": np.array(flat.depth_range, np.float32),
        "rotationRate": flat.rotation_rate,
        "azimuthRange": np.array(flat.azimuth_range, np.float32),
        "numRows": flat.num_rows,
        "numCols": flat.num_cols,
    }


def _is_flat(reading: Reading) -> None:
    from .runtime import LidarRuntime

    sensor = unwrapped(reading.sensor)
    if isinstance(sensor, LidarRuntime):
        require_2d(reading.product.camera_path, sensor.config)


ANNOTATORS = (
    AnnotatorType(
        "IsaacCreateRTXLidarScanBuffer",
        _scan_buffer,
        _scan_channels,
        options={**dict.fromkeys(FLAGS, False), **NO_EFFECT},
        modality=MODALITY,
        keeps_last=True,
        instead="IsaacExtractRTXSensorPointCloud",
    ),
    AnnotatorType(
        "IsaacComputeRTXLidarFlatScan",
        _flat_scan,
        lambda reading: FLAT_SCAN_CHANNELS,
        modality=MODALITY,
        keeps_last=True,
        check=_is_flat,
        instead="IsaacExtractRTXSensorPointCloud, or ROS2RtxLidarHelper with type laser_scan",
    ),
)
