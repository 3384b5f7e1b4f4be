"""Clouds with the fields of lidar drivers: names, offsets and types as their ROS 2 drivers publish them.

velodyne: PointXYZIRT of velodyne_pointcloud. ouster: Point of ouster_ros. autoware: PointXYZIRCAEDT of
autoware_point_types, which Nebula publishes. Intensities and reflectivities are 0 to 255. Headers carry the time of the
first firing, and times count up from it, as odometry packages take them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from graph.base.records import dataclass

from .lidar_frames import column, frame_points, point_times
from .point_clouds import CloudGrid, cloud_of

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from sensors.frame import Frame

METADATA = ("Intensity", "Ring", "Time")
"""The quantities of a cloud that these layouts need."""
SINGLE_STRONGEST = 1
"""ReturnType of autoware_point_types."""
_POSITION = (("x", "<f4", 0), ("y", "<f4", 4), ("z", "<f4", 8))


@dataclass(frozen=True, slots=True)
class _Values:
    """What is known of n points: x, y, z [m] (n, 3); strength 0 to 1; ring; time after the header [ns]; range [m]."""

    points: NDArray[np.float32]
    strength: NDArray[Any]
    ring: NDArray[Any]
    time_ns: NDArray[np.int64]
    distance: NDArray[np.float32]

    @property
    def scaled(self) -> NDArray[np.float32]:
        """Strength 0 to 255."""
        import numpy as np

        found: NDArray[np.float32] = np.clip(self.strength * np.float32(255), 0, 255)
        return found


@dataclass(frozen=True, slots=True)
class DriverCloud:
    """A driver's layout: (field, NumPy format, offset) in order, bytes of a point, how each field is made."""

    fields: tuple[tuple[str, str, int], ...]
    step: int
    make: Mapping[str, Callable[[_Values], Any]]


def _seconds(one: _Values) -> Any:
    return one.time_ns * 1e-9


def _azimuth(one: _Values) -> Any:
    import numpy as np

    return np.arctan2(one.points[:, 1], one.points[:, 0])


def _elevation(one: _Values) -> Any:
    import numpy as np

    return np.arctan2(one.points[:, 2], np.hypot(one.points[:, 0], one.points[:, 1]))


def _rounded(one: _Values) -> Any:
    import numpy as np

    return np.round(one.scaled)


def _millimetres(one: _Values) -> Any:
    import numpy as np

    return np.round(np.nan_to_num(one.distance).astype(np.float64) * 1000)


DRIVER_CLOUDS: Mapping[str, DriverCloud] = {
    "velodyne": DriverCloud(
        (*_POSITION, ("intensity", "<f4", 12), ("ring", "<u2", 16), ("time", "<f4", 18)),
        22,
        {"intensity": lambda one: one.scaled, "ring": lambda one: one.ring, "time": _seconds},
    ),
    "ouster": DriverCloud(
        (
            *_POSITION,
            ("intensity", "<f4", 16),
            ("t", "<u4", 20),
            ("reflectivity", "<u2", 24),
            ("ring", "<u2", 26),
            ("ambient", "<u2", 28),
            ("range", "<u4", 32),
        ),
        48,
        {
            "intensity": lambda one: one.scaled,
            "t": lambda one: one.time_ns,
            "reflectivity": _rounded,
            "ring": lambda one: one.ring,
            "ambient": lambda one: 0,
            "range": _millimetres,
        },
    ),
    "autoware": DriverCloud(
        (
            *_POSITION,
            ("intensity", "u1", 12),
            ("return_type", "u1", 13),
            ("channel", "<u2", 14),
            ("azimuth", "<f4", 16),
            ("elevation", "<f4", 20),
            ("distance", "<f4", 24),
            ("time_stamp", "<u4", 28),
        ),
        32,
        {
            "intensity": _rounded,
            "return_type": lambda one: SINGLE_STRONGEST,
            "channel": lambda one: one.ring,
            "azimuth": _azimuth,
            "elevation": _elevation,
            "distance": lambda one: one.distance,
            "time_stamp": lambda one: one.time_ns,
        },
    ),
}


def driver_cloud(frame: Frame, name: str, nanoseconds: int, frame_id: str, grid: CloudGrid | None = None) -> Any:
    """`sensor_msgs/PointCloud2` of a frame with the fields of a driver; angles, ranges are those of its x, y, z.

    nanoseconds: the time of the first firing.
    """
    import numpy as np

    driver = DRIVER_CLOUDS[name]
    points = frame_points(frame)
    times = np.maximum(point_times(frame) - frame.timestamp_ns, 0)
    strength, ring = column(frame, "Intensity"), column(frame, "Ring")
    values = _Values(points, strength, ring, times, np.linalg.norm(points, axis=1).astype(np.float32))
    names, formats, offsets = zip(*driver.fields, strict=True)
    layout = np.dtype({"names": names, "formats": formats, "offsets": offsets, "itemsize": driver.step})
    packed = np.zeros(len(points), layout)
    packed["x"], packed["y"], packed["z"] = points.T
    for field, make in driver.make.items():
        packed[field] = make(values)
    return cloud_of(packed, points, nanoseconds, frame_id, grid)
