"""A PhysX lidar at (0, 0, 1) between two walls: 4 m ahead of it (+x), 2 m to its left (+y); sky elsewhere."""

import numpy as np
import pytest
from pxr import UsdGeom

from graph import ComputeError
from graph.testing import run_node

PATH = "/World/Lidar"
QUARTERS = {"horizontalResolution": 90.0, "highLod": False, "rotationRate": 0.0, "maxRange": 10.0}
"""Beams at -180, -90, 0 and 90 deg."""


@pytest.fixture
def lidar(stage, world):
    """A function that opens a world with the walls and a lidar with these attributes; 100 Hz physics, 50 Hz loop."""

    def open_world(unit=1.0, turn=0.0, **attributes):
        UsdGeom.SetStageMetersPerUnit(stage, unit)
        for name, place in (("Ahead", (5, 0, 1)), ("Left", (0, 3, 1))):
            wall = UsdGeom.Cube.Define(stage, f"/World/{name}")
            wall.GetSizeAttr().Set(2 / unit)
            wall.AddTranslateOp().Set(tuple(part / unit for part in place))
        prim = UsdGeom.Xformable(stage.DefinePrim(PATH, "Lidar"))
        prim.AddTranslateOp().Set((0, 0, 1 / unit))
        prim.AddRotateZOp().Set(turn)
        for name, value in attributes.items():
            prim.GetPrim().GetAttribute(name).Set(value)
        return world(physics_hz=100, loop_hz=50)

    return open_world


def read(app, node, updates=1):
    return run_node(node, inputs={"lidarPrim": PATH}, pulses={"execIn": range(updates)}, updates=updates, app=app)


def test_at_rate_0_each_update_gives_the_points_that_all_beams_hit_in_metres(lidar):
    trace = read(lidar(**QUARTERS, unit=0.01), "IsaacReadLidarPointCloud", updates=2)
    assert trace.fired("execOut") == [0, 1]
    assert np.allclose(trace.value("data"), [[4, 0, 0], [0, 2, 0]], atol=1e-6)


def test_points_are_in_the_axes_of_the_sensor(lidar):
    """Turned to the left, it has the left wall ahead and the other one at its right."""
    trace = read(lidar(**QUARTERS, turn=90.0), "IsaacReadLidarPointCloud")
    assert np.allclose(trace.value("data"), [[0, -4, 0], [2, 0, 0]], atol=1e-6)


def test_beams_tell_depth_and_intensity_and_maxrange_at_no_hit(lidar):
    trace = read(lidar(**QUARTERS), "IsaacReadLidarBeams")
    assert np.allclose(trace.value("linearDepthData"), [10, 10, 4, 2])
    assert trace.value("intensitiesData").tolist() == [0, 0, 255, 255]
    assert np.allclose(trace.value("beamTimeData"), 0.02)
    assert (trace.value("numRows"), trace.value("numCols")) == (1, 4)
    assert np.allclose(trace.value("azimuthRange"), [-180, 90])
    assert np.allclose(trace.value("zenithRange"), [0, 0])
    assert np.allclose(trace.value("depthRange"), [0.4, 10])
    assert trace.value("horizontalFov") == 360
    assert trace.value("verticalResolution") == 4
    assert trace.value("rotationRate") == 0


def test_rows_of_a_high_level_of_detail_run_downwards(lidar):
    """verticalFov 30 deg in steps of 10 is 4 rows, at -15, -5, 5, 15 deg below the plane; the wall is 2 m high."""
    trace = read(
        lidar(horizontalFov=1.0, horizontalResolution=1.0, yawOffset=0.5, rotationRate=0.0, verticalResolution=10.0),
        "IsaacReadLidarPointCloud",
    )
    slopes = np.tan(np.deg2rad([15, 5, -5, -15]))
    inside = np.abs(4 * slopes) < 1  # 4 m * tan 15 deg = 1.07 m passes over and under the wall
    assert inside.tolist() == [False, True, True, False]
    assert np.allclose(trace.value("data"), [[4, 0, 4 * slope] for slope in slopes[inside]], atol=1e-5)


