"""Ackermann steering: from a car's speed and steering angle to the angles and speeds of its four wheels."""

from __future__ import annotations

import math

from graph.base.records import dataclass
from graph.node import Attribute, Database, node_type
from nodes.bounds import at_least

STRAIGHT = 0.0157
"""A steering angle below this [rad] (0.9 degrees) means straight ahead, as in the original."""

SPEED_REACHED, ANGLE_REACHED = 1e-4, 0.00174533
"""Differences [m/s, rad] below which a ramp is finished."""

ONCE = "read at the first compute after play"


@dataclass(frozen=True, slots=True)
class Car:
    """Geometry [m] and limits of a car; infinity means no limit."""

    wheel_base: float
    track_width: float
    front_radius: float
    back_radius: float
    inverted: bool = False
    max_wheel_speed: float = math.inf
    max_wheel_angle: float = math.inf
    max_acceleration: float = math.inf
    max_steering_speed: float = math.inf

    @property
    def max_speed(self) -> float:
        """The car's speed [m/s] at which the larger wheels turn at their limit."""
        return self.max_wheel_speed * max(self.front_radius, self.back_radius)

    def wheels(self, speed: float, steering: float) -> tuple[tuple[float, float], tuple[float, float, float, float]]:
        """Angles [rad] of the left and right steered wheel, speeds [rad/s] front left, front right, back left, right.

        speed [m/s]: of the centre of the axle that does not steer. steering [rad]: of an imagined wheel at the centre
        of the steering axle, positive to the left, reversed for a car that steers with its back wheels.
        """
        limit = self.max_wheel_speed
        if abs(steering) < STRAIGHT:
            front, back = speed / self.front_radius, speed / self.back_radius
            return (0.0, 0.0), _within4((front, front, back, back), limit)
        half, base = self.track_width / 2, self.wheel_base
        turn = (-1.0 if self.inverted else 1.0) * base / math.tan(steering)
        left, right = (_within(_angle(base, turn + aside), self.max_wheel_angle) for aside in (-half, half))
        radius, side = abs(turn), math.copysign(half, steering)
        near = (radius - side, radius + side)
        far = (math.hypot(near[0], base), math.hypot(near[1], base))
        fronts, backs = (near, far) if self.inverted else (far, near)
        rate = speed / radius
        speeds = (
            *(rate * distance / self.front_radius for distance in fronts),
            *(rate * distance / self.back_radius for distance in backs),
        )
        return (left, right), _within4(speeds, limit)

    def ramped(
        self, present: tuple[float, float], wanted: tuple[float, float], rates: tuple[float, float], dt: float
    ) -> tuple[float, float]:
        """Speed [m/s] and steering [rad] after `dt` [s] on the way to the wanted ones, each at its rate; 0: at once."""
        speed, steering = _within(wanted[0], self.max_speed), _within(wanted[1], self.max_wheel_angle)
        gain, swing = min(abs(rates[0]), self.max_acceleration), min(abs(rates[1]), self.max_steering_speed)
        return (
            ramped(present[0], speed, gain * abs(dt), SPEED_REACHED) if gain else speed,
            ramped(present[1], steering, swing * abs(dt), ANGLE_REACHED) if swing else steering,
        )


def _angle(base: float, radius: float) -> float:
    """arctan(base / radius); a quarter turn if the wheel is beside the centre of the turn."""
    return math.atan(base / radius) if radius else math.pi / 2


def _within(value: float, limit: float) -> float:
    return min(max(value, -limit), limit)


def _within4(values: tuple[float, ...], limit: float) -> tuple[float, float, float, float]:
    first, second, third, fourth = (_within(value, limit) for value in values)
    return first, second, third, fourth


def ramped(current: float, target: float, step: float, reached: float) -> float:
    """One step towards the target, at most `step` long; no step if the target is closer than `reached`."""
    if abs(target - current) <= reached:
        return current
    return min(current + step, target) if target > current else max(current - step, target)


@dataclass(slots=True)
class _Driving:
    car: Car | None = None
    speed: float = 0.0
    steering: float = 0.0


