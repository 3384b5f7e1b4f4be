"""Tasks for an arm: follow a target, pick and place a cube, stack cubes; a subclass says which arm in `set_robot`."""

from __future__ import annotations

from typing import Any

import numpy as np

from graph.isaac.session import app
from graph.sim.usd import UsdGeom

from .arm_motion import DOWN
from .old_objects import DynamicCuboid, FixedCuboid, VisualCuboid
from .stage import generate_next_free_path
from .task import BaseTask

__all__ = ["FollowTarget", "PickPlace", "Stacking"]
SIDE = 0.0515
"""Of the cubes [m]."""
REACHED = 0.035
"""How near to a target counts [m]."""


def _units(*meters: Any) -> Any:
    """Lengths [m] in stage units."""
    return np.asarray(meters, float) / UsdGeom.GetStageMetersPerUnit(app().stage)


def _entry(value: Any, modifiable: bool) -> dict[str, Any]:
    return {"value": value, "modifiable": modifiable}


class _ArmTask(BaseTask):
    _robot: Any = None

    def set_robot(self) -> Any:
        """The arm of the task."""
        raise NotImplementedError(f"{type(self).__name__} has no set_robot(); write one that returns the arm")

    def unique_name(self, name: str) -> str:
        """The name, with a number if the scene has it already."""
        found, number = name, 1
        while self.scene.object_exists(found):
            found, number = f"{name}_{number}", number + 1
        return found

    def set_up_scene(self, scene: Any) -> None:
        super().set_up_scene(scene)
        if not scene.object_exists("default_ground_plane"):
            scene.add_default_ground_plane()
        self.make_objects(scene)
        self._robot = scene.add(self.set_robot())
        self._task_objects[self._robot.name] = self._robot
        self._move_task_objects_to_their_frame()

    def make_objects(self, scene: Any) -> None:
        """Adds what the task is about."""

    def _cube(self, scene: Any, number: int, position: Any, orientation: Any, size: Any) -> Any:
        """A cube, red, green or blue by its number."""
        name = self.unique_name("cube")
        path = generate_next_free_path("/World/Cube", prepend_default_prim=False)
        color = np.eye(3)[(2 - number) % 3]
        made = DynamicCuboid(path, name, position=position, orientation=orientation, scale=size, size=1.0, color=color)
        self._task_objects[name] = scene.add(made)
        return made

    def _joints(self) -> dict[str, Any]:
        tip, _ = self._robot.end_effector.get_world_pose()
        return {"joint_positions": self._robot.get_joint_positions(), "end_effector_position": tip}

    def post_reset(self) -> None:
        gripper = None if self._robot is None else self._robot.gripper
        if gripper is not None:
            gripper.set_joint_positions(gripper.joint_opened_positions)

    def calculate_metrics(self) -> dict[str, Any]:
        raise NotImplementedError

    def is_done(self) -> bool:
        raise NotImplementedError


class PickPlace(_ArmTask):
    def __init__(
        self,
        name: str,
        cube_initial_position: Any = None,
        cube_initial_orientation: Any = None,
        target_position: Any = None,
        cube_size: Any = None,
        offset: Any = None,
    ) -> None:
        super().__init__(name, offset)
        self._start, self._turn, self._size = cube_initial_position, cube_initial_orientation, cube_size
        self._goal = target_position
        self._object: Any = None

    def make_objects(self, scene: Any) -> None:
        self._size = _units(SIDE, SIDE, SIDE) if self._size is None else np.asarray(self._size, float)
        start = _units(0.3, 0.3, 0.3) if self._start is None else np.asarray(self._start, float)
        goal = _units(-0.3, -0.3, 0.0) if self._goal is None else np.asarray(self._goal, float).copy()
        if self._goal is None:
            goal[2] = self._size[2] / 2
        self._goal = goal + self._offset
        self._object = self._cube(scene, 0, start, self._turn, self._size)

    def set_params(self, cube_position: Any = None, cube_orientation: Any = None, target_position: Any = None) -> None:
        if target_position is not None:
            self._goal = np.asarray(target_position, float)
        if cube_position is not None or cube_orientation is not None:
            self._object.set_local_pose(cube_position, cube_orientation)

    def get_params(self) -> dict[str, Any]:
        position, orientation = self._object.get_local_pose()
        return {
            "cube_position": _entry(position, True),
            "cube_orientation": _entry(orientation, True),
            "target_position": _entry(self._goal, True),
            "cube_name": _entry(self._object.name, False),
            "robot_name": _entry(self._robot.name, False),
        }

    def get_observations(self) -> dict[str, Any]:
        position, orientation = self._object.get_world_pose()
        cube = {"position": position, "orientation": orientation, "target_position": self._goal}
        return {self._object.name: cube, self._robot.name: self._joints()}


