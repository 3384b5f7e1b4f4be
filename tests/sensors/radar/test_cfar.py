"""Cell-averaging CFAR, against counts by hand and its closed false alarm rate."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sensors.radar.cfar import Axis, detect, noise_level, noise_level_at
from tests.support.radar_scenes import threshold_factor


@pytest.mark.parametrize(
    ("cells", "rate", "factor"), [(16, 1e-6, 21.94), (32, 1e-6, 17.28), (20, 1e-2, 5.1785), (16, 1e-3, 8.639)]
)
def test_the_threshold_factor_of_exponential_noise(cells, rate, factor):
    assert threshold_factor(cells, rate) == pytest.approx(factor, rel=5e-4)


def test_the_false_alarm_rate_is_the_one_asked_for():
    """10^6 cells in lines of 10^4, 8 training cells on each side: the rate 1e-3 has a deviation of 3.2e-5, and
    neighbouring cells share noise; 5 deviations."""
    noise = np.random.default_rng(7).exponential(2.5, (100, 10_000))
    axes = (Axis(0), Axis(8, 2, wraps=True))
    found = detect(noise, axes, factor=threshold_factor(16, 1e-3))
    assert found.mean() == pytest.approx(1e-3, abs=1.6e-4)


def test_the_training_cells_of_two_dimensions_are_a_box_without_its_guard():
    """16 cells: 5 x 5 without the 3 x 3 of the guard."""
    power = np.zeros((9, 9))
    power[4, 4] = 100.0
    power[4, 6] = 7.0
    axes = (Axis(1, 1), Axis(1, 1))
    level = noise_level(power, axes)
    assert level[4, 4] == pytest.approx(7 / 16)
    assert level[4, 5] == 0.0  # both targets are in its guard
    assert level[0, 0] == 0.0


def test_an_edge_averages_the_cells_that_exist_and_velocity_wraps():
    power = np.arange(1.0, 7.0)
    assert noise_level(power, (Axis(1),)) == pytest.approx([2, 2, 3, 4, 5, 5])
    assert noise_level(power, (Axis(1, wraps=True),)) == pytest.approx([4, 2, 3, 4, 5, 3])


def test_two_equal_neighbours_mask_each_other():
    power = np.zeros((5, 5))
    power[2, 2] = power[2, 3] = 1.0
    axes = (Axis(1), Axis(1))
    assert detect(power, axes, factor=8.0).sum() == 0  # the mean of 8 cells with one target is 1/8
    assert detect(power, axes, factor=7.9).sum() == 2


def test_a_cell_below_the_least_power_is_dropped():
    power = np.array([0.0, 0.0, 3.0, 0.0, 0.0])
    assert detect(power, (Axis(1),), factor=1.0, least=3.0).tolist() == [False, False, True, False, False]
    assert not detect(power, (Axis(1),), factor=1.0, least=3.1).any()


@settings(deadline=None)  # the first call compiles
@given(
    st.integers(1, 7),
    st.integers(1, 7),
    st.integers(0, 4),
    st.integers(0, 2),
    st.booleans(),
    st.booleans(),
    st.integers(0, 2**32),
)
def test_the_noise_level_equals_a_sum_cell_by_cell(rows, columns, training, guard, wrap_rows, wrap_columns, seed):
    power = np.random.default_rng(seed).exponential(1.0, (rows, columns))
    axes = (Axis(training, guard, wrap_rows), Axis(training, guard, wrap_columns))
    level = noise_level(power, axes)
    singly = noise_level_at(power, np.argwhere(power > 0), axes).reshape(rows, columns)

    def window(at, length, half, wraps):
        cells = range(at - half, at + half + 1)
        return {cell % length for cell in cells} if wraps else {cell for cell in cells if 0 <= cell < length}

    for row in range(rows):
        for column in range(columns):
            boxes = [
                {
                    (r, c)
                    for r in window(row, rows, half, wrap_rows)
                    for c in window(column, columns, half, wrap_columns)
                }
                for half in (training + guard, guard)
            ]
            cells = [power[cell] for cell in boxes[0] - boxes[1]]
            expected = pytest.approx(np.mean(cells) if cells else 0.0, abs=1e-12)
            assert (level[row, column], singly[row, column]) == (expected, expected)
