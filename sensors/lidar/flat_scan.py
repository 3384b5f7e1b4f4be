"""Flat scans: a planar lidar's frame as one row of ranges, by azimuth or in the order in which the beams fire."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from graph.base.errors import UserError
from graph.base.records import dataclass, field
from sensors.frame import Frame, spherical
from sensors.sensor_types import prim_types_of

from .config import LidarConfig
from .names import MODALITY
from .pattern import firing_pattern
from .prim import read_config

if TYPE_CHECKING:
    from pxr import Usd


GRID = 0.05
"""How far a beam may lie from its place in the row, as a fraction of the spacing: azimuths are stored as float32."""


@dataclass(frozen=True, slots=True)
class BeamRow:
    """`count` beams: number i has azimuth start_deg + i * step_deg [deg] (a negative step turns clockwise) and fires
    i * time_step_s [s] after the first, which fires `first_ns` after the begin of a turn.
    """

    start_deg: float
    step_deg: float
    count: int
    time_step_s: float
    first_ns: int = 0

    def place(self, azimuth_deg: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """For azimuths (n,), the number of each beam, (n,) int64, and whether the beam is in the row, (n,) bool."""
        ahead = np.sign(self.step_deg) * (azimuth_deg.astype(np.float64) - self.start_deg)
        number = np.rint((ahead + abs(self.step_deg) / 2) % 360.0 / abs(self.step_deg) - 0.5).astype(np.int64)
        return number, (number >= 0) & (number < self.count)


def beam_row(config: LidarConfig) -> BeamRow:
    """One cell for each beam of a turn, starting at the first beam.

    Beams that fire along a row of equal steps keep their order; where a sector is passed at both ends of a turn, the
    cells between stay empty, so that times are true. Others, such as those of emitters that fire back and
    forth, are ordered counter-clockwise, with no time between them; if their spacing differs, cells have its mean.
    """
    pattern = firing_pattern(config)
    azimuth = pattern.azimuth_deg.astype(np.float64)
    if len(azimuth) < 2:
        return BeamRow(float(azimuth[0]) if len(azimuth) else 0.0, 360.0, len(azimuth), 0.0)
    turned = (np.diff(azimuth) + 180.0) % 360.0 - 180.0
    step = float(np.median(turned))
    turned = np.where(turned * step < 0, turned + np.sign(step) * 360.0, turned)
    row = _row(np.concatenate([[0.0], np.cumsum(turned)]), step) if step else None
    if row is not None:
        count, step = row
        seconds = float(pattern.offset_ns[-1] - pattern.offset_ns[0]) * 1e-9 / (count - 1)
        return BeamRow(float(azimuth[0]), step, count, seconds, int(pattern.offset_ns[0]))
    distinct = np.unique(azimuth)
    gap = int(np.argmax(np.diff(distinct, append=distinct[0] + 360.0)))  # the row begins after the largest gap
    start = float(distinct[(gap + 1) % len(distinct)])
    ahead = np.sort((distinct - start) % 360.0)
    row = _row(ahead, float(np.median(np.diff(ahead)))) if len(ahead) > 1 else None
    count, step = row or (len(ahead), float(ahead[-1]) / max(1, len(ahead) - 1) or 360.0)
    return BeamRow(start, step, count, 0.0, int(pattern.offset_ns[0]))


def _row(turned: np.ndarray, step: float) -> tuple[int, float] | None:
    """(count, step) of the row of equal steps that contains angles [deg] relative to the first; None if no row does."""
    place = np.rint(turned / step)
    if place[-1] < 1 or np.any(np.diff(place) < 1) or place[-1] * abs(step) > 360.0:
        return None
    step = float(turned[-1] / place[-1])
    return (int(place[-1]) + 1, step) if np.all(np.abs(turned - place * step) <= GRID * abs(step)) else None


FLAT_SCAN_CHANNELS = frozenset({"beamAzimuth", "beamDistance", "scalar"})
"""Angles and ranges in the sensor's frame, in whatever frame of reference it gives its points."""

EDGE = 1e-3
"""Beams of a rotary lidar lie on edges between columns; this fraction of a column absorbs float32 rounding."""


FLAT_DEG = 1e-3
"""Elevations up to this angle [deg] count as horizontal."""


