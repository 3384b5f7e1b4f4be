"""The accumulator's worked tables, the physics clock, counters: exact numbers."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from graph.base.errors import RunError, UserError
from graph.sim.timing.clocks import Accumulator, Counter, PhysicsClock, checked_rate


def substeps(sps, loop, min_frame_rate=0, updates=12):
    accumulator = Accumulator(Fraction(sps), min_frame_rate)
    return [accumulator.take(1 / Fraction(loop)) for _ in range(updates)]


def test_without_a_cap_no_step_is_held_back():
    assert substeps(60, 24) == [2, 3] * 6
    assert substeps(60, 10) == [6] * 12


def test_exact_arithmetic_where_the_engine_float_loses_a_step():
    assert substeps(60, 100) == [0, 1, 0, 1, 1, 0, 1, 0, 1, 1, 0, 1]
    assert substeps(1000, 50) == [20] * 12
    assert substeps(1000, 100) == [10] * 12


def test_the_carry_of_the_worked_run():
    accumulator, carries = Accumulator(Fraction(100)), []
    for _ in range(3):
        accumulator.take(Fraction(1, 60))
        carries.append(accumulator.carry)
    assert carries == [Fraction(1, 150), Fraction(1, 300), 0]


def test_a_capped_overlong_update_banks_at_most_the_cap():
    accumulator = Accumulator(Fraction(60), 30)
    assert accumulator.take(Fraction(1, 10)) == 2
    assert accumulator.carry == Fraction(2, 60)
    assert accumulator.take(Fraction(1, 1000)) == 2


def test_the_cap_never_falls_below_one_step():
    assert Accumulator(Fraction(10), 30).cap == 1
    assert Accumulator(Fraction(200), 30).cap == 6
    assert Accumulator(Fraction(200)).cap is None


def test_a_new_rate_keeps_the_carry():
    accumulator = Accumulator(Fraction(30))
    assert accumulator.take(Fraction(1, 60)) == 0
    accumulator.configure(Fraction(60))
    assert accumulator.carry == Fraction(1, 60)
    assert accumulator.take(Fraction(1, 60)) == 2


def test_direct_steps_clear_the_carry():
    accumulator = Accumulator(Fraction(30))
    accumulator.take(Fraction(1, 60))
    accumulator.clear()
    assert accumulator.carry == 0


positive = st.fractions(min_value=Fraction(1, 50), max_value=5000, max_denominator=1001)


@given(sps=positive, elapsed=st.lists(st.fractions(0, 2, max_denominator=10**6), min_size=1, max_size=60))
@settings(max_examples=150, deadline=None)
def test_no_step_is_lost_or_doubled_whatever_the_updates_last(sps, elapsed):
    accumulator, steps = Accumulator(sps), 0
    for each in elapsed:
        steps += accumulator.take(each)
        assert 0 <= accumulator.carry < 1 / sps
    assert steps == sum(elapsed, Fraction(0)) * sps // 1
    assert steps / sps + accumulator.carry == sum(elapsed, Fraction(0))


def test_an_uneven_rate_over_an_hour_ends_exactly():
    accumulator, steps = Accumulator(Fraction("333.3")), 0
    for _ in range(3600 * 30):
        steps += accumulator.take(Fraction(1001, 30030))
    assert steps == 3600 * 3333 // 10


def test_time_is_count_over_rate():
    clock = PhysicsClock(Fraction(60))
    clock.advance(60)
    clock.advance()
    assert clock.time == Fraction(61, 60)
    assert clock.seconds == 61 / 60


def test_monotonic_time_survives_stop():
    clock = PhysicsClock(Fraction(60))
    clock.advance(103)
    clock.reset()
    assert (clock.count, clock.time) == (0, 0)
    clock.advance(3)
    assert clock.time == Fraction(3, 60)
    assert clock.monotonic == Fraction(106, 60)


def test_a_new_rate_rescales_the_history_but_not_monotonic_time():
    clock = PhysicsClock(Fraction(60))
    clock.advance(60)
    clock.set_rate(Fraction(120))
    assert (clock.time, clock.rate) == (1, 120)  # nothing moves before the next step
    clock.advance()
    assert clock.time == Fraction(61, 120)
    assert clock.monotonic == 1 + Fraction(1, 120)


def test_a_new_rate_before_the_first_step_of_a_session():
    clock = PhysicsClock(Fraction(60))
    clock.advance(60)
    clock.reset()
    clock.set_rate(Fraction(100))
    clock.advance(50)
    assert clock.time == Fraction(1, 2)
    assert clock.monotonic == Fraction(3, 2)


def test_the_version_changes_with_the_rate_of_time():
    clock = PhysicsClock(Fraction(60))
    before = clock.version
    clock.set_rate(Fraction(120))
    assert clock.version == before
    clock.advance()
    assert clock.version != before


def test_setting_the_same_rate_changes_nothing():
    clock = PhysicsClock(Fraction(60))
    clock.advance(10)
    clock.set_rate(Fraction(60))
    clock.advance()
    assert clock.time == Fraction(11, 60)


@given(
    segments=st.lists(
        st.tuples(positive, st.integers(0, 10**12), st.booleans()),
        max_size=20,
    )
)
@settings(max_examples=100, deadline=None)
def test_monotonic_time_never_decreases_and_sums_the_segments(segments):
    clock, total = PhysicsClock(Fraction(60)), Fraction(0)
    for rate, steps, stop in segments:
        clock.set_rate(rate)
        try:
            clock.advance(steps)
        except RunError:
            break
        total += steps / rate
        assert clock.monotonic == total
        if stop:
            clock.reset()
            assert clock.monotonic == total


def test_a_billion_steps_without_drift():
    clock = PhysicsClock(Fraction(1_000_000))
    clock.advance(10**9)
    assert clock.time == 1000
    clock.advance(1)
    assert clock.time == 1000 + Fraction(1, 10**6)


def test_one_step_a_second_for_290_years():
    clock = PhysicsClock(Fraction(1))
    clock.advance(290 * 365 * 86_400)
    assert clock.time == 290 * 365 * 86_400


def test_beyond_int64_nanoseconds_is_refused():
    clock = PhysicsClock(Fraction(1))
    clock.advance(2**63 // 10**9)
    with pytest.raises(RunError, match="292 years"):
        clock.advance()
    assert clock.count == 2**63 // 10**9


@pytest.mark.parametrize("bad", [Fraction(0), Fraction(-1), Fraction(10**10)])
def test_rates_that_cannot_be_run(bad):
    with pytest.raises(UserError, match="physics_hz"):
        checked_rate(bad, "physics_hz")


def test_a_counter_changes_its_step_without_a_jump():
    counter = Counter(Fraction(1, 60))
    counter.advance(Fraction(1, 60), 30)
    counter.advance(Fraction(1, 24))
    counter.advance(Fraction(1, 24))
    assert counter.time == Fraction(1, 2) + Fraction(1, 12)


def test_a_counter_can_be_set():
    counter = Counter(Fraction(1, 60))
    counter.advance(Fraction(1, 60), 5)
    counter.set(Fraction(2))
    counter.advance(Fraction(1, 60))
    assert counter.time == 2 + Fraction(1, 60)
