"""References of `pxr` to assets by address, CameraInfo of render products, default states, groups of commands."""

from importlib import import_module

import numpy as np
import pytest

import graph.isaac
from graph.sim import App
from tests.support.without_wing import needs_wing

ANT = (
    "https://omniverse-content-production.s3-us-west-2.amazonaws.com/Assets/Isaac/6.0/Isaac/Robots/IsaacSim/Ant/ant.usd"
)


@pytest.fixture
def app():
    with App() as made, graph.isaac.importable():
        import_module("omni.usd").get_context().get_stage()
        yield made


@needs_wing("stand_ins")
@pytest.mark.parametrize("arc", ["GetReferences().AddReference", "GetPayloads().AddPayload"])
def test_what_pxr_refers_to_is_found_as_by_the_functions_of_the_product(app, arc):
    prim = app.stage.DefinePrim("/World/Ant")
    owner, _, call = arc.partition("().")
    assert getattr(getattr(prim, owner)(), call)(ANT)
    assert app.stage.GetPrimAtPath("/World/Ant/torso")
    assert [one.code for one in app.warnings] == ["asset-stand-in"]


def test_a_missing_asset_that_pxr_refers_to_is_said(app):
    prim = app.stage.DefinePrim("/World/Thing")
    prim.GetReferences().AddReference("https://example.com/thing.usd")
    assert [(one.code, one.where) for one in app.warnings] == [("asset-missing", "/World/Thing")]


def test_the_camera_info_of_a_product_is_that_of_its_image(app):
    """fx = 640 px x 24 / 12; K has the image's middle; the helper's message says the same."""
    camera = app.stage.DefinePrim("/World/Rig/Eye", "Camera")
    camera.GetAttribute("focalLength").Set(24.0)
    camera.GetAttribute("horizontalAperture").Set(12.0)
    camera.CreateAttribute("isaac:namespace", import_module("pxr.Sdf").ValueTypeNames.String).Set("eye")
    core = import_module("isaacsim.ros2.core")
    product = import_module("omni.replicator.core").create.render_product("/World/Rig/Eye", (640, 480))
    info, prim = core.read_camera_info(product.path)
    assert (info.width, info.height, info.distortion_model, list(info.d)) == (640, 480, "plumb_bob", [0.0] * 5)
    assert info.k.reshape(3, 3).tolist() == [[1280, 0, 320], [0, 1280, 240], [0, 0, 1]]
    assert info.p.reshape(3, 4).tolist() == [[1280, 0, 320, 0], [0, 1280, 240, 0], [0, 0, 1, 0]]
    assert info.r.reshape(3, 3).tolist() == np.eye(3).tolist()
    assert str(prim.GetPath()) == "/World/Rig/Eye"
    assert core.collect_namespace("", product.path) == "eye"
    assert core.collect_namespace("mine", product.path) == "mine"


def test_a_stereo_pair_is_apart_by_its_baseline(app):
    from graph.sim.usd import UsdGeom

    for name, y in (("Left", 0.06), ("Right", -0.06)):
        UsdGeom.Camera.Define(app.stage, f"/World/{name}").AddTranslateOp().Set((0, y, 0))
    left, right = (app.stage.GetPrimAtPath(f"/World/{name}") for name in ("Left", "Right"))
    translation, rotation = import_module("isaacsim.ros2.core").compute_relative_pose(left, right)
    assert translation.tolist() == pytest.approx([0, 0.12, 0])
    assert rotation.tolist() == np.eye(3).tolist()


def test_the_default_state_of_an_object_is_where_it_was_made(app):
    objects = import_module("isaacsim.core.api.objects")
    cube = objects.DynamicCuboid("/World/Cube", position=np.array([1.0, 2.0, 3.0]))
    cube.set_world_pose(np.array([5.0, 5.0, 5.0]))
    state = cube.get_default_state()
    assert (state.position.tolist(), state.linear_velocity.tolist()) == ([1, 2, 3], [0, 0, 0])
    cube.set_default_state(position=np.array([7.0, 8.0, 9.0]))
    assert cube.get_default_state().position.tolist() == [7, 8, 9]


def test_a_group_of_commands_that_did_not_begin_ends_without_a_word(app):
    undo = import_module("omni.kit.undo")
    undo.end_group()
    assert not undo.undo()


def test_controllers_of_wheels_are_at_the_top_of_their_module(app):
    names = import_module("isaacsim.robot.wheeled_robots")
    deeper = import_module("isaacsim.robot.wheeled_robots.controllers.ackermann_controller")
    assert names.AckermannController is deeper.AckermannController
    assert names.DifferentialController
