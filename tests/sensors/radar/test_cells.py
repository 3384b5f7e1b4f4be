"""Cells and folding, by hand."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sensors.radar.cells import Cells, folded


def test_cells_cover_their_span_and_round_trip():
    cells = Cells.of_resolution(0.0, 50.0, 0.4)
    assert (cells.count, cells.width) == (125, pytest.approx(0.4))
    assert cells.index(np.array([0.0, 10.1, 49.99, 50.0, -0.1])).tolist() == [0, 25, 124, 125, -1]
    assert cells.index(cells.centre(np.arange(125))).tolist() == list(range(125))


def test_a_cell_centre_is_at_most_half_a_cell_away():
    """Uniform in a cell of 0.4 m: deviation 0.4 / sqrt(12) = 0.1155 m."""
    cells = Cells.of_resolution(0.0, 50.0, 0.4)
    ranges = np.random.default_rng(1).uniform(0, 50, 100_000)
    errors = cells.centre(cells.index(ranges)) - ranges
    assert np.abs(errors).max() <= 0.2 + 1e-9
    assert errors.std() == pytest.approx(0.1155, rel=0.01)


@pytest.mark.parametrize(("unambiguous", "seen"), [(50.0, 40.0), (55.0, 50.0), (65.0, -60.0)])
def test_a_velocity_beyond_the_limit_is_seen_folded(unambiguous, seen):
    assert folded(np.array(-60.0), unambiguous) == pytest.approx(seen)


@given(st.floats(-500, 500), st.floats(1, 100))
def test_a_folded_velocity_differs_by_whole_turns(velocity, unambiguous):
    seen = float(folded(np.array(velocity), unambiguous))
    assert -unambiguous <= seen <= unambiguous
    turns = (velocity - seen) / (2 * unambiguous)
    assert turns == pytest.approx(round(turns), abs=1e-6)
