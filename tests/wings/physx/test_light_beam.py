"""A light curtain at (0, 0, 1) before a wall whose face is 4 m ahead (+x), from z = 0 to z = 2."""

import numpy as np
import pytest
from pxr import Gf, UsdGeom

from graph import ComputeError
from graph.testing import run_node

PATH = "/World/Curtain"


@pytest.fixture
def curtain(stage, world):
    """A function that opens a world with the wall and a curtain with these attributes."""

    def open_world(unit=1.0, turn=0.0, **attributes):
        UsdGeom.SetStageMetersPerUnit(stage, unit)
        wall = UsdGeom.Cube.Define(stage, "/World/Wall")
        wall.GetSizeAttr().Set(2 / unit)
        wall.AddTranslateOp().Set((5 / unit, 0, 1 / unit))
        prim = UsdGeom.Xformable(stage.DefinePrim(PATH, "IsaacLightBeamSensor"))
        prim.AddTranslateOp().Set((0, 0, 1 / unit))
        prim.AddRotateZOp().Set(turn)
        for name, value in attributes.items():
            prim.GetPrim().GetAttribute(name).Set(value)
        return world(physics_hz=100, loop_hz=50)

    return open_world


def read(app, path=PATH):
    return run_node("IsaacReadLightBeam", inputs={"lightbeamPrim": path}, pulses={"execIn": [0]}, app=app)


def test_beams_stand_a_share_of_the_length_apart_and_those_above_the_wall_go_on(curtain):
    """Four beams over 2 m: at 0, 0.5, 1 and 1.5 m above the sensor, so two of them pass over the wall (z = 2)."""
    trace = read(curtain(numRays=4, curtainLength=2.0, maxRange=10.0))
    heights = np.array([1, 1.5, 2, 2.5])
    assert trace.fired("execOut") == [0]
    assert trace.value("numRays") == 4
    # The beam at the height of the wall's edge may meet it or not.
    chosen = [0, 1, 3]
    assert np.asarray(trace.value("beamHitData"))[chosen].tolist() == [True, True, False]
    assert np.allclose(trace.value("linearDepthData")[chosen], [4, 4, 10])
    # A beam begins minRange (0.4 m) ahead and, where it hits nothing, ends maxRange from there.
    assert np.allclose(trace.value("beamOrigins"), [[0.4, 0, z] for z in heights])
    ends = np.array([4, 4, 4, 10.4])
    assert np.allclose(trace.value("beamEndPoints")[chosen], np.stack([ends, 0 * ends, heights], 1)[chosen])
    assert np.allclose(trace.value("hitPosData")[chosen], np.stack([ends, 0 * ends, heights - 1], 1)[chosen])


def test_axes_are_the_sensors_and_need_no_length(curtain):
    """Turned by 90 deg, the sensor's -y is the world's +x; its z axis carries the curtain."""
    trace = read(curtain(turn=90.0, forwardAxis=Gf.Vec3f(0, -7, 0)))
    assert np.allclose(trace.value("hitPosData"), [[0, -4, 0]], atol=1e-6)
    assert np.allclose(trace.value("beamEndPoints"), [[4, 0, 1]], atol=1e-6)


def test_lengths_are_metres_but_the_curtain_is_in_units_of_the_stage(curtain):
    trace = read(curtain(unit=0.01, numRays=2, curtainLength=100.0))
    assert np.allclose(trace.value("linearDepthData"), [4, 4])
    assert np.allclose(trace.value("beamOrigins"), [[0.4, 0, 1], [0.4, 0, 1.5]])


def test_a_disabled_curtain_gives_no_reading(curtain):
    assert read(curtain(enabled=False)).fired("execOut") == []


@pytest.mark.parametrize(
    ("attributes", "wrong"),
    [
        ({"numRays": 0}, "numRays is 0; give 1 or more"),
        ({"numRays": 20_000_000}, "raise it with --limit lidar.rays=N"),
        ({"forwardAxis": Gf.Vec3f(0, 0, 0)}, "give a vector of a length above 0"),
        ({"curtainLength": -1.0}, "give 0 or more"),
    ],
)
def test_what_no_curtain_has_is_reported_in_a_line(curtain, attributes, wrong):
    with pytest.raises(ComputeError, match=wrong):
        read(curtain(**attributes))


def test_a_prim_of_another_type_is_reported(curtain):
    with pytest.raises(ComputeError, match="/World/Wall is a Cube; give the path of a IsaacLightBeamSensor prim"):
        read(curtain(), "/World/Wall")
