"""The App over a falling ball: substeps, captures, divergence, play and stop with a real engine."""

from __future__ import annotations

import numpy as np
import pytest

from graph.base.errors import RunError
from graph.sim import App, MemorySink
from graph.sim.scene.stage import open_stage
from tests.support.noting_sensor import NotingLidar, add
from tests.support.physics_worlds import fallen

BALL = "/World/Ball"


def falling_ball(height=100.0):
    stage = open_stage()
    from pxr import Gf, UsdGeom, UsdPhysics

    ball = UsdGeom.Sphere.Define(stage, BALL)
    ball.GetRadiusAttr().Set(0.1)
    UsdGeom.Xformable(ball).AddTranslateOp().Set(Gf.Vec3d(0, 0, height))
    UsdPhysics.RigidBodyAPI.Apply(ball.GetPrim())
    UsdPhysics.CollisionAPI.Apply(ball.GetPrim())
    return stage


class HeightSensor(NotingLidar):
    """Notes how high the ball is in each of its ticks."""

    def __init__(self, app, rate):
        super().__init__(rate)
        self.app = app
        self.heights = []

    def render(self, tick):
        self.heights.append(self.app.fabric.world_matrix(BALL, tick.poses)[2, 3])
        return super().render(tick)


def height(app):
    return app.fabric.world_matrix(BALL)[2, 3]


def test_the_ball_falls_by_the_steps_that_are_counted():
    with App(falling_ball(), physics_hz=240) as app:
        app.play()
        app.update(60)
        assert app.simulation.get_num_physics_steps() == 240
        assert height(app) == pytest.approx(100 - fallen(240, 1 / 240), abs=1e-9)


def test_direct_steps_move_the_ball():
    with App(falling_ball(), physics_hz=100) as app:
        app.play()
        app.simulation.step(steps=7)
        assert height(app) == pytest.approx(100 - fallen(7, 1 / 100), abs=1e-12)


def test_a_frozen_sensor_sees_the_substep_of_its_tick():
    with App(falling_ball(), physics_hz=240) as app:
        sensor = add(app, HeightSensor(app, 7))
        app.play()
        app.update(60)
        # first states at or after k / 7 s: ceil(240 k / 7)
        expected = [100 - fallen(steps, 1 / 240) for steps in (35, 69, 103, 138, 172, 206, 240)]
        assert sensor.heights == pytest.approx(expected, abs=1e-9)


def test_with_tlas_frame_it_sees_the_last_substep_of_the_update():
    with App(falling_ball(), physics_hz=240, fidelity={"tlas": "frame"}) as app:
        sensor = add(app, HeightSensor(app, 7))
        app.play()
        app.update(60)
        expected = [100 - fallen(steps, 1 / 240) for steps in (36, 72, 104, 140, 172, 208, 240)]
        assert sensor.heights == pytest.approx(expected, abs=1e-9)


def test_post_step_subscribers_see_the_new_state():
    with App(falling_ball(), physics_hz=120) as app:
        seen = []
        app.on("physics_post_step", lambda: seen.append(height(app)))
        app.play()
        app.update()
        assert seen == pytest.approx([100 - fallen(1, 1 / 120), 100 - fallen(2, 1 / 120)], abs=1e-12)


def test_a_new_rate_reaches_the_engine():
    with App(falling_ball(), physics_hz=60) as app:
        app.play()
        app.simulation.setup_simulation(dt=1 / 120)
        app.simulation.step()
        assert height(app) == pytest.approx(100 - fallen(1, 1 / 120), abs=1e-12)


def test_stop_frees_physics_and_play_starts_from_the_authored_state():
    with App(falling_ball(), physics_hz=240) as app:
        tracks = []
        for _ in range(2):
            app.play()
            assert app.physics is not None
            track = []
            for _ in range(30):
                app.update()
                track.append(height(app))
            tracks.append(track)
            app.stop()
            assert app.physics is None
            assert height(app) == 100
        assert tracks[0] == tracks[1]


def test_fewer_or_more_sensors_change_no_poses():
    tracks = []
    for count in (0, 1, 5):
        with App(falling_ball(), physics_hz=240) as app:
            for number in range(count):
                add(app, HeightSensor(app, 5 + number), str(number))
            app.play()
            app.update(60)
            tracks.append(height(app))
    assert tracks[0] == tracks[1] == tracks[2]


def test_a_diverging_simulation_ends_the_update_and_keeps_what_was_recorded():
    with App(falling_ball(), physics_hz=240) as app:
        sink = MemorySink()
        app.bus.subscribe(sink)
        app.on("simulation_graphs", lambda: app.bus.publish("/a", "b/msg/C", None, 0))
        app.play()
        app.update(3)
        app.physics.data.qvel[0] = np.nan
        with pytest.raises(RunError, match=BALL):
            app.update()
        assert len(sink["/a"]) == 3
        assert app.simulation.get_num_physics_steps() == 12
        assert app.update_index == 3
        app.stop()
        app.play()
        app.update()
        assert height(app) == pytest.approx(100 - fallen(4, 1 / 240), abs=1e-12)


def test_geometry_is_collected_once_per_play():
    with App(falling_ball()) as app:
        app.play()
        geometry = app.geometry()
        app.update(3)
        assert app.geometry() is geometry
        app.stop()
        assert app.geometry() is not geometry
