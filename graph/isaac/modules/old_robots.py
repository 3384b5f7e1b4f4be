"""`isaacsim.core.api.robots`: one articulation and its controller, with the calls of the former core API."""

from __future__ import annotations

from typing import Any

import numpy as np

from graph.isaac.session import app

from . import articulation as new_articulation
from .old_prims import SingleXFormPrim, row
from .prim_base import attribute
from .values import ArticulationAction, JointsState

__all__ = [
    "ArticulationController",
    "Robot",
    "SingleArticulation",
]


class ArticulationController:
    def __init__(self) -> None:
        self._view: Any = None
        self._action = ArticulationAction()

    def initialize(self, articulation_view: Any) -> None:
        self._view = articulation_view

    def apply_action(self, control_actions: Any) -> None:
        self._action = control_actions
        joints = control_actions.joint_indices
        for name in ("positions", "velocities", "efforts"):
            values = getattr(control_actions, f"joint_{name}")
            if values is None:
                continue
            chosen = joints if joints is not None else range(self._view.num_dofs)
            pairs = [(j, float(v)) for j, v in zip(chosen, values, strict=False) if v is not None and not np.isnan(v)]
            if pairs:
                aim = {"positions": "position_targets", "velocities": "velocity_targets"}.get(name, name)
                getattr(self._view, f"set_dof_{aim}")([v for _, v in pairs], dof_indices=[int(j) for j, _ in pairs])

    def get_applied_action(self) -> ArticulationAction:
        positions = self._view.get_dof_position_targets().numpy()[0]
        velocities = self._view.get_dof_velocity_targets().numpy()[0]
        return ArticulationAction(positions, velocities, self._view.get_dof_efforts().numpy()[0])

    def get_gains(self) -> tuple[np.ndarray, np.ndarray]:
        stiffness, damping = self._view.get_dof_gains()
        return stiffness.numpy()[0], damping.numpy()[0]

    def set_gains(self, kps: Any = None, kds: Any = None, save_to_usd: bool = False) -> None:
        self._view.set_dof_gains(kps, kds)

    def get_max_efforts(self) -> np.ndarray:
        out: np.ndarray = self._view.get_dof_max_efforts().numpy()[0]
        return out

    def set_max_efforts(self, values: Any, joint_indices: Any = None) -> None:
        self._view.set_dof_max_efforts(values, dof_indices=joint_indices)

    def get_effort_modes(self) -> list[str]:
        return list(self._view.get_dof_drive_types()[0])

    def set_effort_modes(self, mode: str, joint_indices: Any = None) -> None:
        """Stores the drives' type on their joints."""
        self._view.set_dof_drive_types(mode, dof_indices=joint_indices)

    def get_joint_limits(self) -> np.ndarray:
        low, high = self._view.get_dof_limits()
        return np.stack([low.numpy()[0], high.numpy()[0]], axis=-1)

    def switch_control_mode(self, mode: str) -> None:
        self._view.switch_dof_control_mode(mode)

    def switch_dof_control_mode(self, dof_index: int, mode: str) -> None:
        self._view.switch_dof_control_mode(mode, dof_indices=[dof_index])


