"""Multi-tick rendering off, sensor or frame state (`tlas`), and physics that stands while the timeline moves."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from graph.sim import App
from graph.sim import settings as keys
from tests.support.lidar_texts import lidar_graph
from tests.support.noting_sensor import NotingLidar, NotingSensor, add

OFF = {keys.MULTI_TICK: False}


def sixtieths(sensor):
    return [(tick.start * 60, tick.end * 60) for tick in sensor.ticks]


def test_every_sensor_renders_every_frame():
    with App(settings=OFF) as app:
        camera, auto = add(app, NotingSensor(10), "camera"), add(app, NotingSensor(), "auto")
        app.play()
        app.update(5)
        assert sixtieths(camera) == sixtieths(auto) == [(n, n + 1) for n in range(5)]


def test_an_accumulating_lidar_emits_its_scan_in_the_update_that_completes_it():
    with App(settings=OFF) as app:
        updates = []
        lidar = add(app, NotingLidar(20))
        app.on("post_render_graphs", lambda: updates.append(app.update_index))
        app.play()
        app.update(9)
        assert sixtieths(lidar) == [(0, 3), (3, 6), (6, 9)]
        assert updates == [2, 5, 8]


def test_stamps_follow_the_run_loop_from_app_construction():
    with App(settings=OFF) as app:
        app.update(7)
        app.play()
        lidar, camera = add(app, NotingLidar(20), "lidar"), add(app, NotingSensor(10), "camera")
        app.update(6)
        assert sixtieths(camera) == [(7 + n, 8 + n) for n in range(6)]
        assert sixtieths(lidar) == [(9, 12)]  # the first turn that begins after 7/60
        assert app.external_time == Fraction(13, 60)
        assert app.simulation.time == Fraction(6, 60)


def test_a_sensor_made_before_play_begins_with_the_play_s_first_update():
    with App(settings=OFF) as app:
        camera, lidar = add(app, NotingSensor(10), "camera"), add(app, NotingLidar(20), "lidar")
        app.update(7)
        assert camera.ticks == []
        app.play()
        app.update(6)
        assert sixtieths(camera)[0] == (7, 8)
        assert sixtieths(lidar) == [(9, 12)]


def test_stamps_are_independent_of_the_timeline():
    with App(settings=OFF) as app:
        camera = add(app, NotingSensor(10))
        app.timeline.set_end_time(Fraction(2, 60))
        app.timeline.set_auto_update(False)
        app.play()
        app.update(2)
        app.timeline.set_auto_update(True)
        app.update(3)
        assert sixtieths(camera) == [(n, n + 1) for n in range(5)]


def test_stamps_are_discontinuous_across_a_pause():
    with App(settings=OFF) as app:
        camera, auto = add(app, NotingSensor(10), "camera"), add(app, NotingSensor(), "auto")
        lidar = add(app, NotingLidar(20), "lidar")
        app.play()
        app.update(4)
        app.pause()
        app.update(100)
        app.play()
        app.update(6)
        assert sixtieths(camera) == sixtieths(auto) == [(n, n + 1) for n in (0, 1, 2, 3, *range(104, 110))]
        assert sixtieths(lidar) == [(0, 3), (105, 108)]  # no scan over the pause
        assert (lidar.product.frames, lidar.product.missed) == (2, 0)
        assert app.simulation.time == Fraction(10, 60)


def test_stop_and_play_go_on_with_the_loop_s_time():
    with App(settings=OFF) as app:
        camera = add(app, NotingSensor(10))
        app.play()
        app.update(2)
        app.stop()
        app.update(5)
        app.play()
        app.update(2)
        assert sixtieths(camera) == [(0, 1), (1, 2), (7, 8), (8, 9)]


def test_updates_without_a_physics_step_render_too():
    with App(settings={**OFF, keys.PLAY_SIMULATIONS: False}) as app:
        camera = add(app, NotingSensor(10))
        app.play()
        app.update(3)
        assert len(camera.ticks) == 3
        assert app.simulation.time == 0
        assert app.timeline.current_time == Fraction(3, 60)


def test_the_switch_is_read_when_playing_starts():
    with App() as app:
        camera = add(app, NotingSensor(10))
        app.play()
        app.settings.set(keys.MULTI_TICK, False)
        app.update(6)
        assert len(camera.ticks) == 1
        app.stop()
        app.play()
        app.update(6)
        assert len(camera.ticks) == 7


BEFORE_A_WALL = """\
tickgraph: 1
scene:
  prims:
    /World/Wall: {type: Cube, size: 2.0, translate: [5, 0, 0]}
    /World/Lidar: {type: OmniLidar, config: Example_Rotary_2D}
