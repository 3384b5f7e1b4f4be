"""Which settings pay, and which one is recommended."""

from __future__ import annotations

import csv
import json
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from graph.session.meter import PARTS, Cost
from wings.trade.bodies import BodyPair
from wings.trade.conduct import timed_length
from wings.trade.errors import Horizon
from wings.trade.outcome import OK, UNSTABLE, Outcome, Row
from wings.trade.outputs import as_csv, as_dict, block
from wings.trade.readings import LIDAR, Reading, Readings
from wings.trade.sights import same_targets, values_of
from wings.trade.states import Trajectory
from wings.trade.study import Scene, Study
from wings.trade.trial import Measured, Timed
from wings.trade.verdict import answer, remarks, summary, values_in

METRIC = "lidar.range_p99"


def timed(*seconds):
    """Runs whose updates take so long, all of it casts."""
    return [
        Timed({part: Cost(one, 2 * one) if part == "casts" else Cost() for part in PARTS}, start=0.5) for one in seconds
    ]


def outcome(rows, budget=None, moved=None):
    study = Study(
        Scene(Path("a.yaml")),
        {"lidar.bins": tuple(row.setting["lidar.bins"] for row in rows)},
        tuple(row.setting for row in rows),
        {"lidar.bins": 16},
        budget or {},
        refined={"lidar.bins": 32},
    )
    given = dict.fromkeys(name for row in rows for name in row.errors)
    return Outcome(study, rows, Horizon(1.0), moved or {}, tuple(given))


def row(bins, seconds, error, **more):
    return Row({"lidar.bins": bins}, OK, errors={METRIC: error, **more}, timed=timed(*seconds))


@pytest.fixture
def rows():
    return [
        row(1, (1.0, 1.2, 1.1), 0.3),
        row(2, (2.0, 2.0, 2.0), 0.4),  # dearer and worse than the first
        row(4, (3.0, 3.0, 3.4), 0.02),
        row(16, (5.0, 5.0, 5.0), 0.0),
    ]


def test_the_cost_is_the_median_and_its_spread_half_the_range(rows):
    assert rows[0].cost == Cost(1.1, 2.2)
    assert rows[0].spread.wall == rows[0].spread.cpu == pytest.approx(0.2 / 2 / 1.1)
    assert rows[2].cost == Cost(3.0, 6.0)


def test_those_pay_that_no_other_beats_in_both(rows):
    assert [one.setting["lidar.bins"] for one in outcome(rows).front(METRIC)] == [1, 4, 16]


def test_of_recall_more_is_better():
    rows = [
        Row({"lidar.bins": n}, OK, errors={"radar.recall": r}, timed=timed(n))
        for n, r in ((1, 0.5), (2, 0.4), (3, 1.0))
    ]
    assert [one.setting["lidar.bins"] for one in outcome(rows).front("radar.recall")] == [1, 3]
    assert outcome(rows, {"radar.recall": 0.9}).recommended is rows[2]


def test_the_cheapest_that_keeps_the_budget_is_recommended(rows):
    assert outcome(rows, {METRIC: 0.02}).recommended is rows[2]
    assert outcome(rows, {METRIC: 0.5}).recommended is rows[0]
    assert outcome(rows, {METRIC: 0.5, "cost.wall": 0.5}).recommended is None
    assert outcome(rows).recommended is None  # without a budget there is nothing to keep


def test_what_the_reference_does_not_resolve_is_neither_paid_for_nor_promised(rows):
    """Refining the reference moves it by 0.025 m, so that it may be off by twice that, 0.05 m (`OWN_ERROR`): 0.02 and 0
    are the same to it; 0.02 is the cheaper.
    """
    found = outcome(rows, {METRIC: 0.03}, {METRIC: 0.025})
    assert [one.setting["lidar.bins"] for one in found.front(METRIC)] == [1, 4]
    assert [found.unresolved(one, METRIC) for one in rows] == [False, False, True, True]
    assert found.recommended is None
    assert found.nearest is rows[2]
    assert outcome(rows, {METRIC: 0.05}, {METRIC: 0.025}).recommended is rows[2]


