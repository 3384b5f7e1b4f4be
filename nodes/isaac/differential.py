"""Differential drive: from body speed and turn rate to wheel speeds."""

from __future__ import annotations

import math

from graph.base.records import dataclass
from graph.node import Attribute, Database, node_type
from nodes.bounds import at_least

UNLIMITED = "0 means no limit; read at the first compute after play"


@dataclass(frozen=True, slots=True)
class Drive:
    """Geometry [m] and limits of a differential drive; 0 means no limit."""

    wheel_radius: float
    wheel_distance: float
    max_linear_speed: float = 0.0
    max_angular_speed: float = 0.0
    max_wheel_speed: float = 0.0
    max_acceleration: float = 0.0
    max_deceleration: float = 0.0
    max_angular_acceleration: float = 0.0

    @property
    def limits_linear_acceleration(self) -> bool:
        """Whether both the acceleration and the deceleration are limited."""
        return self.max_acceleration > 0 and self.max_deceleration > 0

    @property
    def limits_acceleration(self) -> bool:
        """Whether the limits need a time step."""
        return self.limits_linear_acceleration or self.max_angular_acceleration > 0

    def wheel_speeds(self, linear: float, angular: float) -> tuple[float, float]:
        """Left and right wheel speed [rad/s]: the inverse of v = r (wl + wr) / 2, w = r (wr - wl) / d."""
        turn = angular * self.wheel_distance
        left = (2 * linear - turn) / (2 * self.wheel_radius)
        right = (2 * linear + turn) / (2 * self.wheel_radius)
        return clamp(left, self.max_wheel_speed), clamp(right, self.max_wheel_speed)


def clamp(value: float, limit: float) -> float:
    """The value limited to [-limit, limit]; 0 means no limit."""
    return min(max(value, -limit), limit) if limit > 0 else value


def approach(current: float, target: float, gain: float, loss: float) -> float:
    """One step from `current` to `target`: the magnitude grows by at most `gain` and falls by at most `loss`.

    A change of sign stops at 0: the step brakes first, and its rest is not used.
    """
    if current != 0 and (target == 0 or math.copysign(1, target) != math.copysign(1, current)):
        return math.copysign(max(abs(current) - loss, 0.0), current) if abs(current) > loss else 0.0
    if abs(target) < abs(current):
        return math.copysign(max(abs(current) - loss, abs(target)), current)
    return math.copysign(min(abs(current) + gain, abs(target)), target)


@dataclass(slots=True)
class _Driving:
    drive: Drive | None = None
    linear: float = 0.0
    angular: float = 0.0


@node_type(
    "isaacsim.robot.wheeled_robots.DifferentialController",
    version=1,
    check=at_least(wheelRadius=0),
    needs=(("wheelRadius",), ("wheelDistance",)),
    inputs={
        "execIn": Attribute("execution", "computes the wheel speeds"),
        "wheelRadius": Attribute("double", "wheel radius, read at the first compute after play", default=0.0, unit="m"),
        "wheelDistance": Attribute(
            "double", "distance between the wheel centres, read at the first compute after play", default=0.0, unit="m"
        ),
        "dt": Attribute("double", "time step for the acceleration limits", default=0.0, unit="s"),
        "maxAcceleration": Attribute(
            "double", f"limit while speeding up, if maxDeceleration is set too; {UNLIMITED}", default=0.0, unit="m/s^2"
        ),
        "maxDeceleration": Attribute(
            "double", f"limit while slowing down, if maxAcceleration is set too; {UNLIMITED}", default=0.0, unit="m/s^2"
        ),
        "maxAngularAcceleration": Attribute(
            "double", f"limit on the change of the turn rate; {UNLIMITED}", default=0.0, unit="rad/s^2"
        ),
        "maxLinearSpeed": Attribute("double", f"limit on the body's speed; {UNLIMITED}", default=0.0, unit="m/s"),
        "maxAngularSpeed": Attribute("double", f"limit on the turn rate; {UNLIMITED}", default=0.0, unit="rad/s"),
        "maxWheelSpeed": Attribute("double", f"limit on each wheel by itself; {UNLIMITED}", default=0.0, unit="rad/s"),
        "linearVelocity": Attribute(
            "double", "wanted forward speed of the body", default=0.0, unit="m/s", role="command"
        ),
        "angularVelocity": Attribute(
            "double", "wanted turn rate, positive to the left", default=0.0, unit="rad/s", role="command"
        ),
    },
    outputs={
        "velocityCommand": Attribute("double[]", "wheel speeds, left then right", default=[0.0, 0.0], unit="rad/s")
    },
    memory=_Driving,
)
def differential_controller(db: Database) -> bool:
    """Invert the unicycle model within the limits; with acceleration limits and dt <= 0 there is no output."""
    inputs, memory = db.inputs, db.memory
    drive = memory.drive
    if drive is None:
        drive = memory.drive = _read(db)
    linear = clamp(inputs.linearVelocity, drive.max_linear_speed)
    angular = clamp(inputs.angularVelocity, drive.max_angular_speed)
    if drive.limits_acceleration:
        dt = inputs.dt
        if dt <= 0:
            return False
        if drive.limits_linear_acceleration:
            linear = approach(memory.linear, linear, drive.max_acceleration * dt, drive.max_deceleration * dt)
        if drive.max_angular_acceleration > 0:
            change = clamp(angular - memory.angular, drive.max_angular_acceleration * dt)
            angular = memory.angular + change
    memory.linear, memory.angular = linear, angular
    db.outputs.velocityCommand = list(drive.wheel_speeds(linear, angular))
    return True


def _read(db: Database) -> Drive:
    inputs = db.inputs
    radius = inputs.wheelRadius
    if not (math.isfinite(radius) and radius > 0):
        db.lack(f"input wheelRadius is {radius:g} m; give it a positive length")
    return Drive(
        radius,
        inputs.wheelDistance,
        inputs.maxLinearSpeed,
        inputs.maxAngularSpeed,
        inputs.maxWheelSpeed,
        inputs.maxAcceleration,
        inputs.maxDeceleration,
        inputs.maxAngularAcceleration,
    )
