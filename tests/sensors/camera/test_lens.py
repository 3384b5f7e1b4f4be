"""Lenses both ways: against values of OpenCV's formulas, worked out by hand, and back again.

The Hawk is a stereo camera whose maker publishes its rational distortion; the fisheye is an example of OpenCV's.
"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pxr import Gf, Sdf

from graph.base.errors import UserError
from graph.sim import App
from sensors.camera.config import read_config
from sensors.camera.lens import BrownLens, FisheyeLens, FthetaLens, Lens, PrismFisheyeLens
from tests.support.camera_worlds import add_camera, ahead, look
from tests.support.lidar_worlds import add_box, weightless

HAWK = BrownLens(
    *(1920, 1200, 957.81, 957.81, 960.0, 600.0),
    k=(0.147811, -0.032313, 0.008823, 0.517913, -0.06708, 0.01695),
    p=(-0.000194, -0.000035),
)
FISHEYE = FisheyeLens(640, 480, 200.0, 200.0, 320.0, 240.0, (1.0, 0.05, 0.01, -0.003, -0.0005))
FTHETA = FthetaLens(1936, 1216, 1.0, 1.0, 970.9424, 600.3748)
ARIA = PrismFisheyeLens(
    *(640, 480, 200.0, 200.0, 320.0, 240.0, (1.0, 0.05, 0.01, -0.003, -0.0005, 0.0001)),
    p=(0.001, -0.002),
    s=(0.002, -0.0003, 0.001, 0.0002),
)
PRISM = BrownLens(640, 480, 500.0, 510.0, 321.0, 239.0, p=(0.001, -0.002), s=(0.01, -0.002, 0.003, 0.001))


@pytest.mark.parametrize(
    ("point", "bent"),
    [
        ((0.3, 0.2), (0.2865888, 0.1910370)),
        ((0.6, -0.4), (0.5118873, -0.3413712)),
        ((0.9, 0.5), (0.6810745, 0.3781897)),
    ],
)
def test_the_hawk_distorts_as_opencv_says(point, bent):
    u, v = HAWK.project(np.array([[point[0]], [point[1]], [1.0]]))
    assert (u[0] - 960) / 957.81 == pytest.approx(bent[0], abs=5e-8)
    assert (v[0] - 600) / 957.81 == pytest.approx(bent[1], abs=5e-8)


def test_the_fisheye_distorts_as_opencv_says():
    """The angle 85 deg, 1.4835 rad, lies 1.6537920 x 200 px from the centre."""
    angle = np.deg2rad([30.0, 60.0, 85.0])
    u, _ = FISHEYE.project(np.stack([np.sin(angle), 0 * angle, np.cos(angle)]))
    np.testing.assert_allclose((u - 320) / 200, [0.5311359, 1.1123097, 1.6537920], atol=5e-8)


def test_a_prism_fisheye_shifts_the_radial_image():
    """45 deg in the direction (0.6, 0.8): the radial image is r = 0.7853982 (1 + k0 part) as of FISHEYE and k5, then
    the shift by hand: with x = 0.6 r, y = 0.8 r, r2 = r^2.
    """
    a = np.pi / 4
    r = a * (1 + 0.05 * a**2 + 0.01 * a**4 - 0.003 * a**6 - 0.0005 * a**8 + 0.0001 * a**10)
    x, y, r2 = 0.6 * r, 0.8 * r, r * r
    bent_x = x + 0.001 * (r2 + 2 * x * x) - 2 * 0.002 * x * y + 0.002 * r2 - 0.0003 * r2 * r2
    bent_y = y - 0.002 * (r2 + 2 * y * y) + 2 * 0.001 * x * y + 0.001 * r2 + 0.0002 * r2 * r2
    u, v = ARIA.project(np.array([[0.6], [0.8], [1.0]]))
    assert ((u[0] - 320) / 200, (v[0] - 240) / 200) == pytest.approx((bent_x, bent_y), abs=1e-12)


def test_the_schema_of_a_prism_fisheye_counts_its_radius_in_pixels():
    """k0 = 400 px a radian on a nominal image of twice the size: half of it here. Prisms that are not authored have the
    schema's values.
    """
    with App(None) as app:
        add_camera(app)
        prim = app.stage.GetPrimAtPath("/World/Camera")
        prim.AddAppliedSchema("OmniLensDistortionRadTanThinPrismAPI")
        values = {"nominalWidth": 1280, "nominalHeight": 960, "opticalCenter": Gf.Vec2f(640, 480), "k0": 400, "k1": 40}
        for name, value in {**values, "p0": 0.0, "p1": 0.01, "s3": 0.02}.items():
            prim.GetAttribute(f"omni:lensdistortion:radTanThinPrism:{name}").Set(value)
        lens = read_config(prim, (640, 480), 1.0).lens
    assert isinstance(lens, PrismFisheyeLens)
    assert (lens.fx, lens.fy, lens.cx, *lens.coefficients[:3]) == pytest.approx((200, 200, 320, 1, 0.1, 0))
    assert (lens.p, lens.s) == (pytest.approx((0, 0.01)), pytest.approx((-0.00058, -0.00022, 0.00019, 0.02)))


def test_ftheta_is_an_angle_for_a_radius():
    angle = np.deg2rad([30.0, 60.0, 90.0])
    u, _ = FTHETA.project(np.stack([np.sin(angle), 0 * angle, np.cos(angle)]))
    np.testing.assert_allclose(u - 970.9424, [213.7138, 427.4276, 641.1414], atol=5e-5)


def test_ftheta_counts_its_radius_in_pixels_of_the_nominal_image_along_both_sides():
    """192 x 120 shown at 192 x 240: a pixel down is half a nominal one. theta = 0.02 r: r = 40 is 0.8 rad."""
    lens = FthetaLens(192, 240, 1.0, 2.0, 96.0, 120.0, coefficients=(0.0, 0.02))
    right, low = lens.unproject(np.array([[136.0, 96.0], [120.0, 200.0]])).T
    np.testing.assert_allclose(right, (np.sin(0.8), 0, np.cos(0.8)), atol=1e-12)
    np.testing.assert_allclose(low, (0, np.sin(0.8), np.cos(0.8)), atol=1e-12)


@pytest.mark.parametrize("lens", [Lens(640, 480, 500.0, 500.0, 320.0, 240.0), HAWK, FISHEYE, FTHETA, PRISM, ARIA])
@given(u=st.floats(0, 1), v=st.floats(0, 1))
def test_every_pixel_that_has_a_direction_is_where_that_direction_goes(lens, u, v):
    pixel = np.array([[u * lens.width], [v * lens.height]])
    direction = lens.unproject(pixel)
    if direction.any():
        np.testing.assert_allclose(lens.project(direction), pixel, atol=1e-9)
        assert np.linalg.norm(direction) == pytest.approx(1.0, abs=1e-14)


def test_where_the_lens_folds_there_is_no_ray():
    """k1 = -0.3: r (1 - 0.3 r^2) is largest at r = 1 / sqrt(0.9) = 1.0541, where it is 0.7027."""
    lens = BrownLens(640, 480, 200.0, 200.0, 320.0, 240.0, k=(-0.3, 0, 0, 0, 0, 0))
    assert lens.fold == pytest.approx(1.0541, abs=1e-4)
    inside, outside = lens.unproject(np.array([[320 + 0.702 * 200, 320 + 0.703 * 200], [240.0, 240.0]])).T
    assert inside.any()
    assert not outside.any()
    assert np.isnan(lens.project(np.array([[1.06], [0.0], [1.0]]))).any()


def test_a_lens_that_stretches_images_up_to_its_fold():
    """k1 = 0.5, k2 = -0.2: r (1 + 0.5 r^2 - 0.2 r^4) is largest where 1 + 1.5 r^2 = r^4, at r = sqrt(2), where it is
    1.2 sqrt(2) = 1.697: beyond the fold's own radius, up to there each point has one ray.
    """
    lens = BrownLens(640, 480, 100.0, 100.0, 320.0, 240.0, k=(0.5, -0.2, 0, 0, 0, 0))
    r = np.array([1.3, 1.38, 1.41])
    assert lens.fold == pytest.approx(np.sqrt(2), abs=1e-4)
    found = lens.unproject(np.stack([320 + 100 * r * (1 + 0.5 * r**2 - 0.2 * r**4), np.full(3, 240.0)]))
    np.testing.assert_allclose(found[0] / found[2], r, atol=1e-9)
    assert not lens.unproject(np.array([[320 + 170.0], [240.0]])).any()


def test_a_fisheye_images_up_to_its_fold_where_its_radius_is_larger_than_the_angle():
    """k 0.05, 0.01, -0.003, -0.0005: at 110 deg, 1.9199 rad, the radius is 2.0862, more than the fold's 1.984 rad."""
    lens = FisheyeLens(640, 480, 100.0, 100.0, 320.0, 240.0, (1.0, 0.05, 0.01, -0.003, -0.0005))
    angle = np.deg2rad(110.0)
    squared = angle**2
    radius = angle * (1 + squared * (0.05 + squared * (0.01 + squared * (-0.003 - squared * 0.0005))))
    assert radius > lens.fold
    found = lens.unproject(np.array([[320 + 100 * radius], [240.0]]))[:, 0]
    assert found == pytest.approx([np.sin(angle), 0, np.cos(angle)], abs=1e-9)


