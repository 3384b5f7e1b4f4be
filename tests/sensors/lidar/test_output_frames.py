"""CUSTOM and compensated outputs, regions of interest, and prims without OmniSensorAPI."""

import numpy as np
import pytest
from pxr import UsdGeom

from tests.support.lidar_worlds import add_box, add_lidar, frames_of, rotary, stare, weightless

TIMES = np.linspace(0.0, 0.099, 60)


def room(app, config, tick_rate=None):
    add_box(app, "/World/Room", 20.0, (0, 0, 0))
    return add_lidar(app, position=(1, 0, 0), config=config, tick_rate=tick_rate)


def test_custom_points_are_in_the_frame_in_which_the_sensor_has_the_pose_of_the_trafo():
    trafo = (0.5, 0.0, 2.0, 0.0, 0.0, 90.0)  # half a metre ahead, two up, looking left
    config = rotary(4, output_frame_of_reference="CUSTOM", custom_frame_of_reference_trafo=trafo)
    with weightless() as app:
        [frame] = frames_of(app, room(app, config), 6)

    in_sensor = np.array([[9.0, 0, 0], [0, -10, 0], [-11, 0, 0], [0, 10, 0]])
    expected = np.stack([0.5 - in_sensor[:, 1], in_sensor[:, 0], in_sensor[:, 2] + 2.0], axis=1)
    np.testing.assert_allclose(frame.xyz, expected, atol=1e-5)
    np.testing.assert_allclose(frame.channel("distance"), np.linalg.norm(expected, axis=1), rtol=1e-6)
    np.testing.assert_allclose(frame.channel("hitNormals"), [[0, -1, 0], [-1, 0, 0], [0, 1, 0], [1, 0, 0]], atol=1e-6)
    assert frame.frame_of_reference == "CUSTOM"


def test_the_trafo_turns_about_x_then_y_then_z():
    trafo = (0.0, 0.0, 0.0, 90.0, 0.0, 90.0)  # roll: y goes to z; yaw: x goes to y
    config = rotary(4, output_frame_of_reference="CUSTOM", custom_frame_of_reference_trafo=trafo)
    with weightless() as app:
        [frame] = frames_of(app, room(app, config), 6)

    np.testing.assert_allclose(frame.xyz, [[0, 9, 0], [0, 0, -10], [0, -11, 0], [0, 0, 10]], atol=1e-5)


def test_custom_without_a_trafo_is_the_sensor_frame():
    with weightless() as app:
        [frame] = frames_of(app, room(app, rotary(4, output_frame_of_reference="CUSTOM")), 6)

    np.testing.assert_allclose(frame.xyz, [[9, 0, 0], [0, -10, 0], [-11, 0, 0], [0, 10, 0]], atol=1e-5)


@pytest.mark.parametrize("offset", [0.0, 1e6])
@pytest.mark.parametrize("tick_rate", [10, 0])
def test_compensated_points_are_where_the_sensor_at_the_end_of_the_frame_sees_them(offset, tick_rate):
    config = stare(
        TIMES,
        np.linspace(-180, 170, 60),
        output_motion_compensation_state="COMPENSATED",
        skip_dropping_invalid_points=False,
    )
    with weightless(lidar_motion="continuous") as app:
        add_box(app, "/World/Room", 20.0, (offset, 0, 0))
        add_box(app, "/World/Cart", 0.1, (offset, 0, -5), velocity=(4.0, 2.0, 0), spin=(0, 0, 120))
        product = add_lidar(app, "/World/Cart/Lidar", (0.3, 0, 5), config, tick_rate=tick_rate)
        frames = frames_of(app, product, 12)

    for frame in frames:
        pose = frame.end.world_sensor
        world = frame.xyz.astype(np.float64) @ pose[:3, :3].T + pose[:3, 3] - [offset, 0, 0]
        assert frame.motion_compensation == "COMPENSATED"
        if frame.count:
            np.testing.assert_allclose(np.abs(world[:, :2]).max(axis=1), 10.0, atol=1e-4)
            distance = np.linalg.norm(frame.xyz, axis=1)
            np.testing.assert_allclose(frame.channel("distance"), distance, rtol=1e-5)
            inwards = frame.channel("hitNormals").astype(np.float64) @ pose[:3, :3].T
            np.testing.assert_allclose(np.einsum("ij,ij->i", inwards[:, :2], world[:, :2]), -10.0, atol=1e-3)
    assert sum(frame.count for frame in frames) == 120


