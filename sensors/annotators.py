"""What annotator nodes hand out, as plain functions of a frame."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from graph.base.errors import UserError

from .channels import CHANNELS
from .frame import Frame, spherical

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
}
"""Name of a node output -> the channel it comes from; timestamps are absolute, u64 ns."""

SCAN_BUFFER_CHANNELS: dict[str, tuple[str, ...]] = {
    "data": ("xyz",),
    **{name: (channel,) for name, channel in LABELS.items()},
    "radialVelocityMS": (),
}
"""Output of IsaacCreateRTXLidarScanBuffer -> channels to require for it; radialVelocityMS is a radar's only."""

EXTRACT_CHANNELS = frozenset({"xyz", "azimuth", "elevation", "distance", "scalar", "timeOffsetNs"})
"""What IsaacExtractRTXSensorPointCloud always hands out; auxiliary outputs follow what the frame holds."""

FLAT_SCAN_CHANNELS = frozenset({"azimuth", "distance", "scalar"})

EDGE = 1e-3
"""Beams of a rotary lidar lie on the edges between columns: this share of a column absorbs their float32 rounding."""


FLAT_DEG = 1e-3
"""Elevations up to here [deg] count as horizontal."""


def transform_of(frame: Frame) -> np.ndarray:
    """(4, 4) float64 sensor to world, row-vector convention [m], from the frame's end; also when the frame is WORLD."""
    return np.ascontiguousarray(frame.end.world_sensor.T)


def labelled(frame: Frame, name: str) -> np.ndarray:
    """The array of a node output (see `LABELS`), empty where the frame does not hold it.

    objectId: (N, 16) uint8, little-endian. radialVelocityMS: empty for a lidar.
    """
    if name not in LABELS:
        return empty_outputs((name,))[name]
    array = frame.channel(LABELS[name])
    if name == "timestamp":
        return array.astype(np.uint64) + np.uint64(frame.timestamp_ns)
    return array


def empty_outputs(names: Iterable[str]) -> dict[str, np.ndarray]:
    """Node outputs before there is a frame: no elements, each in its own dtype and shape."""
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
    """IsaacExtractRTXSensorPointCloud: `data` points (N, 3) float32 [m], `transform`, and what else the frame holds.

    azimuth and elevation are in degrees (for a Cartesian frame: x, y, z, as the original hands out); distance [m].
    Points are not filtered by the VALID flag.
    """
    found = {"data": frame.xyz, "transform": transform_of(frame)}
    for name in LABELS:
        array = labelled(frame, name)
        if len(array) or frame.has(LABELS[name]):
            found[name] = array
    if frame.coords == "CARTESIAN":
        found |= {name: frame.xyz[:, axis] for axis, name in enumerate(("azimuth", "elevation", "distance"))}
    return found


def scan_buffer(frame: Frame, meters_per_unit: float, names: Iterable[str]) -> dict[str, np.ndarray]:
    """IsaacCreateRTXLidarScanBuffer: `data`, `transform`, and the named outputs; one that the frame lacks is empty.

    `data` (N, 3) float32 and distance are in stage units, and so is the transform's translation. What the frame
    holds is what comes out: nothing is accumulated here.
    """
    to_stage = np.float32(1.0 / meters_per_unit)
    transform = transform_of(frame)
    transform[3, :3] /= meters_per_unit
    found = {"data": frame.xyz * to_stage if meters_per_unit != 1.0 else frame.xyz, "transform": transform}
    for name in names:
        array = labelled(frame, name)
        found[name] = array * to_stage if name == "distance" and meters_per_unit != 1.0 else array
    return found


@dataclass(slots=True)
class FlatScan:
    """A planar scan by columns of equal angle; angles in degrees, ranges in metres, -1 where nothing was hit.

    azimuth_range: start, and end less one resolution. intensities: 0 to 255. rotation_rate [Hz].
    """

    horizontal_fov: float = 0.0
    horizontal_resolution: float = 0.0
    depth_range: tuple[float, float] = (0.0, 0.0)
    rotation_rate: float = 0.0
    azimuth_range: tuple[float, float] = (0.0, 0.0)
    ranges: np.ndarray = field(default_factory=lambda: np.empty(0, np.float32))
    intensities: np.ndarray = field(default_factory=lambda: np.empty(0, np.uint8))
    num_rows: int = 1

    @property
    def num_cols(self) -> int:
        """Number of columns."""
        return len(self.ranges)


