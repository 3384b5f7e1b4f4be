"""What moves an App from outside: committed states, awaited updates, the orchestrator, the loop runner."""

from __future__ import annotations

import asyncio
from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from graph.base.errors import RunError, UserError
from graph.sim import App, SimulationEvent, VirtualClock, app_utils
from graph.sim import settings as keys
from tests.support.noting_sensor import NotingLidar, NotingSensor, add

PRODUCT = "isaacsim-6.0.1"
MANUAL = "/app/runLoops/main/manualModeEnabled"


def hear(app):
    heard = []
    for event in SimulationEvent:
        if event.name.startswith("SIMULATION"):
            app.simulation.register_callback(lambda event: heard.append(event.event_name.rpartition(".")[2]), event)
    return heard


# -- play, pause, stop and their commit ----------------------------------------------------------------------------


def test_commit_true_applies_now_with_callbacks():
    with App(parity=PRODUCT) as app:
        heard = hear(app)
        app.play(commit=True)
        assert (app.timeline.is_playing(), app.simulation.get_num_physics_steps()) == (True, 2)
        assert heard == ["simulation_setup", "started"]


def test_commit_none_applies_now_without_events_and_warm_up():
    with App(parity=PRODUCT) as app:
        heard = hear(app)
        app.play(commit=None)
        assert (app.timeline.is_playing(), app.simulation.get_num_physics_steps(), heard) == (True, 0, [])
        app.update()
        assert app.simulation.get_num_physics_steps() == 1
        app.pause(commit=None)
        app.stop(commit=None)
        assert (heard, app.timeline.is_stopped(), app.simulation.is_simulating()) == ([], True, False)


def test_commit_false_waits_for_the_next_update():
    with App() as app:
        app.play(commit=False)
        assert app.timeline.is_stopped()
        app.update()
        assert app.timeline.is_playing()
        assert app.simulation.get_num_physics_steps() == 1
        app.pause(commit=False)
        assert app.timeline.is_playing()
        app.update()
        app.stop(commit=False)
        assert app.timeline.is_paused()
        app.update()
        assert app.timeline.is_stopped()


def test_trap_1_play_and_one_update_at_60_60():
    """Two warm-up steps and the first update's: step count 3, time 3/60; none of it in `documented`."""
    counts = {}
    for parity in ("documented", PRODUCT):
        for commit in (True, False):
            with App(parity=parity) as app:
                app.play(commit=commit)
                app.update()
                counts[parity, commit] = app.simulation.get_num_physics_steps()
    assert counts == {("documented", True): 1, ("documented", False): 1, (PRODUCT, True): 3, (PRODUCT, False): 3}


def test_is_paused_is_neither_playing_nor_stopped():
    with App() as app:
        states = []
        for change in (lambda: None, app.play, app.pause, app.stop):
            change()
            states.append((app_utils.is_playing(), app_utils.is_paused(), app_utils.is_stopped()))
        assert states == [(False, False, True), (True, False, False), (False, True, False), (False, False, True)]


# -- updates -------------------------------------------------------------------------------------------------------


def test_update_app_callback_i_and_steps_false_stops():
    with App() as app:
        calls = []
        app.update_app(steps=5, callback=lambda i, steps: calls.append((i, steps)) or i < 2)
        assert (calls, app.update_index) == ([(1, 5), (2, 5)], 2)


def test_update_app_async_callback_i_and_steps_false_stops():
    with App() as app:
        calls = []
        asyncio.run(app.update_app_async(steps=5, callback=lambda i, steps: calls.append((i, steps)) or i < 2))
        assert (calls, app.update_index) == ([(1, 5), (2, 5)], 2)


def test_a_run_that_is_asked_to_end_is_updated_no_more():
    with App() as app:
        app.on("end", lambda: setattr(app, "exit_requested", app.update_index == 2))
        app.update_app(steps=9)
        assert app.update_index == 3
    with App() as app:
        app.on("end", lambda: setattr(app, "exit_requested", app.update_index == 2))
        asyncio.run(app.update_app_async(steps=9))
        assert app.update_index == 3