class Stacking(_ArmTask):
    def __init__(
        self,
        name: str,
        cube_initial_positions: Any,
        cube_initial_orientations: Any = None,
        stack_target_position: Any = None,
        cube_size: Any = None,
        offset: Any = None,
    ) -> None:
        super().__init__(name, offset)
        self._places, self._turns = cube_initial_positions, cube_initial_orientations
        self._goal, self._size = stack_target_position, cube_size
        self._cubes: list[Any] = []

    def make_objects(self, scene: Any) -> None:
        self._size = _units(SIDE, SIDE, SIDE) if self._size is None else np.asarray(self._size, float)
        goal = _units(0.5, 0.5, 0.0) if self._goal is None else np.asarray(self._goal, float)
        self._goal = np.array([*goal[:2], self._size[2] / 2]) + self._offset
        places = np.asarray(self._places, float).reshape(-1, 3)
        turns = [None] * len(places) if self._turns is None else self._turns
        each = enumerate(zip(places, turns, strict=True))
        self._cubes = [self._cube(scene, row, place, turn, self._size) for row, (place, turn) in each]

    def get_cube_names(self) -> list[str]:
        return [one.name for one in self._cubes]

    def set_params(
        self,
        cube_name: str | None = None,
        cube_position: Any = None,
        cube_orientation: Any = None,
        stack_target_position: Any = None,
    ) -> None:
        if stack_target_position is not None:
            self._goal = np.asarray(stack_target_position, float)
        if cube_name is not None:
            self._task_objects[cube_name].set_local_pose(cube_position, cube_orientation)

    def get_params(self) -> dict[str, Any]:
        return {"stack_target_position": _entry(self._goal, True), "robot_name": _entry(self._robot.name, False)}

    def get_observations(self) -> dict[str, Any]:
        out = {self._robot.name: self._joints()}
        for level, cube in enumerate(self._cubes):
            position, orientation = cube.get_world_pose()
            goal = self._goal + np.array([0, 0, level * self._size[2]])
            out[cube.name] = {"position": position, "orientation": orientation, "target_position": goal}
        return out


class FollowTarget(_ArmTask):
    def __init__(
        self,
        name: str,
        target_prim_path: str | None = None,
        target_name: str | None = None,
        target_position: Any = None,
        target_orientation: Any = None,
        offset: Any = None,
    ) -> None:
        super().__init__(name, offset)
        self._path, self._name_of_target = target_prim_path, target_name
        self._place, self._turn = target_position, target_orientation
        self._target: Any = None
        self._obstacles: list[Any] = []

    def make_objects(self, scene: Any) -> None:
        place = _units(0.0, 0.1, 0.7) if self._place is None else np.asarray(self._place, float)
        self.set_params(self._path, self._name_of_target, place, DOWN if self._turn is None else self._turn)

    def set_params(
        self,
        target_prim_path: str | None = None,
        target_name: str | None = None,
        target_position: Any = None,
        target_orientation: Any = None,
    ) -> None:
        if self._target is None or target_prim_path is not None:
            path = target_prim_path or generate_next_free_path("/World/TargetCube", prepend_default_prim=False)
            name = self.unique_name(target_name or "target")
            side = _units(0.03, 0.03, 0.03)
            self._target = self.scene.add(VisualCuboid(path, name, scale=side, size=1.0, color=np.array([1.0, 0, 0])))
            self._task_objects[name] = self._target
        if target_position is not None or target_orientation is not None:
            self._target.set_local_pose(target_position, target_orientation)
            self._target.set_default_state(*self._target.get_world_pose())

    def get_params(self) -> dict[str, Any]:
        position, orientation = self._target.get_local_pose()
        return {
            "target_prim_path": _entry(self._target.prim_path, True),
            "target_name": _entry(self._target.name, True),
            "target_position": _entry(position, True),
            "target_orientation": _entry(orientation, True),
            "robot_name": _entry(self._robot.name, False),
        }

    def get_observations(self) -> dict[str, Any]:
        position, orientation = self._target.get_local_pose()
        state = self._robot.get_joints_state()
        robot = {"joint_positions": np.array(state.positions), "joint_velocities": np.array(state.velocities)}
        return {self._robot.name: robot, self._target.name: {"position": position, "orientation": orientation}}

    def target_reached(self) -> bool:
        tip, _ = self._robot.end_effector.get_world_pose()
        target, _ = self._target.get_world_pose()
        return bool(np.linalg.norm(np.asarray(tip) - np.asarray(target)) < _units(REACHED)[0])

    def add_obstacle(self, position: Any = None) -> Any:
        """A fixed cube of 10 cm."""
        path = generate_next_free_path("/World/obstacle", prepend_default_prim=False)
        place = _units(0.1, 0.1, 1.0) if position is None else position
        cube = FixedCuboid(path, self.unique_name("cube"), position=place, scale=_units(0.1, 0.1, 0.1), size=1.0)
        self._obstacles.append(self.scene.add(cube))
        return cube

    def remove_obstacle(self, name: str | None = None) -> None:
        chosen = next((one for one in self._obstacles if one.name == name), self._obstacles[-1])
        self._obstacles.remove(chosen)
        self.scene.remove_object(chosen.name)

    def get_obstacle_to_delete(self) -> Any:
        return self._obstacles[-1]

    def obstacles_exist(self) -> bool:
        return bool(self._obstacles)
