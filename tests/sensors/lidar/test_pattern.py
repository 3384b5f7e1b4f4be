"""The firing table: which ray when, exact."""

from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from graph.base.errors import UserError
from sensors import LidarConfig
from sensors.configs.catalog import find
from sensors.lidar.config import EmitterState
from sensors.lidar.pattern import Turns, firing_pattern, turns_of


def lidar(azimuth=(0.0,), elevation=None, fire=(), **fields):
    azimuth = np.array(azimuth)
    state = EmitterState(
        azimuth_deg=azimuth, elevation_deg=np.zeros(len(azimuth)) if elevation is None else elevation, fire_time_ns=fire
    )
    return LidarConfig(**{"emitter_states": (state,), **fields})


def test_a_clockwise_turn_runs_down_from_the_start_azimuth():
    pattern = firing_pattern(lidar(scan_rate_base_hz=Fraction(10), pattern_firing_rate_hz=Fraction(40)))

    assert pattern.azimuth_deg.tolist() == [0.0, -90.0, -180.0, 90.0]
    assert pattern.offset_ns.tolist() == [0, 25_000_000, 50_000_000, 75_000_000]
    assert pattern.tick_id.tolist() == [0, 1, 2, 3]
    np.testing.assert_allclose(pattern.directions, [[1, 0, 0], [0, -1, 0], [-1, 0, 0], [0, 1, 0]], atol=1e-7)


def test_counter_clockwise_turns_up_and_leaves_the_emitters_azimuth_alone():
    fields = {
        "scan_rate_base_hz": Fraction(10),
        "pattern_firing_rate_hz": Fraction(40),
        "start_azimuth_offset_deg": 5.0,
    }

    left = firing_pattern(lidar(azimuth=[1.0, -1.0], rotation_direction="CCW", **fields))
    right = firing_pattern(lidar(azimuth=[1.0, -1.0], rotation_direction="CW", **fields))

    np.testing.assert_allclose(left.azimuth_deg[:4], [6.0, 4.0, 96.0, 94.0], atol=1e-5)
    np.testing.assert_allclose(right.azimuth_deg[:4], [6.0, 4.0, -84.0, -86.0], atol=1e-5)


def test_firings_of_different_ticks_are_sorted_by_time_and_then_by_emitter():
    config = lidar(
        azimuth=[0.0, 0.0],
        fire=[25_000_000, 0],  # emitter 0 fires when the next tick's emitter 1 does
        scan_rate_base_hz=Fraction(10),
        pattern_firing_rate_hz=Fraction(40),
    )

    pattern = firing_pattern(config)

    assert pattern.offset_ns.tolist() == [0, 0] + [25_000_000] * 2 + [50_000_000] * 2 + [75_000_000] * 2
    assert pattern.emitter_id.tolist() == [0, 1] * 4
    assert pattern.tick_id.tolist() == [3, 0, 0, 1, 1, 2, 2, 3]  # the last tick's late firing wraps into the next turn


def test_a_firing_rate_that_is_not_a_multiple_gives_whole_ticks_and_an_idle_rest():
    pattern = firing_pattern(lidar(scan_rate_base_hz=Fraction(10), pattern_firing_rate_hz=Fraction(35)))

    assert pattern.tick_id.tolist() == [0, 1, 2]  # floor(3.5)
    assert pattern.offset_ns.tolist() == [0, 28_571_429, 57_142_857]  # i / 35 s
    np.testing.assert_allclose(pattern.azimuth_deg, [0.0, -102.857143, 154.285714], atol=1e-4)  # 360 * 10 / 35 apart


def test_solid_state_fires_every_emitter_once_at_its_own_azimuth():
    config = find("picoScan150")

    pattern = firing_pattern(config)

    assert len(pattern) == 2761
    assert pattern.azimuth_deg[0] == 138.0
    assert pattern.azimuth_deg[1380] == 0.0
    assert pattern.azimuth_deg[-1] == pytest.approx(-138.0, abs=1e-4)
    assert pattern.offset_ns[-1] == 49_981_890  # floor(2760 / 2761 * 50 ms)


@pytest.mark.parametrize(
    ("start", "end", "expected"),
    [(0.0, 90.0, [0.0, 90.0]), (270.0, 90.0, [0.0, -90.0, 90.0]), (0.0, 360.0, [0.0, -90.0, -180.0, 90.0])],
)
def test_the_valid_azimuth_window_wraps_through_zero(start, end, expected):
    config = lidar(
        scan_rate_base_hz=Fraction(10),
        pattern_firing_rate_hz=Fraction(40),
        valid_start_azimuth_deg=start,
        valid_end_azimuth_deg=end,
    )

    assert firing_pattern(config).azimuth_deg.tolist() == expected


def test_emitter_states_take_turns_for_state_resolution_step_ticks():
    states = tuple(EmitterState(azimuth_deg=[0.0], elevation_deg=[angle]) for angle in (1.0, 2.0))
    config = LidarConfig(
        scan_rate_base_hz=Fraction(10),
        pattern_firing_rate_hz=Fraction(60),
        emitter_states=states,
        state_resolution_step=2,
    )

    pattern = firing_pattern(config)

    assert pattern.tick_state.tolist() == [0, 0, 1, 1, 0, 0]
    assert pattern.elevation_deg.tolist() == [1.0, 1.0, 2.0, 2.0, 1.0, 1.0]