def test_next_update_async_gives_the_loops_dt():
    with App(loop_hz=50) as app:
        assert asyncio.run(app.next_update_async()) == 1 / 50


def test_all_who_wait_resume_after_the_same_update_in_their_order():
    with App() as app:
        log = []

        async def wait(name, times):
            for _ in range(times):
                await app.next_update_async()
                log.append((name, app.update_index))

        async def both():
            await asyncio.gather(wait("a", 3), wait("b", 2))

        asyncio.run(both())
        assert log == [("a", 1), ("b", 1), ("a", 2), ("b", 2), ("a", 3)]


def test_a_plain_update_resumes_those_who_wait_and_no_other_follows():
    with App() as app:

        async def main():
            waiting = asyncio.create_task(app.next_update_async())
            await asyncio.sleep(0)
            app.update()
            await waiting
            await asyncio.sleep(0)
            return app.update_index

        assert asyncio.run(main()) == 1


def test_what_an_awaited_update_raises_reaches_who_waits():
    with App() as app:
        end = app.on("end", lambda: 1 / 0)

        async def main():
            return await asyncio.gather(app.next_update_async(), app.next_update_async(), return_exceptions=True)

        assert [type(each) for each in asyncio.run(main())] == [ZeroDivisionError, ZeroDivisionError]
        end()
        assert asyncio.run(app.next_update_async()) == 1 / 60


def test_who_gave_up_waiting_runs_no_update():
    with App() as app:

        async def main():
            waiting = asyncio.create_task(app.next_update_async())
            await asyncio.sleep(0)
            waiting.cancel()
            await asyncio.sleep(0)
            await asyncio.sleep(0)
            return app.update_index

        assert asyncio.run(main()) == 0
        asyncio.run(app.next_update_async())
        assert app.update_index == 1


def test_an_event_loop_that_ended_midway_leaves_nothing_behind():
    with App() as app:

        async def leaves():
            asyncio.create_task(app.next_update_async())  # noqa: RUF006
            await asyncio.sleep(0)

        asyncio.run(leaves())
        asyncio.run(app.update_app_async(steps=2))
        assert app.update_index in (2, 3)


def test_a_closed_app_says_so_to_who_waits():
    with App() as app:
        pass
    with pytest.raises(RunError, match="closed"):
        asyncio.run(app.next_update_async())


def test_app_utils_act_on_the_current_app():
    with App(), App() as app:
        app_utils.play()
        app_utils.update_app(steps=2)
        asyncio.run(app_utils.update_app_async(steps=3))
        asyncio.run(app_utils.next_update_async())
        app_utils.pause()
        assert (app.update_index, app.timeline.current_time) == (6, Fraction(1, 10))
        app_utils.stop()
        assert app.timeline.is_stopped()


def test_two_apps_in_one_event_loop_do_not_touch_each_other():
    with App(loop_hz=50) as first, App() as second:
        first.play()
        second.play()

        async def main():
            await asyncio.gather(first.update_app_async(steps=5), second.update_app_async(steps=3))

        asyncio.run(main())
        assert (first.update_index, second.update_index) == (5, 3)
        assert (first.timeline.current_time, second.timeline.current_time) == (Fraction(1, 10), Fraction(1, 20))


async def _steps_async(app, count):
    for _ in range(count):
        await app.orchestrator.step_async(pause_timeline=False)


def _steps(app, count):
    for _ in range(count):
        app.orchestrator.step()
    app.play()


ONE_OF_MANY = (
    lambda app, count: app.update(count),
    lambda app, count: app.update_app(steps=count),
    lambda app, count: asyncio.run(app.update_app_async(steps=count)),
    lambda app, count: asyncio.run(_steps_async(app, count)),
    _steps,
)


