"""`sensor_msgs/LaserScan` messages from beams binned by azimuth."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from .messages import header

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

LASER_SCAN = "sensor_msgs/msg/LaserScan"


def laser_scan(
    ranges: NDArray[np.float32],
    intensities: NDArray[Any],
    *,
    start_deg: float,
    resolution_deg: float,
    horizontal_fov_deg: float,
    depth_range: tuple[float, float],
    rotation_rate: float,
    nanoseconds: int,
    frame_id: str,
) -> Any:
    """A scan by the message's own convention: an empty beam (below 0) is +inf, angle_max is the last beam's angle.

    ranges: (N,) [m]; intensities: (N,), any number type; rotation_rate [Hz], 0 gives scan_time 0.
    time_increment = fov / 360 x scan_time / N, as in Isaac Sim.
    """
    import numpy as np

    from graph.sim.ros_types import message_type

    count = len(ranges)
    start, increment = math.radians(start_deg), math.radians(resolution_deg)
    scan_time = 1.0 / rotation_rate if rotation_rate > 0 else 0.0
    return message_type(LASER_SCAN)(
        header(nanoseconds, frame_id),
        start,
        start + max(count - 1, 0) * increment,
        increment,
        horizontal_fov_deg / 360.0 * scan_time / count if count else 0.0,
        scan_time,
        float(depth_range[0]),
        float(depth_range[1]),
        np.where(ranges < 0, np.float32(np.inf), ranges).astype(np.float32),
        np.asarray(intensities, dtype=np.float32),
    )
