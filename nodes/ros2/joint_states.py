"""Joint states of a robot as a ROS 2 topic."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

from graph.base.records import dataclass
from graph.node import Attribute, Database, node_type
from nodes.isaac.articulation import robot_at
from nodes.isaac.clocks import stamp_ns

from .publishing import TIME_STAMP, Publisher, check_names, publisher_inputs, subscribed_topic
from .robot_messages import JOINT_STATE, joint_state

if TYPE_CHECKING:
    from graph.sim.app import App

GIVEN = "one per joint, or none; with jointNames"
PRISMATIC = 1


@dataclass(slots=True)
class _Joints(Publisher):
    path: str = ""
    articulation: Any = None
    scale: Any = None


@node_type(
    "isaacsim.ros2.bridge.ROS2PublishJointState",
    version=1,
    needs=(("targetPrim", "jointNames"),),
    check=check_names,
    inputs={
        "execIn": Attribute("execution", "publishes the joints"),
        "targetPrim": Attribute("target", "the robot's root prim; read where jointNames is empty"),
        **publisher_inputs("joint_states"),
        "timeStamp": TIME_STAMP,
        "jointNames": Attribute("token[]", "names of the joints to publish instead of a robot's"),
        "jointPositions": Attribute("double[]", f"positions, {GIVEN}", unit="rad or stage units"),
        "jointVelocities": Attribute("double[]", f"speeds, {GIVEN}", unit="rad/s or stage units/s"),
        "jointEfforts": Attribute("double[]", f"efforts, {GIVEN}", unit="N m or N"),
        "jointDofTypes": Attribute("uchar[]", f"0 turns, 1 slides, {GIVEN}"),
        "stageMetersPerUnit": Attribute(
            "float", "metres in a unit, for joints that slide; 0 leaves values", default=0.0
        ),
        "sensorTime": Attribute(
            "float",
            "stamp of the message where timeStamp is 0 and not connected",
            default=0.0,
            unit="s",
            role="stamp",
        ),
    },
    memory=partial(_Joints, JOINT_STATE),
)
def publish_joint_state(db: Database) -> bool:
    """Publish `sensor_msgs/JointState` in rad and m: the joints that the inputs give, else those of targetPrim."""
    topic = subscribed_topic(db)
    if topic is None:
        return False
    inputs = db.inputs
    columns = _given(db) if len(inputs.jointNames) else _of_robot(db)
    time = inputs.timeStamp
    if time == 0 and inputs.sensorTime > 0 and not db.connected("timeStamp"):
        time = inputs.sensorTime
    nanoseconds = stamp_ns(db.app, time)
    db.app.bus.publish(topic, JOINT_STATE, joint_state(nanoseconds, *columns), nanoseconds)
    return True


def _given(db: Database) -> tuple[Any, ...]:
    """Names, positions, velocities, efforts from the inputs, with prismatic joints scaled to metres."""
    import numpy as np

    inputs = db.inputs
    names, kinds = inputs.jointNames, inputs.jointDofTypes
    columns = {
        "jointPositions": inputs.jointPositions,
        "jointVelocities": inputs.jointVelocities,
        "jointEfforts": inputs.jointEfforts,
    }
    for name, column in (*columns.items(), ("jointDofTypes", kinds)):
        if len(column) not in (0, len(names)):
            db.fail(f"{name} has {len(column)} values for {len(names)} joints; give one for each, or none")
    positions, velocities, efforts = columns.values()
    unit = inputs.stageMetersPerUnit
    if unit > 0 and unit != 1 and len(kinds):
        # The nearest decimal: as a float32, 0.01 is a little less.
        scale = np.where(np.asarray(kinds) == PRISMATIC, float(np.format_float_positional(np.float32(unit))), 1.0)
        positions, velocities = (column * scale if len(column) else column for column in (positions, velocities))
    return list(names), positions, velocities, efforts


def _of_robot(db: Database) -> tuple[Any, ...]:
    """Names, positions, velocities, efforts of the robot at targetPrim."""
    inputs, memory, app = db.inputs, db.memory, db.app
    path = str(inputs.targetPrim[0]) if inputs.targetPrim else ""
    if path != memory.path or memory.articulation is None:
        if not path:
            db.lack("nothing to publish; set targetPrim to a robot's root prim, or connect jointNames")
        memory.path, memory.articulation = path, robot_at(db, path)
        memory.scale = _metres(app, memory.articulation)
    robot, scale = memory.articulation, memory.scale
    return robot.labels, robot.positions * scale, robot.velocities * scale, robot.efforts


def _metres(app: App, robot: Any) -> Any:
    """(J,) factors that convert a joint's value to rad or m."""
    import numpy as np

    return np.where(robot.linear, app.meters_per_unit, 1.0)
