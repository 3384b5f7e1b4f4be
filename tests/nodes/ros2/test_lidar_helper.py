import math

import numpy as np
import pytest

from graph import ComputeError
from graph.testing import run_node
from sensors import render_product

HELPER = "ROS2RtxLidarHelper"


def helper(app, updates=60, lidar="/World/Lidar", **inputs):
    path = render_product(app, lidar).path
    inputs = {"renderProductPath": path, "topicName": "points", "type": "point_cloud", **inputs}
    return run_node(HELPER, inputs=inputs, pulses={"execIn": range(updates)}, updates=updates, app=app)


def stamps(app, topic="/points"):
    return [one.message.header.stamp.sec * 10**9 + one.message.header.stamp.nanosec for one in app.sink[topic]]


def names(message):
    return [field.name for field in message.fields]


def test_every_scan_is_published_with_the_time_of_its_pose(lidar, world):
    lidar()
    app = world(physics_hz=240)
    helper(app)
    assert stamps(app) == [k * 100_000_000 for k in range(1, 11)]
    assert [one.stamp_ns for one in app.sink["/points"]] == stamps(app)
    cloud = app.sink["/points"][0].message
    assert cloud.header.frame_id == "sim_lidar"
    points = np.frombuffer(cloud.data.tobytes(), "<f4").reshape(-1, 3)
    ahead = points[(np.abs(points[:, 1]) < 0.1) & (points[:, 0] > 0)]
    left = points[(np.abs(points[:, 0]) < 0.1) & (points[:, 1] > 0)]
    assert ahead[:, 0] == pytest.approx(np.full(len(ahead), 4.0), abs=1e-3)
    assert left[:, 1] == pytest.approx(np.full(len(left), 2.0), abs=1e-3)
    assert len(ahead) > 10
    assert len(left) > 10


