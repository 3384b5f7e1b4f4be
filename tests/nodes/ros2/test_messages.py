import math

import numpy as np
import pytest

from nodes.isaac.transform_trees import FrameTransform
from nodes.ros2.laser_scans import laser_scan
from nodes.ros2.messages import clock, stamp, transforms


@pytest.mark.parametrize(
    ("nanoseconds", "seconds", "rest"),
    [(0, 0, 0), (1, 0, 1), (1_999_999_999, 1, 999_999_999), (2_000_000_000, 2, 0), (-1, -1, 999_999_999)],
)
def test_a_stamp_splits_nanoseconds(nanoseconds, seconds, rest):
    time = stamp(nanoseconds)
    assert (time.sec, time.nanosec) == (seconds, rest)


def test_a_clock_holds_the_stamp():
    assert clock(5_000_000_001).clock.nanosec == 1


def test_transforms_share_one_stamp():
    poses = [
        FrameTransform("world", "base", (1, 2, 3), (0, 0, 0, 1)),
        FrameTransform("base", "arm", (0, 0, 1), (1, 0, 0, 0)),
    ]
    message = transforms(poses, 1_000_000_000)
    assert [(one.header.frame_id, one.child_frame_id, one.header.stamp.sec) for one in message.transforms] == [
        ("world", "base", 1),
        ("base", "arm", 1),
    ]
    first = message.transforms[0].transform
    assert (first.translation.x, first.translation.y, first.translation.z) == (1, 2, 3)
    assert (first.rotation.x, first.rotation.w) == (0, 1)


def scan(ranges, intensities=None, **changes):
    values = {
        "start_deg": -90.0,
        "resolution_deg": 45.0,
        "horizontal_fov_deg": 180.0,
        "depth_range": (0.5, 30.0),
        "rotation_rate": 10.0,
        "nanoseconds": 0,
        "frame_id": "lidar",
    } | changes
    ranges = np.array(ranges, np.float32)
    return laser_scan(ranges, np.zeros(len(ranges)) if intensities is None else intensities, **values)


def test_empty_beams_are_infinite_and_the_end_angle_is_the_last_beams():
    message = scan([1.5, -1, 0.0, -1], np.array([10, 0, 20, 0], np.uint8))
    assert message.ranges.tolist() == [1.5, math.inf, 0.0, math.inf]
    assert message.ranges.dtype == message.intensities.dtype == np.float32
    assert message.intensities.tolist() == [10, 0, 20, 0]
    assert message.angle_min == pytest.approx(-math.pi / 2)
    assert message.angle_max == pytest.approx(math.pi / 4)
    assert message.angle_increment == pytest.approx(math.pi / 4)
    assert (message.range_min, message.range_max) == (0.5, 30.0)


def test_times_follow_rotation_rate_field_of_view_and_number_of_beams():
    message = scan([1, 2, 3, 4])
    assert message.scan_time == pytest.approx(0.1)
    assert message.time_increment == pytest.approx(180 / 360 * 0.1 / 4)
    assert scan([1, 2], rotation_rate=0).scan_time == 0
    assert scan([]).time_increment == 0
