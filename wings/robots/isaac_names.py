"""Steering of cars and holonomic bodies, and path following, of both wheeled robots modules; the nodes' mathematics."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from graph.isaac.modules.robots import BaseController
from graph.isaac.modules.values import ArticulationAction
from graph.isaac.session import app

from . import ackermann, holonomic, quintic

__all__ = [
    "AckermannController",
    "HolonomicController",
    "HolonomicRobotUsdSetup",
    "normalize_angle",
    "pid_control",
    "quintic_polynomials_planner",
]


class ExperimentalAckermannController:
    def __init__(
        self,
        *,
        wheel_base: float,
        track_width: float,
        front_wheel_radius: float = 0.0,
        back_wheel_radius: float = 0.0,
        max_wheel_velocity: float = 0.0,
        invert_steering: bool = False,
        max_wheel_rotation_angle: float = 6.28,
        max_acceleration: float = 0.0,
        max_steering_angle_velocity: float = 0.0,
    ) -> None:
        self.wheel_base, self.track_width = abs(wheel_base), abs(track_width)
        self.front_wheel_radius, self.back_wheel_radius = abs(front_wheel_radius), abs(back_wheel_radius)
        self.max_wheel_velocity, self.invert_steering = abs(max_wheel_velocity), invert_steering
        self.max_wheel_rotation_angle = abs(max_wheel_rotation_angle)
        self.max_acceleration = abs(max_acceleration)
        self.max_steering_angle_velocity = abs(max_steering_angle_velocity)
        self.prev_linear_velocity = self.prev_steering_angle = 0.0

    def forward(self, command: Any) -> tuple[Any, Any]:
        """Two steered angles and four wheel speeds for an angle, its rate, a speed, its rate, and a time step."""
        front = self.front_wheel_radius or self.back_wheel_radius
        if len(command) != 5 or not front:
            return None, None
        angle, swing, speed, gain, dt = (float(one) for one in command)
        if not dt and (swing or gain):
            return None, None
        car = ackermann.Car(
            self.wheel_base,
            self.track_width,
            front,
            self.back_wheel_radius or front,
            self.invert_steering,
            self.max_wheel_velocity or math.inf,
            self.max_wheel_rotation_angle or math.inf,
            self.max_acceleration or math.inf,
            self.max_steering_angle_velocity or math.inf,
        )
        self.prev_linear_velocity, self.prev_steering_angle = car.ramped(
            (self.prev_linear_velocity, self.prev_steering_angle), (speed, angle), (gain, swing), dt
        )
        return car.wheels(self.prev_linear_velocity, self.prev_steering_angle)


class AckermannController(ExperimentalAckermannController, BaseController):
    def __init__(
        self,
        name: str,
        wheel_base: float,
        track_width: float,
        front_wheel_radius: float = 0.0,
        back_wheel_radius: float = 0.0,
        max_wheel_velocity: float = 0.0,
        invert_steering: bool = False,
        max_wheel_rotation_angle: float = 6.28,
        max_acceleration: float = 0.0,
        max_steering_angle_velocity: float = 0.0,
    ) -> None:
        BaseController.__init__(self, name)
        super().__init__(
            wheel_base=wheel_base,
            track_width=track_width,
            front_wheel_radius=front_wheel_radius,
            back_wheel_radius=back_wheel_radius,
            max_wheel_velocity=max_wheel_velocity,
            invert_steering=invert_steering,
            max_wheel_rotation_angle=max_wheel_rotation_angle,
            max_acceleration=max_acceleration,
            max_steering_angle_velocity=max_steering_angle_velocity,
        )

    def forward(self, command: Any) -> Any:
        angles, speeds = super().forward(command)
        return ArticulationAction(joint_positions=angles, joint_velocities=speeds)


class ExperimentalHolonomicController:
    def __init__(
        self,
        *,
        wheel_radius: Any = None,
        wheel_positions: Any = None,
        wheel_orientations: Any = None,
        mecanum_angles: Any = None,
        wheel_axis: Any = None,
        up_axis: Any = None,
        max_linear_speed: float = 1e20,
        max_angular_speed: float = 1e20,
        max_wheel_speed: float = 1e20,
        linear_gain: float = 1.0,
        angular_gain: float = 1.0,
    ) -> None:
        wanted = {
            "wheel_radius": wheel_radius,
            "wheel_positions": wheel_positions,
            "wheel_orientations": wheel_orientations,
            "mecanum_angles": mecanum_angles,
        }
        for name, value in wanted.items():
            if value is None:
                raise ValueError(f"give {name}, one for each wheel")
        self.wheel_positions = np.asarray(wheel_positions, np.float64).reshape(-1, 3)
        self.num_wheels = len(self.wheel_positions)
        self.wheel_orientations = np.asarray(wheel_orientations, np.float64).reshape(-1, 4)
        self.wheel_radius, self.mecanum_angles = (
            np.broadcast_to(np.asarray(one, np.float64).reshape(-1), (self.num_wheels,))
            for one in (wheel_radius, mecanum_angles)
        )
        self.wheel_axis = np.asarray((1, 0, 0) if wheel_axis is None else wheel_axis, np.float64)
        self.up_axis = np.asarray((0, 0, 1) if up_axis is None else up_axis, np.float64)
        self.max_linear_speed, self.max_angular_speed = max_linear_speed, max_angular_speed
        self.max_wheel_speed, self.linear_gain, self.angular_gain = max_wheel_speed, linear_gain, angular_gain
        ways = holonomic.drive_directions(self.wheel_orientations, self.mecanum_angles, self.wheel_axis, self.up_axis)
        self.base_dir = (ways * self.wheel_radius[:, None]).T
        """(3, n) velocity of the body for each wheel's unit speed."""
        self._wheels = holonomic.wheel_matrix(self.wheel_radius, self.wheel_positions, ways)

    def forward(self, command: Any) -> Any:
        """(n,) wheel speeds [rad/s] for the body's speeds along x and y [m/s] and its turn rate [rad/s]."""
        body = holonomic.Platform(self._wheels, self.max_linear_speed, self.max_angular_speed, self.max_wheel_speed)
        ahead, aside, turn = (float(one) for one in command)
        return body.speeds(ahead * self.linear_gain, aside * self.linear_gain, turn * self.angular_gain)


