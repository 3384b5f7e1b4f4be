import math

import numpy as np
import pytest

from graph.sim import App
from graph.sim.scene.stage import open_stage
from graph.sim.usd import UsdGeom, UsdPhysics
from sensors.raycast.rays import RayBundle
from sensors.raycast.shared import cast_world

RATE = 24


def stage_with_a_mover(**more):
    """A cube of 1 m that travels 24 m along X and turns by 90 degrees about Z in the first second."""
    stage = open_stage()
    stage.SetTimeCodesPerSecond(RATE)
    mover = UsdGeom.Xform.Define(stage, "/World/Mover")
    travel, turn = mover.AddTranslateOp(), mover.AddRotateZOp()
    for code, place, angle in ((0, 0, 0), (RATE, 24, 90)):
        travel.Set((place, 0, 0), code)
        turn.Set(float(angle), code)
    box = UsdGeom.Cube.Define(stage, "/World/Mover/Box")
    box.CreateSizeAttr(1.0)
    UsdPhysics.CollisionAPI.Apply(box.GetPrim())
    if more.get("ball"):
        ball = UsdGeom.Cube.Define(stage, "/World/Ball")
        ball.CreateSizeAttr(1.0)
        ball.AddTranslateOp().Set(more["ball"])
        for api in (UsdPhysics.RigidBodyAPI, UsdPhysics.CollisionAPI):
            api.Apply(ball.GetPrim())
    return stage


def distance(app, origin, direction):
    rays = np.zeros((1, 6), np.float32)
    rays[0, 3:] = direction
    return float(cast_world(app.world).cast(RayBundle(np.array(origin, float), rays)).distance[0])


@pytest.mark.parametrize("fabric", ["on", "off"])
@pytest.mark.parametrize("ball", [None, (0, 50, 5)])
def test_what_has_time_samples_follows_the_timeline(fabric, ball):
    with App(stage_with_a_mover(ball=ball), physics_hz=240, loop_hz=60, fidelity={"fabric": fabric}) as app:
        app.play()
        app.update(steps=30)  # half a second: half way, turned by 45 degrees, a corner towards the ray
        assert distance(app, (30, 0, 0), (-1, 0, 0)) == pytest.approx(18 - math.sqrt(0.5), abs=1e-5)
        speed = app.fabric.velocities(["/World/Mover"])[0]
        assert speed == pytest.approx([24, 0, 0, 0, 0, math.pi / 2], abs=1e-3)
        app.update(steps=60)  # beyond the last sample
        assert distance(app, (30, 0, 0), (-1, 0, 0)) == pytest.approx(5.5, abs=1e-5)
        app.stop()
        assert app.fabric.world_matrix("/World/Mover")[0, 3] == 0


def test_each_physics_step_sees_it_where_it_is_then():
    seen = []
    with App(stage_with_a_mover(), physics_hz=240, loop_hz=60) as app:
        app.on("physics_post_step", lambda: seen.append(app.fabric.world_matrix("/World/Mover")[0, 3]), 1)
        app.play()
        app.update(steps=2)
        assert seen == pytest.approx([0.1 * step for step in range(1, 9)])


def test_it_pushes_bodies_out_of_its_way():
    with App(stage_with_a_mover(ball=(1.6, 0, 0)), physics_hz=240) as app:
        app.play()
        app.update(steps=12)
        assert app.fabric.world_matrix("/World/Ball")[0, 3] > 3  # it lay at 1.6


