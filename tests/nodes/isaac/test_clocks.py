from fractions import Fraction

import pytest

from graph.testing import run_node
from nodes.isaac.clocks import split_time, stamp_ns


def test_simulation_time_is_steps_over_rate(world):
    trace = run_node("IsaacReadSimulationTime", updates=4, app=world(physics_hz=240, loop_hz=60))
    assert trace.values("simulationTime") == [1 / 60, 2 / 60, 3 / 60, 4 / 60]


def test_without_a_world_simulation_time_is_that_of_the_updates():
    assert run_node("IsaacReadSimulationTime", updates=3, loop_hz=30).values("simulationTime") == [
        1 / 30,
        2 / 30,
        3 / 30,
    ]


def test_a_stop_resets_simulation_time_by_default(world):
    app = world(physics_hz=100, loop_hz=50)
    run_node("IsaacReadSimulationTime", updates=5, app=app)
    app.stop()
    reset = run_node("IsaacReadSimulationTime", updates=1, app=app)
    assert reset.value("simulationTime") == 1 / 50
    app.stop()
    onward = run_node("IsaacReadSimulationTime", inputs={"resetOnStop": False}, updates=1, app=app)
    assert onward.value("simulationTime") == 7 / 50


def test_a_past_moment_is_read_by_its_fraction(world):
    app = world(physics_hz=240, loop_hz=60)
    app.play()
    app.update(10)
    inputs = {"referenceTimeNumerator": 1, "referenceTimeDenominator": 20}
    assert run_node("IsaacReadSimulationTime", inputs=inputs, app=app).value("simulationTime") == 3 / 60


def test_system_time_is_the_wall_time_of_the_last_step(world):
    app = world(physics_hz=60, loop_hz=60)
    trace = run_node("IsaacReadSystemTime", updates=3, app=app)
    assert trace.value("systemTime") == app.simulation.system_time
    assert len(set(trace.values("systemTime"))) == 3


def test_the_real_time_factor_needs_two_readings_and_is_1_on_the_virtual_clock(world):
    trace = run_node("IsaacRealTimeFactor", updates=5, app=world(physics_hz=60, loop_hz=60))
    assert trace.values("rtf")[0] == 0
    assert trace.values("rtf")[1:] == pytest.approx([1.0] * 4)


@pytest.mark.parametrize(
    ("time", "seconds", "nanoseconds"),
    [
        (1.25, 1, 250_000_000),
        (-0.25, -1, 750_000_000),
        (0.1, 0, 100_000_000),
        (0.3, 0, 300_000_000),
        (7, 7, 0),
        (1e-9, 0, 1),
        (1.9999999999, 1, 999_999_999),
    ],
)
def test_a_time_splits_into_whole_seconds_and_the_rest(time, seconds, nanoseconds):
    assert split_time(float(time)) == (seconds, nanoseconds)


def test_the_time_splitter_gives_the_same_rest_in_three_units():
    trace = run_node("IsaacTimeSplitter", inputs={"time": 12.345678901})
    found = [trace.value(unit) for unit in ("seconds", "milliseconds", "microseconds", "nanoseconds")]
    assert found == [12, 345, 345_678, 345_678_901]


def test_an_integer_is_whole_seconds():
    trace = run_node("IsaacTimeSplitter", inputs={"time": {"type": "int64", "value": -3}})
    assert (trace.value("seconds"), trace.value("nanoseconds")) == (-3, 0)


def test_a_float_that_is_a_clock_gets_that_clocks_exact_stamp(world):
    app = world(physics_hz=Fraction(2997, 100), loop_hz=60)
    app.play()
    app.update(7)
    assert stamp_ns(app, float(app.simulation.time)) == round(app.simulation.time * 10**9)
    assert stamp_ns(app, 0.1) == 100_000_000


def test_the_simulation_gate_counts_while_playing_and_a_stop_clears_it():
    def stop_at_5(update, node):
        if update == 5:
            node.graph.reset()

    trace = run_node(
        "IsaacSimulationGate",
        inputs={"step": 2},
        pulses={"execIn": range(9)},
        updates=9,
        playing=lambda update: update != 1,
        on_update=stop_at_5,
    )
    assert trace.fired("execOut") == [2, 4, 6, 8]


@pytest.mark.parametrize(("step", "fired"), [(0, []), (1, [0, 1, 2]), (3, [2])])
def test_the_simulation_gate_passes_every_step_th_activation(step, fired):
    trace = run_node("IsaacSimulationGate", inputs={"step": step}, pulses={"execIn": range(3)}, updates=3)
    assert trace.fired("execOut") == fired


def test_one_simulation_frame_is_one_pulse_per_play():
    def stop_at_2(update, node):
        if update == 2:
            node.graph.reset()

    trace = run_node("OgnIsaacRunOneSimulationFrame", pulses={"execIn": range(4)}, updates=4, on_update=stop_at_2)
    assert trace.fired("step") == [0, 2]
