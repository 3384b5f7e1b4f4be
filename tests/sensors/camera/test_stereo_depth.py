"""Depth by disparity against its formulas: steps, noise, the band that one imager does not see.

The defaults of the schema at a width of 1280: f b = 897 x 0.055 = 49.335 px m.
"""

import numpy as np
import pytest

from sensors import SingleViewDepthCameraSensor
from sensors.camera.stereo_depth import StereoDepth, measured
from tests.support.camera_worlds import ahead
from tests.support.lidar_worlds import add_box, weightless

QUIET = {"noise_mean": 0.0}


def plane(depth, width=1280, height=8):
    return np.full((height, width), depth, np.float32)


def generator(seed=1):
    return np.random.default_rng(seed)


@pytest.mark.parametrize(("depth", "step_mm"), [(1.0, 5.067), (2.0, 20.270), (4.0, 81.078)])
def test_a_step_of_disparity_is_a_step_of_depth_that_grows_with_its_square(depth, step_mm):
    """Z^2 x 0.25 / 49.335; measured depths are those of whole steps, so no further off than half of one."""
    stereo = StereoDepth(noise_sigma=0.0)
    found, _ = measured(plane(depth), stereo, generator())
    [value] = np.unique(found[:, 100:])
    assert 49.335 / value / 0.25 == pytest.approx(round(49.335 / depth / 0.25), abs=1e-4)
    assert abs(value - depth) <= 1.05 * step_mm / 2000


@pytest.mark.parametrize(("depth", "sigma_mm"), [(1.0, 3.110), (2.0, 12.442), (4.0, 49.767)])
def test_noise_of_disparity_is_noise_of_depth(depth, sigma_mm):
    """A D435, f b = 643 x 0.05 = 32.15: 0.1 px of error is Z^2 x 0.1 / 32.15."""
    stereo = StereoDepth(50.0, 643.0, noise_mean=1e-6, noise_sigma=0.1, min_distance=0.1)
    found, _ = measured(plane(depth, height=100), stereo, generator())
    assert 1000 * found[:, 100:].std() == pytest.approx(sigma_mm, rel=0.02)  # of 118,000 values


def test_what_only_the_first_imager_sees_is_not_measured():
    """1 m before 3 m: 49.335 (1 - 1 / 3) = 32.89 px to the left of the near surface."""
    depth = plane(3.0)
    depth[:, 400:800] = 1.0
    found, _ = measured(depth, StereoDepth(**QUIET), generator())
    holes = np.flatnonzero(found[0, 60:] == 0) + 60
    assert len(holes) == pytest.approx(32.89, abs=1.0)
    assert holes.min() >= 400 - 34
    assert holes.max() < 400
    np.testing.assert_allclose(found[0, 400:800], 1.0, rtol=1e-6)
    np.testing.assert_allclose(found[0, 810:], 3.0, rtol=1e-6)


def test_what_the_second_imager_sees_lies_further_left_by_the_disparity():
    depth = plane(np.inf)
    depth[:, 400:800] = 1.0
    _, second = measured(depth, StereoDepth(**QUIET), generator())
    columns = np.flatnonzero(second[0])
    assert (columns[0], columns[-1]) == (np.floor(400.5 - 49.335), np.floor(799.5 - 49.335))


@pytest.mark.parametrize(
    ("values", "depth"),
    [
        ({}, 0.44),
        ({"max_disparity_pixel": 20}, 2.0),
        ({"max_distance": 3}, 4.0),
        ({"min_distance": 2}, 1.0),
        ({}, np.inf),
    ],
)
def test_what_is_out_of_reach_is_0(values, depth):
    """At 110 px of disparity 0.4485 m is the least."""
    found, _ = measured(plane(depth), StereoDepth(**QUIET, **values), generator())
    assert not found.any()


def test_noise_is_the_same_for_the_same_seed_and_in_squares_where_wanted():
    stereo = StereoDepth(noise_downscale_factor_pixel=4)
    first, again, other = (measured(plane(3.0), stereo, generator(seed))[0] for seed in (1, 1, 2))
    np.testing.assert_array_equal(first, again)
    assert (first != other).any()
    squares = first[:, 200:].reshape(2, 4, -1, 4)
    assert (squares == squares[:, :1, :, :1]).all()


