"""What is changed while the App plays: stops inside updates, rates, time codes; and arguments that cannot be."""

from fractions import Fraction

import pytest
from pxr import UsdPhysics

from graph.sim import App, MemorySink

BALL = {"/World/Ball": {"type": "Sphere", "radius": 0.2, "translate": [0, 0, 2], "rigid_body": True}}


# -- stop inside an update -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("order", [-1, 0])
@pytest.mark.parametrize("phase", ["timeline", "physics", "physics_pre_step", "physics_post_step"])
@pytest.mark.parametrize("dynamic", [False, True])
def test_nothing_advances_in_an_update_after_a_stop(phase, order, dynamic):
    """Every clock stands at 0, and the next play begins there: 24 updates at 60 Hz are 0.4 s."""
    with App(physics_hz=240, loop_hz=60) as app:
        if dynamic:
            app.add_prims(BALL)
        end = app.on(phase, lambda: app.update_index == 3 and app.timeline.is_playing() and app.stop(), order)
        app.play()
        app.update(5)
        end()
        simulation = app.simulation
        assert (simulation.get_num_physics_steps(), simulation.time, simulation.carry) == (0, 0, 0)
        assert (app.timeline.current_time, app.external_time) == (0, 0)
        assert simulation.get_sample_count() == 0
        app.play()
        app.update(24)
        assert simulation.time == app.timeline.current_time == Fraction(2, 5)


def test_a_stop_and_a_play_in_one_update_begin_in_the_next():
    with App(physics_hz=240, loop_hz=60) as app:
        app.on("timeline", lambda: (app.stop(), app.play()) if app.update_index == 3 else None)
        app.play()
        app.update(4)
        assert app.simulation.time == app.timeline.current_time == 0
        app.update(2)
        assert app.simulation.time == app.timeline.current_time == Fraction(1, 30)


# -- the rate of physics ---------------------------------------------------------------------------------------------


def test_a_rate_set_before_the_first_step_moves_nothing():
    with App(physics_hz=60, loop_hz=60) as app:
        app.play()
        app.simulation.setup_simulation(dt=1 / 240)
        app.update(60)
        assert app.simulation.time == 1
        assert "simulation-time-moved" not in app.warnings.codes()


def test_play_takes_the_rate_that_was_authored_since():
    with App(loop_hz=60) as app:
        scene = UsdPhysics.Scene.Define(app.stage, "/World/Physics").GetPrim()
        rate = scene.CreateAttribute("physxScene:timeStepsPerSecond", _uint())
        rate.Set(120)
        app.play()
        app.update(60)
        assert app.simulation.get_num_physics_steps() == 120
        app.stop()
        rate.Set(200)
        app.play()
        app.update(60)
        assert app.simulation.get_num_physics_steps() == 200


def test_an_explicit_rate_beats_what_is_authored_later():
    with App(physics_hz=240, loop_hz=60) as app:
        scene = UsdPhysics.Scene.Define(app.stage, "/World/Physics").GetPrim()
        scene.CreateAttribute("physxScene:timeStepsPerSecond", _uint()).Set(120)
        app.play()
        assert app.simulation.steps_per_second == 240


def test_a_rate_set_on_the_app_is_not_taken_back_by_play():
    with App(loop_hz=60) as app:
        app.simulation.setup_simulation(dt=Fraction(1001, 60000))
        app.play()
        assert app.simulation.steps_per_second == Fraction(60000, 1001)


# -- stage, timeline, stamps -----------------------------------------------------------------------------------------


def test_a_new_stage_has_the_time_codes_of_the_timeline():
    with App() as app:
        assert app.stage.GetTimeCodesPerSecond() == app.timeline.get_time_codes_per_second() == 60
        app.play()
        app.rendering.set_dt(1 / 30)
        app.stop()
        assert app.stage.GetTimeCodesPerSecond() == app.timeline.get_time_codes_per_second() == 30


def test_the_stamp_of_a_frame_in_nanoseconds_finds_its_sample():
    """1/60 s is stamped 16666667 ns, which is not the exact key of a sample, and for the newest one beyond it."""
    with App(physics_hz=60, loop_hz=60) as app:
        app.play()
        app.update(10)
        for step in range(1, 11):
            stamp = round(Fraction(step, 60) * 10**9), 10**9
            assert app.simulation.get_simulation_time_at_time(stamp) == step / 60
            assert app.simulation.get_simulation_time_monotonic_at_time(stamp) == step / 60
        assert app.warnings.codes() == []


# -- what cannot be --------------------------------------------------------------------------------------------------


def test_arguments_that_cannot_be_are_refused_and_change_nothing():
    with App(physics_hz=60, loop_hz=60) as app:
        app.bus.subscribe(MemorySink())
        app.play()
        for call in (
            lambda: app.update(-1),
            lambda: app.update_app(steps=-1),
            lambda: app.simulation.step(steps=-3),
            lambda: app.timeline.set_current_time(-1),
        ):
            with pytest.raises(ValueError, match="give 0"):
                call()
        for call in (
            lambda: app.on("end", print, "a"),
            lambda: app.on("end", print, 1.5),
            lambda: app.rendering.register_callback("isaacsim.rendering.new_frame", callback=print, order="a"),
            lambda: app.simulation.register_callback(print, "isaacsim.simulation.started", order="a"),
        ):
            with pytest.raises(TypeError, match=r"order .*: give a whole number"):
                call()
        app.update()
        assert app.simulation.time == app.timeline.current_time == Fraction(1, 60)


def _uint():
    from pxr import Sdf

    return Sdf.ValueTypeNames.UInt
