import math

import pytest

from graph import ComputeError
from graph.session.open import build_parts
from graph.testing import run_node
from tests.support.fixed_robots import define_cart


@pytest.fixture
def cart(stage, world):
    """A function that opens a world with /World/Cart."""
    define_cart(stage, damping=100.0)
    return lambda: world(physics_hz=240)


def speeds(app, updates=60, **inputs):
    inputs = {"targetPrim": "/World/Cart", **inputs}
    run_node("IsaacArticulationController", inputs=inputs, pulses={"execIn": range(updates)}, updates=updates, app=app)
    articulation = app.physics.articulation("/World/Cart")
    return dict(zip(articulation.joint_names, articulation.velocities.tolist(), strict=True))


def test_velocity_commands_reach_all_joints_in_their_order(cart):
    found = speeds(cart(), velocityCommand=[2.0, -3.0])
    assert found == pytest.approx({"left_joint": 2.0, "right_joint": -3.0}, rel=0.02)


def test_joints_are_chosen_by_name_in_the_order_of_the_names(cart):
    found = speeds(cart(), jointNames=["right_joint", "left_joint"], velocityCommand=[2.0, -3.0])
    assert found == pytest.approx({"left_joint": -3.0, "right_joint": 2.0}, rel=0.02)


def test_names_win_over_indices_and_robotPath_over_targetPrim(cart):
    found = speeds(
        cart(),
        robotPath="/World/Cart",
        targetPrim="/World",
        jointNames=["right_joint"],
        jointIndices=[0],
        velocityCommand=[2.0],
    )
    assert found["right_joint"] == pytest.approx(2.0, rel=0.02)
    assert abs(found["left_joint"]) < 0.1


def test_index_0_alone_means_joint_0_alone(cart):
    found = speeds(cart(), jointIndices=[0], velocityCommand=[2.0])
    assert found["left_joint"] == pytest.approx(2.0, rel=0.02)
    assert abs(found["right_joint"]) < 0.1


def test_nan_leaves_a_joint_at_its_last_command(cart):
    commands = {0: [1.0, 1.0], 30: [math.nan, 4.0]}
    found = speeds(cart(), velocityCommand=lambda update: commands[0 if update < 30 else 30])
    assert found == pytest.approx({"left_joint": 1.0, "right_joint": 4.0}, rel=0.02)


def test_an_empty_command_leaves_all_joints_alone(cart):
    found = speeds(cart(), velocityCommand=lambda update: [2.0, -3.0] if update == 0 else [])
    assert found == pytest.approx({"left_joint": 2.0, "right_joint": -3.0}, rel=0.02)


def test_a_command_of_wrong_width_fails_and_nothing_is_sent(cart):
    app = cart()
    with pytest.raises(ComputeError, match="effortCommand has 3 values for 2 joints of /World/Cart; nothing was sent"):
        speeds(app, velocityCommand=[2.0, -3.0], effortCommand=[1.0, 2.0, 3.0])
    app.update(30)
    assert app.physics.articulation("/World/Cart").velocities == pytest.approx([0, 0], abs=0.01)


@pytest.mark.parametrize(
    ("inputs", "message"),
    [
        ({"jointNames": ["lift_joint"], "velocityCommand": [1.0]}, "no joint lift_joint; the robot has left_joint"),
        (
            {"jointNames": ["left_joint", ""], "velocityCommand": [1.0, 1.0]},
            r"jointNames\[1\] is unset; the robot has left",
        ),
        ({"jointIndices": [2], "velocityCommand": [1.0]}, "no joint with index 2; the robot has 2 joints"),
        ({"targetPrim": []}, "no robot; set targetPrim or robotPath"),
    ],
)
def test_a_joint_or_robot_that_is_not_there_is_reported(cart, inputs, message):
    with pytest.raises(ComputeError, match=message):
        speeds(cart(), **inputs)


def test_a_world_without_the_prim_has_no_robot(world):
    with pytest.raises(ComputeError, match="there is no prim /World/Cart on the stage; correct the path"):
        speeds(world(), velocityCommand=[1.0])


def test_a_command_to_a_joint_without_drive_warns(stage, cart):
    from pxr import UsdPhysics

    prim = stage.GetPrimAtPath("/World/Cart/left_joint")
    prim.RemoveAPI(UsdPhysics.DriveAPI, "angular")
    app = cart()
    inputs = {"targetPrim": "/World/Cart", "velocityCommand": [1.0, 1.0]}
    trace = run_node("IsaacArticulationController", inputs=inputs, pulses={"execIn": range(3)}, updates=3, app=app)
    assert [(one.code, one.count) for one in trace.warnings] == [("joint-without-drive", 1)]


@pytest.mark.parametrize(
    ("gain", "command", "follows"),
    [
        ("damping", "velocityCommand", True),
        ("stiffness", "positionCommand", True),
        ("stiffness", "velocityCommand", False),
        ("damping", "positionCommand", False),
    ],
)
def test_a_command_that_the_drives_gains_ignore_warns(gain, command, follows, stage, cart):
    for name in ("left_joint", "right_joint"):
        prim = stage.GetPrimAtPath(f"/World/Cart/{name}")
        for attribute in ("stiffness", "damping"):
            prim.GetAttribute(f"drive:angular:physics:{attribute}").Set(1.0 if attribute == gain else 0.0)
    inputs = {"targetPrim": "/World/Cart", command: [1.0, 1.0]}
    trace = run_node("IsaacArticulationController", inputs=inputs, pulses={"execIn": [0]}, updates=1, app=cart())
    assert [one.code for one in trace.warnings] == ([] if follows else ["joint-without-drive"])


def test_a_joint_name_that_the_stage_does_not_have_is_a_mistake_of_the_file(tmp_path):
    text = """\
tickgraph: 1
scene:
  prims:
    /World/Arm: {type: Cube, rigid_body: true}
    /World/hinge: {type: PhysicsRevoluteJoint, attributes: {physics:body1: /World/Arm}}
graphs:
  /World/G:
    nodes:
      go: {type: IsaacArticulationController, inputs: {targetPrim: /World, jointNames: [hinge, hinje]}}
"""
    (tmp_path / "a.yaml").write_text(text)
    problems = build_parts(tmp_path / "a.yaml").problems
    assert [one.message for one in problems] == [
        '/World/G/go.inputs:jointNames: no joint on the stage is called "hinje"; did you mean "hinge"?'
    ]
    assert (problems[0].mark.line, problems[0].mark.column) == (9, 76)
