"""The data that annotator nodes give of a frame."""

from fractions import Fraction

import numpy as np
import pytest

from graph.base.errors import UserError
from sensors import LidarConfig
from sensors.annotators.outputs import SCAN_BUFFER_CHANNELS, extract_point_cloud, scan_buffer
from sensors.channels import CHANNELS
from sensors.configs.catalog import find
from sensors.frame import Frame, FramePose, cartesian, spherical
from sensors.lidar.config import EmitterState
from sensors.lidar.flat_scan import flat_scan


def frame(config, coords="SPHERICAL", **arrays):
    pose = np.eye(4)
    pose[:3, 3] = 2.0, 4.0, 6.0
    arrays = {name: np.asarray(values, CHANNELS[name].dtype) for name, values in arrays.items()}
    count = len(next(iter(arrays.values())))
    return Frame(
        timestamp_ns=5_000_000_000,
        frame_id=0,
        start=FramePose(0, np.eye(4)),
        end=FramePose(1, pose),
        count=count,
        arrays=arrays,
        config=config,
        coords=coords,
        sensor_path="/World/Lidar",
    )


def beams(azimuth, distance, scalar=None):
    scalar = np.full(len(azimuth), 0.5) if scalar is None else scalar
    return {"azimuth": azimuth, "elevation": np.zeros(len(azimuth)), "distance": distance, "scalar": scalar}


def rotary(ticks=8, **fields):
    state = EmitterState(azimuth_deg=[0.0], elevation_deg=[0.0])
    return LidarConfig(
        scan_rate_base_hz=Fraction(10), pattern_firing_rate_hz=Fraction(10 * ticks), emitter_states=(state,), **fields
    )


def test_a_rotary_flat_scan_has_one_column_a_tick_from_minus_180():
    scan = flat_scan(frame(rotary(), **beams([0, -45, -90, -135, -180, 135, 90], [1, 2, 3, 4, 5, 6, 7])))

    assert (scan.horizontal_fov, scan.horizontal_resolution, scan.num_cols, scan.num_rows) == (360.0, 45.0, 8, 1)
    assert scan.azimuth_range == (-180.0, 135.0)
    assert scan.depth_range == (0.3, 200.0)
    assert scan.rotation_rate == 10.0
    assert scan.ranges.tolist() == [5, 4, 3, 2, 1, -1, 7, 6]
    assert scan.intensities.tolist() == [127, 127, 127, 127, 127, 0, 127, 127]  # int(0.5 * 255)


def test_every_beam_of_the_2d_example_has_its_own_column():
    config = find("Example_Rotary_2D")
    azimuth = (-np.arange(3600) / 10 + 180) % 360 - 180

    scan = flat_scan(frame(config, **beams(azimuth, 1 + np.arange(3600) / 10)))

    assert scan.num_cols == 3600
    assert np.all(scan.ranges > 0)
    assert scan.ranges[1800] == 1.0  # straight ahead


def test_in_a_column_the_last_element_wins_and_strays_go_to_the_last_column():
    scan = flat_scan(frame(rotary(), **beams([1.0, 2.0, 180.0], [7, 8, 9])))

    assert scan.ranges.tolist() == [-1, -1, -1, -1, 8, -1, -1, 9]


@pytest.mark.parametrize(
    ("name", "first", "spacing"),
    [("picoScan150", -138.0, 0.1), ("TIM781", -225.0, 1 / 3), ("nanoScan3", -137.5, 1 / 6)],
)
def test_a_solid_state_flat_scan_has_a_column_for_each_emitter_where_it_points(name, first, spacing):
    # 2761, 811 and 1651 emitters over 276, 270 and 275 deg: spacing = field of view / (emitters - 1).
    config = find(name)
    azimuth = np.array([(first + i * spacing + 180) % 360 - 180 for i in range(config.number_of_emitters)])

    scan = flat_scan(frame(config, **beams(azimuth, 1 + np.arange(len(azimuth)))))

    assert scan.ranges.tolist() == (1 + np.arange(len(azimuth))).tolist()
    assert scan.horizontal_resolution == pytest.approx(spacing, abs=1e-6)
    assert scan.azimuth_range == pytest.approx((first, first + (len(azimuth) - 1) * spacing), abs=1e-4)