@dataclass(slots=True)
class FlatScan:
    """A planar scan by columns of equal angle; angles in degrees, ranges in metres, -1 without a hit.

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


@dataclass(frozen=True, slots=True)
class Columns:
    """Columns of equal angle that a script gives a scan, as in `FlatScan`; azimuth_range: start and end."""

    horizontal_fov: float
    horizontal_resolution: float
    depth_range: tuple[float, float]
    rotation_rate: float
    azimuth_range: tuple[float, float]

    def problems(self) -> Iterator[str]:
        """What makes no scan, each as one line."""
        for name, value in (("Fov", self.horizontal_fov), ("Resolution", self.horizontal_resolution)):
            if not 0 < value <= 360:
                yield f"horizontal{name} is {value:g} deg; give it an angle above 0 and up to 360"
        if not self.horizontal_fov / MOST_COLUMNS <= self.horizontal_resolution:
            fine = f"horizontalResolution is {self.horizontal_resolution:g} deg"
            yield f"{fine}; a scan has at most {MOST_COLUMNS:,} columns"

    def of(self, frame: Frame) -> FlatScan:
        """The scan of a frame in these columns; elements as in `flat_scan`."""
        start, resolution = self.azimuth_range[0], self.horizontal_resolution
        end = start + self.horizontal_fov - resolution
        scan = FlatScan(self.horizontal_fov, resolution, self.depth_range, self.rotation_rate, (start, end))
        _fill(scan, frame, max(1, int(round(self.horizontal_fov / resolution, 6))), start, resolution)
        return scan


MOST_COLUMNS = 1_000_000


def flat_scan(frame: Frame, *, check_2d: bool = True, bins: bool = False) -> FlatScan:
    """IsaacComputeRTXLidarFlatScan of a frame.

    Rotary: resolution 360 x scan rate / firing rate over -180 to 180 deg. Solid state: one column for each emitter, as
    `beam_row` has them, ascending; with `bins` as in the product: from the smallest to the largest emitter azimuth, as
    many columns as emitters, shifted by -180 deg if it ends beyond 180. In bins an element belongs to column
    int((azimuth - start) / resolution), or to the last column if that is outside; the last element written wins. There
    is no filter by range or VALID flag. check_2d: raises UserError for a Cartesian frame, and for a lidar with an
    emitter out of the plane, which it names; otherwise such points are used unchanged.
    """
    config = frame.config
    if check_2d:
        require_2d(frame.sensor_path, config, frame.coords)
    if not (bins or config.is_rotary):
        return _by_emitter(frame)
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


def _by_emitter(frame: Frame) -> FlatScan:
    row = beam_row(frame.config)
    ranges, scalar = row_of(frame, row)
    step = abs(row.step_deg)
    last = row.start_deg + (row.count - 1) * row.step_deg
    order = slice(None, None, 1 if row.step_deg > 0 else -1)
    return FlatScan(
        horizontal_fov=row.count * step,
        horizontal_resolution=step,
        depth_range=(frame.config.near_range_m, frame.config.far_range_m),
        rotation_rate=float(frame.config.scan_rate_base_hz),
        azimuth_range=(min(row.start_deg, last), max(row.start_deg, last)),
        ranges=ranges[order],
        intensities=_intensities(scalar)[order],
    )


def row_of(frame: Frame, row: BeamRow) -> tuple[np.ndarray, np.ndarray]:
    """Ranges (row.count,) float32 [m], -1 for a beam without a return, and normalised intensities.

    Of several returns of a beam the last counts.
    """
    ranges, intensities = np.full(row.count, -1.0, np.float32), np.zeros(row.count, np.float32)
    azimuth, distance = _measured(frame)
    place, inside = row.place(azimuth)
    inside &= distance > 0  # a kept firing without a return has distance 0
    ranges[place[inside]] = distance[inside]
    scalar = frame.channel("scalar")
    if len(scalar):
        intensities[place[inside]] = scalar[inside]
    return ranges, intensities


def _measured(frame: Frame) -> tuple[np.ndarray, np.ndarray]:
    """Azimuths [deg] and distances [m] in the sensor's frame. Raises UserError if the frame does not hold them."""
    if frame.has("beamAzimuth") and frame.has("beamDistance"):
        return frame.channel("beamAzimuth"), frame.channel("beamDistance")
    if frame.frame_of_reference != "SENSOR":
        raise UserError(
            f"{frame.sensor_path}: a flat or laser scan needs points in the sensor's frame, but this frame holds them "
            f"in outputFrameOfReference {frame.frame_of_reference}; read the scan by renderProductPath"
        )
    azimuth, distance = frame.channel("azimuth"), frame.channel("distance")
    if not len(azimuth) and frame.has("xyz"):
        azimuth, _, distance = spherical(frame.xyz)
    return azimuth, distance


def _intensities(scalar: np.ndarray) -> np.ndarray:
    return np.asarray(np.clip(scalar * np.float32(255.0), 0, 255).astype(np.uint8))


def _fill(scan: FlatScan, frame: Frame, columns: int, start: float, resolution: float) -> None:
    scan.ranges = np.full(columns, -1.0, np.float32)
    scan.intensities = np.zeros(columns, np.uint8)
    azimuth, distance = _measured(frame)
    column = ((azimuth.astype(np.float64) - start) / resolution + EDGE).astype(np.int64)
    column[(column < 0) | (column >= columns)] = columns - 1
    scan.ranges[column] = distance
    scalar = frame.channel("scalar")
    if len(scalar):
        scan.intensities[column] = _intensities(scalar)


def require_2d(sensor_path: str, config: LidarConfig, coords: str = "") -> None:
    """Raises UserError for a lidar that cannot give a flat scan: Cartesian, or with an emitter out of the plane.

    The message names the emitter and its elevation. coords: those of the frame, if given.
    """
    coords = coords or config.elements_coords_type
    if coords != "SPHERICAL":
        raise UserError(f"{sensor_path}: a flat scan needs elementsCoordsType SPHERICAL, not {coords}")
    require_level_beams(sensor_path, config)


def require_level_beams(sensor_path: str, config: LidarConfig) -> None:
    """Raises UserError for a lidar with an emitter out of the plane; the message names it and its elevation."""
    for number, state in enumerate(config.emitter_states, start=1):
        off = np.flatnonzero(np.abs(state.elevation_deg) > FLAT_DEG)
        if len(off):
            which = f"emitter {off[0]}" + (f" of state s{number:03}" if number > 1 else "")
            raise UserError(
                f"{sensor_path}: a flat or laser scan needs a 2D lidar, but {which} points "
                f"{state.elevation_deg[off[0]]:g} deg up; use a lidar of one plane, such as config Example_Rotary_2D, "
                "or publish its point_cloud"
            )


def flat_scan_problem(prim: Usd.Prim) -> str | None:
    """Why a prim's lidar cannot give a flat scan, as one line; None if it can, and for other prims.

    Raises UserError for a lidar prim with an invalid configuration.
    """
    if prim.GetTypeName() not in prim_types_of(MODALITY):
        return None
    config = read_config(prim)
    try:
        require_2d(str(prim.GetPath()), config)
    except UserError as error:
        return str(error)
    return None
