import timeit
from fractions import Fraction

import numpy as np
import pytest

from graph.base.errors import RunError
from graph.sim.physics import build_physics
from graph.sim.scene.prims import author_prims
from graph.sim.scene.stage import open_stage
from graph.sim.state.fabric import Fabric
from graph.sim.usd import UsdGeom

SCENE = {
    "/Body": {"type": "Cube", "rigid_body": True, "translate": [0, 0, 50], "rotate": [0, 0, 90], "scale": 2},
    "/Body/Mount": {"translate": [1, 0, 0]},
    "/Body/Mount/Lidar": {"type": "OmniLidar", "translate": [0, 0, 0.5]},
    "/Still": {"translate": [1, 2, 3]},
    "/Still/Child": {"translate": [1, 0, 0]},
}
LIDAR = "/Body/Mount/Lidar"


def playing(prims=SCENE, hz=100, unit=1.0):
    stage = open_stage()
    UsdGeom.SetStageMetersPerUnit(stage, unit)
    author_prims(stage, prims)
    fabric, physics = Fabric(stage), build_physics(stage, Fraction(1, hz))
    fabric.bind(physics)
    return fabric, physics, stage


def step(fabric, physics, count=1):
    for _ in range(count):
        physics.step()
        fabric.stepped()


def placed(x, y, z):
    matrix = np.eye(4)
    matrix[:3, 3] = x, y, z
    return matrix


def place(matrix):
    return matrix[:3, 3].tolist()


def test_what_is_below_a_body_follows_it_at_its_composed_offset():
    fabric, physics, _ = playing()
    # (1, 0, 0) in a frame turned by 90 degrees and scaled by 2 is (0, 2, 0); the lidar is 0.5 * 2 higher.
    assert place(fabric.world_matrix(LIDAR)) == pytest.approx([0, 2, 51])
    step(fabric, physics, 10)
    drop = 9.81 * 55 / 100**2
    assert place(fabric.world_matrix(LIDAR)) == pytest.approx([0, 2, 51 - drop])
    assert fabric.world_matrix("/Body")[:3, :3] == pytest.approx(np.array([[0, -2, 0], [2, 0, 0], [0, 0, 2]]))
    assert place(fabric.world_matrix("/Still/Child")) == [2, 2, 3]


def test_many_matrices_come_in_one_call():
    fabric, physics, _ = playing()
    step(fabric, physics, 3)
    paths = ["/Still", LIDAR, "/Body", LIDAR]
    together = fabric.world_matrices(paths)
    assert together.shape == (4, 4, 4)
    assert all((together[i] == fabric.world_matrix(path)).all() for i, path in enumerate(paths))


def test_positions_are_in_stage_units_and_rigid_poses_in_metres():
    prims = {"/Body": {"type": "Cube", "rigid_body": True, "translate": [0, 0, 500], "scale": 3}}
    fabric, physics, _ = playing(prims, unit=0.01)
    step(fabric, physics, 10)
    drop = 9.81 * 55 / 100**2
    assert place(fabric.world_matrix("/Body")) == pytest.approx([0, 0, 500 - 100 * drop])
    rigid = fabric.rigid_matrices(["/Body"])[0]
    assert place(rigid) == pytest.approx([0, 0, 5 - drop])
    assert rigid[:3, :3] == pytest.approx(np.eye(3))


def test_a_snapshot_outlives_the_moment():
    fabric, physics, _ = playing()
    step(fabric, physics, 5)
    then = fabric.capture()
    before = fabric.world_matrix(LIDAR).copy()
    step(fabric, physics, 5)
    assert (fabric.world_matrix(LIDAR, then) == before).all()
    assert fabric.world_matrix(LIDAR)[2, 3] < before[2, 3]
    assert fabric.velocities(["/Body", "/Still"], then) == pytest.approx(
        np.array([[0, 0, -9.81 * 5 / 100, 0, 0, 0], [0.0] * 6])
    )
    with pytest.raises(ValueError, match="read-only"):
        then.positions[0, 0] = 1


def test_the_stamp_changes_with_every_step_and_write_and_a_step_costs_no_pose():
    fabric, _, _ = playing()
    stamps = [fabric.stamp]
    for act in (fabric.stepped, lambda: fabric.set_world_matrix("/Still", placed(0, 0, 0)), fabric.stepped):
        act()
        stamps.append(fabric.stamp)
    assert len(set(stamps)) == 4
    assert min(timeit.repeat(fabric.stepped, number=1000, repeat=5)) / 1000 < 5e-6