@given(st.lists(st.tuples(st.integers(0, len(ONE_OF_MANY) - 1), st.integers(1, 4)), max_size=6), st.integers(1, 400))
@settings(max_examples=40, deadline=None)
def test_any_mixture_of_drivers_gives_the_stamps_of_plain_updates(mixture, physics_hz):
    def stamps(run):
        with App(physics_hz=physics_hz) as app:
            product = add(app, NotingSensor()).product
            out = []
            product.writers.append(lambda frame: out.append(frame.end))
            app.play()
            run(app)
            return out, app.simulation.time, app.timeline.current_time, app.update_index, app.loop_time

    def mixed(app):
        for driver, count in mixture:
            ONE_OF_MANY[driver](app, count)

    total = sum(count for _, count in mixture)
    assert stamps(mixed) == stamps(lambda app: app.update(total))


# -- the orchestrator ----------------------------------------------------------------------------------------------


def test_step_plays_runs_one_update_and_pauses():
    with App() as app:
        for steps in (1, 2, 3):
            app.orchestrator.step()
            assert (app.timeline.is_paused(), app.simulation.get_num_physics_steps()) == (True, steps)
        app.orchestrator.step(pause_timeline=False)
        assert app.timeline.is_playing()


def test_step_delta_time_is_the_dt_of_this_one_update():
    with App(physics_hz=100) as app:
        app.orchestrator.step(delta_time=0.25)
        assert (app.timeline.current_time, app.simulation.time) == (Fraction(1, 4), Fraction(1, 4))
        app.orchestrator.step()
        assert app.timeline.current_time == Fraction(1, 4) + Fraction(1, 60)
        assert app.loop.get_manual_step_size() == 1 / 60


def test_step_delta_time_0_holds_the_timeline():
    with App() as app:
        app.orchestrator.step(delta_time=0.0)
        assert (app.timeline.current_time, app.simulation.time, app.update_index) == (0, 0, 1)
        app.orchestrator.step()
        assert app.simulation.get_num_physics_steps() == 1


@pytest.mark.parametrize("parity", ["documented", PRODUCT])
@pytest.mark.parametrize("settings", [{}, {keys.MULTI_TICK: False}])
def test_step_delta_time_0_captures_the_world_once_with_every_product(parity, settings):
    with App(parity=parity, settings=settings) as app:
        sensors = [
            add(app, NotingSensor(), "camera"),
            add(app, NotingSensor(20), "ticking"),
            add(app, NotingLidar(10), "lidar"),
            add(app, NotingSensor(wants_updates=True), "updated"),
        ]
        off = add(app, NotingSensor(), "off")
        off.product.enabled = False
        written = []
        for sensor in sensors:
            sensor.product.writers.append(lambda frame, sensor=sensor: written.append(sensor))
        for number in (1, 2, 3):
            app.orchestrator.step(delta_time=0)
            assert app.timeline.current_time == 0
            assert (len(written), len(set(written))) == (4 * number, 4)
        assert not off.ticks
        app.orchestrator.step(delta_time=0, pause_timeline=False)
        app.orchestrator.step(delta_time=0)
        assert [len(sensor.ticks) for sensor in sensors] == [5] * 4


def test_step_async_delta_time_0_captures_too():
    with App() as app:
        sensor = add(app, NotingSensor(20))
        asyncio.run(app.orchestrator.step_async(delta_time=0))
        assert (len(sensor.ticks), sensor.product.frames, app.timeline.current_time) == (1, 1, 0)


def test_captures_of_the_held_world_leave_the_schedules_alone():
    """60 updates/s: a sensor of 20 Hz is due at 3, 6, 9, ... updates; each tick of an autotrigger covers one update."""
    with App() as app:
        ticking, each = add(app, NotingSensor(20), "ticking"), add(app, NotingSensor(), "each")
        for _ in range(6):
            app.orchestrator.step()
            app.orchestrator.step(delta_time=0)
        moved = [tick for tick in ticking.ticks if not tick.held]
        assert [(tick.index, tick.time) for tick in moved] == [(1, Fraction(3, 60)), (2, Fraction(6, 60))]
        assert [tick.time for tick in ticking.ticks if tick.held] == [Fraction(number, 60) for number in range(1, 7)]
        moved = [tick for tick in each.ticks if not tick.held]
        assert [(tick.start, tick.end) for tick in moved] == [
            (Fraction(number, 60), Fraction(number + 1, 60)) for number in range(6)
        ]
        assert ticking.product.missed == 0


