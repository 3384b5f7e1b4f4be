"""The scopes of a reset: what starts again, and what continues."""

from __future__ import annotations

import numpy as np
import pytest

from graph.base.errors import RunError, UserError
from graph.sim import App
from graph.sim.live.editing import Reset
from graph.sim.usd import Gf, UsdPhysics

PRIMS = {
    "/World/Ground": {"type": "Plane"},
    "/World/Ball": {"type": "Sphere", "radius": 0.2, "translate": [0, 0, 9], "rigid_body": True, "velocity": [1, 0, 0],
                    "angular_velocity": [10, 20, 30]},
    "/World/Wall": {"type": "Cube", "translate": [5, 0, 1]},
    "/World/Arm": {"type": "Cube", "size": 0.2, "translate": [8, 8, 3], "rotate": [0, 20, 0], "rigid_body": True},
}  # fmt: skip
NEW = {"/World/New": {"type": "Sphere", "radius": 0.3, "translate": [3, 3, 7], "rigid_body": True}}


@pytest.fixture(params=["on", "off"])
def app(request):
    with App(physics_hz=240, loop_hz=60, when_playing="recompile", fidelity={"fabric": request.param}) as app:
        app.add_prims(PRIMS)
        joint = UsdPhysics.RevoluteJoint.Define(app.stage, "/World/Hinge")
        joint.CreateAxisAttr("Y")
        joint.CreateBody1Rel().SetTargets(["/World/Arm"])
        joint.CreateLocalPos0Attr((8, 8, 4))
        joint.CreateLocalPos1Attr((0, 0, 1))
        drive = UsdPhysics.DriveAPI.Apply(joint.GetPrim(), "angular")
        drive.CreateStiffnessAttr(100.0)
        drive.CreateDampingAttr(10.0)
        app.play()
        yield app


def bodies(app):
    state = app.simulation.tensors
    arrays = state.positions, state.orientations, state.linear_velocities, state.angular_velocities
    return dict(zip(state.body_paths, np.concatenate(arrays, axis=1), strict=True))


def clocks(app):
    simulation = app.simulation
    times = simulation.get_simulation_time(), app.timeline.get_current_time(), float(app.external_time)
    return (*times, simulation.get_num_physics_steps())


def same(first, second):
    return first.keys() == second.keys() and all(np.array_equal(first[path], second[path]) for path in first)


def test_time_alone(app):
    app.update(30)
    before, monotonic = bodies(app), app.simulation.get_simulation_time_monotonic()
    assert clocks(app) == (0.5, 0.5, 0.5, 120)
    app.reset("time")
    assert clocks(app) == (0, 0, 0, 0)
    assert app.timeline.is_playing()
    assert same(bodies(app), before)
    assert app.simulation.get_simulation_time_monotonic() == monotonic
    app.update(6)
    assert clocks(app) == (0.1, 0.1, 0.1, 24)
    assert bodies(app)["/World/Ball"][2] < before["/World/Ball"][2]


def test_state_alone(app):
    start = bodies(app)
    app.update(30)
    first = bodies(app)
    app.physics.articulation("/World/Arm").set_targets(positions=[1.0])
    app.update(30)
    app.reset("state")
    assert clocks(app) == (1, 1, 1, 240)
    assert same(bodies(app), start)
    app.update(30)
    assert same(bodies(app), first)
    app.reset(Reset.STATE)
    app.update(30)
    assert same(bodies(app), first)


def test_state_puts_back_what_users_have_moved(app):
    app.update(3)
    app.stage.GetPrimAtPath("/World/Wall").GetAttribute("xformOp:translate").Set(Gf.Vec3d(1, 1, 1))
    app.stage.GetPrimAtPath("/World/Ball").GetAttribute("xformOp:translate").Set(Gf.Vec3d(2, 2, 2))
    app.update(3)
    app.reset("state")
    assert app.fabric.world_matrix("/World/Wall")[:3, 3] == pytest.approx([5, 0, 1])
    assert app.fabric.world_matrix("/World/Ball")[:3, 3].tolist() == [0, 0, 9]
    app.update(3)
    assert app.fabric.world_matrix("/World/Wall")[:3, 3] == pytest.approx([5, 0, 1])


def test_spawned_alone(app):
    app.add_prims(NEW)
    app.update(30)
    before, times = bodies(app), clocks(app)
    app.reset("spawned")
    assert clocks(app) == times
    assert not app.stage.GetPrimAtPath("/World/New")
    now = bodies(app)
    assert now.keys() == before.keys() - {"/World/New"}
    assert all(np.array_equal(now[path], before[path]) for path in now)
    assert "/World/New" not in {one.path for one in app.geometry()}
    app.reset("spawned")
    app.update()


def test_what_came_while_playing_begins_where_it_came(app):
    app.update(10)
    app.add_prims(NEW)
    app.update(20)
    app.reset("state")
    state = bodies(app)
    assert state["/World/New"][:3].tolist() == [3, 3, 7]
    assert state["/World/Ball"][:3].tolist() == [0, 0, 9]
    assert state["/World/Ball"][7:10] == pytest.approx([1, 0, 0])
    app.update()


def test_all_is_stop_and_play(app):
    app.stop()
    before = [layer.ExportToString() for layer in app.stage.GetUsedLayers()]
    app.play()
    start = bodies(app)
    app.update(6)
    app.add_prims(NEW)
    app.stage.DefinePrim("/World/Marker", "Xform")
    app.fabric.set("/World/Wall", "mine", 3)
    seen = []
    for name in ("stop", "play"):
        app.on(name, lambda name=name: seen.append(name))
    app.reset()
    assert seen == ["stop", "play"]
    assert clocks(app) == (0, 0, 0, 0)
    assert same(bodies(app), start)
    assert app.fabric.get("/World/Wall", "mine") is None
    app.pause()
    app.reset("all")
    assert app.timeline.is_paused()
    app.stop()
    assert [layer.ExportToString() for layer in app.stage.GetUsedLayers()] == before


def test_scopes_combine_and_names_are_checked(app):
    start = bodies(app)
    app.add_prims(NEW)
    app.update(6)
    app.reset("time | spawned")
    assert clocks(app) == (0, 0, 0, 0)
    assert not same(bodies(app), start)
    app.update(6)
    app.reset(Reset.TIME | Reset.STATE)
    assert same(bodies(app), start)
    assert clocks(app) == (0, 0, 0, 0)
    with pytest.raises(UserError, match="there is no scope 'times' to reset; there are time, state, spawned, all"):
        app.reset("times")


def test_while_stopped_there_is_nothing_to_reset_and_not_inside_an_update(app):
    app.stop()
    for scope in ("time", "state", "spawned", "all"):
        app.reset(scope)
    assert app.timeline.is_stopped()
    app.play()
    app.on("end", lambda: app.reset("time"))
    with pytest.raises(RunError, match="called from inside an update"):
        app.update()
