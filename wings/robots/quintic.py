"""Smooth paths in the plane: quintic polynomials in time from a start to a goal, with speed and acceleration given."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

from graph.base.records import dataclass
from graph.node import Attribute, Database, node_type
from wings.robots.planar import heading, wrapped

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

DURATIONS = tuple(range(5, 100, 5))
"""Durations [s] of a path to try, shortest first."""

SAMPLE_BYTES = 8 * 16
"""Of a sample of the path while it is planned: time, derivatives of x and y, what they give, and its four outputs."""

SAME_PLACE, SAME_HEADING = 0.1, 0.05
"""A goal that moved by less [m, rad] counts as unchanged."""


class Stance(NamedTuple):
    """A position [m], a heading [rad], and speed [m/s] and acceleration [m/s^2] along the heading."""

    x: float
    y: float
    heading: float
    speed: float
    acceleration: float


class Path(NamedTuple):
    """Samples of a path in time: speeds [m/s], places [m], headings [rad], times [s], changes of speed [m/s^2, m/s^3];
    each (n,). within: whether it keeps the limits.
    """

    speeds: Floats
    xs: Floats
    ys: Floats
    headings: Floats
    times: Floats
    accelerations: Floats
    jerks: Floats
    within: bool


def coefficients(start: tuple[float, float, float], end: tuple[float, float, float], duration: float) -> Floats:
    """(6,) of the polynomial in time, lowest first, with position, speed and acceleration given at both ends."""
    import numpy as np

    x0, v0, a0 = start
    x1, v1, a1 = end
    t = duration
    matrix = np.array([[t**3, t**4, t**5], [3 * t**2, 4 * t**3, 5 * t**4], [6 * t, 12 * t**2, 20 * t**3]])
    rest = np.array([x1 - x0 - v0 * t - a0 * t**2 / 2, v1 - v0 - a0 * t, a1 - a0])
    return np.concatenate([[x0, v0, a0 / 2], np.linalg.solve(matrix, rest)])


def plan_path(start: Stance, goal: Stance, max_acceleration: float, max_jerk: float, step: float) -> Path:
    """The path of least duration within the limits [m/s^2, m/s^3], sampled every `step` [s]; else the longest tried.

    Quintic polynomials: Takahashi et al., Local path planning and motion control for AGV in positioning, 1989.
    """
    import numpy as np
    from numpy.polynomial.polynomial import polyder, polyval

    path: Path | None = None
    for duration in DURATIONS:
        times = np.arange(0.0, duration + step, step)
        axes = [
            coefficients(
                (first[place], first.speed * turn(first.heading), first.acceleration * turn(first.heading)),
                (last[place], last.speed * turn(last.heading), last.acceleration * turn(last.heading)),
                float(duration),
            )
            for first, last, place, turn in ((start, goal, 0, math.cos), (start, goal, 1, math.sin))
        ]
        values = [[polyval(times, polyder(axis, order)) for axis in axes] for order in range(4)]
        (xs, ys), speeds, accelerations, jerks = values
        sizes = np.hypot(*accelerations), np.hypot(*jerks)
        within = bool(sizes[0].max() <= max_acceleration and sizes[1].max() <= max_jerk)
        path = Path(np.hypot(*speeds), xs, ys, np.arctan2(speeds[1], speeds[0]), times, *sizes, within)
        if within:
            break
    assert path is not None
    return path


@dataclass(slots=True)
class _Plan:
    target: tuple[float, float, float] | None = None
    arrays: Any = ()


def _metres(doc: str, unit: str, default: float) -> Attribute:
    return Attribute("double", doc, default=default, unit=unit)


@node_type(
    "isaacsim.robot.wheeled_robots.QuinticPathPlanner",
    version=1,
    inputs={
        "execIn": Attribute("execution", "plans where the goal is a new one"),
        "currentPosition": Attribute("vectord[3]", "where the robot is", unit="m"),
        "currentOrientation": Attribute("quatd[4]", "how the robot stands, quaternion x, y, z, w"),
        "targetPrim": Attribute("target", "a prim to go to; wins over targetPosition", optional=True),
        "targetPosition": Attribute("vectord[3]", "where to go", unit="m"),
        "targetOrientation": Attribute("quatd[4]", "how to stand there, quaternion x, y, z, w"),
        "initialVelocity": _metres("speed at the start", "m/s", 0.5),
        "initialAccel": _metres("acceleration at the start", "m/s^2", 0.02),
        "goalVelocity": _metres("speed at the goal", "m/s", 0.5),
        "goalAccel": _metres("acceleration at the goal", "m/s^2", 0.02),
        "maxAccel": _metres("limit of the acceleration", "m/s^2", 1.5),
        "maxJerk": _metres("limit of the acceleration's change", "m/s^3", 0.3),
        "step": _metres("time between two samples of the path", "s", 0.16666666667),
    },
    outputs={
        "execOut": Attribute("execution", "follows every compute"),
        "pathArrays": Attribute("double[]", "speeds, x, y and headings of the path's samples, one after the other"),
        "target": Attribute("double[3]", "the goal: x, y, heading"),
        "targetChanged": Attribute("bool", "whether the path was planned in this compute"),
    },
    memory=_Plan,
)
def quintic_path_planner(db: Database) -> None:
    """Plan a path from the robot's pose when the goal has moved by 0.1 m or 0.05 rad; else keep the present path."""
    import numpy as np

    inputs, outputs, memory = db.inputs, db.outputs, db.memory
    goal = _goal(db)
    known = memory.target
    changed = known is None or not (
        abs(goal[0] - known[0]) < SAME_PLACE
        and abs(goal[1] - known[1]) < SAME_PLACE
        and abs(wrapped(goal[2] - known[2])) < SAME_HEADING
    )
    if changed:
        if not inputs.step > 0:
            db.fail(f"input step is {inputs.step:g} s; give it a positive time")
        db.claim(int(min(DURATIONS[-1] / inputs.step + 2, 1e15)) * SAMPLE_BYTES)
        x, y, _ = (float(part) for part in inputs.currentPosition)
        start = Stance(x, y, heading(inputs.currentOrientation), inputs.initialVelocity, inputs.initialAccel)
        end = Stance(*goal, inputs.goalVelocity, inputs.goalAccel)
        memory.target = goal
        memory.arrays = np.concatenate(plan_path(start, end, inputs.maxAccel, inputs.maxJerk, inputs.step)[:4])
    outputs.pathArrays, outputs.target, outputs.targetChanged = memory.arrays, memory.target, changed
    db.fire("execOut")


def _goal(db: Database) -> tuple[float, float, float]:
    """x, y [m] and heading [rad] of the goal."""
    from nodes.isaac.poses import decompose, world_matrix

    inputs = db.inputs
    if inputs.targetPrim:
        place, turn, _ = decompose(world_matrix(db, str(inputs.targetPrim[0])))
        place = place * db.app.meters_per_unit
    else:
        place, turn = inputs.targetPosition, inputs.targetOrientation
    return float(place[0]), float(place[1]), heading(turn)