class SingleArticulation(SingleXFormPrim):
    _wrapper: Any = new_articulation.Articulation

    def __init__(self, prim_path: str, name: str = "articulation", *args: Any, **named: Any) -> None:
        controller = named.pop("articulation_controller", None)
        named.pop("enable_dof_force_sensors", None)
        super().__init__(prim_path, name, *args, **named)
        self._controller = controller or ArticulationController()
        self._controller.initialize(self._view)
        self._articulation_view = self._view

    @property
    def handles_initialized(self) -> bool:
        return app().physics is not None

    @property
    def num_dof(self) -> int:
        return int(self._view.num_dofs)

    @property
    def num_bodies(self) -> int:
        return int(self._view.num_links)

    @property
    def dof_names(self) -> list[str]:
        return list(self._view.dof_names)

    @property
    def dof_properties(self) -> np.ndarray:
        low, high = self._view.get_dof_limits()
        stiffness, damping = self._view.get_dof_gains()
        kinds = [("type", "i4"), ("hasLimits", "?"), ("lower", "f4"), ("upper", "f4"), ("driveMode", "i4")]
        kinds += [("maxVelocity", "f4"), ("maxEffort", "f4"), ("stiffness", "f4"), ("damping", "f4")]
        out = np.zeros(self.num_dof, dtype=kinds)
        out["lower"], out["upper"] = low.numpy()[0], high.numpy()[0]
        out["hasLimits"] = np.isfinite(out["lower"]) & np.isfinite(out["upper"])
        out["stiffness"], out["damping"] = stiffness.numpy()[0], damping.numpy()[0]
        out["maxEffort"] = self._view.get_dof_max_efforts().numpy()[0]
        out["maxVelocity"] = np.inf
        return out

    def get_articulation_controller(self) -> ArticulationController:
        return self._controller

    def apply_action(self, control_actions: Any) -> None:
        self._controller.apply_action(control_actions)

    def get_applied_action(self) -> ArticulationAction:
        return self._controller.get_applied_action()

    def get_dof_index(self, dof_name: str) -> int:
        return int(self._view.get_dof_indices(dof_name).numpy()[0])

    def get_articulation_body_count(self) -> int:
        return self.num_bodies

    def _joint(self, call: str, joints: Any) -> np.ndarray:
        out: np.ndarray = getattr(self._view, call)(dof_indices=joints).numpy()[0]
        return out

    def get_joint_positions(self, joint_indices: Any = None) -> np.ndarray:
        return self._joint("get_dof_positions", joint_indices)

    def get_joint_velocities(self, joint_indices: Any = None) -> np.ndarray:
        return self._joint("get_dof_velocities", joint_indices)

    def get_measured_joint_efforts(self, joint_indices: Any = None) -> np.ndarray:
        return self._joint("get_dof_projected_joint_forces", joint_indices)

    def get_applied_joint_efforts(self, joint_indices: Any = None) -> np.ndarray:
        return self._joint("get_dof_efforts", joint_indices)

    def get_measured_joint_forces(self, joint_indices: Any = None) -> np.ndarray:
        found = self._view._live()
        return np.zeros((self.num_dof, 6)) if found is None else np.asarray(found.reactions)

    def set_joint_positions(self, positions: Any, joint_indices: Any = None) -> None:
        self._view.set_dof_positions(positions, dof_indices=joint_indices)

    def set_joint_velocities(self, velocities: Any, joint_indices: Any = None) -> None:
        self._view.set_dof_velocities(velocities, dof_indices=joint_indices)

    def set_joint_efforts(self, efforts: Any, joint_indices: Any = None) -> None:
        self._view.set_dof_efforts(efforts, dof_indices=joint_indices)

    def get_joints_state(self) -> JointsState:
        return JointsState(self.get_joint_positions(), self.get_joint_velocities(), None)

    def get_joints_default_state(self) -> JointsState:
        kept = self._view.get_default_state()[4:7]
        return JointsState(*(None if one is None else one.numpy()[0] for one in kept))

    def set_joints_default_state(self, positions: Any = None, velocities: Any = None, efforts: Any = None) -> None:
        self._view.set_default_state(
            dof_positions=row(positions), dof_velocities=row(velocities), dof_efforts=row(efforts)
        )

    def get_linear_velocity(self) -> np.ndarray:
        out: np.ndarray = self._view.get_velocities()[0].numpy()[0]
        return out

    def get_angular_velocity(self) -> np.ndarray:
        out: np.ndarray = self._view.get_velocities()[1].numpy()[0]
        return out

    def get_world_velocity(self) -> np.ndarray:
        return np.concatenate([self.get_linear_velocity(), self.get_angular_velocity()])

    def set_linear_velocity(self, velocity: Any) -> None:
        self._view.set_velocities(row(velocity), None)

    def set_angular_velocity(self, velocity: Any) -> None:
        self._view.set_velocities(None, row(velocity))

    def set_world_velocity(self, velocity: Any) -> None:
        self._view.set_velocities(row(velocity[:3]), row(velocity[3:]))

    def get_enabled_self_collisions(self) -> bool:
        return bool(self._view.get_enabled_self_collisions().numpy()[0])

    def set_enabled_self_collisions(self, flag: bool) -> None:
        self._view.set_enabled_self_collisions(flag)

    def post_reset(self) -> None:
        if app().physics is not None:
            self._view.reset_to_default_state()

    def disable_gravity(self) -> None:
        self._gravity(True)

    def enable_gravity(self) -> None:
        self._gravity(False)

    def _gravity(self, off: bool) -> None:
        for path in self._view.link_paths[0]:
            attribute(app().stage.GetPrimAtPath(path), "physxRigidBody:disableGravity", "bool", off)

    def _setting(self, name: str, kind: str, value: Any = None) -> Any:
        if value is None:
            found = self.prim.GetAttribute(f"physxArticulation:{name}")
            return found.Get() if found else 0
        return attribute(self.prim, f"physxArticulation:{name}", kind, value)

    def get_solver_position_iteration_count(self) -> int:
        return int(self._setting("solverPositionIterationCount", "int") or 32)

    def set_solver_position_iteration_count(self, count: int) -> None:
        self._setting("solverPositionIterationCount", "int", int(count))

    def get_solver_velocity_iteration_count(self) -> int:
        return int(self._setting("solverVelocityIterationCount", "int") or 1)

    def set_solver_velocity_iteration_count(self, count: int) -> None:
        self._setting("solverVelocityIterationCount", "int", int(count))

    def get_sleep_threshold(self) -> float:
        return float(self._setting("sleepThreshold", "float"))

    def set_sleep_threshold(self, threshold: float) -> None:
        self._setting("sleepThreshold", "float", float(threshold))

    def get_stabilization_threshold(self) -> float:
        return float(self._setting("stabilizationThreshold", "float"))

    def set_stabilization_threshold(self, threshold: float) -> None:
        self._setting("stabilizationThreshold", "float", float(threshold))


class Robot(SingleArticulation):
    def __init__(self, prim_path: str, name: str = "robot", *args: Any, **named: Any) -> None:
        super().__init__(prim_path, name, *args, **named)