def test_frames_tell_whether_a_step_rendered_them():
    """In the profile whose frames come one update later, too: a played frame is not taken for that of the next step."""
    for parity in ("documented", PRODUCT):
        with App(parity=parity) as app:
            product = add(app, NotingSensor()).product
            told = []
            product.writers.append(lambda frame, product=product, told=told: told.append(product.stepped))
            app.play()
            app.update(2)
            app.orchestrator.step()
            app.update(2)
            assert told[:3] == [False, False, True]
            assert not any(told[3:])


def test_step_delta_time_in_fixed_stepping_is_reported_to_be_ignored():
    with App(settings={keys.FIXED_STEPPING: True}) as app:
        app.orchestrator.step(delta_time=0.25)
        assert app.timeline.current_time == Fraction(1, 60)
        assert "delta-time-ignored" in app.warnings.codes()


def test_step_subframes_have_nothing_to_converge():
    with App() as app:
        app.orchestrator.step(rt_subframes=8)
        assert app.update_index == 1
        assert "rt-subframes-ignored" in app.warnings.codes()


@pytest.mark.parametrize("options", [{"delta_time": -0.1}, {"rt_subframes": -2}, {"delta_time": float("nan")}])
def test_step_refuses_what_cannot_be(options):
    with App() as app:
        with pytest.raises(ValueError, match=r"delta_time|rt_subframes|finite"):
            app.orchestrator.step(**options)
        assert (app.update_index, app.timeline.is_stopped()) == (0, True)


@pytest.mark.parametrize(("wait", "frames"), [(True, 1), (False, 0)])
def test_wait_for_render_fetches_what_the_product_would_deliver_later(wait, frames):
    with App(parity=PRODUCT) as app:
        product = add(app, NotingSensor()).product
        written = []
        product.writers.append(written.append)
        app.orchestrator.step(wait_for_render=wait)
        assert len(written) == frames
        app.orchestrator.step(wait_for_render=False)
        assert len(written) == 1


def test_step_inside_an_update_is_refused():
    with App() as app:
        app.on("end", app.orchestrator.step)
        with pytest.raises(RunError, match="inside an update"):
            app.update()
        assert app.timeline.is_stopped()


# -- next_render_simulation_async ----------------------------------------------------------------------------------


def test_next_render_simulation_async_takes_one_path_or_many():
    with App() as app:
        add(app, NotingSensor(), "a")
        add(app, NotingSensor(), "b")
        app.play()
        asyncio.run(app.next_render_simulation_async("/Render/a"))
        asyncio.run(app_utils.next_render_simulation_async(["/Render/a", "/Render/b"], 2))
        assert app.update_index == 3


def test_next_render_simulation_async_unknown_product():
    with App() as app:
        add(app, NotingSensor())
        with pytest.raises(UserError, match="there are: /Render/sensor"):
            asyncio.run(app.next_render_simulation_async(["/Render/b"], 1))


def test_next_render_simulation_async_says_when_no_frame_can_come():
    with App() as app:
        product = add(app, NotingSensor()).product
        with pytest.raises(RunError, match=r"app\.play\(\)"):
            asyncio.run(app.next_render_simulation_async([product.path], 1))
        app.play()
        product.enabled = False
        with pytest.raises(RunError, match="is off"):
            asyncio.run(app.next_render_simulation_async([product.path], 1))
        app.rendering.remove(product.path)
        with pytest.raises(UserError, match="none"):
            asyncio.run(app.next_render_simulation_async([product.path], 1))


# -- the loop runner -----------------------------------------------------------------------------------------------


def test_step_size_and_mode_are_independent():
    with App() as app:
        app.loop.set_manual_mode(False)
        app.loop.set_manual_step_size(1 / 30)
        assert (app.loop.get_manual_mode(), app.loop.get_manual_step_size()) == (False, 1 / 30)
        app.loop.set_manual_mode()
        assert (app.loop.get_manual_mode("main"), app.settings.get(MANUAL)) == (True, True)
        app.play()
        app.update()
        assert app.timeline.current_time == Fraction(1, 30)


