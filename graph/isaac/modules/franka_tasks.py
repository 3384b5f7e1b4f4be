"""The Franka's tasks: follow a target, pick and place a cube, stack two cubes."""

from __future__ import annotations

from typing import Any

from graph.isaac.session import app
from graph.sim.usd import UsdGeom

from . import arm_tasks
from .manipulators import Franka
from .stage import generate_next_free_path

__all__ = ["FollowTarget", "PickPlace", "Stacking"]


class _WithFranka:
    """A task whose arm is a Franka."""

    _path_of_robot: str | None = None
    _name_of_robot: str | None = None

    def set_robot(self) -> Any:
        path = self._path_of_robot or generate_next_free_path("/World/Franka", prepend_default_prim=False)
        return Franka(path, self.unique_name(self._name_of_robot or "my_franka"))  # type: ignore[attr-defined]


class FollowTarget(_WithFranka, arm_tasks.FollowTarget):
    def __init__(
        self,
        name: str = "franka_follow_target",
        target_prim_path: str | None = None,
        target_name: str | None = None,
        target_position: Any = None,
        target_orientation: Any = None,
        offset: Any = None,
        franka_prim_path: str | None = None,
        franka_robot_name: str | None = None,
    ) -> None:
        super().__init__(name, target_prim_path, target_name, target_position, target_orientation, offset)
        self._path_of_robot, self._name_of_robot = franka_prim_path, franka_robot_name


class PickPlace(_WithFranka, arm_tasks.PickPlace):
    def __init__(
        self,
        name: str = "franka_pick_place",
        cube_initial_position: Any = None,
        cube_initial_orientation: Any = None,
        target_position: Any = None,
        cube_size: Any = None,
        offset: Any = None,
    ) -> None:
        super().__init__(name, cube_initial_position, cube_initial_orientation, target_position, cube_size, offset)


class Stacking(_WithFranka, arm_tasks.Stacking):
    def __init__(
        self,
        name: str = "franka_stacking",
        target_position: Any = None,
        cube_size: Any = None,
        offset: Any = None,
    ) -> None:
        unit = UsdGeom.GetStageMetersPerUnit(app().stage)
        starts = [[0.3 / unit, y / unit, 0.3 / unit] for y in (0.3, -0.3)]
        super().__init__(name, starts, None, target_position, cube_size, offset)