def test_a_users_write_to_a_parent_does_not_move_its_children():
    fabric, _, _ = playing()
    child = fabric.world_matrix("/Still/Child")
    fabric.set_world_matrix("/Still", placed(7, 7, 7))
    assert place(fabric.world_matrix("/Still")) == [7, 7, 7]
    assert (fabric.world_matrix("/Still/Child") == child).all()
    fabric.unbind()
    assert place(fabric.world_matrix("/Still")) == [1, 2, 3]


def test_a_written_body_is_moved_in_physics_and_takes_its_children_along():
    fabric, physics, _ = playing()
    step(fabric, physics)
    fabric.set_world_matrix("/Body", placed(10, 0, 30))
    assert place(fabric.world_matrix("/Body")) == pytest.approx([10, 0, 30])
    assert place(fabric.world_matrix(LIDAR)) == pytest.approx([12, 0, 31])
    step(fabric, physics)
    assert place(fabric.world_matrix("/Body"))[0] == pytest.approx(10)


def test_a_written_sensor_follows_its_body_from_its_new_place_on():
    fabric, physics, _ = playing()
    fabric.set_world_matrix(LIDAR, placed(0, 0, 60))
    step(fabric, physics, 10)
    assert place(fabric.world_matrix(LIDAR)) == pytest.approx([0, 0, 60 - 9.81 * 55 / 100**2])
    fabric.unbind()
    assert place(fabric.world_matrix(LIDAR)) == pytest.approx([0, 2, 51])


def test_edits_of_the_stage_are_seen():
    fabric, physics, stage = playing()
    step(fabric, physics, 10)
    fabric.world_matrices(["/Still/Child", LIDAR])
    stamp = fabric.stamp
    stage.GetPrimAtPath("/Still").GetAttribute("xformOp:translate").Set((0, 0, 0))
    stage.GetPrimAtPath(LIDAR).GetAttribute("xformOp:translate").Set((0, 0, 1))
    assert fabric.stamp > stamp
    assert place(fabric.world_matrix("/Still/Child")) == [1, 0, 0]
    assert place(fabric.world_matrix(LIDAR)) == pytest.approx([0, 2, 52 - 9.81 * 55 / 100**2])


def test_a_prim_that_is_not_there_is_named():
    fabric, _, _ = playing()
    with pytest.raises(RunError, match=r"/Nowhere: no such prim on the stage"):
        fabric.world_matrix("/Nowhere")
    with pytest.raises(RunError, match=r"/Still: a world matrix must be"):
        fabric.set_world_matrix("/Still", np.zeros((4, 4)))


def test_attributes_live_beside_the_stage_with_change_stamps():
    fabric, _, stage = playing()
    assert fabric.get("/ExternalSimulationTime", "omni:time") is None
    fabric.set("/ExternalSimulationTime", "omni:time", 0.0)
    fabric.set("/ExternalSimulationTime", "omni:time", 0.5)
    assert fabric.get("/ExternalSimulationTime", "omni:time") == 0.5
    assert fabric.change_stamp("/ExternalSimulationTime", "omni:time") == 1
    assert fabric.change_stamp("/Body", "size") == -1
    assert fabric.get("/Body", "size") == 2.0
    fabric.set("/Body", "size", 9.0)
    assert stage.GetPrimAtPath("/Body").GetAttribute("size").Get() == 2.0
    fabric.unbind()
    assert fabric.get("/Body", "size") == 2.0
    assert fabric.get("/ExternalSimulationTime", "omni:time") == 0.5


def test_physics_writes_nothing_to_the_stage():
    fabric, physics, stage = playing()
    before = stage.GetRootLayer().ExportToString(), stage.GetSessionLayer().ExportToString()
    step(fabric, physics, 50)
    fabric.set_world_matrix("/Still", placed(1, 1, 1))
    fabric.world_matrix(LIDAR)
    assert (stage.GetRootLayer().ExportToString(), stage.GetSessionLayer().ExportToString()) == before


def test_without_physics_the_stage_is_read():
    stage = open_stage()
    author_prims(stage, SCENE)
    fabric = Fabric(stage)
    assert place(fabric.world_matrix(LIDAR)) == pytest.approx([0, 2, 51])
    assert fabric.rigid_matrices(["/Body"])[0][:3, :3] == pytest.approx(np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]]))
    assert fabric.capture().velocities(["/Body"]).tolist() == [[0.0] * 6]
