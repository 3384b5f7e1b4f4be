"""The three clocks and one update: a test for each row of the clock, order, accumulator and substep tables."""

from __future__ import annotations

from fractions import Fraction

import pytest

from graph.isaac.managers.rendering import NEW_FRAME
from graph.sim import App
from graph.sim import settings as keys
from tests.support.noting_sensor import NotingSensor, add

PRODUCT = "isaacsim-6.0.1"


def substeps(app, updates):
    counts = []
    for _ in range(updates):
        before = app.simulation.get_num_physics_steps()
        app.update()
        counts.append(app.simulation.get_num_physics_steps() - before)
    return counts


def external_time(app):
    return app.fabric.get("/ExternalSimulationTime", "omni:time")


# -- the three clocks ----------------------------------------------------------------------------------------------


def test_loop_and_timeline_clock_moves_once_per_update_while_playing():
    with App(physics_hz=240, loop_hz=60) as app:
        app.update(3)
        assert app.timeline.get_current_time() == 0
        app.play()
        app.update(3)
        assert app.timeline.current_time == Fraction(3, 60)
        assert app.loop_time == Fraction(6, 60)


def test_physics_clock_is_recomputed_in_each_substep_as_count_over_rate():
    with App(physics_hz=240, loop_hz=60) as app:
        seen = []
        app.on("physics_post_step", lambda: seen.append(app.simulation.get_simulation_time()))
        app.play()
        app.update(100)
        assert seen == [count / 240 for count in range(1, 401)]


def test_renderer_clock_is_overwritten_after_every_substep_and_0_on_stop():
    with App(physics_hz=240, loop_hz=60) as app:
        assert external_time(app) == 0
        seen = []
        app.on("physics_post_step", lambda: seen.append(external_time(app)))
        app.play()
        app.update()
        assert seen == [1 / 240, 2 / 240, 3 / 240, 4 / 240]
        app.stop()
        assert external_time(app) == 0


def test_the_external_time_is_written_with_multi_tick_rendering_off_too():
    with App(settings={keys.MULTI_TICK: False}) as app:
        app.play()
        app.update(2)
        assert external_time(app) == 2 / 60


def test_system_time_is_that_of_the_last_physics_step():
    with App(physics_hz=30, loop_hz=60) as app:
        app.play()
        seen = []
        for _ in range(4):
            app.update()
            seen.append(Fraction(app.simulation.get_system_time()).limit_denominator(10**6))
        # updates begin at 0, 1/60, 2/60, 3/60 of virtual wall time; every second one has a step
        assert seen == [0, Fraction(1, 60), Fraction(1, 60), Fraction(3, 60)]
        app.pause()
        app.update(5)
        assert app.simulation.get_system_time() == 3 / 60


# -- one update, in order ------------------------------------------------------------------------------------------


def watch(app):
    """What happened, in order."""
    seen = []
    for phase in ("timeline_state", "timeline", "physics", "simulation_graphs", "render", "post_render_graphs", "end"):
        app.on(phase, lambda phase=phase: seen.append(phase))
    app.on("play", lambda: seen.append("play"))
    app.rendering.register_callback(NEW_FRAME, callback=lambda event: seen.append("new frame"))
    add(app, NotingSensor())
    return seen


def test_row_minus_100_completed_renders_are_collected_first_where_frames_come_later():
    with App(parity=PRODUCT) as app:
        seen = watch(app)
        app.play()
        app.update()
        seen.clear()
        app.update()
        assert seen[:3] == ["new frame", "post_render_graphs", "timeline_state"]


def test_row_minus_90_an_uncommitted_play_takes_effect_in_the_update_with_its_callbacks():
    with App() as app:
        seen = watch(app)
        app.timeline.play()
        assert not app.timeline.is_playing()
        app.update()
        assert seen[:2] == ["play", "timeline_state"]
        assert app.simulation.get_num_physics_steps() == 1


def test_row_minus_20_the_timeline_advances_before_physics():
    with App() as app:
        seen = []
        app.on("physics", lambda: seen.append((app.timeline.current_time, app.simulation.time)), order=-1)
        app.play()
        app.update()
        assert seen == [(Fraction(1, 60), 0)]


