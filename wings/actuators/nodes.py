"""The node that steps the explicit actuators of a robot."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from graph.base.records import dataclass
from graph.node import Attribute, Database, NodeAtLoad, node_type
from graph.sim.scene.prim_paths import prim_at
from nodes.isaac.articulation import robot_at

if TYPE_CHECKING:
    from .robot import Actuated


@dataclass(slots=True)
class _Driven:
    """The robot with its actuators, and what ends their step before each physics step."""

    path: str = ""
    robot: Actuated | None = None
    end: Any = None


def _release(db: Database) -> None:
    if db.memory.end is not None:
        db.memory.end()
        db.memory.end = None


def _check(node: NodeAtLoad) -> Iterator[tuple[str, str]]:
    """Actuators below the robot that cannot be: without control, with wrong parameters, of neural networks."""
    from .robot import actuator_of, actuator_prims

    if "robotPath" in node.given:
        for prim in actuator_prims(prim_at(node.stage, str(node.db.inputs.robotPath))):
            try:
                actuator_of(prim)
            except (ValueError, NotImplementedError) as error:
                yield "robotPath", str(error)


@node_type(
    "isaacsim.core.experimental.actuators.ArticulationActuators",
    version=1,
    needs=(("robotPath",),),
    inputs={
        "execIn": Attribute("execution", "sets the feedforward, and steps the actuators unless they step themselves"),
        "robotPath": Attribute("string", "path of the articulation's root prim", role="prim"),
        "autoStepPrePhysics": Attribute("bool", "the actuators step before each physics step", default=True),
        "stepDt": Attribute("double", "length of a step that execIn makes", default=0.016667, unit="s"),
        "feedforwardCommand": Attribute(
            "float[]", "added to the efforts; one per joint, or one for all; empty leaves it", unit="N m or N"
        ),
        "indices": Attribute("int[]", "the robots that get the feedforward; the node has one, number 0"),
        "dofIndices": Attribute("int[]", "the joints that get it, by number; empty means all"),
    },
    memory=_Driven,
    check=_check,
    release=_release,
)
def articulation_actuators(db: Database) -> bool:
    """Move joints by the NewtonActuator prims below the robot: delay, PD or PID control, limits of the motor.

    Drives of these joints lose their stiffness and damping until the stop; position and velocity targets, as of the
    articulation controller, are what the actuators follow.
    """
    inputs, memory, app = db.inputs, db.memory, db.app
    if app.timeline.is_stopped():
        return False
    if not inputs.robotPath:
        db.lack("no robot; set robotPath to the root prim of an articulation")
    if inputs.robotPath != memory.path:
        _release(db)
        memory.robot, memory.path = _found(db, inputs.robotPath), inputs.robotPath
    robot = memory.robot
    if inputs.autoStepPrePhysics and memory.end is None:
        memory.end = app.simulation.pre_step.add(lambda: robot.step(float(1 / app.simulation.steps_per_second)))
    elif not inputs.autoStepPrePhysics:
        _release(db)
    if len(inputs.feedforwardCommand):
        _feed(db)
    if not inputs.autoStepPrePhysics:
        robot.step(inputs.stepDt)
    return True


def _found(db: Database, path: str) -> Actuated:
    from .robot import Actuated, actuators_below

    articulation = robot_at(db, path)
    try:
        found = actuators_below(db.app.stage.GetPrimAtPath(path), articulation.joint_paths)
    except (ValueError, NotImplementedError) as error:
        db.fail(str(error))
    if not found:
        db.lack(f"{path} has no prim NewtonActuator below it")
    robot = Actuated(db.app, [path], found)
    robot.release_drives()
    return robot


def _feed(db: Database) -> None:
    inputs, robot = db.inputs, db.memory.robot
    count = len(robot.robots[0].joint_paths)
    joints = [int(one) for one in inputs.dofIndices] or list(range(count))
    wrong = next((one for one in joints if not 0 <= one < count), None)
    if wrong is not None:
        db.fail(f"dofIndices has {wrong}; {inputs.robotPath} has the joints 0 to {count - 1}")
    if any(int(one) != 0 for one in inputs.indices):
        db.fail("indices has a number above 0; robotPath names one robot, number 0")
    if len(inputs.feedforwardCommand) not in (1, len(joints)):
        db.fail(f"feedforwardCommand has {len(inputs.feedforwardCommand)} entries for {len(joints)} joints")
    robot.feed(inputs.feedforwardCommand, [0], joints)
