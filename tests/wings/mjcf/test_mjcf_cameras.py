"""Cameras of MJCF models keep their vertical angle of view at every image size, and their focal lengths."""

import math

import numpy as np
import pytest

from graph.sim.physics.mujoco.library import mujoco
from sensors.camera.config import read_config
from sensors.camera.lens import ParallelLens
from wings.mjcf.scene import open_mjcf

SENSOR = "sensorsize='.0064 .0048' resolution='640 480'"
CAMERAS = {
    "plain": "fovy='40'",
    "sized": "fovy='40' resolution='640 480'",
    "flat": "projection='orthographic' fovy='2'",
    "metric": f"{SENSOR} focal='.005 .005' principal='.0002 .0001'",
    "pixels": f"{SENSOR} focalpixel='500 400' principalpixel='20 -10'",
    "unsized": "sensorsize='.0064 .0048' focal='.005 .005'",
}


@pytest.fixture
def lens(tmp_path):
    """A function: the lens of a named camera for an image size."""
    cameras = "".join(f"<camera name='{name}' {text}/>" for name, text in CAMERAS.items())
    (tmp_path / "eyes.xml").write_text(f"<mujoco><worldbody>{cameras}</worldbody></mujoco>")
    scene = open_mjcf(tmp_path / "eyes.xml")
    found = lambda name, *size: read_config(scene.stage.GetPrimAtPath(f"/World/{name}"), size, 1.0).lens  # noqa: E731
    found.model = scene.model
    return found


@pytest.mark.parametrize("size", [(320, 240), (640, 480), (1280, 720), (240, 320)])
@pytest.mark.parametrize("name", ["plain", "sized"])
def test_fovy_is_the_vertical_angle_at_every_size(lens, name, size):
    # Half the height is f tan(fovy / 2): at 320 x 240, f = 120 / tan 20 deg = 329.70 px, in both directions.
    found, focal = lens(name, *size), size[1] / 2 / math.tan(math.radians(20))
    assert (found.fx, found.fy) == pytest.approx((focal, focal), rel=1e-6)
    assert (found.cx, found.cy) == (size[0] / 2, size[1] / 2)


def test_an_orthographic_camera_shows_its_height_at_every_size(lens):
    for width, height in ((320, 240), (100, 300)):
        found = lens("flat", width, height)
        assert isinstance(found, ParallelLens)
        assert (found.fx, found.fy) == pytest.approx((height / 2, height / 2), rel=1e-6)  # px/m: 2 m high


@pytest.mark.parametrize(
    ("name", "size", "expected"),
    [
        ("metric", (640, 480), (500, 500, 300, 230)),  # 5 mm of pixels of 10 um; 20 and 10 px off the middle
        ("metric", (320, 240), (250, 250, 150, 115)),
        ("pixels", (640, 480), (500, 400, 300, 250)),
        ("pixels", (640, 240), (250, 200, 310, 125)),  # another shape: half the height, so half of all lengths
        ("unsized", (640, 480), (500, 500, 320, 240)),
        ("unsized", (100, 480), (500, 500, 50, 240)),
    ],
)
def test_focal_lengths_and_principal_points_are_the_models(lens, name, size, expected):
    found = lens(name, *size)
    assert (found.fx, found.fy, found.cx, found.cy) == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("name", [*CAMERAS])
def test_the_image_is_what_mujoco_draws(lens, name):
    """The sides of MuJoCo's frustum, divided by its near distance, are those of the lens."""
    model = lens.model
    data, scene, camera = mujoco.MjData(model), mujoco.MjvScene(model, 10), mujoco.MjvCamera()
    mujoco.mj_forward(model, data)
    camera.type, camera.fixedcamid = mujoco.mjtCamera.mjCAMERA_FIXED, model.camera(name).id
    mujoco.mjv_updateScene(model, data, mujoco.MjvOption(), None, camera, mujoco.mjtCatBit.mjCAT_ALL, scene)
    drawn, found = scene.camera[0], lens(name, 640, 480)
    distance = 1.0 if drawn.orthographic else drawn.frustum_near
    top, bottom = found.cy / found.fy, (found.cy - 480) / found.fy
    assert (top, bottom) == pytest.approx((drawn.frustum_top / distance, drawn.frustum_bottom / distance), rel=1e-5)
    if drawn.frustum_width:  # 0: it follows from the shape of the window
        sides = np.array([-1, 1]) * drawn.frustum_width + drawn.frustum_center
        assert (-found.cx / found.fx, (640 - found.cx) / found.fx) == pytest.approx(tuple(sides / distance), rel=1e-5)