def test_the_fisheye_images_up_to_its_fold():
    assert np.rad2deg(FISHEYE.fold) == pytest.approx(113.7, abs=0.1)
    behind = np.deg2rad(100.0)
    u, _ = FISHEYE.project(np.array([[np.sin(behind)], [0.0], [np.cos(behind)]]))
    assert u[0] > 320 + 200 * 1.6537920


def test_fields_of_view_are_those_of_focal_length_and_aperture():
    """65.2385 x 51.2820 deg of the camera C; 60.0000 x 35.9834 of a Kit viewport's, whose f is 18.147562."""
    for size, focal, aperture, expected in (
        ((640, 480), 16.0, 20.48, (65.2385, 51.2820)),
        ((1280, 720), 18.147562, 20.955, (60.0000, 35.9834)),
    ):
        with App(None) as app:
            lens = add_camera(app, size=size, focal=focal, aperture=aperture).sensor.config.lens
        view = (2 * np.rad2deg(np.arctan(side / 2 / f)) for side, f in zip(size, (lens.fx, lens.fy), strict=True))
        assert tuple(view) == pytest.approx(expected, abs=1e-4)


def test_a_schema_gives_the_lens_scaled_to_the_image():
    """An image of half the size: half of fx, fy, cx, cy."""
    with App(None) as app:
        add_camera(app)
        prim = app.stage.GetPrimAtPath("/World/Camera")
        prim.AddAppliedSchema("OmniLensDistortionOpenCvFisheyeAPI")
        lens = read_config(prim, (1024, 512), 1.0).lens
    assert isinstance(lens, FisheyeLens)
    assert (lens.fx, lens.fy, lens.cx, lens.cy) == (450.0, 400.0, 512.0, 256.0)
    assert lens.coefficients == pytest.approx((1.0, 0.00245, 0.0, 0.0, 0.0))