def test_the_mark_the_budget_and_the_summary_take_the_same_error_of_the_reference():
    """A ball falls for 1 s: at 480 Hz it is g dt t / 2 = 9.81 / 960 = 10.22 mm ahead of g t^2 / 2, at 960 Hz half of
    that, so that refining moves it by 5.11 mm: twice that is its own error, exactly. 8 mm is below it, 12 mm is not.
    """
    rows = [
        Row({"lidar.bins": n}, OK, errors={"body.position_max": e}, timed=timed(n)) for n, e in ((1, 0.012), (2, 0.008))
    ]
    found = outcome(rows, {"body.position_max": 0.01}, {"body.position_max": 9.81 / 480 / 4})
    assert found.doubt("body.position_max") == pytest.approx(9.81 / 480 / 2)
    assert [found.unresolved(one, "body.position_max") for one in rows] == [False, True]
    assert found.recommended is None
    assert "the reference's own error may be 0.0102 m" in answer(found)[0][0]
    assert "the reference's own error is taken as twice the difference" in "\n".join(summary(found))
    assert as_dict(found)["reference"]["own_error"] == {"body.position_max": found.doubt("body.position_max")}


def test_the_next_coarser_setting_is_resolved_and_worse_than_the_reference_whatever_the_rounding():
    """First order: at 60 and 120 Hz a fall is g / 120 and g / 240 m off after 1 s. They differ by g / 240, which is the
    own error of 120 Hz, twice its move of g / 480: the reference is the better one.
    """
    for noise in (-1e-12, 0.0, 1e-12):
        rows = [
            Row({"lidar.bins": n}, OK, errors={"body.position_max": error}, timed=timed(n))
            for n, error in ((1, 9.81 / 240 + noise), (2, 0.0))
        ]
        found = outcome(rows, {"cost.wall": 9.0}, {"body.position_max": 9.81 / 480})
        assert [found.unresolved(one, "body.position_max") for one in rows] == [False, True]
        assert found.recommended is rows[1]
        assert found.front("body.position_max") == rows


def test_the_error_of_a_share_is_no_more_than_the_whole():
    """Refining finds 0.4 of the detections again: twice 0.6 is more than all of them."""
    rows = [Row({"lidar.bins": 1}, OK, errors={"radar.recall": 0.5}, timed=timed(1))]
    assert outcome(rows, moved={"radar.recall": 0.4}).doubt("radar.recall") == 1.0


def test_costs_within_their_spreads_are_equal_and_of_equal_ones_the_more_exact_pays():
    """Processor times 2.0, 2.2 and 2.4 s, each +- 0.12 s: the second overlaps both others, which do not overlap."""
    rows = [row(1, (0.94, 1.06, 1.0), 0.3), row(2, (1.04, 1.16, 1.1), 0.2), row(4, (1.14, 1.26, 1.2), 0.25)]
    assert rows[0].as_cheap(rows[1])
    assert rows[1].as_cheap(rows[2])
    assert not rows[0].as_cheap(rows[2])
    assert outcome(rows, {METRIC: 0.5}).recommended is rows[1]
    assert outcome(rows).front(METRIC) == [rows[1]]


def test_of_equal_costs_and_errors_the_first_is_taken_however_the_runs_came_out():
    rows = [row(1, (1.05, 1.0, 1.1), 0.3), row(2, (1.0, 1.05, 0.98), 0.3)]
    assert outcome(rows, {METRIC: 0.5}).recommended is rows[0]
    assert outcome(rows).front(METRIC) == [rows[0]]


def test_what_is_no_difference_from_the_reference_needs_no_refinement():
    rows = [Row({"lidar.bins": n}, OK, errors={"contact.penetration_max": n / 100}, timed=timed(n)) for n in (1, 2)]
    found = outcome(rows, {"contact.penetration_max": 0.01}, {"contact.penetration_max": 0.03})
    assert found.recommended is rows[0]


def test_within_a_budget_of_costs_the_setting_of_least_error_is_recommended(rows):
    assert outcome(rows, {"cost.wall": 4.0}).recommended is rows[2]
    assert outcome(rows, {"cost.wall": 4.0, METRIC: 0.4}).recommended is rows[0]


def test_many_dear_runs_are_timed_for_less_in_whole_periods_of_the_slowest_sensor(rows):
    """12 timed runs in 90 s: 7.5 s each, 1 s of it to open. At 20 s/s the first 0.5 s take more than the rest: the
    least is left, 2 frames. At 10 s/s there are (7.5 - 1) / 10 - 0.5 = 0.15 s; at 4 s/s 1.125 s.
    """
    study = outcome(rows).study

    def length(pace, period):
        return timed_length(study, Measured(opening=1.0, pace=pace, started=0.5, period=Fraction(period)))

    assert (length(20.0, "0.3"), length(10.0, "0.1"), length(4.0, "0.1")) == (Fraction("0.6"), Fraction("0.2"), 1)
    assert length(20.0, 0) == Fraction(1, 5)
    assert length(20.0, 1) == 1


