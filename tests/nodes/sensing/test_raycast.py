"""A raycast sensor between two walls: 4 m ahead of it (+x), 2 m to its left (+y); sky above."""

import math

import numpy as np
import pytest
from pxr import Gf, UsdGeom, UsdPhysics

from graph import ComputeError
from graph.testing import run_node

PATH = "/World/Mount/Sensor"
AHEAD, LEFT, UP = (1, 0, 0), (0, 1, 0), (0, 0, 2)


@pytest.fixture
def sensor(stage, world):
    """A function that opens a world with the walls and a sensor with these rays at (0, 0, 1)."""

    def open_world(directions=(AHEAD, LEFT, UP), unit=1.0, turn=0.0, origins=None, **attributes):
        UsdGeom.SetStageMetersPerUnit(stage, unit)
        for name, place in (("Ahead", (5, 0, 1)), ("Left", (0, 3, 1))):
            wall = UsdGeom.Cube.Define(stage, f"/World/{name}")
            wall.GetSizeAttr().Set(2 / unit)
            wall.AddTranslateOp().Set(tuple(part / unit for part in place))
        mount = UsdGeom.Xform.Define(stage, "/World/Mount")
        mount.AddTranslateOp().Set((0, 0, 1 / unit))
        mount.AddRotateZOp().Set(turn)
        prim = stage.DefinePrim(PATH, "IsaacRaycastSensor")
        given = {
            "numRays": len(directions),
            "rayDirections": [Gf.Vec3f(*one) for one in directions],
            "rayOrigins": [Gf.Vec3f(*one) for one in origins or [(0, 0, 0)] * len(directions)],
            **attributes,
        }
        for name, value in given.items():
            prim.GetAttribute(name).Set(value)
        return world(physics_hz=100, loop_hz=50)

    return open_world


def read(app, updates=1):
    inputs = {"raycastSensorPrim": PATH}
    return run_node(
        "IsaacReadRaycastSensor", inputs=inputs, pulses={"execIn": range(updates)}, updates=updates, app=app
    )


def test_each_ray_tells_how_far_it_goes_and_what_it_hits(sensor):
    trace = read(sensor(reportHitPrimPaths=True, outputFrameOfReference="WORLD", maxRange=50.0))
    assert trace.fired("execOut") == [0]
    assert trace.value("numRays") == 3
    assert trace.value("sensorTime") == pytest.approx(0.02)
    assert np.allclose(trace.value("depths"), [4, 2, 50])
    assert np.allclose(trace.value("hitPositions").reshape(-1, 3), [[4, 0, 1], [0, 2, 1], [0, 0, 51]])
    assert np.allclose(trace.value("hitNormals").reshape(-1, 3), [[-1, 0, 0], [0, -1, 0], [0, 0, 0]])
    assert trace.value("hitPrimPaths") == ["/World/Ahead", "/World/Left", ""]
    assert np.allclose(trace.value("beamOrigins"), [[0, 0, 1]] * 3)
    assert np.allclose(trace.value("beamEndPoints"), [[4, 0, 1], [0, 2, 1], [0, 0, 51]])


def test_hits_are_given_in_the_axes_of_the_sensor_by_default(sensor):
    """Turned to the left, the sensor has the left wall ahead of it and the other one at its right."""
    trace = read(sensor(directions=[AHEAD, (0, -1, 0)], turn=90.0))
    assert np.allclose(trace.value("hitPositions").reshape(-1, 3), [[2, 0, 0], [0, -4, 0]], atol=1e-6)
    assert np.allclose(trace.value("hitNormals").reshape(-1, 3), [[-1, 0, 0], [0, 1, 0]], atol=1e-6)
    assert np.allclose(trace.value("beamEndPoints"), [[0, 2, 1], [4, 0, 1]], atol=1e-6)
    assert trace.value("hitPrimPaths") == []


def test_rays_begin_at_their_origins_and_see_nothing_nearer_than_the_least_range(sensor):
    app = sensor(directions=[AHEAD, AHEAD], origins=[(1, 0, 0), (3.9, 0, 0)], minRange=0.5, maxRange=10.0)
    # The second ray starts inside the wall, 0.4 m behind its face: it leaves it at x = 6.
    assert np.allclose(read(app).value("depths"), [3, 6 - 3.9])


def test_lengths_are_in_units_of_the_stage(sensor):
    trace = read(sensor(unit=0.01, maxRange=5000.0, outputFrameOfReference="WORLD"))
    assert np.allclose(trace.value("depths"), [400, 200, 5000])
    assert np.allclose(trace.value("hitPositions").reshape(-1, 3)[0], [400, 0, 100])


def test_rays_with_time_offsets_take_turns(sensor):
    """A sweep of 0.05 s at 100 Hz: each physics step fires the rays of its own hundredth; the last one is the first.

    Two steps an update: the readings are of the steps that end at 0.02, 0.04, 0.06, 0.08 and 0.1 s.
    """
    offsets = [0.0, 0.01, 0.02, 0.03, 0.04, 0.05]
    directions = [(math.cos(angle), 0, math.sin(angle)) for angle in (0.1, 0.2, 0.3, 0.4, 0.5, 0.6)]
    trace = read(sensor(directions=directions, rayTimeOffsets=offsets), updates=5)
    counts = trace.values("numRays")
    # Steps [0.01, 0.02), [0.03, 0.04), [0.05 = 0, 0.01), [0.02, 0.03), [0.04, 0.05) of the sweep.
    assert counts == [1, 1, 2, 1, 1]


def test_a_sensor_on_a_falling_body_falls_with_it(sensor, stage):
    app = sensor(directions=[(0, 0, -1)], maxRange=100.0)
    mount = stage.GetPrimAtPath("/World/Mount")
    UsdPhysics.RigidBodyAPI.Apply(mount)
    UsdPhysics.MassAPI.Apply(mount).GetMassAttr().Set(1.0)
    mount.GetAttribute("xformOp:translate").Set((0, 0, 50))
    UsdGeom.Plane.Define(stage, "/World/Ground")
    depths = [float(one[0]) for one in read(app, updates=50).values("depths")]
    # One second of free fall: g/2, and g/2 times the step more, since steps are explicit in velocity.
    assert depths[-1] == pytest.approx(50 - 9.81 / 2 * 1.01, abs=1e-3)


def test_a_disabled_sensor_has_no_reading(sensor):
    trace = read(sensor(enabled=False))
    assert trace.fired("execOut") == []
    assert trace.value("numRays") == 0


@pytest.mark.parametrize(
    ("attributes", "message"),
    [
        ({"numRays": 5}, "rayDirections has 3 elements; give it 5"),
        ({"rayTimeOffsets": [0.1]}, "rayTimeOffsets has 1 elements; give it 3"),
        ({"minRange": 5.0, "maxRange": 2.0}, "minRange must be the smaller"),
        ({"outputFrameOfReference": "BODY"}, "must be SENSOR or WORLD"),
        ({"rayDirections": [Gf.Vec3f(0), Gf.Vec3f(1), Gf.Vec3f(1)]}, "a vector of length 0"),
    ],
)
def test_rays_that_do_not_fit_together_fail(sensor, attributes, message):
    with pytest.raises(ComputeError, match=message):
        read(sensor(**attributes))
