"""Functions that make ROS 2 messages about robots: joints, odometry, inertial readings, steering."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from .messages import header, type_of

TWIST = "geometry_msgs/msg/Twist"
JOINT_STATE = "sensor_msgs/msg/JointState"
ODOMETRY = "nav_msgs/msg/Odometry"
IMU = "sensor_msgs/msg/Imu"
ACKERMANN = "ackermann_msgs/msg/AckermannDriveStamped"


def joint_state(
    nanoseconds: int, names: Sequence[str], positions: Any, velocities: Any, efforts: Any, frame_id: str = ""
) -> Any:
    """`sensor_msgs/JointState`; each quantity has one value per joint, or is empty."""
    import numpy as np

    columns = (np.array(column, dtype=np.float64) for column in (positions, velocities, efforts))
    return type_of(JOINT_STATE)(header(nanoseconds, frame_id), list(names), *columns)


def odometry(
    nanoseconds: int,
    frames: tuple[str, str],
    position: Sequence[float],
    orientation: Sequence[float],
    linear: Sequence[float],
    angular: Sequence[float],
) -> Any:
    """`nav_msgs/Odometry`: pose [m; x, y, z, w] in frames[0], velocities [m/s, rad/s] in frames[1]; no covariances."""
    pose = type_of("geometry_msgs/msg/Pose")(point(position), quaternion(orientation))
    return type_of(ODOMETRY)(
        header(nanoseconds, frames[0]),
        frames[1],
        type_of("geometry_msgs/msg/PoseWithCovariance")(pose, _zeros(36)),
        type_of("geometry_msgs/msg/TwistWithCovariance")(twist(linear, angular), _zeros(36)),
    )


def imu(
    nanoseconds: int,
    frame_id: str,
    orientation: Sequence[float] | None,
    angular_velocity: Sequence[float] | None,
    linear_acceleration: Sequence[float] | None,
) -> Any:
    """`sensor_msgs/Imu`; a reading that is None becomes zero with covariance[0] = -1, which marks it as missing."""
    return type_of(IMU)(
        header(nanoseconds, frame_id),
        quaternion(orientation if orientation is not None else (0.0, 0.0, 0.0, 1.0)),
        _covariance(orientation is not None),
        vector(angular_velocity if angular_velocity is not None else (0.0, 0.0, 0.0)),
        _covariance(angular_velocity is not None),
        vector(linear_acceleration if linear_acceleration is not None else (0.0, 0.0, 0.0)),
        _covariance(linear_acceleration is not None),
    )


def ackermann(
    nanoseconds: int, frame_id: str, angle: float, rate: float, speed: float, acceleration: float, jerk: float
) -> Any:
    """`ackermann_msgs/AckermannDriveStamped` [rad, rad/s, m/s, m/s^2, m/s^3]."""
    drive = type_of("ackermann_msgs/msg/AckermannDrive")(angle, rate, speed, acceleration, jerk)
    return type_of(ACKERMANN)(header(nanoseconds, frame_id), drive)


def twist(linear: Sequence[float], angular: Sequence[float]) -> Any:
    """`geometry_msgs/Twist` [m/s, rad/s]."""
    return type_of(TWIST)(vector(linear), vector(angular))


def vector(values: Sequence[float]) -> Any:
    """`geometry_msgs/Vector3`."""
    return type_of("geometry_msgs/msg/Vector3")(*map(float, values))


def point(values: Sequence[float]) -> Any:
    """`geometry_msgs/Point`."""
    return type_of("geometry_msgs/msg/Point")(*map(float, values))


def quaternion(xyzw: Sequence[float]) -> Any:
    """`geometry_msgs/Quaternion` of x, y, z, w."""
    return type_of("geometry_msgs/msg/Quaternion")(*map(float, xyzw))


def _covariance(measured: bool) -> Any:
    covariance = _zeros(9)
    if not measured:
        covariance[0] = -1.0
    return covariance


def _zeros(count: int) -> Any:
    import numpy as np

    return np.zeros(count)