def test_below_a_body_that_forces_move_it_moves_relative_to_that():
    stage = stage_with_a_mover(ball=(0, 50, 5))
    spin = UsdGeom.Xform.Define(stage, "/World/Ball/Spin")
    turn = spin.AddRotateZOp()
    turn.Set(0.0, 0)
    turn.Set(360.0, RATE)
    arm = UsdGeom.Cube.Define(stage, "/World/Ball/Spin/Arm")
    arm.CreateSizeAttr(0.2)
    arm.AddTranslateOp().Set((2, 0, 0))
    with App(stage, physics_hz=240) as app:
        app.play()
        app.update(steps=15)  # a quarter of a second, a quarter of a turn: the arm points along Y
        fallen = app.fabric.world_matrix("/World/Ball")[2, 3]
        assert distance(app, (0, 60, fallen), (0, -1, 0)) == pytest.approx(10 - 2.1, abs=1e-5)
        speed = app.fabric.velocities(["/World/Ball/Spin"])[0]
        assert speed[2] == pytest.approx(-9.81 / 4, rel=1e-3)
        assert speed[5] == pytest.approx(2 * math.pi, rel=1e-3)


def test_a_sensor_on_it_is_carried():
    stage = stage_with_a_mover()
    UsdGeom.Xform.Define(stage, "/World/Mover/Mast").AddTranslateOp().Set((0, 0, 2))
    with App(stage) as app:
        app.play()
        app.update(steps=30)
        assert app.fabric.world_matrix("/World/Mover/Mast")[:3, 3] == pytest.approx([12, 0, 2])


def test_it_holds_in_a_pause_and_goes_where_the_timeline_is_set():
    with App(stage_with_a_mover()) as app:
        app.play()
        app.update(steps=30)
        app.pause()
        app.update(steps=5)
        assert app.fabric.world_matrix("/World/Mover")[0, 3] == pytest.approx(12)
        app.timeline.set_current_time(0.25)
        app.update()
        assert app.fabric.world_matrix("/World/Mover")[0, 3] == pytest.approx(6)


def test_what_does_not_count_from_its_parent_stays():
    stage = stage_with_a_mover()
    free = UsdGeom.Cube.Define(stage, "/World/Mover/Free")
    free.CreateSizeAttr(1.0)
    free.AddTranslateOp().Set((0, 9, 0))
    free.SetResetXformStack(True)
    with App(stage) as app:
        app.play()
        app.update(steps=30)
        assert distance(app, (0, 20, 0), (0, -1, 0)) == pytest.approx(10.5)


def test_samples_that_nothing_plays_are_reported():
    stage = stage_with_a_mover(ball=(0, 50, 5))
    op = UsdGeom.Xformable(stage.GetPrimAtPath("/World/Ball")).GetOrderedXformOps()[0]
    op.Set((0, 50, 5), 0)
    op.Set((0, 50, 9), 24)
    scale = UsdGeom.Xformable(stage.GetPrimAtPath("/World/Mover")).AddScaleOp()
    scale.Set((1, 1, 1), 0)
    scale.Set((2, 2, 2), 24)
    with App(stage) as app:
        app.play()
        found = {(warning.code, warning.where) for warning in app.warnings}
    assert {("animated-body", "/World/Ball"), ("animated-scale", "/World/Mover")} <= found


@pytest.mark.parametrize(("sizes", "said"), [([1, 3, 1, 3, 1], True), ([2, 2, 2, 2, 2], False)])
def test_a_scale_is_looked_at_in_all_its_samples(sizes, said):
    stage = stage_with_a_mover()
    mover = UsdGeom.Xformable(stage.GetPrimAtPath("/World/Mover"))
    scale = mover.AddScaleOp()
    for number, size in enumerate(sizes):  # it also turns, which leaves the size as it is
        scale.Set((size, size, size), 6 * number)
    with App(stage) as app:
        app.play()
        assert ("animated-scale" in app.warnings.codes()) is said


def test_a_sensor_that_does_not_count_from_its_parent_stays():
    stage = stage_with_a_mover()
    mast = UsdGeom.Xform.Define(stage, "/World/Mover/Mast")
    mast.AddTranslateOp().Set((0, 0, 2))
    mast.SetResetXformStack(True)
    with App(stage) as app:
        app.play()
        app.update(steps=30)
        assert app.fabric.world_matrix("/World/Mover/Mast")[:3, 3] == pytest.approx([0, 0, 2])
