"""Rolling shutters: each line shows the world as it was when the line was exposed.

A body at 5 m that moves with 2 m/s crosses 200 px a second; 480 lines 20 us apart take 9.6 ms: 1.92 px.
"""

from fractions import Fraction

import numpy as np
import pytest
from pxr import Gf, UsdGeom

from graph.base.errors import UserError
from graph.sim import App
from sensors.camera.config import read_config
from sensors.replicator import get_annotator
from tests.support.camera_worlds import add_camera, ahead
from tests.support.lidar_worlds import add_box, weightless

LINE_US = 200
"""Ten times as slow as in the text above: 480 lines take 96 ms, 19.2 px."""


def rolling(app, order, path="/World/Camera", size=(640, 480)):
    product = add_camera(app, path, size)
    prim = app.stage.GetPrimAtPath(path)
    prim.AddAppliedSchema("OmniRtxRollingShutterAPI")
    prim.GetAttribute("omni:rtx:rollingShutter:scanOrder").Set(order)
    prim.GetAttribute("omni:rtx:rollingShutter:lineOffset").Set(Gf.Vec2d(LINE_US, 1_000_000))
    return product


def edges(app, product, updates=12):
    """The depth image of the last update, and the stamp of its frame."""
    depth = get_annotator("distance_to_image_plane", app=app).attach(product)
    app.play()
    app.update(steps=updates)
    return depth.get_data(), product.frame


@pytest.mark.parametrize(("order", "sign"), [("topToBottom", 1), ("bottomToTop", -1), ("none", 0)])
def test_a_body_that_moves_is_sheared(order, sign):
    """The front's left edge, 5 m ahead, is 19.2 px x (lines between) / 480 further right in later lines.

    Bodies stand still in each of 32 bands of 15 lines: 0.6 px a band, and half a pixel of rounding.
    """
    with weightless() as app:
        add_box(app, "/World/Body", 4.0, ahead(1, 0, 7), velocity=(2.0, 0, 0))
        product = rolling(app, order)
        depth, frame = edges(app, product)
    left = [int(np.flatnonzero(np.abs(depth[row] - 5.0) < 1e-3)[0]) for row in (60, 420)]
    assert left[1] - left[0] == pytest.approx(sign * 200 * 360 * LINE_US * 1e-6, abs=1.1)
    duration = Fraction(479 * LINE_US, 10**6) if sign else Fraction(0)
    assert frame.timestamp_ns == round((Fraction(12, 60) - duration) * 10**9)
    assert frame.end.timestamp_ns == 200_000_000


def test_the_last_line_shows_the_state_of_the_update():
    def last_line(order):
        with weightless() as app:
            add_box(app, "/World/Body", 4.0, ahead(1, 0, 7), velocity=(2.0, 0, 0))
            return edges(app, rolling(app, order, size=(640, 320)))[0][319]

    # The last band's middle is 1.5 ms before the end: 0.3 px.
    first, second = (np.flatnonzero(np.isfinite(last_line(order)))[0] for order in ("topToBottom", "none"))
    assert abs(int(first) - int(second)) <= 1


def test_a_camera_that_moves_shears_what_stands_still():
    """Carried to the left by 2 m/s the camera sees a wall's edge move to the right: 200 px/s at 5 m, line by line."""
    with weightless() as app:
        add_box(app, "/World/Box", 4.0, ahead(1, 0, 7))
        add_box(app, "/World/Cart", 0.1, ahead(0, 0, -3), velocity=(-2.0, 0, 0))
        product = rolling(app, "topToBottom", "/World/Cart/Camera")
        UsdGeom.XformCommonAPI(app.stage.GetPrimAtPath("/World/Cart/Camera")).SetTranslate(Gf.Vec3d(0, 0, -3))
        depth, _ = edges(app, product)
    left = [int(np.flatnonzero(np.abs(depth[row] - 5.0) < 1e-3)[0]) for row in (60, 420)]
    assert left[1] - left[0] == pytest.approx(200 * 360 * LINE_US * 1e-6, abs=1.0)


def test_columns_are_lines_too():
    """Columns from left to right, 5,000 a second: a front of 400 px at 200 px/s is 1 / (1 - 0.04) as wide."""
    with weightless() as app:
        add_box(app, "/World/Body", 4.0, ahead(0, 0, 7), velocity=(2.0, 0, 0))
        depth, _ = edges(app, rolling(app, "leftToRight"))
    front = np.flatnonzero(np.abs(depth[240] - 5.0) < 1e-3)
    assert len(front) == pytest.approx(400 / (1 - 200 / 5000), abs=2)


def test_what_stands_still_is_the_same_with_any_shutter():
    def image(order):
        with weightless() as app:
            add_box(app, "/World/Box", 4.0, ahead(1, 0, 7))
            return edges(app, rolling(app, order))[0]

    np.testing.assert_allclose(image("topToBottom"), image("none"), rtol=1e-6)


def test_a_fraction_that_is_none_is_told_in_a_line():
    with App(None) as app:
        rolling(app, "topToBottom")
        prim = app.stage.GetPrimAtPath("/World/Camera")
        prim.GetAttribute("omni:rtx:rollingShutter:lineOffset").Set(Gf.Vec2d(1, 0))
        with pytest.raises(UserError, match=r"lineOffset is \(1, 0\); give seconds as a fraction, 0 or more"):
            read_config(prim, (640, 480), 1.0)