def test_row_minus_10_physics_then_graphs_which_read_the_time_after_the_step():
    with App() as app:
        seen = watch(app)
        app.on("simulation_graphs", lambda: seen.append(app.simulation.time))
        app.play()
        seen.clear()
        app.update()
        assert seen[seen.index("physics") :][:3] == ["physics", "simulation_graphs", Fraction(1, 60)]


def test_row_30_rendering_reads_the_external_time_after_the_graphs():
    with App() as app:
        seen = watch(app)
        app.play()
        seen.clear()
        app.update()
        assert seen == [
            "timeline_state",
            "timeline",
            "physics",
            "simulation_graphs",
            "render",
            "new frame",
            "post_render_graphs",
            "end",
        ]
        assert app.rendering.products["/Render/sensor"].frame.time == Fraction(1, 60)


def test_zero_delay_delivers_an_image_in_the_update_of_its_state():
    for parity in ("documented", PRODUCT):
        with App(parity=parity, experience="zero_delay", physics_hz=60) as app:
            seen = watch(app)
            app.play()
            seen.clear()
            app.update()
            assert seen[-3:] == ["new frame", "post_render_graphs", "end"]


def test_step_bookkeeping_stands_at_order_0_between_the_post_step_subscribers():
    with App() as app:
        seen = []
        app.on("physics_pre_step", lambda: seen.append(("pre", app.simulation.get_num_physics_steps())), order=5)
        for order in (-1, 0, 1):
            app.on("physics_post_step", lambda o=order: seen.append((o, app.simulation.get_num_physics_steps())), order)
        app.play()
        app.update()
        assert seen == [("pre", 0), (-1, 0), (0, 1), (1, 1)]


# -- physics runs only if ------------------------------------------------------------------------------------------


def test_physics_needs_the_timeline_to_play():
    with App() as app:
        app.update(3)
        assert app.simulation.get_num_physics_steps() == 0


def test_time_with_physics_disabled_is_lost_not_banked():
    with App() as app:
        app.play()
        app.settings.set(keys.PLAY_SIMULATIONS, False)
        app.update(10)
        app.settings.set(keys.PLAY_SIMULATIONS, True)
        assert substeps(app, 3) == [1, 1, 1]
        assert app.timeline.current_time == Fraction(13, 60)


# -- the carry -----------------------------------------------------------------------------------------------------


def half_a_step(app):
    """Plays one update that leaves half a step waiting: sps 90 at a loop of 60."""
    app.play()
    app.update()
    assert app.simulation.carry == Fraction(1, 180)
    return app


@pytest.fixture
def app():
    with App(physics_hz=90, loop_hz=60) as app:
        yield half_a_step(app)


def test_carry_at_a_direct_step_is_dropped(app):
    app.simulation.step()
    assert app.simulation.carry == 0
    assert substeps(app, 3) == [1, 2, 1]


def test_carry_at_warm_up_is_dropped():
    with App(physics_hz=90, loop_hz=60, parity=PRODUCT) as app:
        half_a_step(app)
        app.stop()
        app.play()
        assert app.simulation.carry == 0


def test_carry_at_stop_is_dropped(app):
    app.stop()
    assert app.simulation.carry == 0


def test_carry_at_pause_and_resume_is_kept(app):
    app.pause()
    app.update(5)
    app.play()
    assert app.simulation.carry == Fraction(1, 180)
    assert substeps(app, 2) == [2, 1]


def test_carry_at_a_change_of_the_rate_is_kept_and_the_new_step_applies_from_the_next_update(app):
    app.simulation.setup_simulation(dt=Fraction(1, 180))
    assert app.simulation.carry == Fraction(1, 180)
    assert substeps(app, 2) == [4, 3]


def test_carry_in_an_update_with_physics_disabled_is_untouched(app):
    app.settings.set(keys.PLAY_SIMULATIONS, False)
    app.update()
    assert app.simulation.carry == Fraction(1, 180)


# -- the worked substep tables -------------------------------------------------------------------------------------

