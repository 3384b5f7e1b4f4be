"""Joints that prims NewtonActuator move by the node, against numbers worked out by hand."""

import pytest

from graph import ComputeError
from graph.files import loads
from graph.node import registry
from graph.session.open import build_parts
from graph.testing import run_node
from nodes.catalog.example import example
from tests.support.fixed_robots import define_base, define_joint

ROOT = "/World/Robot"
HINGE = f"{ROOT}/hinge"
INERTIA = 0.4 * 0.1**2  # of 1 kg without a collider: that of a ball of 0.1 m [kg m2]


@pytest.fixture
def robot(stage, world):
    """A function that opens a world with a cube on a hinge through its middle; a drive and actuators are on it."""
    from pxr import Sdf

    define_base(stage, ROOT)
    define_joint(stage, ROOT, "hinge", "link", (0, 0, 1), stiffness=1e4, damping=1e3)

    def open_world(*actuators):
        for number, (schemas, values) in enumerate(actuators):
            prim = stage.DefinePrim(f"{ROOT}/Actuators/act{number}", "NewtonActuator")
            for schema in schemas:
                prim.AddAppliedSchema(schema)
            for name, value in values.items():
                prim.CreateAttribute(f"newton:{name}", Sdf.ValueTypeNames.Float).Set(value)
            prim.CreateRelationship("newton:targets").SetTargets([HINGE])
        return world(physics_hz=60, loop_hz=60)

    return open_world


FREE = (("NewtonPDControlAPI",), {"kp": 0.0, "kd": 0.0})


def run(app, updates, pulses=None, **inputs):
    pulses = {"execIn": range(updates)} if pulses is None else pulses
    return run_node(
        "ArticulationActuators", inputs={"robotPath": ROOT, **inputs}, pulses=pulses, updates=updates, app=app
    )


def test_a_feedforward_alone_accelerates_the_joint(robot):
    app = robot(FREE)
    run(app, 11, feedforwardCommand=[0.001])
    found = app.physics.articulation(ROOT)
    assert found.commanded("efforts") == pytest.approx([0.001])
    # The first update computes the node after its physics step; ten steps of 1/60 s follow.
    assert found.velocities == pytest.approx([0.001 / INERTIA * 10 / 60], rel=1e-6)


def test_steps_of_the_node_itself_act_in_the_next_physics_step(robot):
    app = robot(FREE)
    run(app, 11, feedforwardCommand=[0.001], autoStepPrePhysics=False)
    assert app.physics.articulation(ROOT).velocities == pytest.approx([0.001 / INERTIA * 10 / 60], rel=1e-6)


def test_the_joint_follows_its_target_by_the_actuator_and_not_by_its_drive(robot):
    app = robot((("NewtonPDControlAPI",), {"kp": 1.0, "kd": 0.1}))
    run(app, 1)
    found = app.physics.articulation(ROOT)
    found.set_targets(positions=[0.3])
    app.update()
    assert found.commanded("efforts") == pytest.approx([0.3])  # kp x 0.3 at rest; the drive would give far more
    for _ in range(120):
        app.update()
    assert found.positions == pytest.approx([0.3], abs=1e-3)


def test_efforts_stay_within_the_limit_of_the_motor(robot):
    limited = ("NewtonPDControlAPI", "NewtonMaxEffortClampingAPI")
    app = robot((limited, {"kp": 100.0, "kd": 0.0, "maxEffort": 0.002}))
    run(app, 1)
    found = app.physics.articulation(ROOT)
    found.set_targets(positions=[0.3])
    app.update()
    assert found.commanded("efforts") == pytest.approx([0.002], rel=1e-6)


def test_a_stop_gives_the_drive_back(robot):
    app = robot(FREE)
    drive = app.stage.GetPrimAtPath(HINGE).GetAttribute("drive:angular:physics:stiffness")
    run(app, 2)
    assert drive.Get() == 0
    app.stop()
    assert drive.Get() == 1e4


@pytest.mark.parametrize(
    ("actuators", "inputs", "said"),
    [
        ([], {}, "has no prim NewtonActuator below it"),
        ([FREE, FREE], {}, "has two actuators"),
        ([(("NewtonMaxEffortClampingAPI",), {"maxEffort": 1.0})], {}, "has 0 controllers"),
        ([(("NewtonPDControlAPI", "NewtonDCMotorClampingAPI"), {})], {}, "needs newton:saturationEffort"),
        ([(("NewtonPDControlAPI",), {"kp": -1.0})], {}, "kp must be 0 or more"),
        ([FREE], {"feedforwardCommand": [1.0, 2.0]}, "2 entries for 1 joints"),
        ([FREE], {"feedforwardCommand": [1.0], "dofIndices": [3]}, "dofIndices has 3"),
        ([FREE], {"feedforwardCommand": [1.0], "indices": [1]}, "one robot, number 0"),
    ],
)
def test_what_cannot_work_is_refused_in_a_line(robot, actuators, inputs, said):
    with pytest.raises(ComputeError, match=said):
        run(robot(*actuators), 1, **inputs)


def test_an_actuator_that_cannot_be_is_told_before_a_run():
    text = example(registry.get("ArticulationActuators")).replace("NewtonPDControlAPI", "NewtonNeuralControlAPI")
    (problem,) = build_parts(loads(text)).problems
    assert "neural networks do not run here; use PD or PID control" in problem.message