def test_without_compensation_each_point_is_where_its_own_firing_saw_it():
    with weightless(lidar_motion="continuous") as app:
        add_box(app, "/World/Room", 20.0, (0, 0, 0))
        add_box(app, "/World/Cart", 0.1, (0, 0, -5), velocity=(4.0, 0, 0))
        [frame] = frames_of(app, add_lidar(app, "/World/Cart/Lidar", (0, 0, 5), stare(TIMES)), 6)

    np.testing.assert_allclose(frame.xyz[:, 0], 10.0 - 4.0 * TIMES, atol=1e-5)
    assert frame.motion_compensation == "NONCOMPENSATED"


def test_a_frozen_scan_is_compensated_as_it_is_and_one_of_updates_says_that_it_is_not():
    def run(motion):
        with weightless(lidar_motion=motion) as app:
            config = rotary(4, output_motion_compensation_state="COMPENSATED")
            [frame] = frames_of(app, room(app, config), 6)
            return frame.motion_compensation, app.warnings.codes()

    assert run("frozen") == ("COMPENSATED", [])
    assert run("update") == ("NONCOMPENSATED", ["motion-compensation-off"])


@pytest.mark.parametrize(
    ("low", "high", "kept"), [(-45.0, 45.0, [0, 1, 7]), (90.0, 180.0, [4, 5, 6]), (170.0, -80.0, [2, 3, 4])]
)
def test_only_firings_in_the_region_of_interest_exist(low, high, kept):
    with weightless() as app:
        config = rotary(8, min_azimuth_roi=low, max_azimuth_roi=high)  # clockwise: tick i at -45 i deg
        [frame] = frames_of(app, room(app, config), 6)

    assert frame.channel("tickId").tolist() == kept
    assert frame.scan_complete


def test_without_the_sensor_api_the_tick_rate_does_not_count_and_a_warning_says_so():
    with weightless() as app:
        prim = app.stage.DefinePrim("/World/Lidar", "OmniLidar")
        add_box(app, "/World/Room", 20.0, (0, 0, 0))
        product = add_lidar(app, config=rotary(60))
        assert app.warnings.codes() == []
        prim.RemoveAppliedSchema("OmniSensorAPI")

        frames = frames_of(app, product, 6)

        assert [frame.count for frame in frames] == [10] * 6
        [missing] = [warning for warning in app.warnings if warning.code == "sensor-api-missing"]
        assert missing.where == "/World/Lidar"
        assert "schemas: [OmniSensorAPI]" in missing.message


def test_below_a_mirroring_parent_a_lidar_looks_where_the_scene_has_it_look_and_says_so():
    # x scaled by -1: ahead is world -x, up stays up. The box behind, at x = -4, is seen ahead at 3.5 m.
    with weightless() as app:
        UsdGeom.Xform.Define(app.stage, "/World/Mirror").AddScaleOp().Set((-1, 1, 1))
        add_box(app, "/World/Box", 1.0, (-4, 0, 0))
        product = add_lidar(app, "/World/Mirror/Lidar", config=rotary(4, elevations=(0.0, 5.0)))
        frame = frames_of(app, product, 6)[-1]
        told = [one.where for one in app.warnings if one.code == "sensor-mirrored"]

    level = np.abs(frame.channel("elevation")) < 1
    np.testing.assert_allclose(frame.xyz[level], [[3.5, 0, 0]], atol=1e-5)
    assert (frame.xyz[~level][:, 2] > 0.3).all()  # 3.5 tan 5 deg = 0.306
    assert frame.end.world_sensor[:3, 2].tolist() == [0, 0, 1]
    assert told == ["/World/Mirror/Lidar"]