@node_type(
    "isaacsim.robot.wheeled_robots.AckermannController",
    version=2,
    check=at_least(wheelBase=0, frontWheelRadius=0, backWheelRadius=0),
    needs=(("wheelBase",), ("frontWheelRadius",), ("backWheelRadius",)),
    inputs={
        "execIn": Attribute("execution", "computes the wheels"),
        "acceleration": Attribute("double", "how fast the speed changes; 0 is at once", default=0.0, unit="m/s^2"),
        "maxAcceleration": Attribute("double", f"limit of it; 0 means no limit; {ONCE}", default=0.0, unit="m/s^2"),
        "speed": Attribute("double", "wanted forward speed", default=0.0, unit="m/s"),
        "steeringAngle": Attribute(
            "double",
            "wanted angle of a wheel in the middle of the steered axle, positive to the left",
            default=0.0,
            unit="rad",
        ),
        "maxWheelRotation": Attribute(
            "double", f"limit of steering angles; 0 means no limit; {ONCE}", default=6.28, unit="rad"
        ),
        "steeringAngleVelocity": Attribute(
            "double", "how fast the steering angle changes; 0 is at once", default=0.0, unit="rad/s"
        ),
        "maxSteeringAngleVelocity": Attribute(
            "double", f"limit of it; 0 means no limit; {ONCE}", default=0.0, unit="rad/s"
        ),
        "wheelBase": Attribute("double", f"distance between the axles; {ONCE}", default=0.0, unit="m"),
        "trackWidth": Attribute("double", f"distance between the wheels of an axle; {ONCE}", default=0.0, unit="m"),
        "frontWheelRadius": Attribute("double", f"radius of the front wheels; {ONCE}", default=0.0, unit="m"),
        "backWheelRadius": Attribute("double", f"radius of the back wheels; {ONCE}", default=0.0, unit="m"),
        "maxWheelVelocity": Attribute(
            "double", f"limit of each wheel's speed; 0 means no limit; {ONCE}", default=0.0, unit="rad/s"
        ),
        "invertSteering": Attribute("bool", f"the back wheels steer; {ONCE}", default=False),
        "dt": Attribute("double", "time since the last compute, for acceleration and steeringAngleVelocity", unit="s"),
    },
    outputs={
        "execOut": Attribute("execution", "follows every compute"),
        "wheelAngles": Attribute("double[]", "angles of the left and the right steered wheel", unit="rad"),
        "wheelRotationVelocity": Attribute(
            "double[]", "speeds of the wheels: front left, front right, back left, back right", unit="rad/s"
        ),
    },
    memory=_Driving,
)
def ackermann_controller(db: Database) -> bool:
    """Steer all wheels about one point, so that no wheel slips.

    With a ramp and dt 0 nothing is computed: the outputs keep their values, and execOut fires.
    """
    inputs, memory = db.inputs, db.memory
    car = memory.car
    if car is None:
        car = memory.car = _read(db)
    rates = inputs.acceleration, inputs.steeringAngleVelocity
    if inputs.dt or not any(rates):
        wanted = inputs.speed, inputs.steeringAngle
        memory.speed, memory.steering = car.ramped((memory.speed, memory.steering), wanted, rates, inputs.dt)
        angles, speeds = car.wheels(memory.speed, memory.steering)
        db.outputs.wheelAngles, db.outputs.wheelRotationVelocity = list(angles), list(speeds)
    else:
        db.warn("time-step-missing", "acceleration and steeringAngleVelocity need dt; connect the time step")
    db.fire("execOut")
    return True


def _read(db: Database) -> Car:
    inputs = db.inputs
    for name in ("wheelBase", "frontWheelRadius", "backWheelRadius"):
        value = getattr(inputs, name)
        if not (math.isfinite(value) and value > 0):
            db.lack(f"input {name} is {value:g} m; give it a positive length")
    return Car(
        inputs.wheelBase,
        inputs.trackWidth,
        inputs.frontWheelRadius,
        inputs.backWheelRadius,
        inputs.invertSteering,
        abs(inputs.maxWheelVelocity) or math.inf,
        abs(inputs.maxWheelRotation) or math.inf,
        abs(inputs.maxAcceleration) or math.inf,
        abs(inputs.maxSteeringAngleVelocity) or math.inf,
    )
