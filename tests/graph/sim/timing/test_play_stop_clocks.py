"""What play, pause, resume and stop do to each clock: a test for each row of the table, in both profiles."""

from __future__ import annotations

from fractions import Fraction

import pytest

from graph.sim import App
from graph.sim import settings as keys

PRODUCT = "isaacsim-6.0.1"


@pytest.fixture(params=["documented", PRODUCT])
def app(request):
    with App(physics_hz=120, loop_hz=60, parity=request.param) as app:
        yield app


def clocks(app):
    """Timeline, simulation and monotonic time, step count, samples, external time; whether it simulates, is paused."""
    simulation = app.simulation
    return (
        app.timeline.current_time,
        simulation.time,
        simulation.monotonic_time,
        simulation.get_num_physics_steps(),
        simulation.get_sample_count(),
        app.fabric.get("/ExternalSimulationTime", "omni:time"),
        simulation.is_simulating(),
        simulation.is_paused(),
    )


def warm_up(app):
    return 2 if app.parity == PRODUCT else 0


def samples(app, updates, steps=2):
    """One an update, or one a substep, warm-up included."""
    return warm_up(app) + updates * steps if app.parity == PRODUCT else updates


def expected(app, *, timeline, steps, monotonic=None, held, playing=True, paused=False):
    """The clocks after `steps` steps of 1/120 s since play."""
    time = Fraction(steps, 120)
    total = time if monotonic is None else Fraction(monotonic, 120)
    return (Fraction(timeline, 60), time, total, steps, held, float(time), playing, paused)


def test_play_from_stopped(app):
    app.play()
    w = warm_up(app)
    assert clocks(app) == expected(app, timeline=0, steps=w, held=w)


def test_update_while_playing_with_a_step(app):
    app.play()
    app.update()
    w = warm_up(app)
    assert clocks(app) == expected(app, timeline=1, steps=w + 2, held=samples(app, 1))


def test_update_while_playing_without_a_step(app):
    app.play()
    app.update()
    app.run_loop.manual_step = Fraction(1, 240)
    before = clocks(app)
    app.update()
    assert clocks(app) == (Fraction(1, 60) + Fraction(1, 240), *before[1:])


def test_pause_then_updates(app):
    app.play()
    app.update()
    app.pause()
    app.update(10)
    w = warm_up(app)
    assert clocks(app) == expected(app, timeline=1, steps=w + 2, held=samples(app, 1), paused=True)


def test_resume_goes_on_without_warm_up_and_rewrites_the_newest_sample(app):
    app.play()
    app.update()
    app.pause()
    app.play()
    w = warm_up(app)
    assert clocks(app) == expected(app, timeline=1, steps=w + 2, held=samples(app, 1))
    app.update()
    assert clocks(app) == expected(app, timeline=2, steps=w + 4, held=samples(app, 2))


def test_resume_without_multi_tick_rendering_adds_a_sample_at_the_loop_s_time():
    with App(settings={keys.MULTI_TICK: False}) as app:
        app.play()
        app.update()
        app.pause()
        app.update(9)
        app.play()
        assert [sample.key for sample in app.simulation.get_all_samples()] == [Fraction(1, 60), Fraction(10, 60)]
        assert [sample.simulation for sample in app.simulation.get_all_samples()] == [Fraction(1, 60)] * 2


def test_stop(app):
    app.play()
    app.update(3)
    app.stop()
    w = warm_up(app)
    assert clocks(app) == expected(app, timeline=0, steps=0, monotonic=w + 6, held=0, playing=False)


def test_direct_steps(app):
    app.play()
    app.update()
    app.simulation.step(steps=5)
    w = warm_up(app)
    assert clocks(app) == expected(app, timeline=1, steps=w + 7, held=samples(app, 1) + 5)


def test_direct_steps_with_a_callback(app):
    app.play()
    told = []
    app.simulation.step(steps=5, callback=lambda i, steps: told.append((i, steps)) or i < 3)
    assert told == [(1, 5), (2, 5), (3, 5)]
    w = warm_up(app)
    assert clocks(app) == expected(app, timeline=0, steps=w + 3, held=w + 3)


def test_render_while_playing(app):
    app.play()
    app.update()
    app.rendering.render()
    w = warm_up(app)
    assert clocks(app) == expected(app, timeline=2, steps=w + 2, held=samples(app, 1))


def test_render_while_stopped_leaves_the_external_time_at_0(app):
    app.rendering.render()
    assert app.fabric.get("/ExternalSimulationTime", "omni:time") == 0.0
    assert app.timeline.get_current_time() == 0


def test_steps_per_second_changed_between_steps():
    with App(physics_hz=60) as app:
        app.play()
        app.update(60)
        assert app.simulation.time == 1
        app.simulation.setup_simulation(dt=Fraction(1, 120))
        assert (app.simulation.time, app.simulation.monotonic_time) == (1, 1)  # until the next step
        app.simulation.step()
        assert (app.simulation.time, app.simulation.monotonic_time) == (Fraction(61, 120), 1 + Fraction(1, 120))
        assert app.fabric.get("/ExternalSimulationTime", "omni:time") == 61 / 120
        assert app.simulation.get_num_physics_steps() == 61


