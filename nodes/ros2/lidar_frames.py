"""Makes ROS 2 messages from lidar frames."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from graph.base.exact import NANOSECONDS, nanoseconds
from graph.base.records import dataclass

from .point_clouds import CLOUD_FIELDS, CloudGrid, point_cloud

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from sensors.frame import Frame
    from sensors.lidar.config import LidarConfig
    from sensors.lidar.flat_scan import BeamRow, Columns

    from .laser_scans import ScanStyle

GRID_CHANNELS = frozenset({"ring", "column"})
"""The channels of a frame that an organised cloud needs."""


def cloud_channels(metadata: Iterable[str]) -> frozenset[str]:
    """The channels of a frame that a cloud with these quantities needs."""
    return frozenset({"xyz", *(CLOUD_FIELDS[name].channel for name in metadata)})


def frame_cloud(
    frame: Frame, metadata: Iterable[str], nanoseconds: int, frame_id: str, grid: CloudGrid | None = None
) -> Any:
    """`sensor_msgs/PointCloud2` of a frame's points, with the chosen quantities as far as the frame holds them."""
    values = {name: column(frame, name) for name in metadata}
    return point_cloud(frame_points(frame), values, nanoseconds, frame_id, grid)


def frame_points(frame: Frame) -> NDArray[np.float32]:
    """(n, 3) the points [m]; NaN for a kept firing without a return, which a frame stores at the origin."""
    import numpy as np

    points = frame.xyz
    if frame.modality != "LIDAR" or not frame.config.skip_dropping_invalid_points:
        return points
    return np.where(np.any(points, axis=1, keepdims=True), points, np.float32(np.nan))


def column(frame: Frame, name: str) -> NDArray[np.generic]:
    """One quantity of `CLOUD_FIELDS` in the form that `point_cloud` takes; empty if the frame does not hold it."""
    import numpy as np

    channel = CLOUD_FIELDS[name].channel
    if channel not in frame.arrays:
        return np.empty(0)
    array = frame.channel(channel)
    if name == "Timestamp":
        return array.astype(np.int64) + frame.timestamp_ns
    if name == "Time":
        return point_times(frame) - nanoseconds(frame.reference)
    return array


def point_times(frame: Frame) -> NDArray[np.int64]:
    """(n,) the time [ns] as of which a transform puts each point where it was seen: of its firing, or of the one pose
    that compensated points share.
    """
    import numpy as np

    offsets = frame.channel("timeOffsetNs").astype(np.int64)
    common = frame.common_ns
    return offsets + frame.timestamp_ns if common is None else np.full_like(offsets, common)


@dataclass(slots=True)
class Grids:
    """The grid of each of a lidar's frames: a row for each line, the lowest first, a column for each firing of it."""

    config: Any = None
    shape: tuple[int, int] = (0, 0)

    def of(self, frame: Frame) -> CloudGrid:
        """The grid of a frame. Raises UserError for a lidar whose grid would be far larger than its scan."""
        import numpy as np

        if frame.config is not self.config:
            self.config, self.shape = frame.config, grid_shape(frame.config, frame.sensor_path)
        height, width = self.shape
        cells = frame.channel("ring").astype(np.int64) * width + frame.channel("column")
        return CloudGrid(height, width, cells)


def grid_shape(config: LidarConfig, path: str) -> tuple[int, int]:
    """(lines, firings of the longest line in a scan). Raises UserError if most of the cells would always be empty."""
    from graph.base.errors import UserError
    from sensors.lidar.lines import lines_of

    lines = lines_of(config)
    lines.check(path)
    height, width = lines.count, lines.longest * config.ticks_per_scan
    if height * width > SPARSEST * config.rays_per_scan:
        raise UserError(
            f"{path}: an organised cloud of {height:,} lines and {width:,} columns would be nearly empty; a scan has "
            f"{config.rays_per_scan:,} rays; leave organized out"
        )
    return height, width


SPARSEST = 16
"""An organised cloud has at most this many cells for each ray of a scan."""


@dataclass(slots=True)
class FrameScan:
    """Makes `sensor_msgs/LaserScan` of a planar lidar's frames: one cell for each beam, in the order of firing; or,
    where `style` wants bins, or there are `columns`, by azimuth as the product does, whatever the elevations. The last
    return of a cell wins.
    """

    frame_id: str
    style: ScanStyle
    config: Any = None
    row: BeamRow | None = None
    columns: Columns | None = None

    def __call__(self, frame: Frame, nanoseconds: int) -> Any:
        """The message of a frame with this stamp."""
        import numpy as np

        from sensors.lidar.flat_scan import flat_scan, row_of

        from .laser_scans import laser_scan

        columns = self.columns
        if columns is not None or self.style.bins:
            flat = columns.of(frame) if columns else flat_scan(frame, check_2d=False, bins=True)
            return laser_scan(
                flat.ranges,
                flat.intensities,
                start_deg=flat.azimuth_range[0],
                resolution_deg=flat.horizontal_resolution,
                horizontal_fov_deg=flat.horizontal_fov,
                depth_range=flat.depth_range,
                rotation_rate=flat.rotation_rate,
                nanoseconds=nanoseconds,
                frame_id=self.frame_id,
                style=self.style,
            )
        config, row = frame.config, self._row(frame)
        ranges, intensities = row_of(frame, row)
        return laser_scan(
            ranges,
            np.clip(intensities * np.float32(255.0), 0, 255).astype(np.uint8),
            start_deg=row.start_deg,
            resolution_deg=row.step_deg,
            horizontal_fov_deg=row.count * abs(row.step_deg),
            depth_range=(config.near_range_m, config.far_range_m),
            rotation_rate=float(config.scan_rate_base_hz),
            time_increment=0.0 if frame.one_instant else row.time_step_s,
            nanoseconds=nanoseconds,
            frame_id=self.frame_id,
            style=self.style,
        )

    def first_ray(self, frame: Frame) -> int:
        """The time [ns] at which the first cell of a frame's scan fires in its turn."""
        if self.columns is not None or self.style.bins:
            return frame.timestamp_ns
        rate = frame.config.scan_rate_base_hz
        turn = (frame.timestamp_ns + 1) * rate // NANOSECONDS  # a part of a scan begins within its turn
        return nanoseconds(turn / rate) + self._row(frame).first_ns

    def _row(self, frame: Frame) -> BeamRow:
        if self.row is None or frame.config is not self.config:
            from sensors.lidar.flat_scan import beam_row

            self.config, self.row = frame.config, beam_row(frame.config)
        return self.row