def test_a_distorted_image_shows_where_opencv_puts_a_point():
    """The left edge of a box 10 m ahead at x / z = 0.3 (y = 0) lies at x' = 0.3 (1 - 0.2 x 0.09) = 0.2946."""
    with weightless() as app:
        add_box(app, "/World/Box", 8.0, ahead(7, 0, 14))
        product = add_camera(app)
        prim = app.stage.GetPrimAtPath("/World/Camera")
        prim.AddAppliedSchema("OmniLensDistortionOpenCvPinholeAPI")
        for name, value in {
            "imageSize": Gf.Vec2i(640, 480),
            "fx": 500,
            "fy": 500,
            "cx": 320,
            "cy": 240,
            "k1": -0.2,
        }.items():
            prim.GetAttribute(f"omni:lensdistortion:opencvPinhole:{name}").Set(value)
        [plane] = look(app, product, "distance_to_image_plane")
    columns = np.flatnonzero(np.abs(plane[240] - 10.0) < 1e-4)  # left of them its side is seen
    assert columns[0] == np.ceil(320 + 0.2946 * 500 - 0.5)


def test_a_fisheye_sees_behind_itself():
    """An equidistant lens of 100 px a radian on 640 x 480: 3.2 rad to the left and right, cut at 180 deg."""
    with weightless() as app:
        add_box(app, "/World/Behind", 2.0, ahead(4, 0, -4))
        product = add_camera(app)
        prim = app.stage.GetPrimAtPath("/World/Camera")
        prim.AddAppliedSchema("OmniLensDistortionOpenCvFisheyeAPI")
        values = {"imageSize": Gf.Vec2i(640, 480), "fx": 100, "fy": 100, "cx": 320, "cy": 240, "k1": 0.0}
        for name, value in values.items():
            prim.GetAttribute(f"omni:lensdistortion:opencvFisheye:{name}").Set(value)
        plane, away = look(app, product, "distance_to_image_plane", "distance_to_camera")
    column = round(320 + 100 * 0.75 * np.pi)
    assert np.isinf(plane[240, 320])
    assert -5 < plane[240, column] < -3
    assert 4 < away[240, column] < 5.7


