"""What is written on the physics scene while playing acts from the next step on, and getters say it before play."""

import pytest

from graph.isaac.managers.physics_scene import PhysicsScene
from graph.sim import App

SCENE = {"/Scene": {"type": "PhysicsScene", "schemas": "PhysxSceneAPI"}}
BALL = {"/Ball": {"type": "Sphere", "radius": 0.1, "rigid_body": True}}


def playing(app, prims=None):
    app.add_prims({**SCENE, **BALL, **(prims or {})})
    app.play()
    return app.stage.GetPrimAtPath("/Scene")


def velocity(app):
    return app.simulation.physics.velocities()[0, :3]


@pytest.mark.parametrize(
    ("name", "value", "gained"),
    [
        ("physics:gravityMagnitude", 1.5, [0, 0, -1.5]),
        ("physics:gravityMagnitude", 0.0, [0, 0, 0]),
        ("physics:gravityDirection", (0, 1, 0), [0, 9.81, 0]),
        ("newton:gravityEnabled", False, [0, 0, 0]),
    ],
)
def test_gravity_is_that_of_the_scene_from_the_next_update_on(name, value, gained):
    """v = g t: one second with 9.81 m/s2 down, then one with what was written."""
    with App() as app:
        scene = playing(app, {"/Scene": {**SCENE["/Scene"], "attributes": {"newton:gravityEnabled": True}}})
        app.update(steps=60)
        before = velocity(app).copy()
        assert before == pytest.approx([0, 0, -9.81], rel=1e-6)
        scene.GetAttribute(name).Set(value)
        app.update(steps=60)
        assert velocity(app) - before == pytest.approx(gained, abs=1e-5)
        app.stop()
        assert PhysicsScene("/Scene", app).get_gravity() == pytest.approx([0, 0, -9.81])
        app.play()
        app.update(steps=60)
        assert velocity(app) == pytest.approx([0, 0, -9.81], rel=1e-6)


@pytest.mark.parametrize("rate", [30, 120, 240])
def test_the_rate_is_that_of_the_scene_from_the_next_update_on(rate):
    """Updates of 1/60 s: 60 steps in the first second, then `rate`."""
    with App() as app:
        counted = []
        scene = playing(app, {"/Scene": {**SCENE["/Scene"], "attributes": {"physxScene:timeStepsPerSecond": 60}}})
        app.on("physics_post_step", lambda: counted.append(1))
        app.update(steps=60)
        assert len(counted) == 60
        scene.GetAttribute("physxScene:timeStepsPerSecond").Set(rate)
        app.update(steps=60)
        assert len(counted) - 60 == pytest.approx(rate, abs=1)


def test_the_rate_that_usd_writes_is_followed_and_getters_agree():
    rate = {"/Scene": {**SCENE["/Scene"], "attributes": {"physxScene:timeStepsPerSecond": 60}}}
    with App() as app:
        app.add_prims({**rate, **BALL})
        scene, wrapper = app.stage.GetPrimAtPath("/Scene"), PhysicsScene("/Scene", app)
        scene.GetAttribute("physxScene:timeStepsPerSecond").Set(120)
        assert wrapper.get_dt() == pytest.approx(1 / 120)
        assert app.simulation.get_physics_dt() == pytest.approx(1 / 120)
        app.play()
        app.update()
        scene.GetAttribute("physxScene:timeStepsPerSecond").Set(300)
        app.update()
        assert wrapper.get_dt() == pytest.approx(1 / 300)
        assert float(app.simulation.physics.dt) == pytest.approx(1 / 300)


def test_a_rate_that_the_app_was_given_stays():
    with App(physics_hz=240) as app:
        scene = playing(app, {"/Scene": {**SCENE["/Scene"], "attributes": {"physxScene:timeStepsPerSecond": 60}}})
        scene.GetAttribute("physxScene:timeStepsPerSecond").Set(120)
        app.update()
        assert app.simulation.physics.dt == pytest.approx(1 / 240)


def test_what_only_play_reads_is_a_warning_and_a_second_scene_is_not():
    iterations = {"attributes": {"newton:maxSolverIterations": 50}}
    with App() as app:
        scene = playing(app, {"/Scene": {**SCENE["/Scene"], **iterations}, "/World/Other": {"type": "PhysicsScene"}})
        app.stage.GetPrimAtPath("/World/Other").GetAttribute("physics:gravityMagnitude").Set(1.0)
        app.update(steps=2)
        assert not any(warning.code == "edit-not-live" for warning in app.warnings)
        scene.GetAttribute("newton:maxSolverIterations").Set(20)
        app.update()
        assert [warning.where for warning in app.warnings if warning.code == "edit-not-live"] == ["/Scene"]
        assert velocity(app)[2] == pytest.approx(-9.81 * 3 / 60)
