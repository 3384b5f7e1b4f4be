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


def test_a_viewport_tells_its_camera(world, camera):
    from nodes.isaac.viewports import viewports_of

    app = world()
    assert run_node("GetActiveViewportCamera", app=app).value("camera") == ""
    viewports_of(app)["Viewport"].camera = camera
    assert run_node("GetActiveViewportCamera", app=app).value("camera") == camera
    trace = run_node("GetActiveViewportCamera", inputs={"viewport": "none"}, app=app)
    assert [one.code for one in trace.warnings] == ["viewport-missing"]