def flat_scan(frame: Frame, *, check_2d: bool = True) -> FlatScan:
    """IsaacComputeRTXLidarFlatScan of a frame.

    Rotary: resolution 360 x scan rate / firing rate over -180 to 180 deg. Solid state: from the smallest to the
    largest emitter azimuth, by their number; shifted by -180 deg when it ends beyond 180. An element falls into column
    int((azimuth - start) / resolution), the last column if that lies outside; the last one written wins. No filter by
    range or VALID flag. check_2d: raises UserError for a Cartesian frame, and for a lidar with an emitter out of the
    plane, naming it; otherwise such points are taken as they are.
    """
    config = frame.config
    if check_2d:
        require_2d(frame.sensor_path, config, frame.coords)
    state = config.emitter_states[0]
    shift = 0.0
    if config.is_rotary:
        resolution = float(360 * config.scan_rate_base_hz / config.ticks_per_second)
        start, end = -180.0, 180.0
    else:
        start, end = float(state.azimuth_deg.min()), float(state.azimuth_deg.max())
        resolution = (end - start) / config.number_of_emitters
        if end > 180.0:
            shift = -180.0
            start, end = start + shift, end + shift
    scan = FlatScan(
        horizontal_fov=end - start,
        horizontal_resolution=resolution,
        depth_range=(config.near_range_m, config.far_range_m),
        rotation_rate=float(config.scan_rate_base_hz),
        azimuth_range=(start, end - resolution),
    )
    columns = int(round((end - start) / resolution, 6)) if resolution > 0 else 0
    if columns:
        _fill(scan, frame, columns, start, resolution)
    return scan


def _fill(scan: FlatScan, frame: Frame, columns: int, start: float, resolution: float) -> None:
    scan.ranges = np.full(columns, -1.0, np.float32)
    scan.intensities = np.zeros(columns, np.uint8)
    azimuth, distance = frame.channel("azimuth"), frame.channel("distance")
    if not len(azimuth) and frame.has("xyz"):
        azimuth, _, distance = spherical(frame.xyz)
    column = ((azimuth.astype(np.float64) - start) / resolution + EDGE).astype(np.int64)
    column[(column < 0) | (column >= columns)] = columns - 1
    scan.ranges[column] = distance
    scalar = frame.channel("scalar")
    if len(scalar):
        scan.intensities[column] = np.clip(scalar * np.float32(255.0), 0, 255).astype(np.uint8)


def require_2d(sensor_path: str, config: Any, coords: str = "") -> None:
    """Raises UserError for a lidar that a flat scan cannot be made of: Cartesian, or with an emitter out of the plane,
    which is named with its elevation. coords: what the frame has, where there is one.
    """
    coords = coords or config.elements_coords_type
    if coords != "SPHERICAL":
        raise UserError(f"{sensor_path}: a flat scan needs elementsCoordsType SPHERICAL, not {coords}")
    for number, state in enumerate(config.emitter_states, start=1):
        off = np.flatnonzero(np.abs(state.elevation_deg) > FLAT_DEG)
        if len(off):
            which = f"emitter {off[0]}" + (f" of state s{number:03}" if number > 1 else "")
            raise UserError(
                f"{sensor_path}: a flat scan needs a 2D lidar, but {which} points {state.elevation_deg[off[0]]:g} deg "
                "up; use a lidar with all elevations 0"
            )


__all__ = [
    "CHANNELS",
    "EXTRACT_CHANNELS",
    "FLAT_SCAN_CHANNELS",
    "LABELS",
    "SCAN_BUFFER_CHANNELS",
    "FlatScan",
    "empty_outputs",
    "extract_point_cloud",
    "flat_scan",
    "labelled",
    "require_2d",
    "scan_buffer",
    "transform_of",
]
