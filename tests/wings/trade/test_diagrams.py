"""The diagrams of `graph trade`: an error of 0 beside a logarithm, spreads of costs, the setting that was chosen."""

from matplotlib.container import ErrorbarContainer
from matplotlib.figure import Figure

from tests.wings.trade.test_outcome import METRIC, outcome, row
from wings.trade.diagrams import diagram


def drawn(rows, budget=None):
    axis = Figure().subplots()
    diagram(axis, outcome(rows, budget), METRIC)
    return axis


def spread(container):
    """The lower and the upper end of the bar of a cost, and the error."""
    ((low, error), (high, _)) = container.lines[2][0].get_segments()[0]
    return low, high, error


def test_an_error_of_zero_stands_below_a_gap_with_a_tick_of_its_own():
    axis = drawn([row(1, (1.0,), 0.3), row(4, (3.0,), 0.02), row(16, (5.0,), 0.0)])
    axis.figure.draw_without_rendering()
    places = dict(zip((text.get_text() for text in axis.get_yticklabels()), axis.get_yticks(), strict=True))
    assert set(places) == {"0", "0.02", "0.05", "0.1", "0.2", "0.5"}
    gap = next(line.get_ydata()[0] for line in axis.lines if line.get_linestyle() not in ("-", "None"))
    assert axis.get_ylim()[0] < places["0"] < gap < 0.02
    assert places["0"] in axis.lines[-1].get_ydata() or any(places["0"] in line.get_ydata() for line in axis.lines)


def test_without_an_error_of_zero_there_is_no_such_line():
    axis = drawn([row(1, (1.0,), 0.3), row(4, (3.0,), 0.02)])
    axis.figure.draw_without_rendering()
    assert "0" not in [text.get_text() for text in axis.get_yticklabels()]


def test_costs_have_bars_of_half_their_range():
    """Three runs of 2, 2.4 and 2.2 s of processor time: 2.2 s, from 2 to 2.4."""
    axis = drawn([row(1, (1.0, 1.2, 1.1), 0.3), row(2, (2.0,), 0.1)])
    ends = [spread(one) for one in axis.containers if isinstance(one, ErrorbarContainer) and one.has_xerr]
    assert [[round(part, 9) for part in one] for one in ends] == [[2.0, 2.4, 0.3]]


def test_the_chosen_setting_has_a_ring_and_its_name():
    rows = [row(1, (1.0,), 0.3), row(4, (3.0,), 0.02), row(16, (5.0,), 0.0)]
    (ring,) = (line for line in drawn(rows, {METRIC: 0.1}).lines if line.get_label() == "recommended")
    assert (ring.get_xdata()[0], ring.get_ydata()[0]) == (6.0, 0.02)
    kept = drawn(rows[:1], {METRIC: 0.1})
    assert [line.get_label() for line in kept.lines if line.get_label().startswith("nearest")] == [
        "nearest to the budget"
    ]
    assert "bins=1" in [text.get_text() for text in kept.texts]
