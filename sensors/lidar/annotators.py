"""Scan buffers, which radars have too, and flat scans, which are a lidar's only."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from graph.base.errors import UserError
from graph.sim import settings as keys
from graph.sim.renderer.wrapper import unwrapped
from sensors.annotators.outputs import SCAN_BUFFER_CHANNELS, channels_of, empty_outputs, scan_buffer
from sensors.annotators.types import AnnotatorType, Reading, with_info
from sensors.sensor_types import measures_of

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


def _scan_channels(reading: Reading) -> frozenset[str]:
    return channels_of(_wanted(reading.options), measures_of(reading.sensor.type_name))


def _scan_buffer(reading: Reading) -> dict[str, Any]:
    found = {**empty_outputs(SCAN_BUFFER_CHANNELS), "objectId": np.empty(0, np.uint32)}
    if reading.frame is not None:
        found |= scan_buffer(reading.frame, reading.scene.meters_per_unit, _wanted(reading.options))
    return with_info(found, reading)


def _flat_scan(reading: Reading) -> dict[str, Any]:
    flat, settings = FlatScan(), reading.scene.settings
    if reading.frame is not None and _not_flat(reading) is None:
        flat = flat_scan(reading.frame, bins=settings.get(keys.SCAN_BINS))
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


def _not_flat(reading: Reading) -> UserError | None:
    """Why a flat scan of the product's lidar is not possible, or None."""
    from .runtime import LidarRuntime

    sensor = unwrapped(reading.sensor)
    if isinstance(sensor, LidarRuntime):
        try:
            require_2d(reading.product.camera_path, sensor.config)
        except UserError as error:
            return error
    return None


def _check_flat(reading: Reading) -> None:
    """Raises UserError for a 3-D lidar; in the profile isaacsim-6.0.1 warns of it."""
    error = _not_flat(reading)
    if error is None:
        return
    if reading.scene.settings.get(keys.FLAT_SCAN_NEEDS_2D):
        raise error
    reading.scene.warn("flat-scan-3d", "IsaacComputeRTXLidarFlatScan", f"{error}; its outputs stay at their defaults")


ANNOTATORS = (
    AnnotatorType(
        "IsaacCreateRTXLidarScanBuffer",
        _scan_buffer,
        _scan_channels,
        options={**dict.fromkeys(FLAGS, False), **NO_EFFECT},
        keeps_last=True,
        instead="IsaacExtractRTXSensorPointCloud",
    ),
    AnnotatorType(
        "IsaacComputeRTXLidarFlatScan",
        _flat_scan,
        lambda reading: FLAT_SCAN_CHANNELS,
        modality=MODALITY,
        keeps_last=True,
        check=_check_flat,
        instead="IsaacExtractRTXSensorPointCloud, or ROS2RtxLidarHelper with type laser_scan",
    ),
)
