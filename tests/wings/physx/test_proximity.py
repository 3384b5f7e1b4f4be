"""Proximity sensors around bodies of known speed, without gravity, at 100 steps per second."""

import math

import numpy as np
import pytest

from graph import UserError
from graph.sim import App
from tests.support.physics_worlds import METRES, physics_of, stage_of
from wings.physx import ProximitySensor, clear_sensors, register_sensor

FREE = 'def PhysicsScene "S" { float physics:gravityMagnitude = 0\n}\n'
ZONE = 'def Cube "Zone" { double size = 1\n}\n'
ROOT_HALF = math.sqrt(0.5)


def prim(kind, name, *lines, at=(0, 0, 0), apis=("PhysicsCollisionAPI",), inner=""):
    applied = ", ".join(f'"{api}"' for api in apis)
    schemas = f"(prepend apiSchemas = [{applied}])" if apis else ""
    return f"""
def {kind} "{name}" {schemas}
{{
    double3 xformOp:translate = {tuple(at)}
    uniform token[] xformOpOrder = ["xformOp:translate"]
    {chr(10).join(lines)}
    {inner}
}}
"""


def ball(name, x, speed, radius=0.25, y=0.0):
    apis = ("PhysicsCollisionAPI", "PhysicsRigidBodyAPI")
    lines = (f"double radius = {radius}", f"vector3f physics:velocity = ({speed}, 0, 0)")
    return prim("Sphere", name, *lines, at=(x, y, 0), apis=apis)


def playing(text, head=METRES):
    app = App(stage_of(FREE + text, head), physics_hz=100, loop_hz=100)
    app.play()
    return app


def test_a_ball_is_inside_from_its_first_step_within_the_box_to_its_last():
    """Its centre is at k / 100 - 2.005 m after k steps; it meets the box while that is within 0.5 + 0.25 m of 0: from
    step 126 (-0.745 m) to step 275 (0.745 m).
    """
    told = []
    inside, enter, leave = (
        lambda one, what=what: told.append((what, one.scene.times.clock.count, one.entered, one.exited))
        for what in ("inside", "enter", "exit")
    )
    with playing(ZONE + ball("Ball", -2.005, 1)) as app:
        sensor = ProximitySensor(app.stage.GetPrimAtPath("/Zone"), [inside, enter, leave])
        register_sensor(sensor)
        for step in range(1, 301):
            app.update()
            here = 126 <= step <= 275
            assert sensor.is_overlapping == here
            assert sensor.get_active_zones() == (["/Ball"] if here else [])
            data = sensor.get_data()
            assert sensor.status() == (here, data)
            if here:
                assert data["/Ball"]["duration"] == (step - 126) / 100
                assert data["/Ball"]["distance"] == pytest.approx(abs(step / 100 - 2.005), abs=1e-9)
            if step == 150:
                assert sensor.to_string() == "/Ball: 0.505 m, for 0.24 s"
    assert [each for each in told if each[0] != "inside"] == [
        ("enter", 126, ("/Ball",), ()),
        ("exit", 276, (), ("/Ball",)),
    ]
    assert [step for what, step, _, _ in told if what == "inside"] == list(range(126, 276))


def test_every_step_of_an_update_is_looked_at():
    """Ten steps an update: the ball enters at step 126, in the 13th update, which ends 0.04 s later."""
    with App(stage_of(FREE + ZONE + ball("Ball", -2.005, 1)), physics_hz=100, loop_hz=10) as app:
        app.play()
        sensor = ProximitySensor("/Zone")
        register_sensor(sensor)
        app.update(steps=12)
        assert sensor.get_data() == {}
        app.update()
        assert sensor.get_data()["/Ball"]["duration"] == 0.04


def test_neither_its_own_body_nor_what_is_excluded_is_reported():
    """Two unit cubes 0.8 m apart overlap, as in the original's example; a wall and its like are within reach too."""
    cube = ("PhysicsCollisionAPI", "PhysicsRigidBodyAPI")
    text = prim("Cube", "cube_1", "double size = 1", "bool physics:kinematicEnabled = 1", at=(0.4, 0, 0), apis=cube)
    text += prim("Cube", "cube_2", "double size = 1", "bool physics:kinematicEnabled = 1", at=(-0.4, 0, 0), apis=cube)
    text += prim("Xform", "Hall", apis=(), inner=prim("Cube", "Wall", "double size = 1", at=(1.2, 0, 0)))
    text += ball("Far", 9, 0)
    with playing(text):
        every, some = ProximitySensor("/cube_1"), ProximitySensor("/cube_1", exclusions=["/Hall", "/cube"])
        for sensor in (every, some):
            sensor.update()
        assert set(every.get_active_zones()) == {"/cube_2", "/Hall/Wall"}
        assert some.get_active_zones() == ["/cube_2"]
        assert some.get_data()["/cube_2"] == {"duration": 0.0, "distance": pytest.approx(0.8)}