TABLE = [
    (60, 60, 30, [1] * 12),
    (60, 60, 60, [1] * 12),
    (100, 60, 30, [1, 2, 2] * 4),
    (120, 60, 30, [2] * 12),
    (200, 60, 30, [3, 3, 4] * 4),
    (240, 60, 30, [4] * 12),
    (600, 60, 30, [10] * 12),
    (1000, 60, 30, [16, 17, 17] * 4),
    (90, 60, 30, [1, 2] * 6),
    (50, 60, 30, [0, 1, 1, 1, 1, 1] * 2),
    (30, 60, 30, [0, 1] * 6),
    (60, 120, 30, [0, 1] * 6),
    (60, 240, 30, [0, 0, 0, 1] * 3),
    (60, 600, 30, [0] * 9 + [1, 0, 0]),
    (60, 30, 30, [2] * 12),
    (60, 24, 30, [2] * 12),
    (60, 24, 15, [2, 3] * 6),
    (60, 10, 30, [2] * 12),
    (60, 10, 15, [4] * 12),
    (100, 30, 30, [3] * 12),
    (100, 30, 15, [3, 3, 4] * 4),
    (100, 20, 30, [3] * 12),
    (100, 20, 20, [5] * 12),
    (200, 25, 30, [6] * 12),
]


@pytest.mark.parametrize(
    ("sps", "loop", "min_frame_rate", "expected"),
    TABLE,
    ids=[f"sps-{sps}-loop-{loop}-minFR-{cap}" for sps, loop, cap, _ in TABLE],
)
def test_substeps_of_updates_1_to_12(sps, loop, min_frame_rate, expected):
    with App(physics_hz=sps, loop_hz=loop, settings={keys.MIN_FRAME_RATE: min_frame_rate}) as app:
        app.play()
        assert substeps(app, 12) == expected


@pytest.mark.parametrize(
    ("sps", "loop", "expected"),
    [(60, 24, [2, 3] * 6), (60, 10, [6] * 12), (100, 30, [3, 3, 4] * 4), (100, 20, [5] * 12), (200, 25, [8] * 12)],
)
def test_the_documented_profile_catches_up_without_a_cap_and_the_product_has_30(sps, loop, expected):
    cap = sps // 30
    with App(physics_hz=sps, loop_hz=loop) as app:
        app.play()
        assert substeps(app, 12) == expected
    with App(physics_hz=sps, loop_hz=loop, parity=PRODUCT) as app:
        app.play()
        assert substeps(app, 12) == [cap] * 12


def test_a_capped_carry_is_pinned_at_one_cap_of_steps():
    with App(physics_hz=100, loop_hz=30, parity=PRODUCT) as app:
        app.play()
        app.update(100)
        assert app.simulation.carry == Fraction(3, 100)


def test_after_an_overlong_update_at_most_one_cap_is_banked():
    with App(physics_hz=60, parity=PRODUCT) as app:
        app.play()
        app.run_loop.manual_step = Fraction(1, 10)
        assert substeps(app, 1) == [2]
        app.run_loop.manual_step = Fraction(1, 1000)
        assert substeps(app, 1) == [2]


@pytest.mark.parametrize(("sps", "loop"), [(60, 100), (1000, 50), (1000, 100)])
def test_exact_steps_where_the_product_s_float_accumulator_is_one_late(sps, loop):
    with App(physics_hz=sps, loop_hz=loop) as app:
        app.play()
        for update in range(1, 61):
            app.update()
            assert app.simulation.get_num_physics_steps() == update * sps // loop


def test_full_worked_run_sps_100_loop_60():
    with App(physics_hz=100, loop_hz=60, parity=PRODUCT) as app:
        app.play()
        assert (app.simulation.get_num_physics_steps(), app.simulation.get_simulation_time()) == (2, 0.02)
        assert app.timeline.get_current_time() == 0
        rows = []
        for _ in range(6):
            (steps,) = substeps(app, 1)
            rows.append((steps, app.simulation.get_num_physics_steps(), app.simulation.time, app.timeline.current_time))
        hundredths = [Fraction(count, 100) for count in (3, 5, 7, 8, 10, 12)]
        assert rows == [
            (steps, count, time, Fraction(update, 60))
            for update, (steps, count, time) in enumerate(
                zip((1, 2, 2, 1, 2, 2), (3, 5, 7, 8, 10, 12), hundredths, strict=True), 1
            )
        ]
