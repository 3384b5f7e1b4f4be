"""Noise of pictures against its formulas; the tone curve."""

import numpy as np
import pytest
from pxr import Sdf, UsdGeom, UsdLux

from graph.base.errors import UserError
from sensors.camera.noise import ImageNoise
from sensors.camera.shading import aces_curve, srgb
from tests.support.camera_worlds import add_camera, look
from tests.support.lidar_worlds import weightless

COUNT = 200_000


def drawn(noise, signal, frame=0, path="/World/Camera", seed=3):
    return noise.applied(np.full((COUNT, 3), signal, np.float32), seed, path, frame).astype(np.float64)


@pytest.mark.parametrize(("signal", "full_well", "read"), [(0.5, 10_000, 5.0), (0.1, 1000, 20.0), (0.25, 40_000, 0.0)])
def test_the_variance_is_that_of_the_electrons_and_of_reading(signal, full_well, read):
    """Mean e, variance e + read^2 + 1/12 for whole electrons; 600,000 values: mean to 5 sigma / 775, sigma to 0.5 %."""
    found = drawn(ImageNoise(full_well, read), signal) * full_well
    electrons = signal * full_well
    sigma = np.sqrt(electrons + read**2 + 1 / 12)
    assert found.mean() == pytest.approx(electrons, abs=5 * sigma / np.sqrt(found.size))
    assert found.std() == pytest.approx(sigma, rel=5e-3)
    np.testing.assert_allclose(found, np.round(found), atol=1e-2)  # whole electrons


def test_black_and_white_are_the_ends():
    """Below 0 and above the full well nothing is read: half of the values are cut."""
    noise = ImageNoise(1000, 5.0)
    assert drawn(noise, 0.0).min() == 0.0
    assert drawn(noise, 7.0).max() == 1.0
    assert np.mean(drawn(noise, 7.0) == 1.0) == pytest.approx(0.5, abs=0.02)


def test_gain_and_offset_differ_from_pixel_to_pixel_and_stay():
    """The mean of frames shows the pattern: of deviation 0.02 x 5,000 and 30 electrons, together 104.4."""
    noise = ImageNoise(10_000, 0.0, gain=0.02, offset=30.0)
    frames = np.mean([drawn(noise, 0.5, frame) for frame in range(20)], axis=0) * 10_000
    left = 5000 / 20  # variance of shot noise in the mean
    assert np.sqrt(frames.var() - left) == pytest.approx(np.hypot(100, 30), rel=0.02)


def test_noise_follows_from_seed_camera_and_frame_alone():
    noise = ImageNoise()
    first = drawn(noise, 0.5)
    np.testing.assert_array_equal(first, drawn(noise, 0.5))
    for other in ({"frame": 1}, {"path": "/World/Other"}, {"seed": 4}):
        assert not np.array_equal(first, drawn(noise, 0.5, **other))


def pictures(frames=2, threads=0, attributes=None, **fidelity):
    with weightless(settings={"/tickgraph/rayThreads": threads}, **fidelity) as app:
        UsdLux.DomeLight.Define(app.stage, "/World/Sky").CreateIntensityAttr(400.0)
        product = add_camera(app, size=(64, 48))
        for name, value in (attributes or {}).items():
            app.stage.GetPrimAtPath("/World/Camera").CreateAttribute(name, Sdf.ValueTypeNames.Float).Set(value)
        found = look(app, product, "rgb", "HdrColor")
        for _ in range(frames - 1):
            app.update()
        return found[0], found[1], product.frame.channel("rgb").copy()


def test_pictures_are_exact_unless_noise_is_on():
    rgb, linear, _ = pictures()
    assert len(np.unique(rgb[..., :3])) == 1
    noisy, same, later = pictures(camera_noise=True)
    assert len(np.unique(noisy[..., :3])) > 3
    np.testing.assert_array_equal(linear, same)  # light itself has no noise
    assert not np.array_equal(noisy[..., :3], later)
    again, _, again_later = pictures(camera_noise=True, threads=1)
    np.testing.assert_array_equal(noisy, again)
    np.testing.assert_array_equal(later, again_later)
    assert noisy[..., :3].mean() == pytest.approx(rgb[..., :3].mean(), abs=0.6)  # both rounded


def test_attributes_of_the_camera_set_the_noise():
    few = pictures(camera_noise=True, attributes={"tickgraph:noise:fullWell": 200.0})[0]
    many = pictures(camera_noise=True)[0]
    assert few[..., :3].std() > 4 * many[..., :3].std()  # sqrt(10,000 / 200) = 7.1 times


@pytest.mark.parametrize("value", [0.0, -1.0, float("nan"), 1e12])
def test_a_full_well_that_cannot_be_is_one_line(value):
    with weightless() as app:
        camera = UsdGeom.Camera.Define(app.stage, "/World/Camera").GetPrim()
        camera.CreateAttribute("tickgraph:noise:fullWell", Sdf.ValueTypeNames.Float).Set(value)
        with pytest.raises(
            UserError, match=r"/World/Camera.tickgraph:noise:fullWell is .*; give a number from 1 to 1e9"
        ):
            look(app, add_camera(app), "rgb")


def test_the_curve_of_aces():
    """x (2.51 x + 0.03) / (x (2.43 x + 0.59) + 0.14): of 0.18 0.086724 / 0.324932, of 1 2.54 / 3.16."""
    x = np.array([-1.0, 0.0, 0.18, 1.0, 1e30, np.inf, np.nan], np.float32)
    found = aces_curve(x)
    np.testing.assert_allclose(found[:4], [0, 0, 0.266899, 0.803797], rtol=1e-5)
    np.testing.assert_allclose(found[4:6], 2.51 / 2.43, rtol=1e-5)
    assert srgb(found)[3] == 232
