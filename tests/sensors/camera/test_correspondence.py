"""Offsets between the pictures of two cameras against projections on paper.

Camera C (500 px, 640 x 480) at the origin and a second one of the same lens 0.2 m to its right: what is at a depth z
lies 100 / z px further left there, or 100 / (640 z) of the width.
"""

import numpy as np
import pytest
from pxr import Gf, Sdf, UsdGeom

from graph.base.errors import UserError
from sensors.replicator import get_annotator
from tests.support.camera_worlds import add_camera, ahead, look
from tests.support.lidar_worlds import add_box, weightless

NAME = "crossCameraReferenceName"


def pair(app, **lens):
    """The product of the first camera; the second is 0.2 m to its right."""
    add_camera(app, "/World/Right", **lens)
    UsdGeom.XformCommonAPI(app.stage.GetPrimAtPath("/World/Right")).SetTranslate(Gf.Vec3d(0.2, 0, 0))
    product = add_camera(app, "/World/Left")
    refer(app, "Right")
    return product


def refer(app, name):
    app.stage.GetPrimAtPath("/World/Left").CreateAttribute(NAME, Sdf.ValueTypeNames.String).Set(name)


def test_a_wall_is_further_left_by_its_disparity_and_the_sky_is_where_it_is():
    """At 4 m 25 px; the first 25 columns are outside. A wall to x = 1 ends at column 445; the sky is not tested."""
    with weightless() as app:
        add_box(app, "/World/Wall", 10.0, ahead(-4, 0, 9))
        [found] = look(app, pair(app), "cross_correspondence")
    assert found.shape == (480, 640, 4)
    assert found.dtype == np.float32
    wall, sky = found[240, :445], found[240, 445:]
    np.testing.assert_allclose(wall[:, 0], -25 / 640, atol=1e-6)
    np.testing.assert_allclose(wall[:, 1], 0, atol=1e-6)
    assert wall[:, 2].tolist() == [1.0] * 25 + [0.0] * 420
    assert (wall[:, 3] == 1).all()
    np.testing.assert_allclose(sky, 0, atol=1e-6)


def test_what_the_second_camera_does_not_see_behind_an_edge_is_hidden():
    """A bar from x = -0.2 to 0.2 at 2 m: columns 270 to 369 here. The second camera sees its left edge over -0.4 at the
    tangent -0.2, that is over x = 0.2 - 0.2 x 4 = -0.6 of the wall at 4 m, column 245; it hides the wall up to there,
    so that columns 245 to 269 of the wall are hidden: 100 (1 / 2 - 1 / 4) = 25.
    """
    with weightless() as app:
        add_box(app, "/World/Wall", 100.0, ahead(0, 0, 54))
        add_box(app, "/World/Bar", 0.4, ahead(0, 0, 2.2))
        [found] = look(app, pair(app), "cross_correspondence")
    row = found[240]
    np.testing.assert_allclose(row[270:370, 0], -50 / 640, atol=1e-6)
    assert np.flatnonzero(row[:, 2]).tolist() == [*range(25), *range(245, 270)]
    assert (row[:, 3] == 1).all()


def test_a_second_camera_of_another_lens_and_size_has_its_own_picture():
    """250 px, 320 x 240, looking 90 degrees to the left of the first sees nothing of a wall ahead; turned back, the
    wall's point at pixel (u, v) is at 160 + 250 (x - 0.2) / 4, x / 4 = (u - 320) / 500: u / 2 - 12.5 of 320.
    """
    with weightless() as app:
        add_box(app, "/World/Wall", 100.0, ahead(0, 0, 54))
        product = pair(app, size=(320, 240))
        [found] = look(app, product, "CrossCorrespondence")
        np.testing.assert_allclose(found[..., 0], -12.5 / 320, atol=1e-6)
        UsdGeom.XformCommonAPI(app.stage.GetPrimAtPath("/World/Right")).SetRotate(Gf.Vec3f(0, 180, 0))
        app.update()
        behind = get_annotator("cross_correspondence", app=app).attach(product)
        app.update()
        data = behind.get_data()
    np.testing.assert_array_equal(data, np.broadcast_to(np.float32([-1, -1, 1, 1]), data.shape))


@pytest.mark.parametrize(
    ("name", "message"),
    [("", "set its attribute crossCameraReferenceName"), ("Nobody", "no camera named 'Nobody' has a render product")],
)
def test_a_camera_without_a_second_one_is_refused_in_a_line(name, message):
    with weightless() as app:
        product = add_camera(app, "/World/Left")
        refer(app, name)
        with pytest.raises(UserError, match=message):
            get_annotator("cross_correspondence", app=app).attach(product)


def test_a_fisheye_pair_corresponds_by_angle():
    """An equidistant lens of 100 px a radian about (320, 240): a wall 4 m ahead at pixel (320.5, 240.5)."""
    with weightless() as app:
        add_box(app, "/World/Wall", 100.0, ahead(0, 0, 54))
        product = pair(app)
        for path in ("/World/Left", "/World/Right"):
            prim = app.stage.GetPrimAtPath(path)
            prim.AddAppliedSchema("OmniLensDistortionOpenCvFisheyeAPI")
            prim.GetAttribute("omni:lensdistortion:model").Set("opencvFisheye")
            values = {"imageSize": Gf.Vec2i(640, 480), "cx": 320.0, "cy": 240.0, "fx": 100.0, "fy": 100.0, "k1": 0.0}
            for key, value in values.items():
                prim.GetAttribute(f"omni:lensdistortion:opencvFisheye:{key}").Set(value)
        [found] = look(app, product, "cross_correspondence")
    angle = 0.005 * np.sqrt(2)
    x = 4 * np.tan(angle) / np.sqrt(2)
    level = np.hypot(x - 0.2, x)
    u, v = (100 * np.arctan2(level, 4) * part / level for part in (x - 0.2, x))
    assert found[240, 320, :2] == pytest.approx([(u - 0.5) / 640, (v - 0.5) / 480], abs=1e-6)
    assert found[240, 320, 2:].tolist() == [0, 1]
