"""Wheeled robots and their controllers, of both core APIs."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from graph.isaac.results import numbers, rows

from . import articulation
from .old_robots import Robot
from .stage import refer
from .values import ArticulationAction

__all__ = [
    "BaseController",
    "DifferentialController",
    "ExperimentalDifferentialController",
    "ExperimentalWheeledRobot",
    "WheelBasePoseController",
    "WheeledRobot",
]


class BaseController:
    def __init__(self, name: str) -> None:
        self.name = name

    def forward(self, *args: Any, **kwargs: Any) -> ArticulationAction:
        raise NotImplementedError

    def reset(self) -> None:
        return None


def wheel_speeds(command: Any, radius: float, base: float, linear: float, angular: float, wheel: float) -> list[float]:
    """Left and right [rad/s] of a speed and a turn rate, each within its limit."""
    forward, turn = (float(one) for one in np.asarray(command).reshape(-1)[:2])
    forward, turn = float(np.clip(forward, -linear, linear)), float(np.clip(turn, -angular, angular))
    sides = ((2 * forward - turn * base) / (2 * radius), (2 * forward + turn * base) / (2 * radius))
    return [float(np.clip(side, -wheel, wheel)) for side in sides]


class ExperimentalDifferentialController:
    def __init__(
        self,
        *,
        wheel_radius: float,
        wheel_base: float,
        max_linear_speed: float = 1e20,
        max_angular_speed: float = 1e20,
        max_wheel_speed: float = 1e20,
    ) -> None:
        if wheel_radius <= 0 or wheel_base <= 0:
            raise ValueError("give wheel_radius and wheel_base above 0")
        self.wheel_radius, self.wheel_base, self.max_wheel_speed = wheel_radius, wheel_base, max_wheel_speed
        self.max_linear_speed, self.max_angular_speed = max_linear_speed, max_angular_speed

    def forward(self, command: Any) -> Any:
        """(2,) speeds of the left and the right wheel [rad/s] for a speed [m/s] and a turn rate [rad/s]."""
        limits = (self.max_linear_speed, self.max_angular_speed, self.max_wheel_speed)
        return np.array(wheel_speeds(command, self.wheel_radius, self.wheel_base, *limits))

    def reset(self) -> None:
        return None


class DifferentialController(ExperimentalDifferentialController, BaseController):
    def __init__(
        self,
        name: str = "differential",
        wheel_radius: float = 0.0,
        wheel_base: float = 0.0,
        max_linear_speed: float = 1e20,
        max_angular_speed: float = 1e20,
        max_wheel_speed: float = 1e20,
    ) -> None:
        BaseController.__init__(self, name)
        super().__init__(
            wheel_radius=wheel_radius,
            wheel_base=wheel_base,
            max_linear_speed=max_linear_speed,
            max_angular_speed=max_angular_speed,
            max_wheel_speed=max_wheel_speed,
        )

    def forward(self, command: Any) -> ArticulationAction:
        return ArticulationAction(joint_velocities=super().forward(command))


class WheelBasePoseController(BaseController):
    def __init__(self, name: str, open_loop_wheel_controller: Any, is_holonomic: bool = False) -> None:
        super().__init__(name)
        self._controller, self._holonomic = open_loop_wheel_controller, is_holonomic

    def forward(
        self,
        start_position: Any,
        start_orientation: Any,
        goal_position: Any,
        lateral_velocity: float = 0.2,
        yaw_velocity: float = 0.5,
        heading_tol: float = 0.05,
        position_tol: float = 0.04,
    ) -> ArticulationAction:
        w, x, y, z = np.asarray(start_orientation, float)
        heading = math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
        way = np.asarray(goal_position, float)[:2] - np.asarray(start_position, float)[:2]
        if np.linalg.norm(way) < position_tol:
            command = [0.0, 0.0]
        else:
            error = math.remainder(math.atan2(way[1], way[0]) - heading, 2 * math.pi)
            turning = abs(error) > heading_tol
            command = [0.0, math.copysign(yaw_velocity, error)] if turning else [lateral_velocity, 0.0]
        out: ArticulationAction = self._controller.forward(command)
        return out


class WheeledRobot(Robot):
    def __init__(
        self,
        prim_path: str,
        name: str = "wheeled_robot",
        robot_path: str | None = None,
        wheel_dof_names: Any = None,
        wheel_dof_indices: Any = None,
        usd_path: str | None = None,
        create_robot: bool = False,
        position: Any = None,
        orientation: Any = None,
    ) -> None:
        from graph.isaac.session import app

        if wheel_dof_names is None and wheel_dof_indices is None:
            raise ValueError("give wheel_dof_names or wheel_dof_indices")
        prim = app().stage.GetPrimAtPath(prim_path)
        if not prim and create_robot and usd_path:
            prim = app().stage.DefinePrim(prim_path, "Xform")
            refer(prim, usd_path)
        root = f"{prim_path}/{robot_path.lstrip('/')}" if robot_path else prim_path
        super().__init__(root, name, position=position, orientation=orientation)
        self._wheel_names = list(wheel_dof_names or [])
        self._wheel_numbers = None if wheel_dof_indices is None else list(wheel_dof_indices)

    @property
    def wheel_dof_indices(self) -> list[int]:
        if self._wheel_numbers is None:
            self._wheel_numbers = [self.get_dof_index(one) for one in self._wheel_names]
        return self._wheel_numbers

    def get_wheel_positions(self) -> np.ndarray:
        return self.get_joint_positions(self.wheel_dof_indices)

    def get_wheel_velocities(self) -> np.ndarray:
        return self.get_joint_velocities(self.wheel_dof_indices)

    def set_wheel_positions(self, positions: Any) -> None:
        self.set_joint_positions(positions, self.wheel_dof_indices)

    def set_wheel_velocities(self, velocities: Any) -> None:
        self.set_joint_velocities(velocities, self.wheel_dof_indices)

    def apply_wheel_actions(self, actions: ArticulationAction) -> None:
        moved = ArticulationAction(joint_indices=self.wheel_dof_indices)
        for name in ("joint_positions", "joint_velocities", "joint_efforts"):
            setattr(moved, name, getattr(actions, name))
        self.apply_action(moved)


class ExperimentalWheeledRobot(articulation.Articulation):
    def __init__(
        self,
        paths: Any,
        *,
        wheel_dof_names: Any = None,
        wheel_dof_indices: Any = None,
        usd_path: str | None = None,
        **pose: Any,
    ) -> None:
        from graph.isaac.session import app

        if wheel_dof_names is None and wheel_dof_indices is None:
            raise ValueError("give wheel_dof_names or wheel_dof_indices")
        path = paths if isinstance(paths, str) else paths[0]
        if usd_path is not None and not app().stage.GetPrimAtPath(path):
            refer(app().stage.DefinePrim(path, "Xform"), usd_path)
        super().__init__(paths, **pose)
        self._wheel_names = wheel_dof_names
        self._wheels = None if wheel_dof_indices is None else numbers(wheel_dof_indices, 0)

    def _resolve_wheel_dof_indices(self) -> list[int]:
        if self._wheels is None:
            self._wheels = numbers(self.get_dof_indices(list(self._wheel_names)), 0)
        return self._wheels

    def apply_wheel_actions(self, velocities: Any) -> None:
        wheels = self._resolve_wheel_dof_indices()
        values = rows(velocities, len(self), len(wheels), "velocities")
        self.set_dof_velocity_targets(values, dof_indices=wheels)
