"""What a lidar sees of a world that is changed while it plays."""

from __future__ import annotations

import numpy as np
import pytest

from graph.sim import App
from graph.sim.usd import Gf, Sdf
from sensors import Lidar, LidarSensor, Radar, RadarSensor, parse_generic_model_output_data

PRIMS = {
    "/World/Ground": {"type": "Plane"},
    "/World/Ball": {"type": "Sphere", "radius": 0.2, "translate": [0, 50, 9], "rigid_body": True},
    "/World/Far": {"type": "Cube", "size": 2, "translate": [11, 0, 1], "rotate": [0, 0, 0]},
}
NEAR = {"/World/New": {"type": "Cube", "size": 2, "translate": [5, 0, 1], "rigid_body": True}}


@pytest.fixture(params=["frozen", "update", "continuous"])
def world(request):
    with App(physics_hz=240, loop_hz=60, fidelity={"lidar.motion": request.param}) as app:
        app.add_prims(PRIMS)
        lidar = Lidar.create("/World/Lidar", config="Example_Rotary_2D", translations=[0, 0, 1], app=app)
        sensor = LidarSensor(lidar, annotators=["generic-model-output"])
        app.play()
        yield app, sensor


def ahead(sensor):
    """The distance of what stands straight ahead [m]."""
    frame = parse_generic_model_output_data(sensor.get_data("generic-model-output")[0])
    azimuth, distance = np.asarray(frame.x), np.asarray(frame.z)
    return float(distance[np.argmin(np.abs(azimuth))])


def scan(app, sensor):
    app.update(6)
    return ahead(sensor)


def test_the_next_tick_hits_what_was_added_and_no_longer_what_was_removed(world):
    app, sensor = world
    assert scan(app, sensor) == pytest.approx(10, abs=0.01)
    app.add_prims(NEAR, when_playing="recompile")
    assert scan(app, sensor) == pytest.approx(4, abs=0.01)
    app.remove_prims("/World/New", when_playing="recompile")
    assert scan(app, sensor) == pytest.approx(10, abs=0.01)
    app.stop()
    app.play()
    assert scan(app, sensor) == pytest.approx(10, abs=0.01)


def test_the_next_tick_hits_a_still_wall_where_the_stage_has_it_now(world):
    app, sensor = world
    assert scan(app, sensor) == pytest.approx(10, abs=0.01)
    app.stage.GetPrimAtPath("/World/Far").GetAttribute("xformOp:translate").Set(Gf.Vec3d(8, 0, 1))
    scan(app, sensor)
    assert scan(app, sensor) == pytest.approx(7, abs=0.01)


def test_the_next_tick_hits_a_wall_where_fabric_has_it_now(world):
    app, sensor = world
    place = Gf.Matrix4d().SetTranslate(Gf.Vec3d(6, 0, 1))
    app.fabric.get_prim_at_path("/World/Far").get_attribute("omni:fabric:worldMatrix").set(place)
    scan(app, sensor)
    assert scan(app, sensor) == pytest.approx(5, abs=0.01)


def test_a_wall_that_is_moved_in_every_update_is_not_a_new_scene(world):
    app, sensor = world
    for number in range(3):
        app.stage.GetPrimAtPath("/World/Far").GetAttribute("xformOp:translate").Set(Gf.Vec3d(10 - number, 0, 1))
        app.update()
        if number == 0:
            geometry, model = app.geometry(), app.physics.model
    assert app.geometry() is geometry
    assert app.physics.model is model
    app.update(9)
    assert ahead(sensor) == pytest.approx(7, abs=0.01)


def test_a_reset_of_time_begins_the_first_scan_again(world):
    app, sensor = world
    app.update(15)
    app.reset("time")
    assert sensor.get_data("generic-model-output")[0] is None
    app.update(6)
    frame = parse_generic_model_output_data(sensor.get_data("generic-model-output")[0])
    assert frame.timestampNs == 0
    assert ahead(sensor) == pytest.approx(10, abs=0.01)


def stamp(sensor):
    return parse_generic_model_output_data(sensor.get_data("generic-model-output")[0]).timestampNs


@pytest.mark.parametrize("how", ["removed", "inactive", "parent removed"])
def test_a_sensor_whose_prim_is_gone_gives_no_frames_and_the_others_go_on(world, how):
    app, lidar = world
    app.stop()
    radar = RadarSensor(Radar("/World/Car/Radar", tick_rate=10, app=app), annotators="generic-model-output")
    app.play()
    app.update(12)
    edits = {
        "removed": lambda: app.stage.RemovePrim("/World/Car/Radar"),
        "inactive": lambda: app.stage.GetPrimAtPath("/World/Car/Radar").SetActive(False),
        "parent removed": lambda: app.stage.RemovePrim("/World/Car"),
    }
    edits[how]()
    app.update(12)
    assert (stamp(radar), stamp(lidar)) == (200_000_000, 300_000_000)
    assert [one.where for one in app.warnings if one.code == "sensor-removed"] == ["/World/Car/Radar"]
    app.stop()
    app.play()
    app.update(12)
    assert stamp(radar) == 200_000_000


def test_a_lidar_that_is_removed_and_put_back_scans_from_then_on(world):
    app, sensor = world
    scan(app, sensor)
    spec = app.stage.GetRootLayer().GetPrimAtPath("/World/Lidar")
    kept = Sdf.Layer.CreateAnonymous(".usda")
    Sdf.CreatePrimInLayer(kept, "/World/Lidar")
    Sdf.CopySpec(spec.layer, spec.path, kept, "/World/Lidar")
    app.stage.RemovePrim("/World/Lidar")
    app.update(6)
    Sdf.CopySpec(kept, "/World/Lidar", app.stage.GetRootLayer(), "/World/Lidar")
    app.update(12)
    assert stamp(sensor) == 300_000_000
    assert ahead(sensor) == pytest.approx(10, abs=0.01)


def test_a_sensor_that_was_removed_before_play_keeps_nobody_from_playing(world):
    app, sensor = world
    app.stop()
    app.stage.RemovePrim("/World/Lidar")
    app.play()
    app.update(12)
    assert sensor.get_data("generic-model-output")[0] is None
    assert "sensor-removed" in app.warnings.codes()
