"""Makes ROS 2 messages from lidar frames."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from graph.base.exact import nanoseconds

from .point_clouds import CLOUD_FIELDS, point_cloud

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from sensors.frame import Frame

    from .laser_scans import ScanStyle

SCAN_CHANNELS = frozenset({"azimuth", "distance", "scalar"})
"""The channels of a frame that a laser scan needs."""


def cloud_channels(metadata: Iterable[str]) -> frozenset[str]:
    """The channels of a frame that a cloud with these quantities needs."""
    return frozenset({"xyz", *(CLOUD_FIELDS[name].channel for name in metadata)})


def frame_cloud(frame: Frame, metadata: Iterable[str], nanoseconds: int, frame_id: str) -> Any:
    """`sensor_msgs/PointCloud2` of a frame's points, with the chosen quantities as far as the frame holds them."""
    values = {name: column(frame, name) for name in metadata}
    return point_cloud(frame_points(frame), values, nanoseconds, frame_id)


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
        return array.astype(np.int64) + (frame.timestamp_ns - nanoseconds(frame.reference))
    return array


@dataclass(slots=True)
class FrameScan:
    """Makes `sensor_msgs/LaserScan` of a planar lidar's frames: one cell for each beam, in the order of firing; or,
    where `style` wants bins, by azimuth as the product does, whatever the elevations. The last return of a cell wins.
    """

    frame_id: str
    style: ScanStyle
    config: Any = None
    row: Any = None

    def __call__(self, frame: Frame, nanoseconds: int) -> Any:
        """The message of a frame with this stamp."""
        import numpy as np

        from sensors.lidar.beams import beam_row
        from sensors.lidar.flat_scan import flat_scan, row_of

        from .laser_scans import laser_scan

        if self.style.bins:
            flat = flat_scan(frame, check_2d=False, bins=True)
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
        config = frame.config
        if config is not self.config:
            self.config, self.row = config, beam_row(config)
        ranges, intensities = row_of(frame, self.row)
        return laser_scan(
            ranges,
            np.clip(intensities * np.float32(255.0), 0, 255).astype(np.uint8),
            start_deg=self.row.start_deg,
            resolution_deg=self.row.step_deg,
            horizontal_fov_deg=self.row.count * abs(self.row.step_deg),
            depth_range=(config.near_range_m, config.far_range_m),
            rotation_rate=float(config.scan_rate_base_hz),
            time_increment=0.0 if frame.one_instant else self.row.time_step_s,
            nanoseconds=nanoseconds,
            frame_id=self.frame_id,
            style=self.style,
        )
