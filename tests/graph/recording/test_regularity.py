"""Stamps against the schedule of their sensor."""

import pickle
from fractions import Fraction

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from graph.base.exact import nanoseconds
from graph.recording.regularity import LISTED, Regularity
from graph.sim.messages.message import Cadence

MS = 10**6
PATIENT = settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])
WALL_2024 = 1_700_000_000 * 10**9


def regularity(stamps, rate=None, every=1):
    one = Regularity(rate=None if rate is None else Fraction(rate), every=every)
    for at in stamps:
        one.add(at, at, 10)
    return one


@PATIENT
@given(
    rate=st.fractions(Fraction(1, 10), 1000, max_denominator=1001),
    first=st.integers(1, 1000),
    skipped=st.sets(st.integers(1, 48)),
)
def test_ticks_without_a_message_are_counted_whatever_the_rate(rate, first, skipped):
    ticks = [first + k for k in range(50) if k not in skipped]
    one = regularity([nanoseconds(tick / rate) for tick in ticks], rate)
    assert (one.ticks, one.missing, one.repeats) == (50 - len(skipped), len(skipped), 0)
    assert one.exact
    assert one.period_ns == 10**9 / rate


@PATIENT
@given(rate=st.fractions(1, 60, max_denominator=1001), loop=st.integers(60, 240))
def test_stamps_of_the_update_that_follows_the_tick_are_late_by_less_than_an_update(rate, loop):
    # Tick k falls in the update that ends at ceil(k / rate loop) / loop.
    stamps = [nanoseconds(Fraction(-((-k * loop) // rate), loop)) for k in range(1, 60)]
    one = regularity(stamps, rate)
    assert (one.ticks, one.missing) == (59, 0)
    low, high = one.late_ns
    assert -1 <= low <= high <= 10**9 / loop + 1


def test_scans_that_are_stamped_at_their_start_are_exact_too():
    one = regularity([k * 50 * MS for k in range(98)], 20)
    assert (one.ticks, one.missing, one.exact, one.late_ns) == (98, 0, True, (0, 0))


def test_a_message_of_the_same_tick_is_a_repeat():
    one = regularity([100 * MS, 110 * MS, 200 * MS, 200 * MS], 10)
    assert (one.ticks, one.repeats, one.exact) == (2, 2, False)


def test_every_second_tick_has_a_message():
    one = regularity([k * 200 * MS for k in (1, 2, 4)], 10, every=2)
    assert one.period_ns == 200 * MS
    assert (one.ticks, one.missing) == (3, 1)
    assert one.gaps() == [(400 * MS, 400 * MS)]


def test_without_a_sensor_the_most_frequent_distance_is_the_period():
    one = regularity([0, 10 * MS, 20 * MS, 50 * MS, 60 * MS])
    assert one.period_ns == 10 * MS
    assert not one.exact
    assert one.gaps() == [(20 * MS, 30 * MS)]
    assert one.distances_ns == (10 * MS, 30 * MS)


def test_steps_of_a_sixtieth_that_are_rounded_to_nanoseconds_are_exact():
    one = regularity([nanoseconds(Fraction(k, 60)) for k in range(1, 301)])
    assert one.exact
    assert float(one.period_ns) == pytest.approx(1e9 / 60, abs=0.01)


def test_a_second_play_starts_time_again_and_is_no_gap():
    one = regularity([100 * MS, 200 * MS, 300 * MS, 100 * MS, 200 * MS], 10)
    assert (one.ticks, one.missing, one.restarts, one.repeats) == (5, 0, 1, 0)


def test_stamps_of_the_wall_clock_are_measured_by_the_time_of_publishing():
    one = Regularity(rate=Fraction(10))
    for k in range(1, 4):
        one.add(WALL_2024 + k * 77, k * 100 * MS)
    assert (one.wall, one.scheduled, one.first_ns) == (True, False, 100 * MS)
    assert one.period_ns == 100 * MS


def test_the_memory_of_a_topic_is_bounded():
    one, longer = (regularity([k * (k + 1) for k in range(count)]) for count in (20_000, 40_000))
    assert len(longer.gaps()) == LISTED
    assert len(pickle.dumps(longer)) < len(pickle.dumps(one)) + 1000  # the first 10,000 distances, the longest gaps


def test_a_message_alone_and_no_message_have_no_period():
    assert regularity([5], 10).exact is False
    assert regularity([5]).period_ns is None
    assert regularity([]).first_ns is None


def test_the_metadata_of_a_channel_says_the_schedule_and_nonsense_there_is_ignored():
    said = Cadence("/World/Lidar", Fraction(2997, 100), 2).as_metadata()
    one = Regularity.of_channel(said)
    assert (one.sensor, one.rate, one.every) == ("/World/Lidar", Fraction(2997, 100), 2)
    for key, value in (("rate_hz", "fast"), ("rate_hz", "-1"), ("every", "0"), ("every", "x")):
        assert Regularity.of_channel({**said, f"tickgraph_{key}": value}).rate is None