def test_manual_step_size_default():
    with App() as app:
        app.loop.set_manual_step_size()
        assert app.loop.get_manual_step_size() == 0.01667


@pytest.mark.parametrize("dt", [0, -1, float("nan")])
def test_manual_step_size_must_be_above_0(dt):
    with App() as app, pytest.raises(ValueError, match=r"above 0|finite"):
        app.loop.set_manual_step_size(dt)


def test_a_loop_of_another_name_is_refused():
    with App() as app:
        for call in (
            lambda: app.loop.set_manual_mode(True, "present"),
            lambda: app.loop.get_manual_mode("present"),
            lambda: app.loop.set_manual_step_size(0.1, "present"),
            lambda: app.loop.get_manual_step_size("present"),
        ):
            with pytest.raises(ValueError, match='"main"'):
                call()


def moves(app, updates):
    out = []
    for _ in range(updates):
        before = app.timeline.current_time
        app.update()
        out.append(app.timeline.current_time - before)
    return out


def test_trap_15_the_setter_acts_at_once_the_setting_one_update_later():
    """Manual dt 1/10; measured dt 1/50 of the virtual wall clock, whole microseconds."""
    options = {"settings": {keys.RATE_LIMIT_FREQUENCY: 50}, "wall_clock": VirtualClock()}
    with App(**options) as app:
        app.loop.set_manual_step_size(0.1)
        app.play()
        app.update(2)
        app.settings.set(MANUAL, False)
        assert moves(app, 3) == [Fraction(1, 10), Fraction(1, 50), Fraction(1, 50)]
        app.settings.set(MANUAL, True)
        assert moves(app, 2) == [Fraction(1, 50), Fraction(1, 10)]
        app.loop.set_manual_mode(False)
        assert moves(app, 2) == [Fraction(1, 50), Fraction(1, 50)]
        app.loop.set_manual_mode(True)
        assert moves(app, 1) == [Fraction(1, 10)]


# -- the timeline's calls ------------------------------------------------------------------------------------------


def test_set_auto_update_false_holds_the_timeline_while_playing():
    with App() as app:
        app.play()
        app.timeline.set_auto_update(False)
        app.update(3)
        assert (app.timeline.current_time, app.simulation.time, app.timeline.is_playing()) == (0, 0, True)
        app.timeline.set_auto_update(True)
        app.update()
        assert app.timeline.current_time == Fraction(1, 60)


def test_forward_one_frame_moves_by_one_time_code():
    with App() as app:
        app.timeline.set_time_codes_per_second(24)
        app.timeline.forward_one_frame()
        app.timeline.forward_one_frame()
        assert app.timeline.current_time == Fraction(2, 24)


@pytest.mark.parametrize("looping", [True, False])
def test_the_end_time_wraps_or_stops_the_timeline_alone(looping):
    """Trap 6: a looping timeline wraps while the simulation time goes on."""
    with App() as app:
        app.timeline.set_end_time(0.1)
        app.timeline.set_looping(looping)
        assert (app.timeline.get_end_time(), app.timeline.is_looping()) == (0.1, looping)
        app.play()
        app.update(9)
        if looping:
            assert (app.timeline.current_time, app.simulation.time) == (Fraction(3, 60), Fraction(9, 60))
        else:
            assert app.timeline.is_stopped()


def test_set_ticks_per_frame():
    with App() as app:
        assert app.timeline.get_ticks_per_frame() == 1
        app.timeline.set_ticks_per_frame(3)
        assert app.settings.get(keys.TICKS_PER_FRAME) == 3
        with pytest.raises(ValueError, match="1 or more"):
            app.timeline.set_ticks_per_frame(0)


def test_trap_16_a_direct_step_is_one_physics_step_and_a_render_no_step():
    """What the deprecated `SimulationContext.step(render=False)` and rendering alone did; neither moves the cap."""
    with App(physics_hz=100, loop_hz=60, settings={keys.MIN_FRAME_RATE: 30}) as app:
        app.play()
        app.simulation.step()
        app.rendering.render()
        assert (app.simulation.get_num_physics_steps(), app.settings.get(keys.MIN_FRAME_RATE)) == (1, 30)
