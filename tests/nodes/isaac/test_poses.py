import itertools
import math

import numpy as np
import pytest

from graph import ComputeError
from graph.testing import run_node
from nodes.isaac.poses import decompose


def pose(translation=(0, 0, 0), rotation=None, scale=(1, 1, 1)):
    matrix = np.eye(4)
    matrix[:3, :3] = (np.eye(3) if rotation is None else rotation) * np.array(scale)
    matrix[:3, 3] = translation
    return matrix


def about_z(degrees):
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])


def test_a_pose_comes_apart_into_translation_quaternion_and_scale():
    translation, orientation, scale = decompose(pose((1, 2, 3), about_z(90), (2, 3, 4)))
    assert translation.tolist() == [1, 2, 3]
    assert orientation == pytest.approx([0, 0, math.sqrt(0.5), math.sqrt(0.5)])
    assert scale == pytest.approx([2, 3, 4])


def test_a_mirrored_pose_has_a_negative_x_scale_and_a_proper_rotation():
    _, orientation, scale = decompose(pose(scale=(-1, 1, 1)))
    assert scale.tolist() == [-1, 1, 1]
    assert orientation.tolist() == [0, 0, 0, 1]


@pytest.fixture
def nested(stage):
    """/World/Frame at (1, 2, 3), turned by 90 deg about z, twice as large; in it /Tip at (1, 0, 0)."""
    from pxr import UsdGeom

    frame = UsdGeom.Xform.Define(stage, "/World/Frame")
    frame.AddTranslateOp().Set((1, 2, 3))
    frame.AddRotateZOp().Set(90)
    frame.AddScaleOp().Set((2, 2, 2))
    UsdGeom.Xform.Define(stage, "/World/Frame/Tip").AddTranslateOp().Set((1, 0, 0))
    return stage


def test_a_nested_prim_is_read_in_world_coordinates_and_stage_units(nested, world):
    from pxr import UsdGeom

    UsdGeom.SetStageMetersPerUnit(nested, 0.01)
    trace = run_node("IsaacReadWorldPose", inputs={"prim": "/World/Frame/Tip"}, app=world())
    assert trace.value("translation") == pytest.approx([1, 4, 3])
    assert trace.value("orientation") == pytest.approx([0, 0, math.sqrt(0.5), math.sqrt(0.5)])
    assert trace.value("scale") == pytest.approx([2, 2, 2])


def test_a_falling_body_is_read_where_it_is(stage, world):
    from pxr import UsdGeom, UsdPhysics

    ball = UsdGeom.Sphere.Define(stage, "/World/Ball")
    ball.AddTranslateOp().Set((0, 0, 10))
    for api in (UsdPhysics.RigidBodyAPI, UsdPhysics.CollisionAPI):
        api.Apply(ball.GetPrim())
    trace = run_node("IsaacReadWorldPose", inputs={"prim": "/World/Ball"}, updates=60, app=world(physics_hz=240))
    fallen = [10 - height for _, _, height in trace.values("translation")]
    assert fallen[59] == pytest.approx(9.81 / 2, rel=0.02)
    assert all(later > earlier for earlier, later in itertools.pairwise(fallen))


def test_a_prim_that_is_not_there_is_an_error(world):
    with pytest.raises(ComputeError, match="there is no prim /World/Nothing on the stage"):
        run_node("IsaacReadWorldPose", inputs={"prim": "/World/Nothing"}, app=world())


def test_one_prim_is_needed(world):
    with pytest.raises(ComputeError, match="input prim names 0 prims"):
        run_node("IsaacReadWorldPose", app=world())


def test_a_node_that_needs_a_world_says_so():
    with pytest.raises(ComputeError, match="needs a world"):
        run_node("IsaacReadWorldPose", inputs={"prim": "/World/Ball"})
