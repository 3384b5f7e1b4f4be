"""TimeSampleStorage through the App, in both modes and both profiles, and the time nodes that read it."""

from __future__ import annotations

import itertools
import math
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st

from graph.sim import App, VirtualClock
from graph.sim import settings as keys
from graph.sim.timing.clocks import PhysicsClock
from graph.sim.timing.time_queries import CAPACITY, TimeSamples

PRODUCT = "isaacsim-6.0.1"
PER_SUBSTEP = {keys.WARM_UP_STEPS: 0}


def microseconds(*numerators):
    return [Fraction(numerator, 10**6) for numerator in numerators]


def sample_keys(app):
    return [sample.key for sample in app.simulation.get_all_samples()]


@pytest.fixture
def product():
    """Plays two updates at 60 Hz; keys 16666 and 33333, monotonic times 1/60 and 2/60."""
    with App(parity=PRODUCT, settings=PER_SUBSTEP, wall_clock=VirtualClock(1_700_000_000)) as app:
        app.play()
        app.update(2)
        yield app


# -- keys and writing ----------------------------------------------------------------------------------------------


def test_product_keys_are_whole_microseconds_rounded_down(product):
    product.update()
    assert sample_keys(product) == microseconds(16666, 33333, 50000)


def test_an_entry_has_its_times_as_floats_and_is_valid(product):
    first = product.simulation.get_all_samples()[0]
    assert (first.valid, first.key) == (True, Fraction(16666, 10**6))
    assert first.data == (1 / 60, 1 / 60, 1_700_000_000.0)
    assert first.data.valid
    assert all(type(each) is float for each in first.data)


def test_product_each_substep_has_its_own_key():
    with App(physics_hz=240, parity=PRODUCT, settings=PER_SUBSTEP) as app:
        app.play()
        app.update()
        assert sample_keys(app) == microseconds(4166, 8333, 12500, 16666)
        assert [sample.simulation for sample in app.simulation.get_all_samples()] == [
            Fraction(n, 240) for n in range(1, 5)
        ]


def test_product_samples_are_there_for_post_step_subscribers_of_the_same_substep():
    with App(physics_hz=240, parity=PRODUCT, settings=PER_SUBSTEP) as app:
        seen = []
        app.on("physics_post_step", lambda: seen.append(app.simulation.get_sample_count()))
        app.play()
        app.update()
        assert seen == [1, 2, 3, 4]
        assert sample_keys(app) == microseconds(4166, 8333, 12500, 16666)


def test_documented_one_sample_an_update_at_the_frame_s_exact_time_with_the_last_substep_s_times():
    with App(physics_hz=240, loop_hz=60) as app:
        app.play()
        app.update(2)
        assert [(s.key, s.simulation, s.monotonic) for s in app.simulation.get_all_samples()] == [
            (Fraction(n, 60),) * 3 for n in (1, 2)
        ]


@pytest.mark.parametrize("parity", ["documented", PRODUCT])
def test_multi_tick_off_all_substeps_of_a_frame_share_the_loop_s_time(parity):
    with App(physics_hz=240, parity=parity, settings={keys.MULTI_TICK: False, **PER_SUBSTEP}) as app:
        app.update(6)  # the loop's time runs before play too
        app.play()
        app.update(2)
        assert sample_keys(app) == [Fraction(7, 60), Fraction(8, 60)]
        assert [s.simulation for s in app.simulation.get_all_samples()] == [Fraction(4, 240), Fraction(8, 240)]
        assert app.simulation.get_simulation_time_at_time(Fraction(7, 60)) == 4 / 240
        assert app.simulation.get_simulation_time_at_time(Fraction(15, 120)) == pytest.approx(6 / 240)


@pytest.mark.parametrize(("parity", "physics"), [("documented", 60), (PRODUCT, 60), (PRODUCT, 1000)])
def test_capacity_31_the_oldest_is_evicted(parity, physics):
    with App(physics_hz=physics, parity=parity, settings=PER_SUBSTEP) as app:
        app.play()
        app.update(90)
        assert app.simulation.get_buffer_capacity() == app.simulation.get_sample_count() == CAPACITY == 31
        first, last = app.simulation.get_sample_range()
        assert last == Fraction(3, 2)
        # 31 steps or updates: 0.5 s at 60 Hz, 30 ms at 1000 Hz between the first and the last
        assert last - first == Fraction(30, physics)


def test_direct_steps_of_a_billion_leave_the_last_31(product):
    product.simulation.step(steps=10**9)
    assert product.simulation.get_sample_count() == 31
    last = Fraction(10**9 + 2, 60)
    assert sample_keys(product)[-1] == Fraction(math.floor(last * 10**6), 10**6)
    assert product.simulation.get_all_samples()[0].simulation == last - Fraction(30, 60)


def test_the_newest_key_is_overwritten_and_older_ones_never():
    clock, samples = PhysicsClock(Fraction(4_000_000)), TimeSamples(per_substep=True)
    for number in range(1, 9):  # 0.25 us a step: four steps share a whole microsecond
        clock.advance()
        samples.record(clock, Fraction(number))
    assert [(s.key * 10**6, s.system) for s in samples.all()] == [(0, 3), (1, 7), (2, 8)]


def test_cleared_on_stop_gone_after_close(product):
    product.stop()
    assert (product.simulation.get_sample_count(), product.simulation.get_sample_range()) == (0, None)
    product.play()
    product.update()
    product.close()
    assert product.simulation.get_all_samples() == []


def test_a_resume_rewrites_the_newest(product):
    before = product.simulation.get_all_samples()
    product.pause()
    product.update(5)
    product.play()
    assert product.simulation.get_all_samples() == before


