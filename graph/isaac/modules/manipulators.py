"""`isaacsim.robot.manipulators`: arms with a gripper of two fingers or of suction cups, and the Franka."""

from __future__ import annotations

from typing import Any

import numpy as np

from graph.isaac.outcomes import inert
from graph.isaac.session import app, warn
from graph.sim.usd import UsdGeom

from .old_prims import SingleRigidPrim
from .old_robots import Robot, SingleArticulation
from .stage_old import add_reference_to_stage
from .storage import get_assets_root_path
from .surface_grippers import GripperStatus, acquire_surface_gripper_interface
from .values import ArticulationAction

__all__ = ["Franka", "Gripper", "ParallelGripper", "SingleManipulator", "SurfaceGripper"]
FRANKA = "/Isaac/Robots/FrankaRobotics/FrankaPanda/franka.usd"


class Gripper:
    """What moves with the body at its prim, whose pose and speed it has once it is initialized."""

    def __init__(self, end_effector_prim_path: str) -> None:
        self._path = end_effector_prim_path
        self._body: Any = None
        self._default_state: Any = None

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_") or self._body is None:
            raise AttributeError(f"{type(self).__name__} has no {name}; a gripper has its body after initialize()")
        return getattr(self._body, name)

    def initialize(self, physics_sim_view: Any = None) -> None:
        self._body = SingleRigidPrim(self._path, "gripper")

    def set_default_state(self, *args: Any, **kwargs: Any) -> None:
        raise NotImplementedError

    def get_default_state(self, *args: Any, **kwargs: Any) -> Any:
        raise NotImplementedError

    def post_reset(self) -> None:
        return None


class ParallelGripper(Gripper):
    def __init__(
        self,
        end_effector_prim_path: str,
        joint_prim_names: list[str],
        joint_opened_positions: Any,
        joint_closed_positions: Any,
        action_deltas: Any = None,
        use_mimic_joints: bool = False,
    ) -> None:
        super().__init__(end_effector_prim_path)
        self.joint_prim_names, self._deltas = joint_prim_names, action_deltas
        self.joint_opened_positions, self.joint_closed_positions = joint_opened_positions, joint_closed_positions
        self.joint_dof_indicies = np.array([None, None])
        self.active_joint_count = 1 if use_mimic_joints else 2

    @property
    def active_joint_indices(self) -> list[Any]:
        return list(self.joint_dof_indicies[: self.active_joint_count])

    def initialize(  # type: ignore[override]
        self,
        articulation_apply_action_func: Any,
        get_joint_positions_func: Any,
        set_joint_positions_func: Any,
        dof_names: list[str],
        physics_sim_view: Any = None,
    ) -> None:
        super().initialize(physics_sim_view)
        self._apply, self._get, self._set = (
            articulation_apply_action_func,
            get_joint_positions_func,
            set_joint_positions_func,
        )
        self._dofs = len(dof_names)
        wanted = list(self.joint_prim_names)[: self.active_joint_count]
        if lacking := [name for name in wanted if name not in dof_names]:
            there = ", ".join(dof_names) or "none"
            raise Exception(f"{self._path}: the arm has no joint {lacking[0]!r} for its gripper; it has {there}")
        self.joint_dof_indicies[: len(wanted)] = [dof_names.index(name) for name in wanted]
        if self._default_state is None:
            self._default_state = np.array(self.get_joint_positions())

    def open(self) -> None:
        self._apply(self.forward("open"))

    def close(self) -> None:
        self._apply(self.forward("close"))

    def set_action_deltas(self, value: Any) -> None:
        self._deltas = value

    def get_action_deltas(self) -> Any:
        return self._deltas

    def set_default_state(self, joint_positions: Any) -> None:
        self._default_state = joint_positions

    def get_default_state(self) -> Any:
        return self._default_state

    def post_reset(self) -> None:
        if self._body is not None:
            self.set_joint_positions(self._default_state)

    def set_joint_positions(self, positions: Any) -> None:
        self._set(positions=positions, joint_indices=self.active_joint_indices)

    def get_joint_positions(self) -> Any:
        return self._get(joint_indices=self.active_joint_indices)

    def forward(self, action: str) -> ArticulationAction:
        """Targets of the fingers, None for the other joints: opened or closed, or a step of the deltas that way."""
        if action not in ("open", "close"):
            raise Exception(f"action {action} is not defined for ParallelGripper")
        aims, sign = (self.joint_opened_positions, 1) if action == "open" else (self.joint_closed_positions, -1)
        if self._deltas is not None:
            aims = [now + sign * step for now, step in zip(self.get_joint_positions(), self._deltas, strict=False)]
        return self._spread(joint_positions=aims)

    def apply_action(self, control_actions: ArticulationAction) -> None:
        names = ("joint_positions", "joint_velocities", "joint_efforts")
        given = {name: values for name in names if (values := getattr(control_actions, name)) is not None}
        self._apply(self._spread(**given))

    def _spread(self, **fingers: Any) -> ArticulationAction:
        """An action of the whole arm."""
        action = ArticulationAction()
        for name, values in fingers.items():
            row: list[Any] = [None] * self._dofs
            for joint, value in zip(self.active_joint_indices, values, strict=False):
                row[joint] = float(value)
            setattr(action, name, row)
        return action


