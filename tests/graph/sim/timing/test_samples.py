"""Time samples: capacity, exact matches, interpolation, replacement."""

from __future__ import annotations

from fractions import Fraction

from graph.sim.timing.clocks import PhysicsClock
from graph.sim.timing.time_queries import CAPACITY, TimeSamples


def recorded(updates, steps=1):
    clock, samples = PhysicsClock(Fraction(60)), TimeSamples()
    for update in range(1, updates + 1):
        clock.advance(steps)
        samples.record(clock, Fraction(update))
    return clock, samples


def test_the_oldest_of_32_is_evicted():
    _, samples = recorded(32)
    assert len(samples) == CAPACITY == 31
    assert samples.all()[0].key == Fraction(2, 60)
    assert samples.at(Fraction(1, 60), "simulation") is None


def test_an_exact_match_gives_the_stored_value():
    _, samples = recorded(5)
    assert samples.at(Fraction(3, 60), "system") == 3
    assert samples.at(Fraction(3, 60), "monotonic") == Fraction(3, 60)


def test_between_two_samples_it_interpolates():
    _, samples = recorded(2)
    assert samples.at(Fraction(3, 120), "simulation") == Fraction(1, 40)
    assert samples.at(Fraction(3, 120), "system") == Fraction(3, 2)


def test_outside_there_is_no_answer():
    _, samples = recorded(3)
    assert samples.at(Fraction(0), "simulation") is None
    assert samples.at(Fraction(4, 60), "simulation") is None


def test_keys_compare_as_numbers():
    _, samples = recorded(4)
    assert samples.at(Fraction(302, 15 * 302), "simulation") == Fraction(4, 60)


def test_a_sample_with_the_newest_key_replaces_it():
    clock, samples = recorded(3)
    samples.record(clock, Fraction(9))
    assert len(samples) == 3
    assert samples.all()[-1].system == 9


def test_samples_of_the_run_loop_keep_their_own_keys():
    clock, samples = PhysicsClock(Fraction(60)), TimeSamples()
    for update in (1, 2, 2):
        clock.advance()
        samples.record(clock, Fraction(0), Fraction(update))
    assert [(sample.key, sample.simulation) for sample in samples.all()] == [
        (1, Fraction(1, 60)),
        (2, Fraction(3, 60)),
    ]


def test_the_past_keeps_its_rate():
    clock, samples = recorded(60)
    clock.set_rate(Fraction(120))
    clock.advance()
    samples.record(clock, Fraction(61))
    last = samples.all()[-2:]
    assert [sample.simulation for sample in last] == [1, Fraction(61, 120)]
    assert [sample.monotonic for sample in last] == [1, 1 + Fraction(1, 120)]


def test_clear_forgets():
    _, samples = recorded(3)
    samples.clear()
    assert (len(samples), samples.at(Fraction(1, 60), "simulation")) == (0, None)
