"""Cells and folding, by hand."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sensors.radar.bins import place
from sensors.radar.cells import Cells
from sensors.radar.cube import Grid

RANGES = Cells.of_resolution(0.0, 50.0, 0.4)
ANGLES = Cells(-1.0, 1.0, 1)


def placed(range_m, velocity, unambiguous):
    """The range cell and the velocity [m/s] of what a radar with one cell of velocity and angle measures."""
    grid = Grid(RANGES, Cells(-unambiguous, unambiguous, 1), ANGLES, ANGLES)
    cell, _, seen = place(grid.bins, range_m, velocity, 0)
    return cell, seen


def range_cells(ranges):
    return [placed(range_m, 0.0, 50.0)[0] for range_m in ranges]


def test_cells_cover_their_span_and_round_trip():
    assert (RANGES.count, RANGES.width) == (125, pytest.approx(0.4))
    assert range_cells([0.0, 10.1, 49.99, 50.0, -0.1]) == [0, 25, 124, -1, -1]
    assert range_cells(RANGES.centre(np.arange(125))) == list(range(125))


def test_a_cell_centre_is_at_most_half_a_cell_away():
    """Uniform in a cell of 0.4 m: deviation 0.4 / sqrt(12) = 0.1155 m."""
    ranges = np.random.default_rng(1).uniform(0, 50, 10_000)
    errors = RANGES.centre(np.array(range_cells(ranges))) - ranges
    assert np.abs(errors).max() <= 0.2 + 1e-9
    assert errors.std() == pytest.approx(0.1155, rel=0.02)


@pytest.mark.parametrize(("unambiguous", "seen"), [(50.0, 40.0), (55.0, 50.0), (65.0, -60.0)])
def test_a_velocity_beyond_the_limit_is_seen_folded(unambiguous, seen):
    assert placed(10.0, -60.0, unambiguous)[1] == pytest.approx(seen)


@given(st.floats(-500, 500), st.floats(1, 100))
def test_a_folded_velocity_differs_by_whole_turns(velocity, unambiguous):
    seen = placed(10.0, velocity, unambiguous)[1]
    assert -unambiguous <= seen <= unambiguous
    turns = (velocity - seen) / (2 * unambiguous)
    assert turns == pytest.approx(round(turns), abs=1e-6)
