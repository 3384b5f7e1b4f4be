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
        ("Robots/IsaacSim/Ant/ant_instanceable.usd", "joints/left_back_foot", "PhysicsRevoluteJoint"),
        ("Robots/IsaacSim/Ant/ant_colored.usd", "Arm_04/Lower_Arm/lower_arm_joint", "PhysicsRevoluteJoint"),
        (
            "Robots/IsaacSim/SimpleArticulation/simple_articulation.usd",
            "Slider/PrismaticJoint",
            "PhysicsPrismaticJoint",
        ),
        ("Robots/NVIDIA/Jetbot/jetbot.usd", "chassis/left_wheel_joint", "PhysicsRevoluteJoint"),
        ("Robots_Multiphysics/NVIDIA/Jetbot/jetbot.usda", "chassis/left_wheel_joint", "PhysicsRevoluteJoint"),
        ("Robots_Multiphysics/IsaacSim/Ant/ant.usda", "joints/left_back_foot", "PhysicsRevoluteJoint"),
        (
            "Robots_Multiphysics/FrankaRobotics/FrankaPanda/franka/franka.usda",
            "panda_link6/panda_joint7",
            "PhysicsRevoluteJoint",
        ),
        ("Robots/FrankaRobotics/FrankaPanda/franka.usd", "panda_link6/panda_joint7", "PhysicsRevoluteJoint"),
        ("Robots/FrankaRobotics/FrankaFR3/fr3.usd", "fr3_link6/fr3_joint7", "PhysicsRevoluteJoint"),
        ("Robots/Turtlebot/Turtlebot3/turtlebot3_burger.usd", "base_link/wheel_left_joint", "PhysicsRevoluteJoint"),
        ("Robots/iRobot/Create3/create_3.usd", "base_link/left_wheel_joint", "PhysicsRevoluteJoint"),
        ("Robots/Crazyflie/cf2x.usd", "body/m4_joint", "PhysicsRevoluteJoint"),
        ("Robots/Clearpath/Jackal/jackal.usd", "base_link/rear_left_wheel", "PhysicsRevoluteJoint"),
        ("Robots/NVIDIA/Carter/carter_v1_physx_lidar.usd", "chassis_link/left_wheel", "PhysicsRevoluteJoint"),
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


@pytest.mark.parametrize(
    ("asset", "chassis", "radius", "wheels"),
    [
        ("Jetbot/jetbot.usd", "chassis", 0.03, ["left_wheel_joint", "right_wheel_joint"]),
        ("NVIDIA/NovaCarter/nova_carter.usd", "chassis_link", 0.14, ["joint_wheel_left", "joint_wheel_right"]),
        ("NVIDIA/Carter/carter_v1.usd", "chassis_link", 0.24, ["left_wheel", "right_wheel"]),
    ],
)
def test_a_robot_on_two_wheels_drives_by_them(tmp_path, asset, chassis, radius, wheels):
    """Both rims move at 0.3 m/s: after a second the robot is at 0.3 m, less the start."""
    with App(open_stage(scene(tmp_path, f"{ROOT}/Isaac/Robots/{asset}", GROUND))) as app:
        app.play()
        tensors = app.simulation.tensors
        assert [path.rpartition("/")[2] for path in tensors.joint_paths] == wheels
        tensors.set_joint_targets(velocities=[0.3 / radius] * 2)
        app.update(steps=60)
        x, y, _ = app.simulation.tensors.positions[list(tensors.body_paths).index(f"/P0/{chassis}")]
        assert 0.25 < x < 0.305
        assert abs(y) < 0.01


def test_the_forklift_turns_about_its_front_axle_by_its_back_wheels(tmp_path):
    """Back wheels at -atan(base / (r -+ half a track)) from a circle of r = 4 m: yaw grows by speed / r."""
    with App(open_stage(scene(tmp_path, f"{ROOT}/Isaac/Robots/IsaacSim/ForkliftC/forklift_c.usd", GROUND))) as app:
        app.play()
        robot = app.physics.articulation("/P0")
        names = list(robot.joint_names)
        assert sorted(names) == sorted(
            [f"{side}_{end}_wheel_joint" for side in ("left", "right") for end in ("front", "back")]
            + ["left_rotator_joint", "right_rotator_joint"]
        )
        turns = [-np.arctan2(1.65, 4.0 - side * 0.525) for side in (1, -1)]
        robot.set_targets(positions=turns, joints=[names.index(f"{one}_rotator_joint") for one in ("left", "right")])
        app.update(steps=60)
        speeds = [1.5 * (4.0 - side * 0.525) / 4.0 / 0.325 for side in (1, -1)]
        front = [names.index(f"{one}_front_wheel_joint") for one in ("left", "right")]
        back = [names.index(f"{one}_back_wheel_joint") for one in ("left", "right")]
        robot.set_targets(velocities=speeds, joints=front)
        robot.set_targets(velocities=[np.hypot(1.65, 4.0 - s * 0.525) * 1.5 / 4 / 0.255 for s in (1, -1)], joints=back)
        app.update(steps=120)
        row = list(app.simulation.tensors.body_paths).index("/P0/body")
        assert app.simulation.tensors.angular_velocities[row][2] == pytest.approx(1.5 / 4.0, rel=0.1)


