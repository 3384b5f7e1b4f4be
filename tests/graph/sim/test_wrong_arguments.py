"""Calls with arguments that cannot be meant say so in one line, and change nothing."""

from __future__ import annotations

import asyncio
from fractions import Fraction

import pytest

from graph.base.errors import UserError
from graph.sim import App, PhysicsScene


@pytest.fixture
def app():
    with App() as made:
        made.play()
        yield made


CALLS = {
    "update": lambda app, steps: app.update(steps=steps),
    "update_app": lambda app, steps: app.update_app(steps=steps),
    "update_app_async": lambda app, steps: asyncio.run(app.update_app_async(steps=steps)),
    "step": lambda app, steps: app.simulation.step(steps=steps),
}


@pytest.mark.parametrize("call", CALLS.values(), ids=CALLS)
@pytest.mark.parametrize(
    ("steps", "message"),
    [
        (1.5, "steps 1.5: give a whole number"),
        ("3", "steps '3': give a whole number"),
        (None, "steps None: give a whole number"),
    ],
)
def test_a_number_of_steps_is_a_whole_one(app, call, steps, message):
    with pytest.raises(TypeError) as raised:
        call(app, steps)
    assert str(raised.value) == message
    assert (app.update_index, app.simulation.get_num_physics_steps()) == (0, 0)


@pytest.mark.parametrize("call", CALLS.values(), ids=CALLS)
def test_no_steps_are_not_mistake_and_fewer_are(app, call):
    call(app, 0)
    with pytest.raises(ValueError, match=r"^steps -1: give 0 or more$"):
        call(app, -1)
    assert (app.update_index, app.simulation.get_num_physics_steps()) == (0, 0)


def test_a_stage_is_a_path_or_a_stage():
    with pytest.raises(UserError, match=r"^stage 5: give the path of a USD file, a Usd.Stage, or None"):
        App(stage=5)


def test_a_seed_is_a_whole_number():
    with pytest.raises(TypeError, match=r"^seed 'a': give a whole number$"):
        App(seed="a")


@pytest.mark.parametrize("time", ["now", None, (1,), (1, 2, 3), (0.5, 2), float("nan"), object()])
def test_a_reference_time_is_a_fraction_or_a_pair(app, time):
    app.update(2)
    for call in (
        app.simulation.get_simulation_time_at_time,
        app.simulation.get_simulation_time_monotonic_at_time,
        app.simulation.get_system_time_at_time,
    ):
        with pytest.raises(ValueError, match=r"^reference time .*: give a fraction or \(numerator, denominator\)$"):
            call(time)
    assert app.simulation.get_simulation_time_at_time(Fraction(1, 60)) == 1 / 60


@pytest.mark.parametrize("gravity", ["down", None, [0, -9.81], [0, 0, float("inf")], [0, 0, "x"]])
def test_gravity_is_three_finite_numbers(gravity):
    with App():
        scene = PhysicsScene("/PhysicsScene")
        with pytest.raises(ValueError, match="give three finite numbers"):
            scene.set_gravity(gravity)
        assert scene.get_gravity()[2] == pytest.approx(-9.81)


@pytest.mark.parametrize(("ticks", "error"), [(0, ValueError), (-2, ValueError), (1.5, TypeError), ("x", TypeError)])
def test_ticks_per_frame_are_one_or_more(app, ticks, error):
    with pytest.raises(error, match="ticks per frame"):
        app.timeline.set_ticks_per_frame(ticks)
    assert app.timeline.get_ticks_per_frame() == 1


@pytest.mark.parametrize("dt", [0, -1, 1e-12, "x", None, True, float("nan"), float("inf")])
def test_a_loop_dt_is_a_positive_number(app, dt):
    with pytest.raises(ValueError, match=r"above 0 s|not a .*number"):
        app.rendering.set_dt(dt)
    assert app.rendering.get_dt() == 1 / 60
