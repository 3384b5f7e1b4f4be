"""Stand-ins for assets that are not downloaded: their prims, joints, limits and weights."""

import numpy as np
import pytest

from graph.sim import App
from graph.sim.scene.stage import open_stage
from graph.sim.usd import UsdGeom, UsdPhysics
from sensors.xform import place
from tests.graph.sim.scene.test_assets import GROUND, ROOT, opened, scene


@pytest.mark.parametrize(
    ("asset", "prim", "kind"),
    [
        ("Environments/Grid/default_environment.usd", "GroundPlane", "Plane"),
        ("Environments/Grid/default_environment.usd", "SphereLight", "SphereLight"),
        ("Environments/Simple_Room/simple_room.usd", "wall_east", "Cube"),
        ("Environments/Simple_Room/simple_room.usd", "SphereLight", "SphereLight"),
        ("Environments/Simple_Warehouse/warehouse.usd", "SphereLight", "SphereLight"),
        ("Environments/Simple_Warehouse/full_warehouse.usd", "rack_0_shelf_0", "Cube"),
        ("Props/Blocks/basic_block.usd", "Cube", "Cube"),
        ("Robots/IsaacSim/Ant/ant_colored.usd", "Arm_04/Lower_Arm/lower_arm_joint", "PhysicsRevoluteJoint"),
        (
            "Robots/IsaacSim/SimpleArticulation/simple_articulation.usd",
            "Slider/PrismaticJoint",
            "PhysicsPrismaticJoint",
        ),
        ("Robots/NVIDIA/Jetbot/jetbot.usd", "chassis/left_wheel_joint", "PhysicsRevoluteJoint"),
        ("Robots/FrankaRobotics/FrankaPanda/franka.usd", "panda_link6/panda_joint7", "PhysicsRevoluteJoint"),
    ],
)
def test_a_known_asset_that_is_not_here_has_a_stand_in_that_is_said_once(tmp_path, asset, prim, kind):
    address = f"{ROOT}/Isaac/{asset}"
    stage, warnings = opened(scene(tmp_path, address, address))
    assert stage.GetPrimAtPath(f"/P1/{prim}").GetTypeName() == kind
    ((code, where, message),) = warnings
    assert (code, where) == ("asset-stand-in", address)
    assert message.startswith("it is not downloaded; in its place: ")


def test_the_franka_has_the_joints_and_limits_of_the_original(tmp_path):
    file = scene(tmp_path, f"{ROOT}/Isaac/Robots/FrankaRobotics/FrankaPanda/franka.usd")
    with App(open_stage(file)) as app:
        app.play()
        tensors = app.simulation.tensors
        names = [path.rpartition("/")[2] for path in tensors.joint_paths]
        assert names == [f"panda_joint{n}" for n in range(1, 8)] + ["panda_finger_joint1", "panda_finger_joint2"]
        home = [0, -0.57, 0, -2.81, 0, 3.037, 0.741, 0.04, 0.04]
        assert np.allclose(tensors.joint_positions, home, atol=1e-3)
        app.update(steps=60)
        assert np.allclose(tensors.joint_positions, home, atol=0.02)  # its drives hold it against gravity
        joint = app.stage.GetPrimAtPath("/P0/panda_link3/panda_joint4")
        limits = [joint.GetAttribute(f"physics:{side}Limit").Get() for side in ("lower", "upper")]
        assert np.allclose(np.radians(limits), [-3.0718, -0.0698], atol=1e-4)


def test_the_jetbot_drives_by_its_wheels(tmp_path):
    """0.03 m x 10 rad/s x 1 s = 0.3 m, less the start."""
    with App(open_stage(scene(tmp_path, f"{ROOT}/Isaac/Robots/Jetbot/jetbot.usd", GROUND))) as app:
        app.play()
        tensors = app.simulation.tensors
        tensors.set_joint_targets(velocities=[10.0, 10.0])
        app.update(steps=60)
        x, y, _ = app.simulation.tensors.positions[list(tensors.body_paths).index("/P0/chassis")]
        assert 0.25 < x < 0.305
        assert abs(y) < 0.01


def test_the_pivot_arm_is_a_load_of_two_kilograms_at_a_metre(tmp_path):
    asset = f"{ROOT}/Isaac/Robots/IsaacSim/SimpleArticulation/simple_articulation.usd"
    stage, _ = opened(scene(tmp_path, asset))
    stage.GetPrimAtPath("/P0/Arm/RevoluteJoint").GetAttribute("physics:axis").Set("Y")
    with App(stage) as app:
        app.play()
        app.update(steps=4)
        efforts = app.simulation.tensors.joint_efforts
        # Arm and slider, 1 kg each, with their centres 1 m from the joint: 2 kg x 1 m x 9.81 m/s2, against gravity.
        assert efforts[0] == pytest.approx(-19.62, abs=0.05)


def test_the_ant_stands_on_four_legs_whose_tips_bear_its_weight(tmp_path):
    file = scene(tmp_path, f"{ROOT}/Isaac/Robots/IsaacSim/Ant/ant_colored.usd")
    stage, _ = opened(file)
    plane = UsdGeom.Plane.Define(stage, "/Ground")
    plane.AddTranslateOp().Set((0, 0, -0.78))
    UsdPhysics.CollisionAPI.Apply(plane.GetPrim())
    with App(stage) as app:
        app.play()
        app.update(steps=120)
        held = app.physics.contacts()
        forces = [abs(force[2]) for force in held.forces]
        # A ball of 2 kg and eight links of 0.25 kg: 4 kg.
        assert (len(forces), sum(forces)) == (4, pytest.approx(4 * 9.81, rel=0.02))


def test_a_pose_over_a_referenced_prim_keeps_the_precision_of_its_ops(tmp_path):
    stage, _ = opened(scene(tmp_path, f"{ROOT}/Isaac/Props/Blocks/basic_block.usd"))
    block = stage.GetPrimAtPath("/P0/Cube")
    place(block, positions=np.array([1.0, 2.0, 3.0]), scales=np.array([2.0, 2.0, 2.0]))
    ops = UsdGeom.Xformable(block).GetOrderedXformOps()
    assert [str(op.GetAttr().GetTypeName()) for op in ops] == ["double3", "quatd", "float3"]
    assert tuple(ops[0].Get()) == (1, 2, 3)
    assert tuple(ops[2].Get()) == (2, 2, 2)
