"""`datacubeMode` WAVEFORM: returns spread as the Fourier transform of samples under a Hann window spreads them."""

import numpy as np
import pytest

from sensors.radar.bins import place
from sensors.radar.cube import Cube, as_chirps_give
from sensors.radar.detector import range_velocity
from tests.support.radar_scenes import SCAN, WPM, plate, radar_world


def one_return(grid_of, range_m, velocity):
    grid = grid_of
    values = np.array([[range_m], [velocity], [0.0], [0.0]])
    cell, *values[:2, 0] = place(grid.bins, *values[:2, 0], grid.angles(*values[2:])[0])
    return Cube(grid, np.array([cell]), np.array([1.0]), values, np.ones(1, np.uint8))


@pytest.fixture
def grid():
    from sensors.radar.config import ScanConfig
    from sensors.radar.cube import Grid

    return Grid.of(ScanConfig(), 0)


@pytest.mark.parametrize(("away", "expected"), [(0.0, 1.0), (0.5, 0.7206), (0.25, 0.9224)])
def test_a_return_beside_the_middle_of_its_cell_is_weaker(grid, away, expected):
    """(sinc x / (1 - x^2))^2: 1, (0.6366 / 0.75)^2, (0.9003 / 0.9375)^2."""
    middle = grid.velocity.centre(np.array(340))
    spread = range_velocity(as_chirps_give(one_return(grid, 20.2 + 0.4 * away * 0.999, middle)))
    assert spread.max() == pytest.approx(expected, abs=2e-3)


def test_the_response_is_that_of_a_discrete_fourier_transform_under_a_hann_window(grid):
    """128 samples of a wave 10.3 cells up, against the cells 8 to 12."""
    count, at = 128, 10.3
    window = 0.5 - 0.5 * np.cos(2 * np.pi * (np.arange(count) + 0.5) / count)
    wave = np.exp(2j * np.pi * at * np.arange(count) / count)
    expected = np.abs(np.fft.fft(window * wave))[8:13] ** 2 / window.sum() ** 2
    middle = grid.velocity.centre(np.array(340))
    spread = range_velocity(as_chirps_give(one_return(grid, (at + 0.5) * 0.4, middle)))
    assert spread[8:13, 340] == pytest.approx(expected, abs=1e-3)


def test_velocities_wrap(grid):
    spread = range_velocity(as_chirps_give(one_return(grid, 20.2, -50.0)))
    assert spread[50, 0] > 0.5
    assert spread[50, -1] > 0.2


@pytest.mark.parametrize("mode", ["2D", "4D"])
def test_one_target_is_one_detection_at_its_range(mode):
    attributes = {f"{WPM}datacubeMode": "WAVEFORM", f"{WPM}cfarMode": mode}
    with radar_world(plate(0.2, 20.33), attributes) as (app, product):
        app.update()
        assert product.frame.count == 1
        assert product.frame.channel("distance")[0] == pytest.approx(20.33, abs=2e-3)


@pytest.mark.parametrize("mode", ["2D", "4D"])
@pytest.mark.parametrize("away", [0.0, 0.1, 0.2, 0.37])
def test_the_cross_section_does_not_depend_on_where_in_its_cell_a_target_is(away, mode):
    """4 pi A^2 / lambda^2 = 19.17 dBsm of a plate of 0.1 m; beside the edge of a cell the cell holds 1.4 dB less."""
    tuning = {f"{SCAN}rcsTuningCoefficients": (-60.0, 1.0, 0.0)}
    attributes = {f"{WPM}datacubeMode": "WAVEFORM", f"{WPM}cfarMode": mode, **tuning}
    with radar_world(plate(0.1, 20.0 + away), attributes) as (app, product):
        app.update()
        assert product.frame.channel("scalar").max() == pytest.approx(19.17, abs=0.1)


def test_targets_closer_than_the_lobe_are_one_where_fast_shows_two():
    """Two plates 0.5 m apart: neighbouring cells, one peak."""
    prims = {}
    for name, distance, side in (("A", 10.3, -0.4), ("B", 10.7, 0.4)):
        box = plate(0.1, distance)["/World/Plate"]
        turn = float(np.degrees(side / distance))
        prims[f"/World/{name}"] = {**box, "translate": [distance, side, 0], "rotate": [0, 0, turn]}
    counts = {}
    for mode in ("FAST", "WAVEFORM"):
        with radar_world(prims, {f"{WPM}datacubeMode": mode, f"{SCAN}cfarOffset": 0.5}) as (app, product):
            app.update()
            counts[mode] = product.frame.count
    assert counts == {"FAST": 2, "WAVEFORM": 1}