def test_the_nearest_exceeds_the_budget_least(rows):
    found = outcome(rows, {METRIC: 0.3, "cost.wall": 1.0})
    assert found.recommended is None
    assert found.nearest is rows[0]  # 0.3 is within, 1.1 s is 10 % over


def test_a_knob_changes_no_error_where_settings_that_differ_in_it_alone_have_the_same():
    def at(bins, tlas, error):
        return Row({"lidar.bins": bins, "tlas": tlas}, OK, errors={METRIC: error}, timed=timed(1.0))

    rows = [at(1, "sensor", 0.3), at(1, "frame", 0.3), at(2, "sensor", 0.1), at(2, "frame", 0.1)]
    found = outcome(rows)
    found = replace(found, study=replace(found.study, varied={"lidar.bins": (1, 2), "tlas": ("sensor", "frame")}))
    assert found.idle == {"tlas": True}
    assert [*remarks(found)] == ["tlas changes no error here: take the cheapest value"]
    rows[3].errors[METRIC] = 0.1 + 1e-12  # another order of summing
    assert found.idle == {"tlas": True}
    rows[3].errors[METRIC] = 0.2
    assert found.idle == {}
    found.moved = {METRIC: 0.1}  # the reference's own error is 0.2: 0.1 and 0.2 are the same to it
    assert found.idle == {"tlas": False}
    assert [*remarks(found)] == [
        "tlas changes no error that this reference resolves: a finer --reference would tell more"
    ]
    assert as_dict(found)["no_effect"] == ["tlas"]


def test_the_knobs_with_the_most_leverage_are_named_first():
    """Of 2 s of processor time, all of it casts, the radar takes 1.2 and the lidar 0.5; physics takes none."""
    rows = [row(bins, (1.0,), 0.1 * bins) for bins in (1, 16)]
    for one in rows:
        one.read = frozenset({"lidar.bins", "radar.rays", "radar.bounces", "physics.hz"})
        one.timed = [replace(one.timed[0], sensors={"radar": 1.2, "lidar": 0.5})]
    found = outcome(rows)
    assert [*found.leverage][:3] == ["mesh", "radar", "lidar"]
    assert found.leverage["radar"] == pytest.approx(0.6)
    assert summary(found)[0] == (
        "processor time that knobs act on: radar 60% (not varied: radar.rays, radar.bounces), lidar 25% (varied: "
        "lidar.bins)"
    )
    varied = {"lidar.bins": (1, 16), "radar.rays": (9,)}
    assert replace(found, study=replace(found.study, varied=varied)).knobs == ("radar.rays", "lidar.bins")


def test_settings_that_are_the_same_run_share_a_row_and_are_all_written():
    rows = [row(1, (1.0,), 0.3), row(16, (2.0,), 0.0)]
    rows[0].also.append({"lidar.bins": 2})
    found = outcome(rows)
    assert values_in(rows[0], "lidar.bins") == "1|2"
    assert [*remarks(found)] == ["the same run, made once: lidar.bins=1 = lidar.bins=2"]
    assert [(one["setting"], one["same_as"]) for one in as_dict(found)["settings"]] == [
        ({"lidar.bins": "1"}, None),
        ({"lidar.bins": "2"}, {"lidar.bins": "1"}),
        ({"lidar.bins": "16"}, None),
    ]
    assert [line["lidar.bins"] for line in csv.DictReader(as_csv(found).splitlines())] == ["1", "2", "16"]


def test_an_unstable_setting_is_never_recommended(rows):
    rows[2].status = UNSTABLE
    assert outcome(rows, {METRIC: 0.02}).recommended is rows[3]


def test_the_block_has_the_knobs_of_the_setting(rows):
    assert block(outcome(rows, {METRIC: 0.02}), rows[2]) == "fidelity:\n  lidar.bins: 4"


def test_json_and_csv_hold_every_figure(rows):
    rows.append(Row({"lidar.bins": 3}, UNSTABLE, "it diverged"))
    found = outcome(rows, {METRIC: 0.02}, {METRIC: 0.001})
    told = json.loads(json.dumps(as_dict(found), allow_nan=False))
    assert told["recommended"] == {"lidar.bins": "4"}
    assert told["settings"][0]["cost"]["runs"][1] == {"wall": 1.2, "cpu": 2.4}
    assert told["settings"][4] == {
        "setting": {"lidar.bins": "3"},
        "same_as": None,
        "status": "unstable",
        "why": "it diverged",
        "cost": None,
        "frames": None,
        "errors": {METRIC: None},
        "front": [],
        "unresolved": [],
        "warnings": [],
    }
    assert told["reference"]["moved"] == {METRIC: 0.001}
    table = list(csv.DictReader(as_csv(found).splitlines()))
    assert [line["lidar.bins"] for line in table] == ["1", "2", "4", "16", "3"]
    assert float(table[2][METRIC]) == 0.02
    assert table[4]["cost.wall"] == table[4][METRIC] == ""


