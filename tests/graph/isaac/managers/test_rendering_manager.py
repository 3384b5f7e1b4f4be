"""RenderingManager, row by row: set_dt, get_dt, render, callbacks."""

from __future__ import annotations

import asyncio
import gc
from fractions import Fraction

import pytest

from graph.isaac.managers.rendering import NEW_FRAME
from graph.sim import App, RenderingEvent
from graph.sim import settings as keys
from tests.support.listeners import Listener
from tests.support.noting_sensor import NotingLidar, NotingSensor, add

PRODUCT = "isaacsim-6.0.1"


# -- set_dt and get_dt ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("dt", [0, -1 / 60, float("nan")])
def test_set_dt_value_error_if_dt_is_not_above_0(dt):
    with App() as app, pytest.raises(ValueError, match=r"dt|finite"):
        app.rendering.set_dt(dt)


def test_set_dt_sets_time_codes_manual_mode_and_the_fabric_period():
    with App() as app:
        app.rendering.set_dt(1 / 30)
        assert app.stage.GetTimeCodesPerSecond() == 30
        assert app.timeline.get_time_codes_per_second() == 30
        assert (app.loop.get_manual_mode(), app.loop.get_manual_step_size()) == (True, 1 / 30)
        period = [
            app.settings.get(f"/app/settings/fabricDefaultSimPeriod{part}") for part in ("Numerator", "Denominator")
        ]
        assert period == [1, 30]


def test_set_dt_sets_the_rate_limit_always_in_documented():
    with App() as app:
        app.rendering.set_dt(1 / 30)
        assert app.settings.get(keys.RATE_LIMIT_FREQUENCY) == 30
        assert app.timeline.get_target_framerate() == 30
        assert app.settings.get(keys.RATE_LIMIT_ENABLED) is False


@pytest.mark.parametrize(("limited", "frequency"), [(False, 120), (True, 30)])
def test_set_dt_sets_the_rate_limit_only_if_enabled_in_the_product(limited, frequency):
    with App(parity=PRODUCT, settings={keys.RATE_LIMIT_ENABLED: limited}) as app:
        app.rendering.set_dt(1 / 30)
        assert app.settings.get(keys.RATE_LIMIT_FREQUENCY) == frequency


@pytest.mark.parametrize("parity", ["documented", PRODUCT])
def test_set_dt_does_not_touch_the_physics_rate_or_min_frame_rate(parity):
    """Traps 2 and 16: nothing of ours moves the catch-up cap."""
    with App(physics_hz=100, parity=parity) as app:
        before = app.settings.get(keys.MIN_FRAME_RATE)
        app.rendering.set_dt(1 / 24)
        app.simulation.setup_simulation(dt=1 / 50)
        assert app.settings.get(keys.MIN_FRAME_RATE) == before
        app.rendering.set_dt(1 / 60)
        assert app.simulation.steps_per_second == 50


def test_get_dt_first_match_rate_limit_then_manual_step_then_rate_limit():
    with App(settings={keys.RATE_LIMIT_FREQUENCY: 50}) as app:
        app.loop.set_manual_step_size(1 / 40)
        assert app.rendering.get_dt() == 1 / 40
        app.loop.set_manual_mode(False)
        assert app.rendering.get_dt() == 1 / 50
        app.loop.set_manual_mode(True)
        app.settings.set(keys.RATE_LIMIT_ENABLED, True)
        assert app.rendering.get_dt() == 1 / 50


@pytest.mark.parametrize(("limited", "dt"), [(False, 1 / 60), (True, 1 / 120)])
def test_trap_13_stock_values_of_get_dt_in_the_product(limited, dt):
    with App(parity=PRODUCT, settings={keys.RATE_LIMIT_ENABLED: limited}) as app:
        assert app.rendering.get_dt() == dt
        assert app.timeline.get_time_codes_per_second() == 60