class SurfaceGripper(Gripper):
    _dofs: int | None = None

    def __init__(self, end_effector_prim_path: str, surface_gripper_path: str) -> None:
        super().__init__(end_effector_prim_path)
        self._gripper_path, self._interface = surface_gripper_path, acquire_surface_gripper_interface()

    def initialize(self, physics_sim_view: Any = None, articulation_num_dofs: int | None = None) -> None:
        super().initialize(physics_sim_view)
        self._dofs = articulation_num_dofs
        if self._default_state is None:
            self._default_state = not self.is_closed()

    def close(self) -> None:
        if not self.is_closed():
            self._interface.close_gripper(self._gripper_path)
        if not self.is_closed():
            warn("gripper-holds-nothing", self._gripper_path, "it did not close: nothing is within reach of its points")

    def open(self) -> None:
        self._interface.open_gripper(self._gripper_path)

    @inert("isaacsim.robot.manipulators.grippers")
    def update(self) -> None: ...

    def is_closed(self) -> bool:
        return self._interface.get_gripper_status(self._gripper_path) is GripperStatus.Closed

    def is_open(self) -> bool:
        return self._interface.get_gripper_status(self._gripper_path) is GripperStatus.Open

    def set_default_state(self, opened: bool) -> None:
        self._default_state = opened

    def get_default_state(self) -> dict[str, Any]:
        return {"opened": self._default_state}

    def post_reset(self) -> None:
        if self._default_state is not None:
            (self.open if self._default_state else self.close)()

    def forward(self, action: str) -> ArticulationAction:
        """Opens or closes at once; the action leaves every joint as it is."""
        if self._dofs is None:
            raise Exception("initialize a SurfaceGripper with articulation_num_dofs before forward()")
        if action not in ("open", "close"):
            raise Exception(f"action {action} is not defined for SurfaceGripper")
        getattr(self, action)()
        return ArticulationAction(joint_positions=[None] * self._dofs)


class _WithGripper(SingleArticulation):
    """An arm whose end effector is a rigid body, and its gripper if there is one."""

    _end_effector_path: str
    _gripper: Any = None
    _end_effector: Any = None

    @property
    def end_effector(self) -> Any:
        return self._end_effector

    @property
    def gripper(self) -> Any:
        return self._gripper

    def initialize(self, physics_sim_view: Any = None) -> None:
        super().initialize(physics_sim_view)
        self._end_effector = SingleRigidPrim(self._end_effector_path, f"{self.name}_end_effector")
        if isinstance(self._gripper, ParallelGripper):
            functions = (self.apply_action, self.get_joint_positions, self.set_joint_positions)
            self._gripper.initialize(*functions, self.dof_names, physics_sim_view)
        elif isinstance(self._gripper, SurfaceGripper):
            self._gripper.initialize(physics_sim_view, self.num_dof)

    def post_reset(self) -> None:
        super().post_reset()
        if self._gripper is not None:
            self._gripper.post_reset()


class SingleManipulator(_WithGripper):
    def __init__(
        self,
        prim_path: str,
        end_effector_prim_path: str,
        name: str = "single_manipulator",
        position: Any = None,
        translation: Any = None,
        orientation: Any = None,
        scale: Any = None,
        visible: bool | None = None,
        gripper: Any = None,
    ) -> None:
        self._end_effector_path, self._gripper = end_effector_prim_path, gripper
        super().__init__(prim_path, name, position, translation, orientation, scale, visible)


class Franka(_WithGripper, Robot):
    def __init__(
        self,
        prim_path: str,
        name: str = "franka_robot",
        usd_path: str | None = None,
        position: Any = None,
        orientation: Any = None,
        end_effector_prim_name: str | None = None,
        gripper_dof_names: list[str] | None = None,
        gripper_open_position: Any = None,
        gripper_closed_position: Any = None,
        deltas: Any = None,
    ) -> None:
        if not app().stage.GetPrimAtPath(prim_path):
            add_reference_to_stage(usd_path or get_assets_root_path() + FRANKA, prim_path)
        self._end_effector_path = f"{prim_path}/{end_effector_prim_name or 'panda_rightfinger'}"
        super().__init__(prim_path, name, position, orientation=orientation)
        wide = np.full(2, 0.05) / UsdGeom.GetStageMetersPerUnit(app().stage)
        self._gripper = ParallelGripper(
            self._end_effector_path,
            gripper_dof_names or ["panda_finger_joint1", "panda_finger_joint2"],
            wide if gripper_open_position is None else gripper_open_position,
            np.zeros(2) if gripper_closed_position is None else gripper_closed_position,
            wide if deltas is None else deltas,
        )