def test_nothing_nearer_than_minrange_is_seen_and_depth_counts_from_the_sensor(lidar):
    """A beam begins minRange ahead: at 2.5 m to the left that is inside the wall, which it leaves at 4 m."""
    trace = read(lidar(**{**QUARTERS, "minRange": 2.5, "maxRange": 3.0}), "IsaacReadLidarBeams")
    # Ahead: from 2.5 m on, 3 m far, so 4 m is met; behind and right: nothing.
    assert np.allclose(trace.value("linearDepthData"), [3, 3, 4, 4])


def test_a_hit_at_maxrange_or_farther_is_not_a_point(lidar):
    trace = read(lidar(**{**QUARTERS, "minRange": 2.5, "maxRange": 3.0}), "IsaacReadLidarPointCloud")
    assert trace.fired("execOut") == [0]
    assert len(trace.value("data")) == 0


def test_a_rotating_lidar_gives_a_scan_once_a_turn_of_the_columns_fired_in_each_update(lidar):
    """4 columns at 12.5 Hz are one column in 20 ms: each update of 50 Hz fires one, every fourth completes a turn."""
    app = lidar(**{**QUARTERS, "rotationRate": 12.5})
    trace = read(app, "IsaacReadLidarBeams", updates=8)
    assert trace.fired("execOut") == [3, 7]
    assert np.allclose(trace.value("beamTimeData"), [0.10, 0.12, 0.14, 0.16])
    assert np.allclose(trace.value("linearDepthData"), [10, 10, 4, 2])


def test_a_turn_that_begins_within_an_update_is_complete_in_the_update_that_ends_it(lidar):
    """At 20 Hz a turn lasts 2.5 updates: turns end at 50, 100 and 150 ms, in the updates 2, 4 and 7 (from 0)."""
    app = lidar(**{**QUARTERS, "rotationRate": 20.0})
    trace = read(app, "IsaacReadLidarPointCloud", updates=8)
    assert trace.fired("execOut") == [2, 4, 7]
    assert np.allclose(trace.value("data"), [[4, 0, 0], [0, 2, 0]], atol=1e-6)


def test_of_several_turns_in_an_update_the_newest_whole_one_is_given(lidar):
    """At 120 Hz an update of 20 ms is 2.4 turns."""
    app = lidar(**{**QUARTERS, "rotationRate": 120.0})
    trace = read(app, "IsaacReadLidarBeams", updates=3)
    assert trace.fired("execOut") == [0, 1, 2]
    # Turn 6 (from 0) ends at 58.3 ms, in the third update; all its columns were fired there.
    assert np.allclose(trace.value("beamTimeData"), 0.06)


def test_a_disabled_lidar_gives_nothing(lidar):
    assert read(lidar(**QUARTERS, enabled=False), "IsaacReadLidarBeams").fired("execOut") == []


@pytest.mark.parametrize(
    ("attribute", "value", "wrong"),
    [
        ("horizontalFov", 400.0, "give at most 360"),
        ("horizontalResolution", 0.0, "give a number above 0"),
        ("rotationRate", -1.0, "give 0 or more"),
        ("verticalFov", float("nan"), "give a finite number"),
        ("maxRange", 0.1, "give at least minRange, 0.4"),
        ("horizontalResolution", 1e-6, "the limit is 10,000,000 rays; raise it with --limit lidar.rays=N"),
    ],
)
def test_what_no_lidar_has_is_reported_in_a_line(lidar, attribute, value, wrong):
    with pytest.raises(ComputeError, match=wrong):
        read(lidar(**{attribute: value}), "IsaacReadLidarBeams")


def test_readers_share_one_cast_and_an_edit_counts_from_the_next_update(lidar):
    from sensors.polled import polled_sensor

    app = lidar(**QUARTERS)
    app.play()
    app.update()
    polled = polled_sensor(app.world, PATH, "Lidar")
    polled.require("me", ("distance",))
    app.update()
    first = polled.read()
    assert first is polled.read() is polled_sensor(app.world, PATH, "Lidar").read()
    assert not first.has("xyz")  # nobody asked for it
    app.stage.GetPrimAtPath(PATH).GetAttribute("maxRange").Set(3.0)
    app.update()
    assert np.allclose(polled.read().channel("distance"), [3, 3, 3, 2])
    app.stop()
    app.play()
    app.update()
    assert polled_sensor(app.world, PATH, "Lidar") is not polled