def test_trap_13_is_gone_in_documented():
    with App(settings={keys.RATE_LIMIT_ENABLED: True}) as app:
        assert app.rendering.get_dt() == 1 / 60


# -- render --------------------------------------------------------------------------------------------------------


def test_render_without_physics_leaves_the_external_time_at_0():
    with App() as app:
        app.rendering.render()
        assert app.fabric.get("/ExternalSimulationTime", "omni:time") == 0.0
        assert app.external_time == 0
        assert app.update_index == 1


def test_trap_5_render_moves_the_timeline_by_ldt_and_runs_no_physics_step():
    with App() as app:
        app.play()
        app.update(3)
        app.rendering.render()
        assert app.simulation.get_num_physics_steps() == 3
        assert app.timeline.current_time == Fraction(4, 60)
        assert app.settings.get(keys.PLAY_SIMULATIONS) is True
        app.update()  # the lead is for good
        assert app.timeline.current_time - app.simulation.time == Fraction(1, 60)


def test_trap_5_step_moves_physics_and_not_the_timeline_and_clears_the_carry():
    with App(physics_hz=100) as app:
        app.play()
        app.update()
        assert app.simulation.carry == Fraction(1, 150)
        app.simulation.step(steps=2)
        assert (app.simulation.get_num_physics_steps(), app.simulation.carry) == (3, 0)
        assert app.timeline.current_time == Fraction(1, 60)


def test_render_leaves_play_simulations_false_if_it_was():
    with App(settings={keys.PLAY_SIMULATIONS: False}) as app:
        app.rendering.render()
        assert app.settings.get(keys.PLAY_SIMULATIONS) is False


def test_render_that_raises_puts_play_simulations_back():
    with App() as app:
        end = app.on("end", lambda: 1 / 0)
        with pytest.raises(ZeroDivisionError):
            app.rendering.render()
        end()
        assert app.settings.get(keys.PLAY_SIMULATIONS) is True


@pytest.mark.parametrize("parity", ["documented", PRODUCT])
def test_render_on_a_frozen_clock_renders_autotrigger_sensors(parity):
    with App(parity=parity) as app:
        idle, ticking = add(app, NotingSensor(), "idle"), add(app, NotingLidar(60), "ticking")
        app.play()
        app.update()
        before = len(idle.ticks), len(ticking.ticks)
        app.rendering.render()
        assert (len(idle.ticks) - before[0], len(ticking.ticks) - before[1]) == (1, 0)
        app.settings.set(keys.PLAY_SIMULATIONS, False)
        app.update()  # no step, and nobody asked for pictures: only the product renders
        assert len(idle.ticks) - before[0] == (2 if parity == PRODUCT else 1)


@pytest.mark.parametrize("parity", ["documented", PRODUCT])
def test_render_shows_a_wall_where_it_is_now(parity):
    """A wall 4 m ahead of an autotrigger camera is moved to 3 m without a physics step."""
    from pxr import UsdGeom

    from sensors.replicator import get_annotator, render_product

    with App(parity=parity, settings={keys.FRAMES_LATER: False}) as app:
        UsdGeom.Camera.Define(app.stage, "/World/Camera")
        wall = UsdGeom.Cube.Define(app.stage, "/World/Wall")
        place = wall.AddTranslateOp()
        place.Set((0, 0, -5))
        depth = get_annotator("distance_to_image_plane", app=app).attach(render_product(app, "/World/Camera", (4, 4)))
        app.play()
        app.update()
        assert depth.get_data()[2, 2] == pytest.approx(4.0)
        place.Set((0, 0, -4))
        app.rendering.render()
        assert depth.get_data()[2, 2] == pytest.approx(3.0)


def test_render_async_is_one_update_too():
    async def render():
        await app.rendering.render_async()

    with App() as app:
        app.play()
        asyncio.run(render())
        assert (app.update_index, app.simulation.get_num_physics_steps()) == (1, 0)
        assert app.settings.get(keys.PLAY_SIMULATIONS) is True