def test_settings_without_effect_are_kept_and_told():
    with weightless() as app:
        app.stage.DefinePrim("/World/Camera", "Camera").AddAppliedSchema("OmniSensorAPI")
        sensor = SingleViewDepthCameraSensor("/World/Camera", resolution=(4, 6), app=app)
        sensor.set_sensor_disparity_confidence(0.9)
        sensor.set_sensor_output_mode(7)
        sensor.set_enabled_outlier_removal(False)
        product = app.stage.GetPrimAtPath(sensor.render_product.path)
        names = ("confidenceThreshold", "rgbDepthOutputMode", "outlierRemovalEnabled")
        kept = [product.GetAttribute(f"omni:rtx:post:depthSensor:{name}").Get() for name in names]
        assert kept == [pytest.approx(0.9), 7, False]
        kept = sensor.get_sensor_disparity_confidence(), sensor.get_sensor_output_mode()
        assert (*kept, sensor.get_enabled_outlier_removal()) == (pytest.approx(0.9), 7, False)
        assert [one.code for one in app.warnings] == ["depth-setting-ignored"] * 3
        with pytest.raises(AssertionError, match="give confidenceThreshold"):
            sensor.set_sensor_disparity_confidence(None)
        with pytest.raises(ValueError, match="mode 8: give a whole number from 0 to 7"):
            sensor.set_sensor_output_mode(8)


def test_the_sensor_hands_it_out_and_has_no_colours():
    with weightless() as app:
        add_box(app, "/World/Wall", 100.0, ahead(0, 0, 52))
        names = [name for name in SingleViewDepthCameraSensor.annotator_specs if name.startswith("depth_sensor")]
        sensor = SingleViewDepthCameraSensor("/World/Eye", resolution=(48, 64), annotators=names, app=app)
        sensor.camera.set_clipping_ranges(0.01)
        sensor.set_sensor_noise_parameters(0.0)
        sensor.set_sensor_baseline(100.0)
        assert (sensor.stereo.noise_mean, sensor.stereo.baseline_mm) == (0.0, 100.0)
        assert sensor.get_data(names[0]) == (None, {})
        app.play()
        app.update()
        shapes = {name: sensor.get_data(name)[0].shape for name in names}
        distance, places = sensor.get_data(names[0])[0], sensor.get_data(names[2])[0]
        assert shapes == dict(zip(names, [(48, 64, 1), (48, 64, 1), (48, 64, 3), (48, 64, 4)], strict=True))
        np.testing.assert_allclose(distance[:, 10:], 2.0, rtol=1e-5)
        np.testing.assert_allclose(places[:, 10:, 2], -2.0, rtol=1e-5)
        with pytest.raises(ValueError, match="there is no annotator 'rgb'"):
            sensor.get_data("rgb")
        with pytest.raises(AssertionError, match="give noise_mean or noise_sigma"):
            sensor.set_sensor_noise_parameters()
        with pytest.raises(ValueError, match="baseline_mm 0: give a number above 0"):
            sensor.set_sensor_baseline(0)


def test_the_render_product_has_the_schema_and_its_defaults():
    """The table of OmniSensorDepthSensorSingleViewAPI; 0.7 is a float32."""
    with weightless() as app:
        sensor = SingleViewDepthCameraSensor("/World/Camera", resolution=(4, 6), app=app)
        product = app.stage.GetPrimAtPath(sensor.render_product.path)
        assert "OmniSensorDepthSensorSingleViewAPI" in product.GetAppliedSchemas()
        assert product.GetAttribute("omni:rtx:post:depthSensor:maxDisparityPixel").Get() == 110
        found = (sensor.get_sensor_baseline(), sensor.get_sensor_focal_length(), sensor.get_sensor_size())
        assert found == (55.0, 897.0, 1280.0)
        assert sensor.get_sensor_distance_cutoffs() == (0.5, 1e7)
        assert sensor.get_sensor_noise_parameters() == (0.25, 0.25)
        assert (sensor.get_sensor_maximum_disparity(), sensor.get_sensor_disparity_noise_downscale()) == (110.0, 1.0)
        assert sensor.get_sensor_disparity_confidence() == pytest.approx(0.7)
        assert (sensor.get_enabled_post_processing(), sensor.get_sensor_output_mode()) == (True, 0)
        sensor.set_sensor_baseline(75)
        sensor.set_sensor_distance_cutoffs(maximum_distance=4.0)
        sensor.set_enabled_post_processing(False)
        assert (sensor.get_sensor_baseline(), sensor.get_sensor_distance_cutoffs()) == (75.0, (0.5, 4.0))
        assert sensor.get_enabled_post_processing() is False


@pytest.mark.parametrize("value", ["wide", float("nan"), float("inf")])
def test_a_setting_that_is_not_a_finite_number_is_reported(value):
    with weightless() as app:
        sensor = SingleViewDepthCameraSensor("/World/Camera", resolution=(4, 6), app=app)
        for write in (sensor.set_sensor_baseline, sensor.set_sensor_disparity_confidence):
            with pytest.raises(ValueError, match=f"{value!r}: give a finite number"):
                write(value)