class HolonomicController(ExperimentalHolonomicController, BaseController):
    def __init__(
        self,
        name: str,
        wheel_radius: Any = None,
        wheel_positions: Any = None,
        wheel_orientations: Any = None,
        mecanum_angles: Any = None,
        wheel_axis: Any = (1, 0, 0),
        up_axis: Any = (0, 0, 1),
        max_linear_speed: float = 1e20,
        max_angular_speed: float = 1e20,
        max_wheel_speed: float = 1e20,
        linear_gain: float = 1.0,
        angular_gain: float = 1.0,
    ) -> None:
        BaseController.__init__(self, name)
        super().__init__(
            wheel_radius=wheel_radius,
            wheel_positions=wheel_positions,
            wheel_orientations=wheel_orientations,
            mecanum_angles=mecanum_angles,
            wheel_axis=wheel_axis,
            up_axis=up_axis,
            max_linear_speed=max_linear_speed,
            max_angular_speed=max_angular_speed,
            max_wheel_speed=max_wheel_speed,
            linear_gain=linear_gain,
            angular_gain=angular_gain,
        )

    def forward(self, command: Any) -> Any:
        return ArticulationAction(joint_velocities=super().forward(command))


def normalize_angle(angle: float) -> float:
    """The angle in [-pi, pi]. Raises ValueError for one that is not finite."""
    if not math.isfinite(angle):
        raise ValueError(f"the angle is {angle}; give a finite one")
    return math.remainder(angle, 2 * math.pi)


def pid_control(target: float, current: float, Kp: float = 0.1) -> float:
    return Kp * (target - current)


def quintic_polynomials_planner(
    sx: float,
    sy: float,
    syaw: float,
    sv: float,
    sa: float,
    gx: float,
    gy: float,
    gyaw: float,
    gv: float,
    ga: float,
    max_accel: float,
    max_jerk: float,
    dt: float,
) -> tuple[list[float], ...]:
    """Times, x, y, headings, speeds, accelerations and jerks of a path. Raises ValueError if none keeps the limits."""
    start, goal = quintic.Stance(sx, sy, syaw, sv, sa), quintic.Stance(gx, gy, gyaw, gv, ga)
    path = quintic.plan_path(start, goal, max_accel, max_jerk, dt)
    if not path.within:
        raise ValueError(f"no path of {quintic.DURATIONS[0]} to {quintic.DURATIONS[-1]} s keeps max_accel and max_jerk")
    out = (path.times, path.xs, path.ys, path.headings, path.speeds, path.accelerations, path.jerks)
    return tuple(one.tolist() for one in out)


class HolonomicRobotUsdSetup:
    """Reads the wheels of a robot on the stage: revolute joints with isaacmecanumwheel:radius and :angle."""

    def __init__(self, robot_prim_path: str, com_prim_path: str = "") -> None:
        stage = app().stage
        center = com_prim_path if com_prim_path and stage.GetPrimAtPath(com_prim_path) else robot_prim_path
        found = holonomic.wheels_of(stage, robot_prim_path, center)
        if found is None:
            raise ValueError(
                f"{robot_prim_path} has no wheels: give their revolute joints {holonomic.RADIUS} and {holonomic.ANGLE}"
            )
        self._found = found

    def get_holonomic_controller_params(self) -> tuple[Any, ...]:
        """Radii, positions, orientations w, x, y, z, mecanum angles [deg], axle and up axis."""
        names = ("wheelRadius", "wheelPositions", "wheelOrientations", "mecanumAngles", "wheelAxis", "upAxis")
        return tuple(np.asarray(self._found[name]) for name in names)

    def get_articulation_controller_params(self) -> list[str]:
        return list(self._found["wheelDofNames"])


class New:
    """The names of `isaacsim.robot.experimental.wheeled_robots`."""

    AckermannController = ExperimentalAckermannController
    HolonomicController = ExperimentalHolonomicController
    normalize_angle = staticmethod(normalize_angle)
    quintic_polynomials_planner = staticmethod(quintic_polynomials_planner)

    @staticmethod
    def pid_control(target: float, current: float, kp: float = 0.1) -> float:
        return pid_control(target, current, kp)
