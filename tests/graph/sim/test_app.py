"""The App over an empty stage: phases, clocks, play and stop, several Apps, endings."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from graph.base.errors import RunError, UserError
from graph.isaac.managers.rendering import NEW_FRAME
from graph.sim import App, MemorySink, VirtualClock
from graph.sim import settings as keys
from graph.sim.phases import EVENTS, PHASES
from graph.sim.scene.stage import open_stage
from tests.support.noting_sensor import NotingLidar, NotingSensor, add


def test_an_update_runs_its_phases_in_order():
    with App() as app:
        add(app, NotingSensor())
        ran = []
        for phase in (*PHASES, *EVENTS):
            app.on(phase, lambda phase=phase: ran.append(phase))
        app.timeline.play()
        app.update()
        assert ran == [
            "play",
            "timeline_state",
            "timeline",
            "physics_pre_step",
            "physics_post_step",
            "physics",
            "simulation_graphs",
            "render",
            "post_render_graphs",
            "end",
        ]


def test_subscribers_run_by_order_then_registration_around_the_phases_own_work():
    with App() as app:
        app.play()
        seen = []
        for name, order in (("b", 0), ("late", 5), ("c", 0), ("early", -1)):
            app.on("physics", lambda name=name: seen.append((name, app.simulation.get_num_physics_steps())), order)
        app.update()
        assert seen == [("early", 0), ("b", 1), ("c", 1), ("late", 1)]


def test_post_step_subscribers_below_zero_see_the_old_time_the_others_the_new():
    with App(physics_hz=120) as app:
        app.play()
        seen = {-1: [], 0: [], "pre": []}
        for order in (-1, 0):
            app.on("physics_post_step", lambda order=order: seen[order].append(app.simulation.time), order)
        app.on("physics_pre_step", lambda: seen["pre"].append(app.simulation.time), 3)
        app.update()
        assert seen[-1] == seen["pre"] == [0, Fraction(1, 120)]
        assert seen[0] == [Fraction(1, 120), Fraction(2, 120)]


def test_graphs_read_the_time_after_physics_and_before_rendering():
    with App() as app:
        app.play()
        sensor = add(app, NotingSensor())
        seen = []
        app.on("simulation_graphs", lambda: seen.append((app.external_time, len(sensor.ticks))))
        app.update(2)
        assert seen == [(Fraction(1, 60), 0), (Fraction(2, 60), 1)]


def test_unsubscribing_ends_it_and_may_happen_twice():
    with App() as app:
        ran = []
        end = app.on("end", lambda: ran.append(app.update_index))
        app.update(2)
        end()
        end()
        app.update()
        assert ran == [0, 1]


def test_a_subscriber_may_end_itself_while_it_runs():
    with App() as app:
        ran = []

        def once():
            ran.append("once")
            end()

        end = app.on("end", once)
        app.on("end", lambda: ran.append("other"))
        app.update(2)
        assert ran == ["once", "other", "other"]


def test_post_render_graphs_run_only_with_a_new_frame():
    with App() as app:
        add(app, NotingLidar(20))
        ran = []
        app.on("post_render_graphs", lambda: ran.append(app.update_index))
        app.play()
        app.update(9)
        assert ran == [2, 5, 8]


def test_an_unknown_phase_lists_those_there_are():
    with App() as app, pytest.raises(UserError, match="timeline_state, timeline, physics"):
        app.on("sometime", print)


def test_an_update_inside_an_update_is_refused():
    with App() as app:
        app.on("end", app.update)
        with pytest.raises(RunError, match="inside an update"):
            app.update()


def test_the_three_clocks_agree_at_equal_rates():
    with App() as app:
        app.play()
        app.update(300)
        assert app.simulation.time == app.timeline.current_time == app.external_time == 5
        assert app.simulation.get_simulation_time() == 5.0
        assert app.fabric.get("/ExternalSimulationTime", "omni:time") == 5.0
        assert app.update_index == 300


def test_steps_count_when_nothing_is_dynamic():
    with App(physics_hz=240) as app:
        app.play()
        app.update(60)
        assert app.physics is None
        assert app.simulation.get_num_physics_steps() == 240


def test_simulation_trails_the_timeline_by_the_carry():
    with App(physics_hz=100) as app:
        app.play()
        steps = []
        for _ in range(6):
            app.update()
            steps.append(app.simulation.get_num_physics_steps())
            assert app.simulation.time + app.simulation.carry == app.timeline.current_time
        assert steps == [1, 3, 5, 6, 8, 10]


def test_no_sensor_outputs_on_updates_without_a_step():
    with App(physics_hz=20) as app:
        sensor = add(app, NotingSensor())
        app.play()
        app.update(9)
        assert [tick.end for tick in sensor.ticks] == [Fraction(n, 20) for n in (1, 2, 3)]


def test_nothing_moves_before_play_and_while_paused():
    with App() as app:
        app.update(3)
        assert (app.simulation.time, app.timeline.current_time) == (0, 0)
        app.play()
        app.update(3)
        app.pause()
        app.update(3)
        assert app.simulation.time == app.timeline.current_time == Fraction(3, 60)
        assert (app.simulation.is_simulating(), app.simulation.is_paused()) == (True, True)
        app.play()
        app.update()
        assert app.simulation.time == Fraction(4, 60)


def test_stop_resets_all_clocks_but_the_monotonic_one():
    with App() as app:
        app.play()
        app.update(60)
        app.stop()
        assert (app.simulation.time, app.external_time, app.timeline.current_time) == (0, 0, 0)
        assert app.simulation.get_num_physics_steps() == 0
        assert app.fabric.get("/ExternalSimulationTime", "omni:time") == 0.0
        assert app.simulation.monotonic_time == 1
        assert not app.simulation.is_simulating()
        app.play()
        app.update(30)
        assert app.simulation.time == Fraction(1, 2)
        assert app.simulation.monotonic_time == Fraction(3, 2)


def test_an_uncommitted_play_takes_effect_in_the_next_update():
    with App() as app:
        app.timeline.play()
        assert not app.timeline.is_playing()
        app.update()
        assert app.simulation.get_num_physics_steps() == 1


def test_play_simulations_off_freezes_physics_while_the_timeline_moves():
    with App(settings={keys.PLAY_SIMULATIONS: False}) as app:
        app.play()
        app.update(6)
        assert app.timeline.current_time == Fraction(1, 10)
        assert app.simulation.time == 0
        app.settings.set(keys.PLAY_SIMULATIONS, True)
        app.update()
        assert app.simulation.get_num_physics_steps() == 1  # what passed meanwhile is lost, not banked


def test_the_catch_up_cap_gives_slow_motion():
    with App(loop_hz=24, settings={keys.MIN_FRAME_RATE: 30}) as app:
        app.play()
        app.update(24)
        assert app.simulation.get_num_physics_steps() == 48


def test_direct_steps_move_physics_only_and_drop_the_carry():
    with App(physics_hz=100) as app:
        app.play()
        app.update()
        assert app.simulation.carry == Fraction(1, 150)
        app.simulation.step(steps=10)
        assert app.simulation.get_num_physics_steps() == 11
        assert app.timeline.current_time == Fraction(1, 60)
        assert app.simulation.carry == 0


def test_a_direct_step_callback_can_end_it():
    with App() as app:
        app.play()
        calls = []
        app.simulation.step(steps=5, callback=lambda i, n: calls.append((i, n)) or i < 3)
        assert calls == [(1, 5), (2, 5), (3, 5)]
        assert app.simulation.get_num_physics_steps() == 3


def test_direct_steps_need_play():
    with App() as app, pytest.raises(RunError, match=r"app\.play\(\)"):
        app.simulation.step()


def test_a_billion_steps_without_a_loop():
    with App(physics_hz=1_000_000) as app:
        app.play()
        app.simulation.step(steps=10**9)
        app.update()
        assert app.simulation.time == 1000 + Fraction(16666, 10**6)


def test_a_sensor_ticks_once_after_direct_steps_passed_its_grid():
    with App() as app:
        sensor = add(app, NotingLidar(10))
        app.play()
        app.simulation.step(steps=30)
        app.update()
        assert [tick.index for tick in sensor.ticks] == [5]
        assert sensor.product.missed == 4


def test_changing_the_physics_rate_while_playing():
    with App() as app:
        app.play()
        app.update(60)
        app.simulation.setup_simulation(dt=1 / 120)
        assert app.simulation.time == 1
        app.update()
        assert app.simulation.time == Fraction(62, 120)
        assert app.simulation.monotonic_time == 1 + Fraction(2, 120)


@pytest.mark.parametrize("dt", [0, -0.1, 1.5, float("nan")])
def test_physics_steps_that_cannot_be(dt):
    with App() as app, pytest.raises(ValueError, match=r"dt|finite"):
        app.simulation.setup_simulation(dt=dt)


def test_the_rates_of_the_options():
    with App(physics_hz="29.97", loop_hz="60000/1001") as app:
        assert app.simulation.steps_per_second == Fraction(2997, 100)
        assert app.loop_rate == Fraction(60000, 1001)


def stage_with_rate(rate):
    stage = open_stage()
    scene = stage.DefinePrim("/PhysicsScene", "PhysicsScene")
    scene.CreateAttribute("physxScene:timeStepsPerSecond", _sdf().ValueTypeNames.UInt).Set(rate)
    return stage


def _sdf():
    from pxr import Sdf

    return Sdf


def test_the_argument_beats_the_scene_which_beats_sixty():
    assert App().simulation.steps_per_second == 60
    assert App(stage_with_rate(200)).simulation.steps_per_second == 200
    assert App(stage_with_rate(200), physics_hz=90).simulation.steps_per_second == 90
    assert App(stage_with_rate(200), physics_hz=90, fidelity={"physics.hz": 30}).simulation.steps_per_second == 30


def test_zero_delay_runs_both_at_one_rate():
    app = App(loop_hz=50, experience="zero_delay")
    assert (app.simulation.steps_per_second, app.loop_rate) == (50, 50)
    app = App(stage_with_rate(200), experience="zero_delay")
    assert (app.simulation.steps_per_second, app.loop_rate) == (200, 200)
    with pytest.raises(UserError, match="physics_hz 100 and loop_hz 50 differ"):
        App(physics_hz=100, loop_hz=50, experience="zero_delay")


@pytest.mark.parametrize(
    "options",
    [
        {"physics_hz": 0},
        {"physics_hz": -60},
        {"loop_hz": float("nan")},
        {"loop_hz": "sixty"},
        {"loop_hz": float("inf")},
        {"experience": "bare"},
        {"parity": "isaacsim-5"},
        {"fidelity": {"lidar.motion": "at_once"}},
        {"fidelity": {"lidar.moton": "frozen"}},
        {"settings": {keys.RATE_LIMIT_FREQUENCY: 0}},
    ],
)
def test_options_that_cannot_be_run(options):
    with pytest.raises(UserError):
        App(**options)


def test_a_misspelt_setting_is_a_warning():
    with App(settings={"/app/player/playSimulation": False}) as app:
        assert [(w.code, w.where) for w in app.warnings] == [("setting-unknown", "/app/player/playSimulation")]


def test_multi_tick_is_read_when_playing_starts():
    with App() as app:
        sensor = add(app, NotingLidar(10))
        app.settings.set(keys.MULTI_TICK, False)
        app.settings.set(keys.PLAY_SIMULATIONS, False)
        app.play()
        app.update(12)  # the run loop goes on while physics does not
        assert [tick.time for tick in sensor.ticks] == [Fraction(1, 10), Fraction(2, 10)]


def test_fixed_stepping_makes_a_slow_loop_slow_motion():
    with App(loop_hz=30, experience="full") as app:
        app.play()
        app.update(30)
        assert app.timeline.current_time == app.simulation.time == Fraction(1, 2)
        assert app.wall_clock.now() == 1


def test_fixed_stepping_subsamples_a_fast_loop():
    with App(loop_hz=120, experience="full") as app:
        app.play()
        app.update(120)
        assert app.timeline.current_time == app.simulation.time == 1
        assert app.wall_clock.now() == 1


def test_an_update_lasts_the_rate_limits_period_of_virtual_time():
    with App(loop_hz=120) as app:
        app.update(60)
        assert app.wall_clock.now() == Fraction(1, 2)


def test_system_time_is_that_of_the_last_physics_step():
    with App(physics_hz=30, wall_clock=VirtualClock(1000)) as app:
        assert app.simulation.system_time == 1000.0
        app.play()
        app.update(3)  # the only step ran in the second update, which began 1/60 s after the first
        assert app.simulation.system_time == float(1000 + Fraction(1, 60))


def test_without_manual_mode_dt_is_whole_microseconds_of_wall_time():
    with App(settings={keys.MANUAL_MODE: False}) as app:
        app.play()
        app.update(2)
        assert app.timeline.current_time == Fraction(2 * 16_666, 10**6)


def test_set_dt_moves_every_clock_of_the_loop_and_not_physics():
    with App() as app:
        app.rendering.set_dt(1 / 24)
        assert app.rendering.get_dt() == pytest.approx(1 / 24)
        assert app.loop_rate == 24
        assert app.settings.get(keys.RATE_LIMIT_FREQUENCY) == 24
        assert app.timeline.get_target_framerate() == 24
        assert app.timeline.get_time_codes_per_second() == 24
        assert app.stage.GetTimeCodesPerSecond() == 24
        assert app.simulation.steps_per_second == 60
        app.play()
        app.update(24)
        assert app.timeline.current_time == app.simulation.time == 1


def test_get_dt_prefers_the_rate_limit_where_it_is_on():
    with App(settings={keys.RATE_LIMIT_FREQUENCY: 120}) as app:
        assert app.rendering.get_dt() == 1 / 60
        app.settings.set(keys.RATE_LIMIT_ENABLED, True)
        assert app.rendering.get_dt() == 1 / 120


@pytest.mark.parametrize("dt", [0, -1])
def test_set_dt_refuses_what_is_not_a_step(dt):
    with App() as app, pytest.raises(ValueError, match="above 0"):
        app.rendering.set_dt(dt)


def test_render_is_an_update_without_physics():
    with App() as app:
        sensor = add(app, NotingSensor())
        app.play()
        app.update()
        assert len(sensor.ticks) == 1
        app.rendering.render()
        assert app.simulation.get_num_physics_steps() == 1
        assert app.timeline.current_time == Fraction(2, 60)
        assert len(sensor.ticks) == 2  # what is there now, although the physics clock did not move
        assert app.settings.get(keys.PLAY_SIMULATIONS) is True


def test_render_restores_physics_also_when_it_fails():
    with App() as app:
        app.on("end", lambda: 1 / 0)
        with pytest.raises(ZeroDivisionError):
            app.rendering.render()
        assert app.settings.get(keys.PLAY_SIMULATIONS) is True


def test_new_frame_callbacks_by_order_and_id():
    with App() as app:
        add(app, NotingLidar(30))
        heard = []
        first = app.rendering.register_callback(NEW_FRAME, callback=lambda event: heard.append("first"))
        app.rendering.register_callback(
            NEW_FRAME, callback=lambda event: heard.append([p.path for p in event.products]), order=-1
        )
        app.play()
        app.update(2)
        assert heard == [["/Render/sensor"], "first"]
        app.rendering.deregister_callback(first)
        app.rendering.deregister_callback(99)
        assert [warning.code for warning in app.warnings] == ["unknown-callback"]
        assert app.rendering.register_callback(NEW_FRAME, callback=print) == 2
        with pytest.raises(ValueError, match="no rendering event"):
            app.rendering.register_callback("other", callback=print)


def test_bound_methods_are_held_weakly():
    class Listener:
        heard = 0

        def listen(self, event):
            Listener.heard += 1

    with App() as app:
        add(app, NotingLidar(60))
        listener = Listener()
        app.rendering.register_callback(NEW_FRAME, callback=listener.listen)
        app.play()
        app.update()
        del listener
        app.update()
        assert Listener.heard == 1


def test_writers_get_each_new_frame_before_the_graphs():
    with App() as app:
        product = add(app, NotingLidar(30)).product
        seen = []
        app.on("post_render_graphs", lambda: seen.append("graphs"))
        product.writers.append(lambda frame: seen.append(frame.end))
        app.play()
        app.update(4)
        assert seen == [Fraction(1, 30), "graphs", Fraction(2, 30), "graphs"]


def test_the_moment_of_a_product_is_the_start_of_the_update_that_makes_it():
    with App() as app:
        app.play()
        app.update(5)
        moments = []
        app.on("simulation_graphs", lambda: moments.append(app.rendering.moment))
        app.update()
        assert moments == [Fraction(5, 60)]
        assert app.rendering.moment == Fraction(6, 60)


def test_stop_restores_the_stage():
    with App() as app:
        app.stage.DefinePrim("/World/Before", "Xform")
        before = app.stage.GetRootLayer().ExportToString()
        app.play()
        app.stage.DefinePrim("/World/During", "Xform")
        app.update(3)
        app.stop()
        assert app.stage.GetRootLayer().ExportToString() == before


def test_stop_then_play_repeats_the_first_run():
    with App(physics_hz=240) as app:
        sensor = add(app, NotingLidar(7))
        runs = []
        for played in range(3):
            app.play()
            app.update(60)
            runs.append([(tick.index, tick.time) for tick in sensor.ticks])
            sensor.ticks.clear()
            app.stop()
            assert sensor.resets == played + 1
        assert runs[0] == runs[1] == runs[2]
        assert len(runs[0]) == 7


def test_stop_from_inside_an_update():
    with App(physics_hz=240) as app:
        app.on("physics_post_step", lambda: app.simulation.get_num_physics_steps() == 2 and app.stop())
        app.play()
        app.update()
        assert app.simulation.get_num_physics_steps() == 0
        assert app.simulation.get_sample_count() == 0
        assert app.timeline.is_stopped()


def test_a_play_that_a_subscriber_refuses_leaves_the_world_stopped():
    with App() as app:
        before = app.stage.GetRootLayer().ExportToString()

        def refuse():
            app.stage.DefinePrim("/World/Half", "Xform")
            raise UserError("no")

        end = app.on("play", refuse)
        with pytest.raises(UserError, match="no"):
            app.play()
        assert app.timeline.is_stopped()
        assert app.stage.GetRootLayer().ExportToString() == before
        end()
        app.play()
        app.update()
        assert app.simulation.get_num_physics_steps() == 1


def test_events_see_the_world_they_announce():
    with App() as app:
        seen = []
        app.on("play", lambda: seen.append(("play", app.simulation.is_simulating())))
        app.on("stop", lambda: seen.append(("stop", app.simulation.time)))
        app.play()
        app.update()
        app.stop()
        assert seen == [("play", True), ("stop", 0)]


def test_the_most_recently_entered_app_is_the_current_one():
    with App() as outer:
        assert App.current() is outer
        with App() as inner:
            assert App.current() is inner
        assert App.current() is outer
    with pytest.raises(UserError, match="no current App"):
        App.current()


def test_two_apps_do_not_disturb_each_other():
    with App(physics_hz=240) as one, App(loop_hz=30) as two:
        one.play()
        two.play()
        for _ in range(10):
            one.update()
            two.update()
        assert (one.simulation.time, two.simulation.time) == (Fraction(1, 6), Fraction(1, 3))
        one.stop()
        assert two.simulation.time == Fraction(1, 3)


def test_close_stops_tells_and_closes_sinks_once():
    told = []

    class Sink(MemorySink):
        def close(self):
            told.append("sink")

    app = App()
    app.bus.subscribe(Sink())
    app.on("stop", lambda: told.append("stop"))
    app.on("close", lambda: told.append("close"))
    app.play()
    app.close()
    app.close()
    assert told == ["stop", "close", "sink"]
    with pytest.raises(RunError, match="closed"):
        app.update()


def test_sinks_close_also_when_a_subscriber_fails():
    closed = []

    class Sink(MemorySink):
        def close(self):
            closed.append(True)

    app = App()
    app.bus.subscribe(Sink())
    app.on("close", lambda: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        app.close()
    assert closed == [True]


def test_an_error_in_the_body_closes_the_app_and_passes():
    closed = []
    with pytest.raises(RunError, match="boom"), App() as app:  # noqa: PT012
        app.on("close", lambda: closed.append(True))
        raise RunError("boom")
    assert closed == [True]


def test_a_failing_update_is_not_counted_and_the_next_one_runs():
    with App() as app:
        app.play()
        failing = app.on("simulation_graphs", lambda: 1 / 0)
        with pytest.raises(ZeroDivisionError):
            app.update()
        failing()
        assert app.update_index == 0
        app.update()
        assert (app.update_index, app.simulation.get_num_physics_steps()) == (1, 2)


def test_timing_has_its_four_buckets():
    with App() as app:
        app.play()
        app.on("simulation_graphs", lambda: app.bus.publish("/a", "b/msg/C", None, 1))
        app.bus.subscribe(MemorySink())
        app.update(5)
        assert set(app.timing) == {"physics", "render", "graph", "io"}
        assert all(seconds > 0 for seconds in app.timing.values())


def test_time_samples_answer_by_reference_time():
    with App() as app:
        app.play()
        app.update(2)
        simulation = app.simulation
        assert simulation.get_sample_count() == 2
        assert simulation.get_simulation_time_at_time((1, 60)) == 1 / 60
        assert simulation.get_simulation_time_monotonic_at_time(Fraction(1, 40)) == 0.025
        assert simulation.get_simulation_time_at_time((0, 0)) == 2 / 60
        assert not list(app.warnings)
        assert simulation.get_simulation_time_at_time((5, 1)) == 2 / 60
        assert [warning.code for warning in app.warnings] == ["time-sample-missing"]


rates = st.fractions(min_value=Fraction(1, 2), max_value=500, max_denominator=1001)


@given(physics=rates, loop=rates, sensor=rates, updates=st.integers(1, 80))
@settings(max_examples=40, deadline=None)
def test_any_rates_give_the_closed_form_through_the_whole_app(physics, loop, sensor, updates):
    with App(physics_hz=physics, loop_hz=loop) as app:
        noting = add(app, NotingLidar(sensor))
        app.play()
        app.update(updates)
        steps = [updates_done * physics // loop for updates_done in range(updates + 1)]
        times = [step / physics for step in steps]
        newest = [time * sensor // 1 for time in times]
        assert app.simulation.get_num_physics_steps() == steps[-1]
        assert app.external_time == times[-1]
        assert app.timeline.current_time == updates / loop
        assert [(tick.index, tick.time) for tick in noting.ticks] == [
            (after, time) for before, after, time in zip(newest, newest[1:], times[1:], strict=False) if after > before
        ]
        assert noting.product.due == newest[-1]