def test_the_cart_slides_and_its_pole_swings(tmp_path):
    with App(open_stage(scene(tmp_path, f"{ROOT}/Isaac/Robots/IsaacSim/Cartpole/cartpole.usd"))) as app:
        app.play()
        robot = app.physics.articulation("/P0")
        assert (list(robot.joint_names), list(robot.linear)) == (["cartJoint", "poleJoint"], [True, False])


def test_a_variant_of_the_franka_can_be_chosen(tmp_path):
    stage, _ = opened(scene(tmp_path, f"{ROOT}/Isaac/Robots/FrankaRobotics/FrankaPanda/franka.usd"))
    sets = stage.GetPrimAtPath("/P0").GetVariantSets()
    assert sets.GetAllVariantSelections() == {"Gripper": "Default", "Mesh": "Performance"}
    assert sets.GetVariantSet("Gripper").SetVariantSelection("AlternateFinger")
    assert stage.GetPrimAtPath("/P0/panda_leftfinger")


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


@pytest.mark.parametrize("name", ["ant_colored", "ant_instanceable"])
def test_the_ant_stands_on_four_legs_whose_tips_bear_its_weight(tmp_path, name):
    file = scene(tmp_path, f"{ROOT}/Isaac/Robots/IsaacSim/Ant/{name}.usd")
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


@pytest.mark.parametrize(
    ("asset", "names", "height"),
    [
        ("Unitree/Go2/go2.usd", ("hip_joint", "thigh_joint", "calf_joint"), 0.3),
        ("Unitree/Go1/go1.usd", ("hip_joint", "thigh_joint", "calf_joint"), 0.3),
        ("Unitree/A1/a1.usd", ("hip_joint", "thigh_joint", "calf_joint"), 0.3),
        ("BostonDynamics/spot/spot.usd", ("hx", "hy", "kn"), 0.5),
    ],
)
def test_a_robot_on_four_legs_stands(tmp_path, asset, names, height):
    file = scene(tmp_path, GROUND, f"{ROOT}/Isaac/Robots/{asset}")
    with App(open_stage(file)) as app:
        place(app.stage.GetPrimAtPath("/P1"), positions=np.array([0, 0, height + 0.1]))
        app.play()
        tensors = app.simulation.tensors
        joints = [path.rpartition("/")[2] for path in tensors.joint_paths]
        legs = ["fl", "fr", "hl", "hr"] if "spot" in asset else ["FL", "FR", "RL", "RR"]
        assert sorted(joints) == sorted(f"{leg}_{name}" for leg in legs for name in names)
        assert joints[:4] == [f"{leg}_{names[0]}" for leg in legs]
        app.update(steps=120)
        trunk = tensors.positions[0]
        assert height - 0.06 < trunk[2] < height + 0.06
        assert abs(trunk[1]) < 0.01


@pytest.mark.parametrize(
    ("asset", "prim", "solid"),
    [("Axis_Aligned_Physics/003_cracker_box.usd", "/P0", True), ("Axis_Aligned/025_mug.usd", "/P0", False)],
)
def test_a_ycb_object_is_a_body_only_in_the_folder_of_bodies(tmp_path, asset, prim, solid):
    stage, _ = opened(scene(tmp_path, f"{ROOT}/Isaac/Props/YCB/{asset}"))
    root = stage.GetPrimAtPath(prim)
    assert root.HasAPI(UsdPhysics.RigidBodyAPI) is solid
    assert stage.GetPrimAtPath(f"{prim}/shape").HasAPI(UsdPhysics.CollisionAPI) is solid
    if solid:
        assert root.GetAttribute("physics:mass").Get() == pytest.approx(0.411)
        assert root.GetAttribute("physxRigidBody:disableGravity").Get() is False