def test_detections_of_a_target_are_matched_once_and_within_a_cell():
    """Cells of 1 m, 0.5 m/s and 0.1 rad (5.7 degrees): the second is found a cell further, the third is not."""
    one = {"distance": np.array([10.0, 21.0, 32.0]), "rv_ms": np.zeros(3), "azimuth": np.zeros(3)}
    two = {"distance": np.array([10.0, 20.0, 30.0, 10.5]), "rv_ms": np.zeros(4), "azimuth": np.zeros(4)}
    mine, theirs = same_targets(one, two, (1.0, 0.5, 0.1))
    assert dict(zip(mine.tolist(), theirs.tolist(), strict=True)) == {0: 0, 1: 1}


def test_a_return_from_another_prim_is_lost_and_extra_and_no_range_error():
    """Of firings 1, 2, 3 the run has 2 off by 0.5 m, 3 from another prim 9 m behind, 4 instead of 1."""

    def seen(firings, distances, prims):
        arrays = {"firing": np.array(firings), "distance": np.array(distances), "prim": np.array(prims)}
        frame = Reading(0, 10**8, 10**8, {**arrays, "scalar": np.zeros(3)})
        return {"/Product": Readings("/Lidar", LIDAR, [frame])}

    found = values_of(seen([2, 3, 4], [5.5, 15.0, 7.0], [7, 8, 7]), seen([1, 2, 3], [4.0, 5.0, 6.0], [7, 7, 7]), 1.0)
    assert (found["lidar.range_max"], found["lidar.lost"], found["lidar.extra"]) == (0.5, 2 / 3, 2 / 3)
    assert found["lidar.velocity_p99"] is None  # nothing read velocities
    assert (
        values_of({}, seen([1, 2, 3], [4.0, 5.0, 6.0], [7, 7, 7]), 1.0)["lidar.lost"] == 1
    )  # no such sensor in the run
    assert values_of({}, seen([1, 2, 3], [4.0, 5.0, 6.0], [7, 7, 7]), 0.05) == {}  # beyond the horizon


def spinning(rate, times):
    """A body that turns about z at `rate` [rad/s] and runs along x at 1 m/s, its centre of mass 0.5 m ahead of it."""
    n, half = len(times), rate * times / 2
    turns = np.stack([np.cos(half), 0 * half, 0 * half, np.sin(half)], axis=1)[:, None]
    positions = np.stack([times, 0 * times, 0 * times], axis=1)[:, None]
    velocities = np.tile([1.0, 0, 0, 0, 0, rate], (n, 1, 1))
    flags = np.ones((n, 1), np.bool_)
    return Trajectory(
        *(("/A",), times, positions, turns, velocities, np.array([2.0]), np.diag([1.0, 1.0, 3.0])[None]),
        *(np.array([[0.5, 0.0, 0.0]]), np.array([True]), np.zeros(n), ~flags, np.zeros(3)),
    )


def test_turns_are_compared_as_angles_whatever_the_sign_of_a_quaternion():
    times = np.linspace(0, 1, 11)
    one, two = spinning(2.0, times), spinning(2.5, times)
    two.orientations[:] *= -1
    assert BodyPair(one, two, 1.0).angle[:, 0] == pytest.approx(0.5 * times)


def test_energy_counts_the_turn_and_the_centre_of_mass():
    """At t = 0 the centre moves at (1, 2 * 0.5, 0): m v^2 / 2 = 2 * 2 / 2 = 2 J, and I w^2 / 2 = 3 * 4 / 2 = 6 J."""
    one = spinning(2.0, np.array([0.0, 1e-9]))
    assert BodyPair(one, one, 1.0).energies[0][0] == pytest.approx(8.0)


def test_a_finer_run_is_met_between_its_states():
    """The cubic through positions and velocities is exact for straight motion; turns are even."""
    coarse, fine = spinning(2.0, np.array([0.0, 0.31, 0.62])), spinning(2.0, np.linspace(0, 1, 8))
    both = BodyPair(coarse, fine, 1.0)
    assert both.times == pytest.approx([0.0, 0.31, 0.62])
    assert both.distance.max() == pytest.approx(0, abs=1e-12)
    assert both.angle.max() == pytest.approx(0, abs=1e-7)
