import numpy as np
import pytest
from pxr import UsdGeom

from graph import ComputeError
from graph.testing import run_node


@pytest.fixture
def camera(stage):
    """A camera at (0, 0, 5) in a group at (10, 0, 0), looking straight down (Z up)."""
    UsdGeom.Xform.Define(stage, "/World/Rig").AddTranslateOp().Set((10, 0, 0))
    UsdGeom.Camera.Define(stage, "/World/Rig/Camera").AddTranslateOp().Set((0, 0, 5))
    return "/World/Rig/Camera"


def aim(app, camera, **inputs):
    run_node("SetCameraTarget", inputs={"primPath": camera, **inputs}, pulses={"execIn": [0]}, app=app)
    return app.fabric.world_matrix(camera)


def test_a_camera_turns_upright_to_its_target(world, camera):
    placed = aim(world(), camera, target=[0, 0, 5])
    assert placed[:3, 3] == pytest.approx([10, 0, 5])
    assert placed[:3, :3] == pytest.approx(np.array([[0, 0, 1], [1, 0, 0], [0, 1, 0]]))


def test_a_camera_can_look_straight_down(world, camera):
    placed = aim(world(), camera, target=[10, 0, 0])
    assert placed[:3, 2] == pytest.approx([0, 0, 1])
    assert np.linalg.det(placed[:3, :3]) == pytest.approx(1)


def test_a_camera_can_move_instead_and_keep_its_direction_and_distance(world, camera):
    placed = aim(world(), camera, target=[10, 3, 1], rotate=False)
    assert placed[:3, :3] == pytest.approx(np.eye(3))
    assert placed[:3, 3] == pytest.approx([10, 3, 6])


def test_a_camera_cannot_look_at_itself(world, camera):
    with pytest.raises(ComputeError, match="input target is where /World/Rig/Camera is"):
        aim(world(), camera, target=[10, 0, 5])


@pytest.mark.parametrize("rotate", [True, False])
def test_a_camera_cannot_look_at_a_point_that_is_not_finite(world, camera, rotate):
    app = world()
    with pytest.raises(ComputeError, match=r"/World/Rig/Camera would be at .* look at .*; give finite numbers"):
        aim(app, camera, target=[np.nan, 0, 5], rotate=rotate)
    assert app.fabric.world_matrix(camera)[:3, 3].tolist() == [10, 0, 5]


def test_a_viewport_tells_its_camera(world, camera):
    from nodes.isaac.viewports import viewports_of

    app = world()
    assert run_node("GetActiveViewportCamera", app=app).value("camera") == ""
    viewports_of(app)["Viewport"].camera = camera
    assert run_node("GetActiveViewportCamera", app=app).value("camera") == camera
    trace = run_node("GetActiveViewportCamera", inputs={"viewport": "none"}, app=app)
    assert [one.code for one in trace.warnings] == ["viewport-missing"]


def test_a_camera_is_moved_and_then_turned_and_says_both(world, camera):
    """What the public test of these nodes asserts, below a parent that is moved."""
    app = world()
    aimed = {"primPath": camera}
    run_node("SetCameraPosition", inputs={**aimed, "position": [1, 2, 3]}, pulses={"execIn": [0]}, app=app)
    run_node("SetCameraTarget", inputs={**aimed, "target": [-1, -2, -3]}, pulses={"execIn": [0]}, app=app)
    assert run_node("GetCameraPosition", inputs=aimed, app=app).value("position") == pytest.approx([1, 2, 3])
    assert run_node("GetCameraTarget", inputs=aimed, app=app).value("target") == pytest.approx([-1, -2, -3])
    forward = -app.fabric.world_matrix(camera)[:3, 2]
    assert forward == pytest.approx(np.array([-2, -4, -6]) / np.sqrt(56))


def test_a_camera_that_moves_looks_at_the_same_point_or_keeps_its_direction(world, camera):
    app = world()
    aimed = {"usePath": False, "prim": [camera]}
    aim(app, camera, target=[10, 3, 5])  # level, along +y
    run_node(
        "SetCameraPosition", inputs={**aimed, "position": [13, 3, 5]}, pulses={"execIn": [0]}, app=app
    )  # beside the point: along -x
    assert -app.fabric.world_matrix(camera)[:3, 2] == pytest.approx([-1, 0, 0])
    inputs = {**aimed, "position": [13, 7, 5], "rotate": False}
    run_node("SetCameraPosition", inputs=inputs, pulses={"execIn": [0]}, app=app)
    assert -app.fabric.world_matrix(camera)[:3, 2] == pytest.approx([-1, 0, 0])
    assert run_node("GetCameraTarget", inputs=aimed, app=app).value("target") == pytest.approx([10, 7, 5])


def test_a_target_that_nobody_set_is_reported(world, camera):
    trace = run_node("GetCameraTarget", inputs={"primPath": camera}, app=world())
    assert [one.code for one in trace.warnings] == ["camera-target-missing"]


def test_a_viewport_shows_the_camera_that_is_set_and_tells_its_frames(world, camera):
    from nodes.isaac.viewports import product_of, viewports_of

    app = world()
    trace = run_node("SetActiveViewportCamera", inputs={"primPath": camera}, pulses={"execIn": [0]}, app=app)
    assert trace.fired("execOut") == [0]
    assert run_node("GetActiveViewportCamera", app=app).value("cameraPrim") == [camera]
    assert product_of(app, viewports_of(app)["Viewport"]).camera_path == camera
    frames = run_node("OnNewFrame", updates=4, app=app)
    assert frames.fired("execOut") == [1, 2, 3]  # a graph of the simulation: one update after each frame
    assert frames.value("frameNumber") == 3
    with pytest.raises(ComputeError, match="/World/Rig is a Xform; a viewport shows a Camera"):
        run_node("SetActiveViewportCamera", inputs={"primPath": "/World/Rig"}, pulses={"execIn": [0]}, app=app)


@pytest.mark.parametrize("node", ["SetCameraPosition", "SetCameraTarget"])
def test_a_camera_that_usepath_hides_is_not_moved_in_silence(world, camera, node):
    """usePath is on by default, as in the product: then primPath names the camera, and it is empty."""
    with pytest.raises(ComputeError, match="input primPath is empty; give it the path of a prim, or clear usePath"):
        run_node(node, inputs={"prim": [camera]}, pulses={"execIn": [0]}, app=world())
