"""`sensor_msgs/LaserScan` messages from beams binned by azimuth."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from graph.base.records import dataclass
from graph.sim import settings as keys

from .messages import header

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from graph.sim.app import App

LASER_SCAN = "sensor_msgs/msg/LaserScan"


@dataclass(frozen=True, slots=True)
class ScanStyle:
    """How a laser scan is laid out.

    The range of an empty beam [m]; whether angle_max is the last beam's angle or one increment beyond it; whether the
    beams are ascending bins of the field of view, or the lidar's own beams in the order of firing.
    """

    empty: float = math.inf
    ends_beyond: bool = False
    bins: bool = False


PLAIN = ScanStyle()


def scan_style(app: App) -> ScanStyle:
    """The style that an App's settings choose."""
    settings = app.settings
    empty = -1.0 if settings.get(keys.SCAN_EMPTY_MINUS_ONE) else math.inf
    return ScanStyle(empty, bool(settings.get(keys.SCAN_END_BEYOND)), bool(settings.get(keys.SCAN_BINS)))


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
    style: ScanStyle = PLAIN,
    time_increment: float | None = None,
) -> Any:
    """A scan in the message's own convention, unless `style` says otherwise; a range below 0 means an empty beam.

    ranges: (N,) [m]; intensities: (N,), any number type; rotation_rate [Hz], 0 gives scan_time 0.
    time_increment [s]: between beams; None: fov / 360 x scan_time / N, as in Isaac Sim.
    """
    import numpy as np

    from graph.sim.messages.ros_types import message_type

    count = len(ranges)
    start, increment = math.radians(start_deg), math.radians(resolution_deg)
    scan_time = 1.0 / rotation_rate if rotation_rate > 0 else 0.0
    if time_increment is None:
        time_increment = horizontal_fov_deg / 360.0 * scan_time / count if count else 0.0
    return message_type(LASER_SCAN)(
        header(nanoseconds, frame_id),
        start,
        start + (count if style.ends_beyond else max(count - 1, 0)) * increment,
        increment,
        time_increment,
        scan_time,
        float(depth_range[0]),
        float(depth_range[1]),
        np.where(ranges < 0, np.float32(style.empty), ranges).astype(np.float32),
        np.asarray(intensities, dtype=np.float32),
    )