def test_a_solid_state_flat_scan_in_bins_divides_its_span_by_its_emitters_and_shifts():
    scan = flat_scan(frame(find("picoScan150"), **beams([0.0], [3.0])), bins=True)

    assert scan.horizontal_fov == pytest.approx(359.9, abs=1e-4)
    assert scan.horizontal_resolution == pytest.approx(359.9 / 2761, abs=1e-6)
    assert scan.num_cols == 2761
    assert scan.azimuth_range[0] == -180.0  # 0 .. 359.9 shifted by -180, not wrapped
    assert scan.azimuth_range[1] == pytest.approx(179.9 - 359.9 / 2761, abs=1e-4)
    assert scan.ranges[int(180.0 / (359.9 / 2761))] == 3.0


def test_a_flat_scan_of_a_3d_lidar_names_the_emitter_and_its_elevation():
    tilted = frame(find("XT32"), **beams([0.0], [3.0]))

    with pytest.raises(UserError, match=r"/World/Lidar: .* emitter 0 points 15 deg up"):
        flat_scan(tilted)
    assert flat_scan(tilted, check_2d=False).num_cols == 2000


def test_a_cartesian_frame_is_binned_only_where_nobody_checks():
    cartesian_frame = frame(rotary(), "CARTESIAN", xyz=[[0.0, 3.0, 4.0]])

    with pytest.raises(UserError, match="needs elementsCoordsType SPHERICAL"):
        flat_scan(cartesian_frame)
    assert flat_scan(cartesian_frame, check_2d=False).ranges.tolist() == [-1, -1, -1, -1, -1, -1, 5, -1]


def test_an_empty_frame_is_a_scan_of_empty_columns():
    scan = flat_scan(frame(rotary(), **beams(np.zeros(0), np.zeros(0))))

    assert scan.ranges.tolist() == [-1.0] * 8


def test_a_scan_buffer_is_in_stage_units_and_its_times_are_absolute():
    measured = frame(rotary(), **beams([0.0, 90.0], [1.0, 2.0]), timeOffsetNs=[0, 25], emitterId=[3, 4])

    found = scan_buffer(measured, 0.5, ["distance", "timestamp", "emitterId", "intensity", "radialVelocityMS"])

    np.testing.assert_allclose(found["data"], [[2, 0, 0], [0, 4, 0]], atol=1e-6)
    assert found["distance"].tolist() == [2.0, 4.0]
    assert found["timestamp"].tolist() == [5_000_000_000, 5_000_000_025]
    assert found["timestamp"].dtype == np.uint64
    assert found["emitterId"].dtype == np.uint32
    assert len(found["radialVelocityMS"]) == 0
    assert found["transform"][3].tolist() == [4.0, 8.0, 12.0, 1.0]  # row vectors: the translation is the last row


def test_an_extracted_cloud_holds_what_the_frame_holds():
    found = extract_point_cloud(frame(rotary(), **beams([0.0], [1.0]), objId=np.arange(16)[None]))

    assert found["data"].tolist() == [[1.0, 0.0, 0.0]]
    assert found["objectId"].dtype == np.uint8
    assert found["objectId"].tolist() == [list(range(16))]  # 16 bytes a return
    assert "velocity" not in found
    assert found["transform"][3].tolist() == [2.0, 4.0, 6.0, 1.0]


def test_each_output_of_the_scan_buffer_names_a_channel_that_exists():
    assert set(SCAN_BUFFER_CHANNELS.values()) <= CHANNELS.keys()


def test_spherical_and_cartesian_are_inverse():
    points = np.random.default_rng(0).normal(size=(1000, 3)).astype(np.float32) * 30

    np.testing.assert_allclose(cartesian(*spherical(points)), points, atol=2e-5)


def test_a_vanishing_distance_is_the_origin():
    assert cartesian(np.float32([30]), np.float32([40]), np.float32([1e-7])).tolist() == [[0, 0, 0]]