def test_stage_attached():
    with App(physics_hz=120) as app:
        assert clocks(app) == (0, 0, 0, 0, 0, 0.0, False, False)
        assert app.simulation.get_sample_range() is None


def test_stage_closed(app):
    app.play()
    app.update()
    app.close()
    assert app.simulation.get_sample_count() == 0
    assert not app.simulation.is_simulating()


# -- what the table's text adds ----------------------------------------------------------------------------------------


def test_play_and_one_update_at_60_60_makes_step_count_3_in_the_product():
    with App(parity=PRODUCT) as app:
        app.timeline.play()
        app.update()
        assert app.simulation.get_num_physics_steps() == 3
        assert app.simulation.time == Fraction(3, 60)
        assert app.timeline.current_time == Fraction(1, 60)


def test_warm_up_steps_reach_raw_step_subscribers():
    with App(parity=PRODUCT) as app:
        seen = []
        app.on("physics_post_step", lambda: seen.append(app.simulation.get_num_physics_steps()))
        app.play()
        assert seen == [1, 2]


def test_warm_up_steps_move_bodies():
    from graph.sim.scene.prims import author_prims
    from graph.sim.scene.stage import open_stage

    heights = {}
    for parity in ("documented", PRODUCT):
        stage = open_stage()
        author_prims(stage, {"/World/Ball": {"type": "Sphere", "translate": [0, 0, 5], "rigid_body": True}})
        with App(stage, parity=parity) as app:
            app.play()
            heights[parity] = app.fabric.world_matrix("/World/Ball")[2, 3]
    assert heights["documented"] == 5
    assert heights[PRODUCT] < 5


def test_nothing_is_warmed_up_with_play_simulations_off():
    with App(parity=PRODUCT, settings={keys.PLAY_SIMULATIONS: False}) as app:
        app.play()
        assert app.simulation.get_num_physics_steps() == 0


def test_the_monotonic_example():
    with App(parity=PRODUCT) as app:
        app.play()
        app.update()
        app.simulation.step(steps=100)
        app.stop()
        app.play()
        app.update()
        assert app.simulation.monotonic_time == Fraction(106, 60)
        assert app.simulation.time == Fraction(3, 60)


def test_the_example_of_a_new_rate_without_a_stop():
    with App(physics_hz=60) as app:
        app.play()
        app.update(60)
        app.simulation.setup_simulation(dt=1 / 120)
        app.simulation.step()
        assert app.simulation.get_simulation_time() == pytest.approx(0.508333, abs=1e-6)
        assert app.simulation.get_simulation_time_monotonic() == pytest.approx(1.008333, abs=1e-6)


def test_each_play_from_stopped_warms_up_and_a_resume_does_not():
    with App(parity=PRODUCT) as app:
        for _ in range(3):
            app.play()
            app.pause()
            app.play()
            assert app.simulation.get_num_physics_steps() == 2
            app.stop()


def test_changes_wait_for_the_next_update_or_a_commit():
    with App() as app:
        app.timeline.play()
        assert not app.timeline.is_playing()
        app.timeline.commit()
        assert app.timeline.is_playing()
        app.timeline.pause()
        app.update()
        assert app.timeline.is_paused()


def test_a_silent_commit_is_known_as_such_while_it_is_reported():
    from graph.sim.settings import Settings
    from graph.sim.timing.timeline import Timeline

    told = []
    timeline = Timeline(Settings(), lambda change: told.append((change, timeline.silent)))
    timeline.play()
    timeline.commit_silently()
    timeline.pause()
    timeline.commit()
    assert told == [("play", True), ("pause", False)]


@pytest.mark.parametrize("parity", ["documented", "isaacsim-6.0.1"])
def test_a_step_applies_a_play_that_waits_for_the_next_update(parity):
    with App(parity=parity) as app:
        app.timeline.play()
        app.simulation.step(steps=3)
        assert app.simulation.get_num_physics_steps() == 3 + app.settings.get("/tickgraph/warmUpSteps")
        assert app.timeline.get_current_time() == 0


@pytest.mark.parametrize("parity", ["documented", "isaacsim-6.0.1"])
def test_what_a_step_made_due_is_rendered_in_the_next_update_also_while_paused(parity):
    """The renderer's clock moves with each physics step and is read in every update, whatever the timeline does."""
    from tests.support.noting_sensor import NotingLidar, NotingSensor, add

    with App(parity=parity) as app:
        sensors = add(app, NotingSensor(), "every"), add(app, NotingLidar(60), "ticking")
        app.play()
        app.update()
        before = [len(one.ticks) for one in sensors]
        app.simulation.step()
        app.pause()
        app.update(2)
        assert [len(one.ticks) - old for one, old in zip(sensors, before, strict=True)] == [1, 1]