@pytest.mark.parametrize(
    ("model", "attribute", "value", "message"),
    [
        ("OpenCvPinhole", "opencvPinhole:fx", 0.0, "opencvPinhole:fx is 0; give a number above 0"),
        ("Ftheta", "ftheta:nominalWidth", -1.0, "ftheta:nominalWidth is -1; give a number above 0"),
        (
            "Ftheta",
            "model",
            "lot",
            "model is 'lot'; there are opencvPinhole, opencvFisheye, ftheta, kannalaBrandtK3, rad",
        ),
        ("RadTanThinPrism", "radTanThinPrism:k0", 0.0, "radTanThinPrism:k0 is 0; give a number above 0"),
        ("OpenCvFisheye", "opencvFisheye:k1", float("nan"), "is not finite"),
        ("Ftheta", "model", "lut", "rayEnterDirectionTexture is missing; apply OmniLensDistortionLutAPI"),
    ],
)
def test_a_lens_that_cannot_be_is_reported_in_a_line(model, attribute, value, message):
    with App(None) as app:
        add_camera(app)
        prim = app.stage.GetPrimAtPath("/World/Camera")
        prim.AddAppliedSchema(f"OmniLensDistortion{model}API")
        prim.GetAttribute(f"omni:lensdistortion:{attribute}").Set(value)
        with pytest.raises(UserError, match=message):
            read_config(prim, (640, 480), 1.0)


def test_a_lens_that_folds_everywhere_is_reported():
    """k1 = -1e6 folds at r = sqrt(1 / 3e6) = 0.6e-3, within the innermost pixel's 0.7 / 500 = 1.4e-3."""
    with weightless() as app:
        product = add_camera(app)
        prim = app.stage.GetPrimAtPath("/World/Camera")
        prim.AddAppliedSchema("OmniLensDistortionOpenCvPinholeAPI")
        values = {"imageSize": Gf.Vec2i(640, 480), "cx": 320, "cy": 240, "fx": 500, "fy": 500, "k1": -1e6}
        for name, value in values.items():
            prim.GetAttribute(f"omni:lensdistortion:opencvPinhole:{name}").Set(value)
        assert np.isinf(look(app, product, "distance_to_image_plane")).all()
        assert [(one.code, one.where) for one in app.warnings] == [("lens-without-rays", "/World/Camera")]


def test_a_lens_described_as_up_to_isaac_sim_4_is_reported():
    with weightless() as app:
        product = add_camera(app)
        prim = app.stage.GetPrimAtPath("/World/Camera")
        for name, value in (("cameraProjectionType", "fisheyePolynomial"), ("physicalDistortionModel", "plumb_bob")):
            prim.CreateAttribute(name, Sdf.ValueTypeNames.Token).Set(value)
        look(app, product, "distance_to_image_plane")
        [warning] = app.warnings
    assert (warning.code, warning.where) == ("camera-attribute-ignored", "/World/Camera")
    assert warning.message.startswith("cameraProjectionType, physicalDistortionModel: no effect on pictures")