# -- callbacks -----------------------------------------------------------------------------------------------------


def test_register_callback_new_frame_by_order_then_registration():
    with App() as app:
        add(app, NotingSensor())
        heard = []
        for name, order in (("b", 0), ("late", 1), ("c", 0), ("early", -1)):
            app.rendering.register_callback(
                RenderingEvent.NEW_FRAME, callback=lambda event, name=name: heard.append(name), order=order
            )
        app.play()
        app.update()
        assert heard == ["early", "b", "c", "late"]


def test_new_frame_comes_before_the_writers_and_names_the_products():
    with App() as app:
        product = add(app, NotingSensor()).product
        heard = []
        product.writers.append(lambda frame: heard.append("writer"))
        app.rendering.register_callback(NEW_FRAME, callback=lambda event: heard.append(event))
        app.play()
        app.update()
        event, writer = heard
        assert (event.event_name, event.products, event["products"], event.get("x", 1)) == (
            "isaacsim.rendering.new_frame",
            (product,),
            (product,),
            1,
        )
        assert writer == "writer"


def test_new_frame_is_not_one_to_one_with_updates():
    with App() as app:
        add(app, NotingLidar(20))
        heard = []
        app.rendering.register_callback(NEW_FRAME, callback=lambda event: heard.append(app.update_index))
        app.play()
        app.update(9)
        assert heard == [2, 5, 8]


def test_rendering_ids_count_up_from_0_and_are_never_reused():
    with App() as app:
        uids = [app.rendering.register_callback(NEW_FRAME, callback=print) for _ in range(2)]
        app.rendering.deregister_callback(1)
        uids.append(app.rendering.register_callback(NEW_FRAME, callback=print))
        app.rendering.deregister_all_callbacks()
        uids.append(app.rendering.register_callback(NEW_FRAME, callback=print))
        assert uids == [0, 1, 2, 3]


def test_rendering_deregister_warns_on_an_unknown_id():
    with App() as app:
        assert app.rendering.deregister_callback(7) is None
        assert "unknown-callback" in app.warnings.codes()


def test_register_callback_value_error_for_another_event():
    with App() as app, pytest.raises(ValueError, match=r"isaacsim\.rendering\.new_frame"):
        app.rendering.register_callback("isaacsim.rendering.other", callback=print)


def test_trap_10_the_rendering_manager_takes_event_then_callback():
    with App() as app:
        for call in (
            lambda: app.rendering.register_callback(print, NEW_FRAME),
            lambda: app.rendering.register_callback(NEW_FRAME, print),
        ):
            with pytest.raises(ValueError, match=r"register_callback\(event, callback=function\)"):
                call()
        with pytest.raises(ValueError, match="give callback=function"):
            app.rendering.register_callback(NEW_FRAME)


def test_trap_11_bound_methods_are_weak_and_end_with_their_object():
    with App() as app:
        add(app, NotingSensor())
        listener = Listener()
        heard = listener.heard
        app.rendering.register_callback(NEW_FRAME, callback=listener.listen)
        app.play()
        app.update()
        del listener
        gc.collect()
        app.update()
        assert len(heard) == 1
        assert "callback-dropped" not in app.warnings.codes()


def test_trap_11_a_callback_that_goes_before_it_was_ever_called_is_reported():
    with App() as app:
        app.rendering.register_callback(NEW_FRAME, callback=Listener().listen)
        gc.collect()
        assert "callback-dropped" in app.warnings.codes()


def test_a_callback_may_deregister_itself_and_others_while_it_runs():
    with App() as app:
        add(app, NotingSensor())
        heard = []

        def once(event):
            heard.append("once")
            app.rendering.deregister_callback(uid)

        uid = app.rendering.register_callback(NEW_FRAME, callback=once)
        app.rendering.register_callback(NEW_FRAME, callback=lambda event: heard.append("other"))
        app.play()
        app.update(2)
        assert heard == ["once", "other", "other"]
