"""ROS2RtxRadarHelper: clouds of a radar before a corner of 14.4 dBsm, 20 m ahead."""

import numpy as np
import pytest

from graph.testing import run_node
from sensors import render_product
from tests.support.radar_scenes import RADAR, radar_world, trihedral

HELPER = "ROS2RtxRadarHelper"


@pytest.fixture
def app():
    from graph.sim.messages.bus import MemorySink

    with radar_world(trihedral(0.1, 20.0)) as (app, product):
        product.sensor.release("test")
        app.stop()
        app.sink = MemorySink()
        app.bus.subscribe(app.sink)
        yield app


def helper(app, updates=3, **inputs):
    path = render_product(app, RADAR).path
    inputs = {"renderProductPath": path, **inputs}
    return run_node(HELPER, inputs=inputs, pulses={"execIn": range(updates)}, updates=updates, app=app)


def test_every_frame_is_a_cloud_with_the_fields_that_are_asked_for(app):
    helper(app, outputIntensity=True, outputTimestamp=True, outputRadialVelocityMS=True)
    messages = [one.message for one in app.sink["/radar_point_cloud"]]
    stamps = [message.header.stamp.sec * 10**9 + message.header.stamp.nanosec for message in messages]
    assert stamps == [16_666_667, 33_333_333, 50_000_000]
    cloud = messages[-1]
    names = [field.name for field in cloud.fields]
    assert names == ["x", "y", "z", "intensity", "timestamp_0", "timestamp_1", "radial_velocity_ms"]
    assert (cloud.header.frame_id, cloud.height, cloud.width) == ("sim_radar", 1, len(cloud.data) // 28)
    rows = np.frombuffer(cloud.data.tobytes(), "<f4").reshape(-1, 7)
    corner = rows[np.argmax(rows[:, 3])]
    assert corner[:3] == pytest.approx([20, 0, 0], abs=5e-3)
    assert corner[3] == pytest.approx(14.4 + 21.76, abs=0.2)
    assert corner[6] == 0
    times = np.frombuffer(cloud.data.tobytes(), "<u4").reshape(-1, 7)[:, 4:6]
    assert times[0, 0] + (int(times[0, 1]) << 32) == 50_000_000


def test_a_cloud_has_points_alone_where_nothing_else_is_asked_for(app):
    helper(app, topicName="front", frameId="bumper")
    cloud = app.sink["/front"][0].message
    assert [field.name for field in cloud.fields] == ["x", "y", "z"]
    assert cloud.header.frame_id == "bumper"


def test_without_the_level_the_velocity_is_left_out_with_a_warning(app):
    from sensors.prim import write_aux_level

    write_aux_level(app.stage.GetPrimAtPath(RADAR), "NONE")
    helper(app, outputRadialVelocityMS=True)
    assert [field.name for field in app.sink["/radar_point_cloud"][0].message.fields] == ["x", "y", "z"]
    assert any(warning.code == "aux-level-too-low" for warning in app.warnings)


def test_a_product_of_something_else_is_reported_and_publishes_nothing(app):
    app.stage.DefinePrim("/World/Lidar", "OmniLidar")
    path = render_product(app, "/World/Lidar").path
    trace = run_node(HELPER, inputs={"renderProductPath": path}, pulses={"execIn": [0]}, updates=2, app=app)
    assert [warning.code for warning in trace.warnings] == ["not-a-radar"]
    assert app.sink["/radar_point_cloud"] == []


def test_switched_off_it_attaches_nothing(app):
    helper(app, enabled=False)
    assert app.sink["/radar_point_cloud"] == []