def test_a_laser_scan_has_infinite_empty_beams_and_the_last_beams_angle(lidar, world):
    lidar()
    app = world()
    helper(app, updates=13, type="laser_scan", frameId="front")
    scan = app.sink["/points"][0].message
    count = len(scan.ranges)
    assert count == 3600
    assert scan.header.frame_id == "front"
    # Clockwise from straight ahead: the wall to the left, at 90 deg, comes after 270 deg.
    assert scan.ranges[0] == pytest.approx(4.0, abs=1e-3)
    assert scan.ranges[3 * count // 4] == pytest.approx(2.0, abs=1e-3)
    assert scan.ranges[count // 2] == math.inf
    assert (scan.angle_min, scan.angle_increment) == pytest.approx((0, -math.radians(0.1)))
    assert scan.angle_max == pytest.approx(-2 * math.pi + math.radians(0.1))
    assert scan.time_increment == 0  # a frozen scan shows one instant
    assert (scan.scan_time, scan.range_max) == pytest.approx((0.1, 200), rel=1e-6)


def test_a_laser_scan_of_a_lidar_with_many_elevations_is_refused(lidar, world):
    lidar("Example_Rotary")
    with pytest.raises(ComputeError, match="/World/Lidar: a flat or laser scan needs a 2D lidar, but emitter 0 points"):
        helper(world(), updates=7, type="laser_scan")


def test_check_refuses_laser_scans_of_a_lidar_with_many_elevations(tmp_path):
    from graph.base.errors import UserError
    from graph.sim import App
    from tests.support.lidar_texts import lidar_graph

    scene = "tickgraph: 1\nscene: {prims: {/World/Lidar: {type: OmniLidar, config: Example_Rotary}}}\n"
    file = tmp_path / "g.yaml"
    file.write_text(scene + lidar_graph("type: laser_scan"))
    with pytest.raises(UserError, match="needs a 2D lidar, but emitter 0 points -15 deg up"), App.from_file(file):
        pass
    file.write_text(scene + "clock: {parity: isaacsim-6.0.1}\n" + lidar_graph("type: laser_scan"))
    with App.from_file(file):
        pass


@pytest.mark.parametrize(("motion", "between"), [("continuous", 1 / 36000), ("update", 1 / 36000), ("frozen", 0)])
def test_the_beams_of_a_laser_scan_follow_each_other_as_they_fire(stage, lidar, motion, between):
    # 36000 firings a second.
    from graph.sim import App
    from graph.sim.messages.bus import MemorySink

    lidar()
    with App(stage, fidelity={"lidar.motion": motion}) as app:
        app.sink = MemorySink()
        app.bus.subscribe(app.sink)
        helper(app, updates=13, type="laser_scan")
        assert app.sink["/points"][0].message.time_increment == pytest.approx(between, rel=1e-6)


@pytest.mark.parametrize("name", ["picoScan150", "TIM781"])
def test_every_beam_of_a_solid_state_laser_scan_has_its_true_bearing(lidar, world, name):
    # A wall at x = 4 m fills the bearings to its edges: the range at bearing b is 4 / cos(b).
    lidar(name)
    app = world()
    helper(app, updates=13, type="laser_scan")
    scan = app.sink["/points"][0].message
    bearing = scan.angle_min + np.arange(len(scan.ranges)) * scan.angle_increment
    ahead = np.abs((bearing + np.pi) % (2 * np.pi) - np.pi) < math.radians(10)
    assert len(scan.ranges) == {"picoScan150": 2761, "TIM781": 811}[name]
    assert ahead.sum() > 50
    assert scan.ranges[ahead] == pytest.approx(4 / np.cos(bearing[ahead]), abs=1e-3)


def test_firings_without_a_return_that_are_kept_are_not_points_at_the_origin(stage, lidar, world):
    from sensors.lidar.names import PREFIX

    lidar()
    stage.GetPrimAtPath("/World/Lidar").GetAttribute(f"{PREFIX}skipDroppingInvalidPoints").Set(True)
    app = world()
    helper(app, updates=7)
    cloud = app.sink["/points"][0].message
    points = np.frombuffer(cloud.data.tobytes(), "<f4").reshape(-1, 3)
    dark = np.isnan(points).all(axis=1)
    assert (len(points), cloud.is_dense) == (3600, False)
    assert dark.any()
    assert (np.linalg.norm(points[~dark], axis=1) > 1).all()


def test_firings_without_a_return_that_are_kept_are_empty_beams(stage, lidar, world):
    from sensors.lidar.names import PREFIX

    lidar()
    stage.GetPrimAtPath("/World/Lidar").GetAttribute(f"{PREFIX}skipDroppingInvalidPoints").Set(True)
    app = world()
    helper(app, updates=7, type="laser_scan")
    ranges = app.sink["/points"][0].message.ranges
    assert np.isinf(ranges).any()
    assert ranges.min() > 1


def test_metadata_adds_fields_and_ring_and_time_come_at_any_auxiliary_level(lidar, world):
    lidar("XT32")
    app = world()
    helper(app, updates=7, selectedMetadata=["Time", "Intensity", "Ring", "Timestamp"])
    cloud = app.sink["/points"][0].message
    assert names(cloud) == ["x", "y", "z", "intensity", "timestamp_0", "timestamp_1", "ring", "time"]
    dtype = np.dtype([("xyz", "<f4", 3), ("i", "<f4"), ("t", "<u8"), ("ring", "<u2"), ("time", "<f4")])
    points = np.frombuffer(cloud.data.tobytes(), dtype)
    assert points["ring"].max() - points["ring"].min() < 32
    assert -0.1 <= points["time"].min() < points["time"].max() < 0
    start = cloud.header.stamp.sec * 10**9 + cloud.header.stamp.nanosec
    assert points["time"] == pytest.approx((points["t"].astype(np.int64) - start) * 1e-9, abs=1e-7)
    assert not list(app.warnings)


def test_metadata_above_the_auxiliary_level_warns_and_its_field_stays_out(lidar, world):
    lidar()
    app = world()
    helper(app, updates=7, selectedMetadata=["Intensity", "EmitterId"])
    assert names(app.sink["/points"][0].message) == ["x", "y", "z", "intensity"]
    assert [one.code for one in app.warnings] == ["aux-level-too-low"]


def test_unknown_metadata_is_refused_with_the_nearest_name(lidar, world):
    lidar()
    with pytest.raises(ComputeError, match='no quantity "Rings"; did you mean "Ring"'):
        helper(world(), updates=1, selectedMetadata=["Rings"])


def test_a_quantity_that_a_lidar_does_not_measure_is_left_out_with_a_warning(lidar, world):
    lidar()
    app = world()
    trace = helper(app, updates=7, selectedMetadata=["RadialVelocityMS", "Intensity"])
    assert names(app.sink["/points"][0].message) == ["x", "y", "z", "intensity"]
    [told] = trace.warnings
    assert told.code == "metadata-not-measured"
    assert "measures no RadialVelocityMS" in told.message


def test_the_config_node_lists_what_is_chosen_in_order():
    trace = run_node(
        "ROS2RtxLidarPointCloudConfig",
        inputs={"outputTime": True, "outputIntensity": True, "outputTickState": True, "outputRing": True},
    )
    assert trace.value("selectedMetadata") == ["Intensity", "TickState", "Ring", "Time"]


def test_frame_skip_publishes_every_third_scan_and_warns(lidar, world):
    lidar()
    app = world()
    trace = helper(app, frameSkipCount=2)
    assert stamps(app) == [300_000_000, 600_000_000, 900_000_000]
    assert [(one.code, one.count) for one in trace.warnings] == [("frame-skip-deprecated", 1)]


@pytest.mark.parametrize(("full_scan", "codes"), [(True, []), (False, ["full-scan-deprecated"])])
def test_fullScan_warns_when_it_is_false(lidar, world, full_scan, codes):
    lidar()
    assert [one.code for one in helper(world(), updates=2, fullScan=full_scan).warnings] == codes


def test_an_empty_product_path_warns_and_nothing_is_attached(lidar, world):
    lidar()
    app = world()
    trace = helper(app, updates=3, renderProductPath="")
    assert [(one.code, one.count) for one in trace.warnings] == [("render-product-missing", 3)]
    assert not app.bus.topics


def test_a_product_that_is_not_there_is_an_error(lidar, world):
    lidar()
    with pytest.raises(ComputeError, match="there is no render product /Render/Gone"):
        helper(world(), updates=1, renderProductPath="/Render/Gone")


def test_a_disabled_helper_publishes_nothing_and_switching_off_takes_the_writer_away(lidar, world):
    lidar()
    app = world()
    helper(app, enabled=lambda update: 20 <= update < 40)
    assert stamps(app) == [400_000_000, 500_000_000, 600_000_000]
    [product] = app.rendering.products.values()
    assert not product.writers


def test_a_stop_takes_the_writer_away(lidar, world):
    lidar()
    app = world()
    path = render_product(app, "/World/Lidar").path
    inputs = {"renderProductPath": path, "topicName": "points", "type": "point_cloud"}

    def stop_at_10(update, node):
        if update == 10:
            app.stop()
            app.play()

    run_node(HELPER, inputs=inputs, pulses={"execIn": range(20)}, updates=20, app=app, on_update=stop_at_10)
    assert [len(one.writers) for one in app.rendering.products.values()] == [1]
    assert stamps(app) == [100_000_000, 100_000_000]


def test_without_a_subscriber_no_channel_is_asked_for(stage, lidar):
    from graph.sim import App

    lidar()
    with App(stage) as app:
        product = render_product(app, "/World/Lidar")
        helper(app, updates=10, selectedMetadata=["Intensity"])
        assert product.sensor.channels() == frozenset()
        assert [topic.messages for topic in app.bus.topics.values()] == [0]


def test_the_topic_takes_the_namespace_of_the_lidars_ancestors(stage, lidar, world):
    from pxr import Sdf

    lidar(path="/World/Robot/Lidar")
    robot = stage.GetPrimAtPath("/World/Robot")
    robot.CreateAttribute("isaac:namespace", Sdf.ValueTypeNames.String).Set("r1")
    app = world()
    helper(app, updates=7, lidar="/World/Robot/Lidar")
    assert [len(app.sink["/r1/points"]), len(app.sink["/points"])] == [1, 0]


def test_system_time_stamps_with_the_wall_clock_and_says_that_it_never_resets(lidar, world):
    lidar()
    app = world()
    trace = helper(app, updates=7, useSystemTime=True)
    # Rendered in update 5; each update lasts 1/60 s of the virtual wall clock.
    assert stamps(app) == [round(5 * 10**9 / 60)]
    assert [one.code for one in trace.warnings] == ["system-time-never-resets"]


def test_monotonic_stamps_go_on_after_a_stop(lidar, world):
    lidar()
    app = world(physics_hz=60, loop_hz=60)
    app.play()
    app.update(30)
    app.stop()
    helper(app, updates=12, resetSimulationTimeOnStop=False)
    assert stamps(app) == [600_000_000, 700_000_000]


def test_an_object_id_map_needs_ids(lidar, world):
    lidar()
    trace = helper(world(), updates=2, enableObjectIdMap=True)
    assert [one.code for one in trace.warnings] == ["object-id-map-unavailable"]


def test_an_object_id_map_is_json_with_decimal_ids_and_the_stamp():
    import json

    from nodes.ros2.messages import object_id_map

    message = object_id_map({2**100: "/World/Box", 7: "/World/Ball"}, 1_500_000_000)
    assert json.loads(message.data) == {
        "id_to_labels": {"7": "/World/Ball", str(2**100): "/World/Box"},
        "time_stamp": {"sec": 1, "nanosec": 500_000_000},
    }


def test_the_semantic_class_is_a_field_and_its_labels_a_topic_beside_the_cloud(stage, lidar, world):
    import json

    from pxr import Sdf

    lidar()
    wall = stage.GetPrimAtPath("/World/Ahead")
    wall.CreateAttribute("semantics:labels:class", Sdf.ValueTypeNames.TokenArray).Set(["wall"])
    app = world(physics_hz=240)
    helper(app, updates=13, selectedMetadata=["ClassId"])
    cloud = app.sink["/points"][0].message
    assert names(cloud) == ["x", "y", "z", "class_id"]
    points = np.frombuffer(cloud.data.tobytes(), np.dtype([("xyz", "<f4", 3), ("class_id", "<u4")]))
    first, second = (json.loads(one.message.data) for one in app.sink["/points_labels"])
    assert first == {
        "0": {"class": "BACKGROUND"},
        "1": {"class": "UNLABELLED"},
        "2": {"class": "wall"},
        "time_stamp": {"sec": 0, "nanosec": 100_000_000},
    }
    assert second["time_stamp"] == {"sec": 0, "nanosec": 200_000_000}
    ahead = points["xyz"][:, 0] > 3.9  # the wall four metres ahead
    assert set(points["class_id"][ahead]) == {2}
    assert set(points["class_id"][~ahead]) == {1}


def test_the_debug_view_is_drawn_into_the_runs_folder(tmp_path, lidar, world):
    lidar()
    app = world(physics_hz=240)
    app.output_folder = tmp_path
    assert helper(app, updates=13, showDebugView=True).warnings == []
    assert sorted(file.name for file in (tmp_path / "debug_view").iterdir()) == [
        "World_Lidar_000000.png",
        "World_Lidar_000001.png",
    ]


def test_without_a_folder_the_debug_view_says_what_it_needs(lidar, world):
    lidar()
    [warning] = helper(world(physics_hz=240), updates=7, showDebugView=True).warnings
    assert (warning.code, "--out" in warning.message) == ("debug-view-unavailable", True)
