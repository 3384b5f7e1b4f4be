"""Ticks and stamps: the schedule against its closed form, on integers and on random rationals."""

from __future__ import annotations

import itertools
import math
from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from graph.sim.renderer.schedule import NEVER, EveryUpdate, TickSchedule
from graph.sim.timing.clocks import Accumulator, PhysicsClock

RATES = [Fraction(5), Fraction(7), Fraction("7.5"), Fraction(10), Fraction("29.97"), Fraction(30), Fraction(60)]
TEN_MINUTES, HOUR = 600, 3600

rates = st.fractions(min_value=Fraction(1, 100), max_value=2000, max_denominator=1001)


@pytest.mark.parametrize("physics", [60, 100, 240, 500, 1000])
@pytest.mark.parametrize("loop", [24, 30, 60, 120])
def test_ten_minutes_of_every_rate_equal_the_closed_form(physics, loop):
    """Rates, physics and loop meet again after 100 s: the sixth round is the first."""
    clock, accumulator, dt = PhysicsClock(Fraction(physics)), Accumulator(Fraction(physics)), Fraction(1, loop)
    schedules = [TickSchedule(rate, accumulates=True) for rate in RATES]
    for schedule in schedules:
        schedule.bind(clock.rate)
    rendered = [[] for _ in RATES]
    counts = []
    pairs = list(zip(schedules, (frames.append for frames in rendered), strict=True))
    take, advance = accumulator.take, clock.advance
    for _ in range(TEN_MINUTES * loop):
        steps = take(dt)
        if steps:
            advance(steps)
            count = clock.count
            counts.append(count)
            for schedule, note in pairs:
                if count >= schedule.due_step:
                    note(schedule.advance_steps(count).index)

    assert clock.time == TEN_MINUTES
    assert clock.monotonic == TEN_MINUTES
    for rate, schedule, frames in zip(RATES, schedules, rendered, strict=True):
        scale, per = rate.numerator, rate.denominator * physics
        newest = [count * scale // per for count in counts]
        expected = [k for before, k in zip([0, *newest], newest, strict=False) if k > before]
        assert frames == expected
        assert frames[-1] == math.floor(rate * TEN_MINUTES)
        assert len(frames) + schedule.missed == math.floor(rate * TEN_MINUTES)


@pytest.mark.parametrize(("rate", "frames"), [("5", 18_000), ("7", 25_200), ("7.5", 27_000), ("29.97", 107_892)])
def test_a_sensor_slower_than_the_loop_misses_nothing(rate, frames):
    schedule = TickSchedule(Fraction(rate))
    schedule.bind(Fraction(60))
    assert sum(schedule.advance_steps(step) is not None for step in range(1, HOUR * 60 + 1)) == frames
    assert schedule.missed == 0


@given(
    rate=rates,
    physics=rates,
    loop=st.fractions(min_value=1, max_value=300, max_denominator=1001),
    updates=st.integers(1, 400),
    held=st.integers(0, 30),
    accumulates=st.booleans(),
)
@settings(max_examples=150, deadline=None)
def test_any_rates_obey_the_definition(rate, physics, loop, updates, held, accumulates):
    clock, accumulator, dt = PhysicsClock(physics), Accumulator(physics), 1 / loop
    schedule = None
    before = Fraction(0)
    expected, missed, last = [], 0, None
    got = []
    for update in range(updates):
        if update == held:
            created = clock.time
            schedule = TickSchedule(rate, created, accumulates=accumulates)
            schedule.bind(physics)
            after = itertools.count(max(1, math.floor(created * rate) - 1))
            last = next(k for k in after if ((k - 1) / rate >= created if accumulates else k / rate > created)) - 1
        clock.advance(accumulator.take(dt))
        time = clock.time
        assert time == Fraction(clock.count) / physics
        assert abs(time + accumulator.carry - (update + 1) * dt) == 0
        if schedule is not None:
            newest = math.floor(time * rate)
            if newest > math.floor(before * rate) and newest > last:
                expected.append((newest, (newest - 1) / rate, newest / rate, time))
                missed += newest - last - 1
                last = newest
            tick = schedule.advance_steps(clock.count)
            if tick is not None:
                got.append((tick.index, tick.start, tick.end, tick.time))
                state = schedule.state_step(tick.index)
                assert Fraction(state) / physics >= tick.end > Fraction(state - 1) / physics
        before = time
    assert got == expected
    assert (schedule.missed if schedule else 0) == missed


@given(rate=rates, physics=rates, steps=st.lists(st.integers(0, 50), max_size=100))
@settings(max_examples=100, deadline=None)
def test_integers_and_fractions_give_the_same_ticks(rate, physics, steps):
    on_steps, on_time, count = TickSchedule(rate), TickSchedule(rate), 0
    on_steps.bind(physics)
    for more in steps:
        count += more
        a, b = on_steps.advance_steps(count), on_time.advance(count / physics)
        assert (a and (a.index, a.time)) == (b and (b.index, b.time))
        assert on_steps.missed == on_time.missed


def test_there_is_no_tick_at_time_zero():
    schedule = TickSchedule(Fraction(10))
    assert schedule.advance(Fraction(0)) is None
    assert schedule.next_due == Fraction(1, 10)


def test_a_tick_waits_for_the_whole_scan_of_an_accumulating_lidar():
    created = Fraction(5, 60)
    assert TickSchedule(Fraction(20), created).first_index == 2  # 0.1 s is after 0.0833 s
    assert TickSchedule(Fraction(20), created, accumulates=True).first_index == 3  # [0.1, 0.15) is the first whole one


def test_a_creation_on_the_grid_takes_the_scan_that_begins_there():
    created = Fraction(1, 10)
    assert TickSchedule(Fraction(10), created).first_index == 2
    assert TickSchedule(Fraction(10), created, accumulates=True).first_index == 2


def test_only_the_newest_of_several_grid_times_is_rendered():
    schedule = TickSchedule(Fraction(100))
    ticks = [schedule.advance(Fraction(update, 30)) for update in range(1, 4)]
    assert [tick.index for tick in ticks] == [3, 6, 10]
    assert schedule.missed == 2 + 2 + 3


def test_the_frozen_state_is_the_first_at_or_after_the_grid_time():
    schedule = TickSchedule(Fraction("29.97"))
    schedule.bind(Fraction(240))
    # 240 / 29.97 = 8.008: the first grid time lies just behind step 8
    assert [schedule.state_step(k) for k in (1, 2, 3)] == [9, 17, 25]
    schedule = TickSchedule(Fraction(20))
    schedule.bind(Fraction(240))
    assert [schedule.state_step(k) for k in (1, 2, 3)] == [12, 24, 36]


def test_a_schedule_rebinds_when_the_physics_rate_changes():
    schedule = TickSchedule(Fraction(10))
    schedule.bind(Fraction(60))
    assert schedule.due_step == 6
    schedule.bind(Fraction(120))
    assert schedule.due_step == 12
    assert schedule.advance_steps(11) is None
    assert schedule.advance_steps(12).time == Fraction(1, 10)


def test_time_going_back_renders_nothing_until_it_is_passed_again():
    schedule = TickSchedule(Fraction(10))
    assert schedule.advance(Fraction(1)).index == 10
    assert schedule.advance(Fraction(1, 2)) is None
    assert schedule.advance(Fraction(11, 10)).index == 11


def test_an_unbound_schedule_is_never_due_by_steps():
    assert TickSchedule(Fraction(10)).due_step == NEVER


def test_a_rate_of_zero_is_not_a_tick_schedule():
    with pytest.raises(ValueError, match="above 0 Hz"):
        TickSchedule(Fraction(0))


def test_every_update_covers_the_time_since_the_last_output():
    schedule = EveryUpdate(Fraction(1, 10))
    assert schedule.advance(Fraction(1, 10)) is None
    ticks = [schedule.advance(Fraction(n, 60)) for n in (7, 7, 8)]
    assert ticks[1] is None
    assert (ticks[0].start, ticks[0].end) == (Fraction(1, 10), Fraction(7, 60))
    assert (ticks[2].start, ticks[2].end) == (Fraction(7, 60), Fraction(8, 60))


def test_ticks_far_from_zero_are_exact():
    schedule = TickSchedule(Fraction("29.97"))
    schedule.bind(Fraction(1_000_000))
    steps = 10**9 * 1_000_000
    tick = schedule.advance_steps(steps)
    assert tick.index == 29_970_000_000
    assert tick.end == tick.time == 10**9
