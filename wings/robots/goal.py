"""Whether a robot in the plane has reached its goal."""

from __future__ import annotations

import math

from graph.base.records import dataclass
from graph.node import Attribute, Database, node_type
from wings.robots.planar import heading, wrapped


@dataclass(slots=True)
class _Goal:
    x: float = 0.0
    y: float = 0.0
    heading: float = 0.0


@node_type(
    "isaacsim.robot.wheeled_robots.CheckGoal2D",
    version=1,
    inputs={
        "execIn": Attribute("execution", "compares"),
        "currentPosition": Attribute("vectord[3]", "where the robot is", unit="m"),
        "currentOrientation": Attribute("quatd[4]", "how the robot stands, quaternion x, y, z, w"),
        "target": Attribute("double[3]", "the goal: x, y, heading; taken over with targetChanged", default=[0, 0, 0]),
        "targetChanged": Attribute("bool", "take target over now; the goal is the origin before", default=False),
        "thresholds": Attribute("double[2]", "how close counts: distance [m] and angle [rad]", default=[0.1, 0.1]),
    },
    outputs={
        "execOut": Attribute("execution", "follows every compute"),
        "reachedGoal": Attribute("bool[]", "whether the position is reached, and whether the heading is"),
    },
    memory=_Goal,
)
def check_goal_2d(db: Database) -> None:
    """Compare position and heading with the goal's.

    The original compares the heading itself, not its difference, with the threshold, so that every right turn counts as
    aligned; this is not copied.
    """
    inputs, goal = db.inputs, db.memory
    if inputs.targetChanged:
        goal.x, goal.y, goal.heading = (float(part) for part in inputs.target)
    x, y, _ = inputs.currentPosition
    apart = math.hypot(x - goal.x, y - goal.y)
    turn = abs(wrapped(heading(inputs.currentOrientation) - goal.heading))
    near, aligned = inputs.thresholds
    db.outputs.reachedGoal = [bool(apart <= near), bool(turn <= aligned)]
    db.fire("execOut")
