"""Noise and false alarms of a radar, and what makes them the same again."""

import hashlib

import numpy as np
import pytest

from graph.base.errors import UserError
from graph.sim.settings import RAY_THREADS
from sensors.gmo import pack
from sensors.radar.cfar import Axis, noise_level, sparse_noise_level
from sensors.radar.noise import Noise
from tests.support.radar_scenes import SCAN, WPM, plate, radar_world, threshold_factor, trihedral

MILLION = {
    **{f"{SCAN}binsFromSpec": False, f"{SCAN}rBins": 1000, f"{SCAN}vBins": 1000, f"{SCAN}raysPerDeg": 0.5},
    **{f"{SCAN}cfarNoiseMean": 1e-15, f"{SCAN}cfarNoiseSDev": 1e-15, f"{SCAN}cfarMinVal": 1e-30},
    **{f"{SCAN}cfarRnT": 0, f"{SCAN}cfarVnT": 8, f"{SCAN}cfarVnG": 2},
    **{f"{SCAN}rcsTuningCoefficients": [-300.0, 1.0, 0.0]},
}


def test_false_alarms_come_as_often_as_the_formula_says():
    """10^6 cells of exponential noise, 16 training cells: at 8.639 a thousand alarms; deviation
    32, and neighbours share noise: 5 deviations."""
    with radar_world({}, {**MILLION, f"{SCAN}cfarOffset": threshold_factor(16, 1e-3)}) as (app, product):
        app.update()
        assert product.frame.count == pytest.approx(1000, abs=160)


def test_false_alarms_over_four_axes_come_as_often_as_the_formula_says():
    """10 ranges x 500 velocities x 4 azimuths x 5 elevations of noise, 16 training cells along velocity, which wraps:
    at 8.639 a hundred of the 10^5 cells; deviation 10, five of them for neighbours that share noise."""
    four = {
        **{f"{WPM}cfarMode": "4D", f"{SCAN}elevMode": "FULL_EL", f"{SCAN}cfarAznT": 0, f"{SCAN}cfarElnT": 0},
        **{f"{SCAN}rBins": 10, f"{SCAN}vBins": 500, f"{SCAN}azBins": 4, f"{SCAN}elBins": 5},
        f"{SCAN}cfarOffset": threshold_factor(16, 1e-3),
    }
    with radar_world({}, {**MILLION, **four}) as (app, product):
        app.update()
        assert product.frame.count == pytest.approx(100, abs=50)


def test_noise_over_four_axes_is_refused_before_it_takes_too_much_memory():
    """125 ranges x 749 velocities x 116 azimuths x 8 elevations."""
    noise = {f"{SCAN}cfarNoiseMean": 1e-17, f"{SCAN}maxAzAngDeg": 75.0, f"{SCAN}maxElAngDeg": 20.0}
    noise |= {f"{WPM}cfarMode": "4D", f"{SCAN}elevMode": "FULL_EL"}
    refused = pytest.raises(UserError, match=r"noise in its [0-9,]+ cells \(cfarMode 4D\) takes [0-9,]+ bytes")
    with refused, radar_world({}, noise) as (app, _):
        app.update()


def test_noise_of_mean_0_is_the_magnitude_of_normal_numbers():
    """A mean of sqrt(2 / pi) = 0.798 deviations; of 10^5, that is known to 0.0019."""
    assert Noise(0, "/R", 0).power("cells", (100_000,), 0.0, 1.0).mean() == pytest.approx(0.798, abs=0.01)


def test_a_frame_that_is_full_says_so():
    """At 1e-2 ten thousand cells of the million are detected."""
    with radar_world({}, {**MILLION, f"{SCAN}cfarOffset": threshold_factor(16, 1e-2)}) as (app, product):
        app.update()
        assert product.frame.count == 2500
        assert "radar-frame-full" in {one.code for one in app.warnings}


def test_without_noise_there_are_no_false_alarms():
    with radar_world(plate(0.1, 20.0)) as (app, product):
        app.update(steps=5)
        assert product.frame.count == 1


def test_value_noise_has_its_mean_and_deviation():
    """50 frames: the mean of 0.2 m is known to 0.3 / sqrt(50) = 0.042, three deviations 0.13."""
    noise = {f"{SCAN}rangeNoiseMean": 0.2, f"{SCAN}rangeNoiseSDev": 0.3, f"{SCAN}velocityNoiseSDev": 0.5}
    with radar_world(plate(0.1, 20.0), {**noise, f"{SCAN}raysPerDeg": 1.0}) as (app, product):
        ranges, velocities = [], []
        for _ in range(50):
            app.update()
            ranges.append(float(product.frame.channel("distance")[0]))
            velocities.append(float(product.frame.channel("rv_ms")[0]))
    assert np.mean(ranges) == pytest.approx(20.2, abs=0.13)
    assert np.std(ranges) == pytest.approx(0.3, rel=0.35)
    assert np.std(velocities) == pytest.approx(0.5, rel=0.35)


def frames(seed=0, threads=0, repeats=1, steps=3):
    prims = {
        **trihedral(0.1, 20.0),
        "/World/Ground": {"type": "Plane", "translate": [0, 0, -1], "material": "asphalt"},
        "/World/Ball": {"type": "Sphere", "radius": 0.3, "translate": [15, 2, 1], "rigid_body": True},
    }
    noise = {f"{SCAN}cfarNoiseMean": 1e-17, f"{SCAN}cfarNoiseSDev": 1e-17, f"{SCAN}rangeNoiseSDev": 0.1}
    found = []
    with radar_world(prims, noise, seed=seed) as (app, product):
        app.settings.set(RAY_THREADS, threads)
        for repeat in range(repeats):
            if repeat:
                app.stop()
                app.play()
            for _ in range(steps):
                app.update()
                found.append(hashlib.sha256(pack(product.frame).tobytes()).hexdigest())
    return found


def test_the_same_bytes_over_threads_runs_and_plays_and_others_with_another_seed():
    first = frames(threads=1, repeats=2)
    assert first[:3] == first[3:]
    assert frames(threads=2) == frames(threads=3) == first[:3]
    assert frames(seed=1) != first[:3]


@pytest.mark.parametrize("wraps", [False, True])
def test_the_noise_level_of_a_sparse_cube_is_that_of_a_dense_one(wraps):
    generator = np.random.default_rng(2)
    shape = (7, 9, 5, 3)
    power = np.where(generator.random(shape) < 0.1, generator.exponential(1.0, shape), 0.0)
    cells = np.flatnonzero(power)
    axes = (Axis(1), Axis(2, 1, wraps=True), Axis(1, 1, wraps=wraps), Axis(1))
    sparse = sparse_noise_level(cells, power.reshape(-1)[cells], shape, axes)
    assert sparse == pytest.approx(noise_level(power, axes).reshape(-1)[cells], abs=1e-12)


def test_four_axes_separate_what_two_merge():
    """Two plates at the same range, 4 deg apart: one cell of range and velocity, two of angle."""
    prims = {}
    for name, azimuth in (("A", -2.0), ("B", 2.0)):
        turn = np.radians(azimuth)
        box = plate(0.1, 20.0)["/World/Plate"]
        place = [20.1 * np.cos(turn), 20.1 * np.sin(turn), 0.0]
        prims[f"/World/{name}"] = {**box, "translate": [float(x) for x in place], "rotate": [0, 0, azimuth]}
    counts = {}
    for mode in ("2D", "4D"):
        with radar_world(prims, {f"{WPM}cfarMode": mode}) as (app, product):
            app.update()
            counts[mode] = product.frame.count
    assert counts == {"2D": 1, "4D": 2}