settings: {/rtx/hydra/supportMultiTickRate: false}
"""


def test_a_real_lidar_emits_whole_scans_by_the_loop_and_stamps_them_with_the_simulation_time(tmp_path):
    file = tmp_path / "g.yaml"
    file.write_text(BEFORE_A_WALL + lidar_graph())
    from graph.sim import MemorySink

    with App.from_file(file) as app:
        sink = MemorySink()
        app.bus.subscribe(sink)
        app.update(3)
        app.play()
        app.update(18)
        app.pause()
        app.update(10)
        app.play()
        app.update(12)
        # Turns of 6/60 s of the loop: the first begins at 6/60 and is cast at 12/60, when 9/60 s are simulated; after
        # the pause (31/60) the first whole one begins at 36/60 and is cast at 42/60, when 29/60 s are.
        stamps = [message.message.header.stamp for message in sink["points"]]
        assert [(stamp.sec, stamp.nanosec) for stamp in stamps] == [
            (0, 150_000_000),
            (0, 250_000_000),
            (0, 483_333_333),
        ]


# -- perSensorTickTlas = fidelity tlas -----------------------------------------------------------------------------

FALLING = """\
tickgraph: 1
scene:
  prims:
    /World/Lidar: {type: OmniLidar, config: Example_Rotary_2D}
    /World/Wall: {type: Cube, size: 1.0, translate: [5, 0, 0], rigid_body: true, velocity: [6, 0, 0]}
clock: {physics_hz: 240, loop_hz: 7}
"""


@pytest.mark.parametrize(
    ("options", "own"),
    [
        ({}, True),
        ({"settings": {keys.SENSOR_TICK_TLAS: False}}, False),
        ({"fidelity": {"tlas": "frame"}}, False),
    ],
    ids=["sensor", "setting off", "fidelity frame"],
)
def test_a_frozen_scan_sees_the_state_of_its_own_tick_or_the_frame_s_last(tmp_path, options, own):
    file = tmp_path / "g.yaml"
    file.write_text(FALLING)
    with App.from_file(file, **options) as app:
        from sensors import Lidar, LidarSensor

        sensor = LidarSensor(Lidar("/World/Lidar", app=app), annotators=["generic-model-output"])
        app.play()
        app.update()  # 1/7 s: 34 steps; the tick of 0.1 s is step 24
        ranges = sensor.render_product.frame.channel("distance")
        seen_at = Fraction(24 if own else 34, 240)
        assert np.min(ranges) == pytest.approx(4.5 + 6 * float(seen_at), abs=0.01)


# -- playSimulations -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("parity", ["documented", "isaacsim-6.0.1"])
def test_play_simulations_off_freezes_the_physics_clock_while_the_timeline_advances(parity):
    with App(parity=parity, settings={keys.WARM_UP_STEPS: 0}) as app:
        sensor = add(app, NotingSensor(30))
        app.play()
        app.update(2)
        app.settings.set(keys.PLAY_SIMULATIONS, False)
        app.update(60)
        assert app.simulation.time == app.external_time == Fraction(2, 60)
        assert app.fabric.get("/ExternalSimulationTime", "omni:time") == 2 / 60
        assert app.timeline.current_time == Fraction(62, 60)
        assert len(sensor.ticks) == 1
        app.settings.set(keys.PLAY_SIMULATIONS, True)
        app.update(2)
        assert [tick.time for tick in sensor.ticks] == [Fraction(2, 60), Fraction(4, 60)]