def test_a_sensor_on_a_body_goes_with_it_and_reports_bodies_by_their_own_path():
    """The zone reaches 1 m ahead of a cart at 1 m/s, to -2.005 + k / 100 + 1; the wheel of the other begins at 0.75."""
    zone = 'def Cube "Zone" { double size = 2\n}\n'
    apis = ("PhysicsCollisionAPI", "PhysicsRigidBodyAPI")
    cart = prim("Cube", "Cart", "double size = 0.2", "vector3f physics:velocity = (1, 0, 0)", at=(-2.005, 0, 0),
                apis=apis, inner=zone)  # fmt: skip
    wheel = prim("Sphere", "Wheel", "double radius = 0.25")
    other = prim("Xform", "Other", at=(1, 0, 0), apis=("PhysicsRigidBodyAPI",), inner=wheel)
    with playing(cart + other) as app:
        sensor = ProximitySensor("/Cart/Zone")
        register_sensor(sensor)
        app.update(steps=175)
        assert sensor.get_active_zones() == []
        app.update()
        assert sensor.get_active_zones() == ["/Other"]
        assert sensor.get_data()["/Other"]["distance"] == pytest.approx(1.245, abs=1e-9)


def test_lengths_are_metres_and_scale_counts():
    """Centimetres; the box is 2 x 1 m: a ball of 25 cm at 1.24 m along its longer side is inside, at 0.76 m not."""
    head = METRES.replace("metersPerUnit = 1", "metersPerUnit = 0.01")
    zone = 'def Cube "Zone" { double size = 100\n float3 xformOp:scale = (2, 1, 1)\n'
    zone += 'uniform token[] xformOpOrder = ["xformOp:scale"]\n}\n'
    text = zone + ball("In", 124, 0, radius=25) + ball("Out", 0, 0, radius=25, y=76)
    with playing(text, head):
        sensor = ProximitySensor("/Zone")
        sensor.update()
        assert sensor.get_data() == {"/In": {"duration": 0.0, "distance": pytest.approx(1.24)}}


def test_a_stop_and_a_clear_end_what_is_inside():
    with playing(ZONE + ball("Ball", 0, 0)) as app:
        sensor = ProximitySensor("/Zone")
        register_sensor(sensor)
        register_sensor(sensor)
        app.update(steps=11)
        assert sensor.get_data()["/Ball"]["duration"] == 0.1
        app.stop()
        assert sensor.status() == (False, {})
        app.play()
        app.update(steps=21)
        assert sensor.get_data()["/Ball"]["duration"] == 0.2
        clear_sensors()
        sensor.reset()
        app.update()
        assert sensor.get_active_zones() == []


CUBE_POINTS = [(x, y, z) for x in (-0.25, 0.25) for y in (-0.25, 0.25) for z in (-0.25, 0.25)]
FACES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
MESH = (
    f"point3f[] points = {CUBE_POINTS}",
    "int[] faceVertexCounts = [4, 4, 4, 4, 4, 4]",
    f"int[] faceVertexIndices = {[corner for face in FACES for corner in face]}",
)


@pytest.mark.parametrize(
    ("kind", "lines", "reach", "origin"),
    [
        ("Sphere", ["double radius = 0.25"], 0.25, 1e5),
        ("Cube", ["double size = 0.5"], 0.25, 0),
        ("Cube", ["double size = 0.5"], 0.25, 1e5),
        ("Capsule", ["double radius = 0.25", "double height = 0.5"], 0.25, 0),
        ("Cylinder", ["double radius = 0.25", "double height = 0.5"], 0.25, 0),
        ("Mesh", MESH, 0.25, 0),
        ("Mesh", MESH, 0.25, 1e5),
        ("Plane", ['uniform token axis = "X"'], -2 * ROOT_HALF, 0),
    ],
)
def test_a_turned_box_meets_a_shape_where_its_edge_does(kind, lines, reach, origin):
    """An edge of a unit cube turned by 45 deg is sqrt(0.5) m ahead; shapes reach 0.25 m back, a plane's solid side
    covers all behind it: the box is clear of it where the plane is sqrt(0.5) m behind.
    """
    c = ROOT_HALF
    pose = np.array([[c, -c, 0, origin], [c, c, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
    for off in (-1e-6, 1e-6):
        x = origin + ROOT_HALF + reach + off
        physics, _ = physics_of(stage_of(FREE + prim(kind, "It", *lines, at=(x, 0, 0)) + ball("Far", -9, 0)))
        meets = off > 0 if kind == "Plane" else off < 0
        assert physics.overlapping(pose, np.full(3, 0.5)) == ([("/It", "")] if meets else [])


@pytest.mark.parametrize(
    ("path", "callbacks", "wrong"),
    [
        ("/Nothing", [None] * 3, "no such prim"),
        ("/S", [None] * 3, "give the prim of a shape"),
        ("/Zone", [None], "give 3: inside, enter, exit"),
    ],
)
def test_what_no_sensor_can_watch_is_refused_in_a_line(path, callbacks, wrong):
    with playing(ZONE + ball("Ball", 0, 0)), pytest.raises(UserError, match=wrong):
        ProximitySensor(path, callbacks)
