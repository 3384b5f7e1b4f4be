"""The settings that clocks and rendering read, and the traps they set: a test for each row."""

from __future__ import annotations

from fractions import Fraction

import pytest

from graph.base.errors import UserError
from graph.sim import App
from graph.sim import settings as keys

PRODUCT = "isaacsim-6.0.1"

DEFAULTS = {
    # path: value in base, full and zero_delay of the documented profile, then what differs in the product's
    keys.RATE_LIMIT_ENABLED: ((False, True, False), {}),
    keys.RATE_LIMIT_FREQUENCY: ((60, 60, 60), {"base": 120, "full": 120, "zero_delay": 120}),
    keys.MANUAL_MODE: ((True, False, True), {}),
    keys.FIXED_STEPPING: ((False, True, False), {}),
    keys.FAST_MODE: ((False, False, False), {}),
    keys.TARGET_FRAMERATE: ((60, 60, 60), {}),
    keys.TICKS_PER_FRAME: ((1, 1, 1), {}),
    keys.PLAY_DELAY: ((0.0, 0.0, 0.0), {}),
    keys.PLAY_SIMULATIONS: ((True, True, True), {}),
    keys.TIME_CODES_PER_SECOND: ((60, 60, 60), {}),
    keys.MIN_FRAME_RATE: ((0, 0, 0), {"base": 30, "full": 30, "zero_delay": 30}),
    keys.MULTI_TICK: ((True, True, True), {}),
    keys.SENSOR_TICK_TLAS: ((True, True, True), {}),
    "/app/hydraEngine/waitIdle": ((False, False, True), {}),
    keys.RENDER_COMPLETE_ORDER: ((-100, -100, 1000), {}),
    "/app/settings/fabricDefaultSimPeriodNumerator": ((1, 1, 1), {}),
    "/app/settings/fabricDefaultSimPeriodDenominator": ((30, 30, 30), {}),
    "/app/settings/fabricDefaultStageFrameHistoryCount": ((3, 3, 3), {}),
    "/persistent/physics/resetOnStop": ((True, True, True), {}),
    "/exts/isaacsim.core.simulation_manager/default_engine": (("mujoco",) * 3, {}),
}


@pytest.mark.parametrize(("path", "values", "product"), [(k, *v) for k, v in DEFAULTS.items()], ids=DEFAULTS.keys())
def test_default_of(path, values, product):
    for experience, value in zip(("base", "full", "zero_delay"), values, strict=True):
        with App(experience=experience) as app:
            assert app.settings.get(path) == value
        with App(experience=experience, parity=PRODUCT) as app:
            assert app.settings.get(path) == product.get(experience, value)


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        (keys.TICKS_PER_FRAME, 0, "must be 1 or more"),
        (keys.TICKS_PER_FRAME, 1.5, "whole number"),
        (keys.PLAY_DELAY, -1, "must be 0 or greater"),
        (keys.WARM_UP_STEPS, -1, "whole number, 0 or more"),
        (keys.BARE_LIDAR_TICK_RATE, -10, "must be 0 or greater"),
        (keys.MIN_FRAME_RATE, "many", "not a number"),
        (keys.FRAMES_LATER, "perhaps", "neither true nor false"),
    ],
)
def test_a_value_that_cannot_be(path, value, message):
    with pytest.raises(UserError, match=message):
        App(settings={path: value})


def test_set_ticks_per_frame_is_the_setting_timeline_subsample_rate():
    with App() as app:
        app.timeline.set_ticks_per_frame(4)
        assert app.settings.get(keys.TICKS_PER_FRAME) == app.timeline.get_ticks_per_frame() == 4
        with pytest.raises(ValueError, match="1 or more"):
            app.timeline.set_ticks_per_frame(0)


def test_set_play_every_frame_and_set_target_framerate_are_settings():
    with App() as app:
        app.timeline.set_play_every_frame(True)
        app.timeline.set_target_framerate(100)
        assert app.settings.get(keys.FAST_MODE) is True
        assert app.settings.get(keys.TARGET_FRAMERATE) == 100


