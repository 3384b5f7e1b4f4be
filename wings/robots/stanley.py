"""Following a path in the plane: Stanley steering, proportional speed."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from graph.base.records import dataclass
from graph.node import Attribute, Database, node_type
from wings.robots.planar import heading, wrapped

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

SLOWEST = 0.05
"""Speed at the end of a path [m/s]."""

MAX_TURN = 1.0
"""Limit of the turn rate on the spot [rad/s]."""


@dataclass(slots=True)
class _Following:
    """The goal, the path's target speeds, positions and headings, and the last nearest sample."""

    target: tuple[float, float, float] = (0.0, 0.0, 0.0)
    speeds: Any = ()
    xs: Any = ()
    ys: Any = ()
    headings: Any = ()
    index: int = 0


def speed_profile(speeds: Floats, fastest: float) -> Floats:
    """Target speeds: the path's, scaled to reach `fastest`, falling to 0.05 m/s over the last third."""
    import numpy as np

    largest = float(np.abs(speeds).max(initial=0.0))
    if largest == 0:
        return np.zeros_like(speeds)
    out: Floats = speeds / largest * fastest
    count = min(len(speeds) // 3, int(fastest * 60))
    for back in range(1, count):
        out[-back] = max(min(out[-back], out[-back] / math.sqrt(count - back)), SLOWEST)
    return out


def steering_angle(
    pose: tuple[float, float, float],
    speed: float,
    path: tuple[Floats, Floats, Floats],
    first: int,
    arm: float,
    k: float,
) -> tuple[float, int]:
    """Steering angle [rad] of a front axle `arm` [m] ahead of a pose (x, y, heading), and the path's sample it aims at.

    path: xs, ys, headings; samples before `first` are not used again. Thrun et al., Stanley: the robot that won the
    DARPA grand challenge, 2006, section 9.2: heading error plus arctan(k x distance from the path / speed).
    """
    import numpy as np

    x, y, yaw = pose
    xs, ys, headings = path
    dx, dy = x + arm * math.cos(yaw) - xs, y + arm * math.sin(yaw) - ys
    nearest = int(np.argmin(np.hypot(dx, dy)))
    aside = dx[nearest] * math.sin(yaw) - dy[nearest] * math.cos(yaw)
    index = max(nearest, first)
    return wrapped(float(headings[index]) - yaw) + math.atan2(k * float(aside), speed), index


@node_type(
    "isaacsim.robot.wheeled_robots.StanleyControlPID",
    version=1,
    inputs={
        "execIn": Attribute("execution", "computes the speeds"),
        "currentPosition": Attribute("vectord[3]", "where the robot is", unit="m"),
        "currentOrientation": Attribute("quatd[4]", "how the robot stands, quaternion x, y, z, w"),
        "currentSpeed": Attribute("vectord[3]", "velocity of the robot", unit="m/s"),
        "maxVelocity": Attribute("double", "largest wanted speed", default=1.5, unit="m/s"),
        "reachedGoal": Attribute(
            "bool[]", "whether the position is reached, and whether the heading is", default=[False, False]
        ),
        "pathArrays": Attribute("double[]", "speeds, x, y and headings of the path's samples, one after the other"),
        "target": Attribute("double[3]", "the goal: x, y, heading; taken over with targetChanged", default=[0, 0, 0]),
        "targetChanged": Attribute("bool", "take target and pathArrays over now", default=False),
        "wheelBase": Attribute("double", "distance between the axles", default=0.4132, unit="m"),
        "thresholds": Attribute(
            "double[2]", "how close counts: within the distance [m] the robot turns on the spot", default=[0.1, 0.1]
        ),
        "drawPath": Attribute("bool", "draw the path; there is nothing to draw on, so it is ignored", default=False),
        "step": Attribute("double", "time until the next compute", default=0.16666666667, unit="s"),
        "gains": Attribute(
            "double[3]",
            "gains of the distance from the path and of the speed, and the largest steering angle [rad]",
            default=[0.5, 0.1, 0.0872665],
        ),
    },
    outputs={
        "execOut": Attribute("execution", "follows every compute"),
        "linearVelocity": Attribute("double", "forward speed of the body", unit="m/s"),
        "angularVelocity": Attribute("double", "turn rate, positive to the left", unit="rad/s"),
    },
    memory=_Following,
)
def stanley_control_pid(db: Database) -> bool:
    """Drive along the path, turn on the spot to the goal's heading near the goal, and stop when both are reached."""
    inputs, outputs, memory = db.inputs, db.outputs, db.memory
    near, aligned = (*(bool(flag) for flag in inputs.reachedGoal[:2]), False, False)[:2]
    if near and aligned:
        outputs.linearVelocity, outputs.angularVelocity = 0.0, 0.0
        db.fire("execOut")
        return True
    base, step = inputs.wheelBase, inputs.step
    if not (base > 0 and step > 0):
        db.fail(f"wheelBase is {base:g} m and step {step:g} s; give both a positive value")
    if inputs.targetChanged:
        _take_path(db)
    x, y, _ = (float(part) for part in inputs.currentPosition)
    yaw = heading(inputs.currentOrientation)
    across, speed_gain, largest = (float(gain) for gain in inputs.gains)
    target = memory.target
    if near or math.hypot(x - target[0], y - target[1]) <= inputs.thresholds[0]:
        turn = wrapped(target[2] - yaw) * speed_gain / step
        linear, angular = 0.0, min(max(turn, -MAX_TURN), MAX_TURN)
    elif not len(memory.xs):
        return False
    else:
        speed = math.hypot(float(inputs.currentSpeed[0]), float(inputs.currentSpeed[1]))
        arm = base * speed_gain
        wanted = float(memory.speeds[memory.index])
        path = (memory.xs, memory.ys, memory.headings)
        steering, memory.index = steering_angle((x, y, yaw), speed, path, memory.index, arm, across)
        angular = speed / arm * math.tan(min(max(steering, -largest), largest)) if arm else 0.0
        linear = speed + speed_gain * (wanted - speed)
        if linear > 0:
            angular *= 1 + abs(base * angular / linear) * speed_gain / step
    outputs.linearVelocity, outputs.angularVelocity = linear, angular
    db.fire("execOut")
    return True


def _take_path(db: Database) -> None:
    import numpy as np

    inputs, memory = db.inputs, db.memory
    arrays = np.array(inputs.pathArrays, dtype=np.float64)
    if len(arrays) % 4 or not len(arrays):
        db.fail(f"pathArrays has {len(arrays)} numbers; it holds speeds, x, y and headings, equally many of each")
    speeds, memory.xs, memory.ys, memory.headings = arrays.reshape(4, -1)
    memory.speeds = speed_profile(speeds, inputs.maxVelocity)
    memory.target = tuple(float(part) for part in inputs.target)
    memory.index = 0
