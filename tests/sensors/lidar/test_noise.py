"""Noise: off means exact; on means the authored errors, and the same ones in every run."""

import numpy as np
import pytest

from tests.support.lidar_worlds import add_box, add_lidar, frames_of, rotary, stare, weightless

COUNT = 4000


def frames(config, noise="on", updates=6, motion="frozen", seed=0, others=0, threads=0, path="/World/Lidar", **options):
    """Frames of a lidar in the middle of a room 20 m wide."""
    settings = {"/tickgraph/rayThreads": threads}
    with weightless(lidar_noise=noise, lidar_motion=motion, seed=seed, settings=settings, **options) as app:
        add_box(app, "/World/Room", 20.0, (0, 0, 0))
        for number in range(others):
            add_lidar(app, f"/World/Other{number}", config=config)
        return frames_of(app, add_lidar(app, path, config=config), updates)


def ahead(azimuth=0.0, **fields):
    """Many beams of one azimuth, without any error but those of `fields`."""
    exact = {"range_accuracy_m": 0.0, "range_resolution_m": 0.0}
    return stare(np.arange(COUNT) * 1e-6, np.full(COUNT, azimuth), **{**exact, **fields})


def ranges(config, **options):
    return frames(config, **options)[0].channel("distance").astype(np.float64)


def spread_within(values, deviation):
    """Whether the standard deviation of a normal sample agrees: its own is s / sqrt(2 n); five of those either way."""
    return abs(values.std() - deviation) < 5 * deviation / np.sqrt(2 * len(values))


def test_off_is_exact_whatever_errors_are_authored():
    config = ahead(range_accuracy_m=0.5, range_offset_m=0.3, azimuth_error_std=1.0, origin_error_std=(1.0, 1.0, 1.0))

    np.testing.assert_allclose(ranges(config, noise="off"), 10.0, atol=1e-5)


def test_accuracy_is_the_standard_deviation_of_the_range_and_offset_its_mean():
    found = ranges(ahead(range_accuracy_m=0.02, range_offset_m=0.05)) - 10.0

    assert spread_within(found, 0.02)
    assert abs(found.mean() - 0.05) < 5 * 0.02 / np.sqrt(COUNT)
    assert len(np.unique(found)) > COUNT / 2


def test_ranges_come_in_steps_of_the_resolution():
    found = ranges(ahead(range_accuracy_m=0.05, range_resolution_m=0.03)) / 0.03

    np.testing.assert_allclose(found, np.round(found), atol=1e-4)
    assert len(np.unique(np.round(found))) > 5


@pytest.mark.parametrize(("angle", "nominal"), [("azimuth", 30.0), ("elevation", 0.0)])
def test_a_beam_leaves_at_a_wrong_angle_but_is_reported_at_its_own(angle, nominal):
    deviation, mean = 0.2, 2.0
    config = ahead(nominal, **{f"{angle}_error_std": deviation, f"{angle}_error_mean": mean})

    frame = frames(config)[0]

    off = np.rad2deg(np.arccos(10.0 / frame.channel("distance").astype(np.float64))) - nominal
    assert spread_within(off, deviation)
    assert abs(off.mean() - mean) < 5 * deviation / np.sqrt(COUNT)
    assert np.all(frame.channel("azimuth") == nominal)
    assert not frame.channel("elevation").any()


def test_an_origin_that_is_off_ahead_shortens_the_range():
    found = ranges(ahead(origin_error_mean=(0.5, 0.0, 0.0), origin_error_std=(0.01, 0.0, 0.0)))

    assert spread_within(found, 0.01)
    assert abs(found.mean() - 9.5) < 5 * 0.01 / np.sqrt(COUNT)


def test_gates_are_for_the_range_that_is_reported():
    config = ahead(range_accuracy_m=0.1, far_range_m=10.0, skip_dropping_invalid_points=False)

    found = ranges(config)

    assert found.max() <= 10.0
    assert abs(len(found) - COUNT / 2) < 5 * np.sqrt(COUNT / 4)


NOISY = rotary(200, elevations=(0.0, 3.0), azimuth_error_std=0.1, elevation_error_std=0.1, origin_error_std=(0.01,) * 3)


def content(found):
    return [{name: array.tobytes() for name, array in sorted(frame.arrays.items())} for frame in found]


def test_errors_follow_from_seed_sensor_and_turn_alone():
    alone = content(frames(NOISY, updates=18))

    assert len(alone) == 3
    assert content(frames(NOISY, updates=18, others=3, threads=2)) == alone
    assert content(frames(NOISY, updates=18, threads=1)) == alone
    distances = [entry["distance"] for entry in alone]
    assert len(set(distances)) == 3  # every turn has its own
    assert content(frames(NOISY, seed=1))[0]["distance"] != distances[0]
    assert content(frames(NOISY, path="/World/Twin"))[0]["distance"] != distances[0]


@pytest.mark.parametrize("motion", ["frozen", "update"])
def test_the_order_in_which_sensors_run_changes_no_error(motion):
    def each(order):
        with weightless(lidar_noise="on", lidar_motion=motion) as app:
            add_box(app, "/World/Room", 20.0, (0, 0, 0))
            products = {name: add_lidar(app, f"/World/{name}", (0, 0, 0), NOISY) for name in order}
            app.play()
            app.update(steps=12)
            return {name: content([product.frame]) for name, product in products.items()}

    found = each("ABC")

    assert each("CAB") == found
    assert len({entry[0]["distance"] for entry in found.values()}) == 3  # each sensor has its own


@pytest.mark.parametrize("motion", ["update", "continuous"])
def test_cutting_a_turn_into_slices_changes_no_error(motion):
    assert content(frames(NOISY, updates=12, motion=motion)) == content(frames(NOISY, updates=12))