# -- traps ---------------------------------------------------------------------------------------------------------


def test_trap_1_simulation_time_leads_the_timeline_by_the_warm_up_for_good():
    with App(parity=PRODUCT) as app:
        app.play()
        app.update(500)
        assert app.simulation.time - app.timeline.current_time == Fraction(2, 60)


def test_trap_2_set_dt_and_setup_simulation_leave_the_cap_alone():
    with App(parity=PRODUCT) as app:
        app.rendering.set_dt(0.1)
        app.simulation.setup_simulation(dt=1 / 120)
        assert app.settings.get(keys.MIN_FRAME_RATE) == 30


def test_trap_4_only_monotonic_time_survives_a_new_rate():
    with App() as app:
        app.play()
        app.update(60)
        app.simulation.setup_simulation(dt=1 / 30)
        app.simulation.step()
        assert app.simulation.time == Fraction(61, 30)
        assert app.simulation.monotonic_time == 1 + Fraction(1, 30)


@pytest.mark.parametrize("parity", ["documented", PRODUCT])
def test_trap_5_render_moves_the_timeline_alone_step_physics_alone_and_clears_the_carry(parity):
    with App(physics_hz=90, parity=parity, settings={keys.WARM_UP_STEPS: 0}) as app:
        app.play()
        app.update()
        app.rendering.render()
        assert (app.timeline.current_time, app.simulation.get_num_physics_steps()) == (Fraction(2, 60), 1)
        assert app.simulation.carry == Fraction(1, 180)
        app.simulation.step()
        assert (app.timeline.current_time, app.simulation.get_num_physics_steps()) == (Fraction(2, 60), 2)
        assert app.simulation.carry == 0


def test_trap_6_a_looping_timeline_wraps_and_simulation_time_does_not():
    with App() as app:
        app.timeline.set_end_time(Fraction(1, 2))
        app.play()
        app.update(60)
        assert (app.timeline.current_time, app.simulation.time) == (Fraction(1, 2), 1)
        app.update()
        assert (app.timeline.current_time, app.simulation.time) == (Fraction(1, 60), Fraction(61, 60))


def test_trap_8_paused_is_still_simulating():
    with App() as app:
        app.play()
        app.pause()
        assert app.simulation.is_simulating()
        assert app.simulation.is_paused()


def test_trap_13_the_rate_limit_on_with_stock_settings():
    with App(parity=PRODUCT, settings={keys.RATE_LIMIT_ENABLED: True}) as app:
        assert app.rendering.get_dt() == 1 / 120
        assert app.timeline.get_time_codes_per_second() == 60


def test_trap_14_zero_delay_sets_the_order_of_completion_only():
    with App(parity=PRODUCT, experience="zero_delay") as app:
        assert app.settings.get(keys.RENDER_COMPLETE_ORDER) == 1000
        assert app.rendering.get_dt() == 1 / 60 == app.simulation.get_physics_dt()


def test_trap_15_the_manual_mode_setting_lags_one_update_the_setter_does_not():
    with App(loop_hz=40, settings={keys.RATE_LIMIT_FREQUENCY: 100}) as app:
        seen = []
        app.on("end", lambda: seen.append(app.run_loop.dt))
        app.update()
        app.settings.set(keys.MANUAL_MODE, False)
        app.update(2)
        assert seen == [Fraction(1, 40), Fraction(1, 40), Fraction(1, 100)]
        app.run_loop.manual_mode = True
        app.update()
        assert seen[-1] == Fraction(1, 40)


def test_the_step_size_is_independent_of_the_mode():
    with App(settings={keys.MANUAL_MODE: False, keys.RATE_LIMIT_FREQUENCY: 100}) as app:
        app.run_loop.manual_step = Fraction(1, 7)
        app.update()
        assert app.run_loop.dt == Fraction(1, 100)
        app.run_loop.manual_mode = True
        app.update()
        assert app.run_loop.dt == Fraction(1, 7)