# -- looking up ----------------------------------------------------------------------------------------------------


def test_the_worked_examples(product):
    simulation = product.simulation
    assert simulation.get_simulation_time_monotonic_at_time((25_000, 10**6)) == pytest.approx(
        1 / 60 + 8334 / 16667 / 60, abs=1e-12
    )
    assert simulation.get_simulation_time_monotonic_at_time((25_000, 10**6)) == pytest.approx(0.0250005, abs=5e-8)
    assert simulation.get_simulation_time_at_time((25_000, 10**6)) == 0.025
    assert simulation.get_simulation_time_at_time((5, 1)) == 5.0
    assert simulation.get_simulation_time_monotonic_at_time((5, 1)) == 2 / 60


def test_exact_match(product):
    assert product.simulation.get_simulation_time_monotonic_at_time((16666, 10**6)) == 1 / 60
    assert product.simulation.get_system_time_at_time((16666, 10**6)) == 1_700_000_000
    # an update lasts 1/120 s of wall time: the product's rateLimitFrequency
    assert product.simulation.get_system_time_at_time((33333, 10**6)) == 1_700_000_000 + 1 / 120


def test_interpolation_of_system_time(product):
    middle = (16666 + 33333, 2 * 10**6)
    assert product.simulation.get_system_time_at_time(middle) - 1_700_000_000 == pytest.approx(1 / 240, abs=1e-6)


@pytest.mark.parametrize("parity", ["documented", PRODUCT])
def test_equal_fractions_are_one_key(parity):
    with App(parity=parity, settings=PER_SUBSTEP) as app:
        app.play()
        app.update(6)
        assert app.simulation.get_simulation_time_monotonic_at_time((1, 10)) == 0.1
        assert app.simulation.get_simulation_time_monotonic_at_time((302, 3020)) == 0.1
        assert app.simulation.get_simulation_time_monotonic_at_time(Fraction(604, 6040)) == 0.1


@pytest.mark.parametrize("parity", ["documented", PRODUCT])
def test_an_empty_store_and_a_zero_denominator_answer_with_the_present(parity):
    with App(parity=parity, settings=PER_SUBSTEP) as app:
        assert app.simulation.get_simulation_time_at_time((5, 1)) == 0
        app.play()
        app.update(3)
        for moment in ((0, 0), (7, 0)):
            assert app.simulation.get_simulation_time_at_time(moment) == 3 / 60
            assert app.simulation.get_simulation_time_monotonic_at_time(moment) == 3 / 60
        assert not [warning for warning in app.warnings if warning.code == "time-sample-missing"]


@pytest.mark.parametrize("parity", ["documented", PRODUCT])
def test_before_the_first_after_the_last_and_evicted_answer_with_the_present_and_a_warning(parity):
    with App(parity=parity, settings=PER_SUBSTEP) as app:
        app.play()
        app.update(60)
        for moment in ((1, 10), (2, 1)):
            assert app.simulation.get_simulation_time_monotonic_at_time(moment) == 1.0
        warned = [(w.code, w.where, w.count) for w in app.warnings]
        assert warned == [("time-sample-missing", "simulation.monotonic", 2)]


def test_one_sample_answers_only_its_own_key(product):
    product.stop()
    product.play()
    product.update()
    assert product.simulation.get_simulation_time_monotonic_at_time((16666, 10**6)) == 3 / 60
    assert product.simulation.get_sample_count() == 1
    assert product.simulation.get_simulation_time_monotonic_at_time((16000, 10**6)) == 3 / 60


def test_documented_simulation_time_at_t_is_looked_up_not_echoed():
    with App(physics_hz=50, loop_hz=60) as app:
        app.play()
        app.update(12)
        assert app.simulation.get_simulation_time_at_time((1, 50)) == 1 / 50
        assert app.simulation.get_simulation_time_at_time((5, 1)) == app.simulation.get_simulation_time()


def test_statistics_go_to_the_log(product, caplog):
    import logging

    with caplog.at_level(logging.INFO, logger="tickgraph.clocks"):
        product.simulation.log_statistics()
    assert "2 of 31 time samples, from 0.016666 s to 0.033333 s" in caplog.text


@given(
    per_substep=st.booleans(),
    rate=st.fractions(Fraction(1, 10), 10**5, max_denominator=1000),
    batches=st.lists(st.integers(1, 40), min_size=1, max_size=12),
    share=st.fractions(0, 1),
)
@hypothesis_settings(max_examples=200, deadline=None)
def test_any_samples_interpolate_between_their_neighbours(per_substep, rate, batches, share):
    """Whatever was stepped: at most 31 samples, keys rise, and a look-up lies between those around it."""
    clock, samples = PhysicsClock(rate), TimeSamples(per_substep=per_substep)
    for batch in batches:
        clock.advance(batch)
        samples.record(clock, clock.time, None, batch if per_substep else 1)
    found = samples.all()
    assert len(found) == min(31, sum(batches) if per_substep else len(batches))
    assert found[-1].simulation == clock.time
    assert all(a.key < b.key and a.monotonic < b.monotonic for a, b in itertools.pairwise(found))
    if per_substep:
        assert all(s.key == Fraction(math.floor(s.simulation * 10**6), 10**6) for s in found)
    if len(found) > 1:
        first, last = found[0].key, found[-1].key
        at = samples.at(first + share * (last - first), "monotonic")
        assert found[0].monotonic <= at <= found[-1].monotonic
    assert samples.at(found[-1].key + 1, "monotonic") is None