def test_offsets_to_the_left_turn_with_the_rotor():
    state = EmitterState(azimuth_deg=[0.0], elevation_deg=[0.0], hor_offset_m=[0.1], vert_offset_m=[0.05])
    config = LidarConfig(scan_rate_base_hz=Fraction(10), pattern_firing_rate_hz=Fraction(40), emitter_states=(state,))

    origins = firing_pattern(config).origins

    np.testing.assert_allclose(origins[:2], [[0.0, 0.1, 0.05], [0.1, 0.0, 0.05]], atol=1e-7)


def test_range_gates_follow_the_emitters_range_id():
    state = EmitterState(azimuth_deg=[0.0, 1.0], elevation_deg=[0.0, 0.0], range_id=[1, 0])
    config = LidarConfig(
        scan_type="SOLID_STATE",
        pattern_firing_rate_hz=Fraction(10),
        emitter_states=(state,),
        ranges_min_m=(0.5, 2.0),
        ranges_max_m=(50.0, 900.0),
    )

    pattern = firing_pattern(config)

    assert pattern.near_m.tolist() == [2.0, 0.5]
    assert pattern.far_m.tolist() == [200.0, 50.0]  # never beyond farRangeM


@settings(max_examples=60, deadline=None)
@given(
    scan=st.fractions(Fraction(1, 2), Fraction(60), max_denominator=20),
    ticks=st.integers(1, 40),
    rest=st.fractions(Fraction(0), Fraction(49, 50), max_denominator=50),
    cuts=st.lists(st.fractions(0, 3, max_denominator=60), max_size=8),
    fire=st.lists(st.integers(0, 50_000_000), min_size=1, max_size=3),
)
def test_slices_of_any_intervals_hold_every_firing_of_three_turns_once(scan, ticks, rest, cuts, fire):
    config = lidar(
        azimuth=np.zeros(len(fire)), fire=fire, scan_rate_base_hz=scan, pattern_firing_rate_hz=scan * (ticks + rest)
    )
    turns = Turns(config)
    pattern, period = turns.pattern(0), 1 / scan
    times = sorted({Fraction(0), period, 2 * period, 3 * period, *(cut * period for cut in cuts)})

    found = [
        (turn, row)
        for start, end in pairwise(times)
        for turn, rows in turns.slices(start, end)
        for row in range(rows.start, rows.stop)
    ]

    assert len(pattern) == ticks * len(fire)
    assert found == [(turn, row) for turn in range(3) for row in range(len(pattern))]
    assert np.all(np.diff(pattern.offset_ns) >= 0)
    assert pattern.offset_ns[0] >= 0
    assert int(pattern.offset_ns[-1]) < period * 10**9


def test_an_interval_longer_than_a_turn_keeps_its_last_turn():
    turns = Turns(lidar(scan_rate_base_hz=Fraction(10), pattern_firing_rate_hz=Fraction(40)))

    assert turns.slices(Fraction(0), Fraction(35, 100)) == [(2, slice(2, 4)), (3, slice(0, 2))]


def test_lidars_of_equal_configuration_share_their_turns_whatever_they_are_called():
    first = turns_of(lidar(azimuth=[0.0, 1.0], name="/World/A"))

    assert turns_of(lidar(azimuth=[0.0, 1.0], name="/World/B")) is first
    assert turns_of(lidar(azimuth=[0.0, 2.0], name="/World/A")) is not first
    assert turns_of(lidar(azimuth=[0.0, 1.0], start_azimuth_offset_deg=5.0)) is not first


def test_patterns_of_many_turns_are_worked_out_again_where_keeping_them_takes_too_much(monkeypatch):
    monkeypatch.setattr("sensors.lidar.pattern.MOST_KEPT_RAYS", 2)
    states = tuple(EmitterState(azimuth_deg=[0.0], elevation_deg=[float(angle)]) for angle in range(5))
    turns = Turns(lidar(scan_rate_base_hz=Fraction(10), pattern_firing_rate_hz=Fraction(10), emitter_states=states))

    assert (turns.count, turns.kept) == (5, 2)
    assert [turns.pattern(turn).tick_state.tolist() for turn in (0, 1, 2, 3, 4, 5, 9, 5)] == [
        *([0], [1], [2], [3], [4], [0], [4], [0])
    ]


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"scan_rate_base_hz": Fraction(1, 10)}, "slowest scan"),
        ({"near_range_m": 5.0, "far_range_m": 4.0}, "near must be below far"),
        ({"far_range_m": float("nan")}, "farRangeM is not finite"),
        ({"rotation_direction": "LEFT"}, "rotationDirection = 'LEFT' is not one of CW, CCW"),
        ({"pattern_firing_rate_hz": Fraction(0)}, "patternFiringRateHz must be above 0"),
        ({"emitter_states": ()}, "no emitters"),
        ({"num_rays_per_line": (2, 3)}, "sums to 5 for 1 emitters"),
        ({"max_returns": 256}, "maxReturns must be from 1 to 255"),
        ({"ranges_min_m": (3.0,), "ranges_max_m": (2.0,)}, "rangesMinM must be at least 0 and below rangesMaxM"),
        (
            {"emitter_states": (EmitterState(np.array([0.0]), np.array([91.0])),)},
            "s001: elevationDeg holds a value beyond 90 deg",
        ),
    ],
)
def test_a_configuration_that_no_lidar_can_have_is_refused(fields, message):
    with pytest.raises(UserError, match=message):
        lidar(**fields)
