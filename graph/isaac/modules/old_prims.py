"""`isaacsim.core.prims` and `isaacsim.core.api.robots`: wrappers with the calls of the former core API."""

from __future__ import annotations

from typing import Any

import numpy as np

from graph.isaac.results import numbers
from graph.isaac.session import app
from graph.sim.usd import UsdGeom

from . import articulation as new_articulation
from . import prims as new
from .prim_base import XformPrim
from .values import ArticulationAction, DynamicState, DynamicsViewState, JointsState, XFormPrimState, XFormPrimViewState

__all__ = [
    "Articulation",
    "ArticulationController",
    "ArticulationView",
    "GeometryPrim",
    "GeometryPrimView",
    "RigidPrim",
    "RigidPrimView",
    "Robot",
    "RobotView",
    "SingleArticulation",
    "SingleGeometryPrim",
    "SingleRigidPrim",
    "SingleXFormPrim",
    "XFormPrim",
    "XFormPrimView",
]


def _pose(named: dict[str, Any], *, one: bool) -> dict[str, Any]:
    """The pose among the arguments of a constructor, in the words of the present wrappers."""
    end = "" if one else "s"
    words = {f"position{end}": "positions", f"translation{end}": "translations", f"orientation{end}": "orientations"}
    words[f"scale{end}"] = "scales"
    return {new: named.pop(old, None) for old, new in words.items()}


class SingleXFormPrim:
    _wrapper: Any = XformPrim

    def __init__(self, prim_path: str, name: str = "xform_prim", *args: Any, **named: Any) -> None:
        for key, value in zip(("position", "translation", "orientation", "scale", "visible"), args, strict=False):
            named.setdefault(key, value)
        stage = app().stage
        if not stage.GetPrimAtPath(prim_path):
            stage.DefinePrim(prim_path, "Xform")
        visible = named.pop("visible", None)
        named.pop("reset_xform_properties", None)
        pose = {key: None if value is None else np.asarray(value) for key, value in _pose(named, one=True).items()}
        self._view = self._wrapper(prim_path, resolve_paths=False, **pose)
        self._first = self.get_world_pose()
        """The default pose until one is set."""
        self.name = name
        if visible is not None:
            self.set_visibility(visible)

    @property
    def prim_path(self) -> str:
        return str(self._view.paths[0])

    @property
    def prim(self) -> Any:
        return self._view.prims[0]

    @property
    def non_root_articulation_link(self) -> bool:
        return bool(self._view.is_non_root_articulation_link)

    def initialize(self, physics_sim_view: Any = None) -> None:
        return None

    def is_valid(self) -> bool:
        return bool(self._view.valid)

    def post_reset(self) -> None:
        self._view.reset_to_default_state()

    def get_world_pose(self) -> tuple[np.ndarray, np.ndarray]:
        position, orientation = self._view.get_world_poses()
        return position.numpy()[0], orientation.numpy()[0]

    def set_world_pose(self, position: Any = None, orientation: Any = None) -> None:
        self._view.set_world_poses(_row(position), _row(orientation))

    def get_local_pose(self) -> tuple[np.ndarray, np.ndarray]:
        translation, orientation = self._view.get_local_poses()
        return translation.numpy()[0], orientation.numpy()[0]

    def set_local_pose(self, translation: Any = None, orientation: Any = None) -> None:
        self._view.set_local_poses(_row(translation), _row(orientation))

    def get_local_scale(self) -> np.ndarray:
        out: np.ndarray = self._view.get_local_scales().numpy()[0]
        return out

    def get_world_scale(self) -> np.ndarray:
        matrix = np.array(UsdGeom.Xformable(self.prim).ComputeLocalToWorldTransform(0))
        return np.asarray(np.linalg.norm(matrix[:3, :3], axis=1))

    def set_local_scale(self, scale: Any) -> None:
        self._view.set_local_scales(_row(scale))

    def get_visibility(self) -> bool:
        return bool(self._view.get_visibilities().numpy()[0])

    def set_visibility(self, visible: bool) -> None:
        self._view.set_visibilities(bool(visible))

    def apply_visual_material(self, visual_material: Any, weaker_than_descendants: bool = False) -> None:
        self._view.apply_visual_materials(visual_material)

    def get_applied_visual_material(self) -> Any:
        from .materials import OmniPBR

        found = self._view.get_applied_visual_materials()[0]
        return None if found is None else OmniPBR(found.paths[0])

    def is_visual_material_applied(self) -> bool:
        return self.get_applied_visual_material() is not None

    def get_default_state(self) -> Any:
        position, orientation = self._default_pose()
        return XFormPrimState(position, orientation)

    def _default_pose(self) -> list[Any]:
        kept = self._view.get_default_state()[:2]
        return [first if one is None else one.numpy()[0] for one, first in zip(kept, self._first, strict=True)]

    def set_default_state(self, position: Any = None, orientation: Any = None) -> None:
        self._view.set_default_state(_row(position), _row(orientation))


def _row(values: Any) -> Any:
    return None if values is None else np.asarray(values, np.float64).reshape(1, -1)


class SingleGeometryPrim(SingleXFormPrim):
    _wrapper: Any = new.GeomPrim

    def __init__(self, prim_path: str, name: str = "geometry_prim", *args: Any, **named: Any) -> None:
        collision = named.pop("collision", False)
        named.pop("track_contact_forces", None), named.pop("prepare_contact_sensor", None)
        super().__init__(prim_path, name, *args, **named)
        if collision:
            self._view.apply_collision_apis()

    def set_collision_enabled(self, enabled: bool) -> None:
        self._view.set_enabled_collisions(enabled)

    def get_collision_enabled(self) -> bool:
        return bool(self._view.get_enabled_collisions().numpy()[0])

    def set_collision_approximation(self, approximation_type: str) -> None:
        self._view.set_collision_approximations(approximation_type)

    def apply_physics_material(self, physics_material: Any, weaker_than_descendants: bool = False) -> None:
        self._view.apply_physics_materials(physics_material)


class SingleRigidPrim(SingleXFormPrim):
    _wrapper: Any = new.RigidPrim

    def __init__(self, prim_path: str, name: str = "rigid_prim", *args: Any, **named: Any) -> None:
        mass, density = named.pop("mass", None), named.pop("density", None)
        linear, angular = named.pop("linear_velocity", None), named.pop("angular_velocity", None)
        super().__init__(prim_path, name, *args, **named)
        if mass is not None:
            self.set_mass(mass)
        if density is not None:
            self.set_density(density)
        if linear is not None or angular is not None:
            self._view.set_velocities(_row(linear), _row(angular))

    def get_linear_velocity(self) -> np.ndarray:
        out: np.ndarray = self._view.get_velocities()[0].numpy()[0]
        return out

    def get_angular_velocity(self) -> np.ndarray:
        out: np.ndarray = self._view.get_velocities()[1].numpy()[0]
        return out

    def set_linear_velocity(self, velocity: Any) -> None:
        self._view.set_velocities(_row(velocity), None)

    def set_angular_velocity(self, velocity: Any) -> None:
        self._view.set_velocities(None, _row(velocity))

    def get_mass(self) -> float:
        return float(self._view.get_masses().numpy()[0, 0])

    def set_mass(self, mass: float) -> None:
        self._view.set_masses(mass)

    def get_density(self) -> float:
        return float(self._view.get_densities().numpy()[0, 0])

    def set_density(self, density: float) -> None:
        self._view.set_densities(density)

    def get_sleep_threshold(self) -> float:
        found = self.prim.GetAttribute("physxRigidBody:sleepThreshold")
        return float((found.Get() if found else None) or 0.0)

    def set_sleep_threshold(self, threshold: float) -> None:
        new.attribute(self.prim, "physxRigidBody:sleepThreshold", "float", float(threshold))

    def get_com(self) -> tuple[np.ndarray, np.ndarray]:
        positions, orientations = self._view.get_coms()
        return positions.numpy()[0], orientations.numpy()[0]

    def set_com(self, position: Any, orientation: Any) -> None:
        self._view.set_coms(_row(position), _row(orientation))

    def enable_rigid_body_physics(self) -> None:
        self._view.set_enabled_rigid_bodies(True)

    def disable_rigid_body_physics(self) -> None:
        self._view.set_enabled_rigid_bodies(False)

    def get_current_dynamic_state(self) -> Any:
        return DynamicState(*self.get_world_pose(), self.get_linear_velocity(), self.get_angular_velocity())

    def get_default_state(self) -> Any:
        speeds = (np.zeros(3) if one is None else one.numpy()[0] for one in self._view.get_default_state()[2:])
        return DynamicState(*self._default_pose(), *speeds)

    def set_default_state(
        self,
        position: Any = None,
        orientation: Any = None,
        linear_velocity: Any = None,
        angular_velocity: Any = None,
    ) -> None:
        self._view.set_default_state(_row(position), _row(orientation), _row(linear_velocity), _row(angular_velocity))

    def apply_force(self, force: Any, is_global: bool = True) -> None:
        self._view.apply_forces(_row(force), local_frame=not is_global)


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
            dof_positions=_row(positions), dof_velocities=_row(velocities), dof_efforts=_row(efforts)
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
        self._view.set_velocities(_row(velocity), None)

    def set_angular_velocity(self, velocity: Any) -> None:
        self._view.set_velocities(None, _row(velocity))

    def set_world_velocity(self, velocity: Any) -> None:
        self._view.set_velocities(_row(velocity[:3]), _row(velocity[3:]))

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
            new.attribute(app().stage.GetPrimAtPath(path), "physxRigidBody:disableGravity", "bool", off)

    def _setting(self, name: str, kind: str, value: Any = None) -> Any:
        if value is None:
            attribute = self.prim.GetAttribute(f"physxArticulation:{name}")
            return attribute.Get() if attribute else 0
        return new.attribute(self.prim, f"physxArticulation:{name}", kind, value)

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


class _View:
    """The calls of views of several prims, with arrays as results."""

    _wrapper: Any = XformPrim

    def __init__(self, prim_paths_expr: Any, name: str = "xform_prim_view", *args: Any, **named: Any) -> None:
        named |= dict(zip(("positions", "translations", "orientations", "scales"), args, strict=False))
        pose = {key: value for key, value in _pose(named, one=False).items() if value is not None}
        filters = named.get("contact_filter_prim_paths_expr")
        if filters is not None and issubclass(self._wrapper, new.RigidPrim):
            pose["contact_filter_paths"] = filters
        self._view = self._wrapper(prim_paths_expr, **pose)
        self.name = name
        for key in ("masses", "densities"):
            if named.get(key) is not None:
                getattr(self._view, f"set_{key}")(named[key])

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        return getattr(self._view, name)

    @property
    def count(self) -> int:
        return len(self._view)

    @property
    def prim_paths(self) -> list[str]:
        return list(self._view.paths)

    def initialize(self, physics_sim_view: Any = None) -> None:
        return None

    def is_valid(self, indices: Any = None) -> bool:
        return bool(self._view.valid)

    def post_reset(self) -> None:
        self._view.reset_to_default_state()

    def get_world_poses(self, indices: Any = None, usd: bool = True, clone: bool = True) -> Any:
        return tuple(one.numpy() for one in self._view.get_world_poses(indices=indices))

    def get_local_poses(self, indices: Any = None) -> Any:
        return tuple(one.numpy() for one in self._view.get_local_poses(indices=indices))

    def set_world_poses(
        self, positions: Any = None, orientations: Any = None, indices: Any = None, usd: bool = True
    ) -> None:
        self._view.set_world_poses(positions, orientations, indices=indices)

    def set_local_poses(self, translations: Any = None, orientations: Any = None, indices: Any = None) -> None:
        self._view.set_local_poses(translations, orientations, indices=indices)

    def get_local_scales(self, indices: Any = None) -> Any:
        return self._view.get_local_scales(indices=indices).numpy()

    def set_local_scales(self, scales: Any, indices: Any = None) -> None:
        self._view.set_local_scales(scales, indices=indices)

    def get_visibilities(self, indices: Any = None) -> Any:
        return self._view.get_visibilities(indices=indices).numpy()

    def set_visibilities(self, visibilities: Any, indices: Any = None) -> None:
        self._view.set_visibilities(visibilities, indices=indices)

    def get_world_scales(self, indices: Any = None) -> Any:
        poses = [app().fabric.world_matrix(self._view.paths[one]) for one in numbers(indices, len(self._view))]
        return np.linalg.norm(np.array(poses)[:, :3, :3], axis=1)

    def apply_visual_materials(
        self, visual_materials: Any, weaker_than_descendants: Any = None, indices: Any = None
    ) -> None:
        self._view.apply_visual_materials(visual_materials, indices=indices)

    def get_applied_visual_materials(self, indices: Any = None) -> Any:
        return self._view.get_applied_visual_materials(indices=indices)

    def is_visual_material_applied(self, indices: Any = None) -> list[bool]:
        return [one is not None for one in self.get_applied_visual_materials(indices)]

    def get_default_state(self) -> Any:
        return XFormPrimViewState(*self._view.get_default_state()[:2])

    def set_default_state(self, positions: Any = None, orientations: Any = None, indices: Any = None) -> None:
        self._view.set_default_state(positions, orientations, indices=indices)

    # velocities, of views of bodies and robots

    def get_velocities(self, indices: Any = None, clone: bool = True) -> Any:
        return np.concatenate([one.numpy() for one in self._view.get_velocities(indices=indices)], axis=1)

    def set_velocities(self, velocities: Any, indices: Any = None) -> None:
        values = np.asarray(velocities)
        self._view.set_velocities(values[:, :3], values[:, 3:], indices=indices)

    def get_linear_velocities(self, indices: Any = None, clone: bool = True) -> Any:
        return self._view.get_velocities(indices=indices)[0].numpy()

    def get_angular_velocities(self, indices: Any = None, clone: bool = True) -> Any:
        return self._view.get_velocities(indices=indices)[1].numpy()

    def set_linear_velocities(self, velocities: Any, indices: Any = None) -> None:
        self._view.set_velocities(velocities, None, indices=indices)

    def set_angular_velocities(self, velocities: Any, indices: Any = None) -> None:
        self._view.set_velocities(None, velocities, indices=indices)


class XFormPrim(_View): ...


class GeometryPrim(_View):
    _wrapper: Any = new.GeomPrim

    def __init__(self, prim_paths_expr: Any, name: str = "geometry_prim_view", *args: Any, **named: Any) -> None:
        super().__init__(prim_paths_expr, name, *args, **named)
        if named.get("collisions") is not None:
            self._view.apply_collision_apis()


class RigidPrim(_View):
    _wrapper: Any = new.RigidPrim

    def __init__(self, prim_paths_expr: Any, name: str = "rigid_prim_view", *args: Any, **named: Any) -> None:
        super().__init__(prim_paths_expr, name, *args, **named)

    def get_contact_force_matrix(self, indices: Any = None, clone: bool = True, dt: float = 1.0) -> Any:
        return self._view.get_contact_force_matrix(indices=indices, dt=dt).numpy()

    def get_contact_force_data(self, indices: Any = None, clone: bool = True, dt: float = 1.0) -> tuple[Any, ...]:
        return tuple(one.numpy() for one in self._view.get_contact_force_data(indices=indices, dt=dt))

    def get_masses(self, indices: Any = None, clone: bool = True) -> Any:
        return self._view.get_masses(indices=indices).numpy()[:, 0]

    def get_net_contact_forces(self, indices: Any = None, clone: bool = True, dt: float = 1.0) -> Any:
        return self._view.get_net_contact_forces(indices=indices).numpy()

    def get_current_dynamic_state(self) -> Any:
        return DynamicsViewState(*self.get_world_poses(), *(one.numpy() for one in self._view.get_velocities()))

    def apply_forces(self, forces: Any, indices: Any = None, is_global: bool = True) -> None:
        self._view.apply_forces(forces, indices=indices, local_frame=not is_global)


class Articulation(_View):
    _wrapper: Any = new_articulation.Articulation

    def __init__(self, prim_paths_expr: Any, name: str = "articulation_prim_view", *args: Any, **named: Any) -> None:
        super().__init__(prim_paths_expr, name, *args, **named)

    @property
    def num_dof(self) -> int:
        return int(self._view.num_dofs)

    @property
    def body_names(self) -> list[str]:
        return list(self._view.link_names)

    def get_dof_index(self, dof_name: str) -> int:
        return int(self._view.get_dof_indices(dof_name).numpy()[0])

    def _joints(self, joint_indices: Any, joint_names: Any) -> Any:
        return self._view.get_dof_indices(joint_names) if joint_names is not None else joint_indices

    def get_joint_positions(
        self, indices: Any = None, joint_indices: Any = None, joint_names: Any = None, clone: bool = True
    ) -> Any:
        return self._view.get_dof_positions(
            indices=indices, dof_indices=self._joints(joint_indices, joint_names)
        ).numpy()

    def get_joint_velocities(
        self, indices: Any = None, joint_indices: Any = None, joint_names: Any = None, clone: bool = True
    ) -> Any:
        return self._view.get_dof_velocities(
            indices=indices, dof_indices=self._joints(joint_indices, joint_names)
        ).numpy()

    def get_measured_joint_efforts(
        self, indices: Any = None, joint_indices: Any = None, joint_names: Any = None, clone: bool = True
    ) -> Any:
        chosen = self._joints(joint_indices, joint_names)
        return self._view.get_dof_projected_joint_forces(indices=indices, dof_indices=chosen).numpy()

    def get_measured_joint_forces(self, *_: Any, **__: Any) -> Any:
        found = [self._view._live(one) for one in range(len(self._view))]
        return np.array([np.zeros((self.num_dof, 6)) if one is None else one.reactions for one in found])

    def set_joint_positions(
        self, positions: Any, indices: Any = None, joint_indices: Any = None, joint_names: Any = None
    ) -> None:
        self._view.set_dof_positions(positions, indices=indices, dof_indices=self._joints(joint_indices, joint_names))

    def set_joint_velocities(
        self, velocities: Any, indices: Any = None, joint_indices: Any = None, joint_names: Any = None
    ) -> None:
        self._view.set_dof_velocities(velocities, indices=indices, dof_indices=self._joints(joint_indices, joint_names))

    def set_joint_position_targets(
        self, positions: Any, indices: Any = None, joint_indices: Any = None, joint_names: Any = None
    ) -> None:
        self._view.set_dof_position_targets(
            positions, indices=indices, dof_indices=self._joints(joint_indices, joint_names)
        )

    def set_joint_velocity_targets(
        self, velocities: Any, indices: Any = None, joint_indices: Any = None, joint_names: Any = None
    ) -> None:
        self._view.set_dof_velocity_targets(
            velocities, indices=indices, dof_indices=self._joints(joint_indices, joint_names)
        )

    def set_joint_efforts(
        self, efforts: Any, indices: Any = None, joint_indices: Any = None, joint_names: Any = None
    ) -> None:
        self._view.set_dof_efforts(efforts, indices=indices, dof_indices=self._joints(joint_indices, joint_names))

    def set_gains(
        self, kps: Any = None, kds: Any = None, indices: Any = None, joint_indices: Any = None, *_: Any, **__: Any
    ) -> None:
        self._view.set_dof_gains(kps, kds, indices=indices, dof_indices=joint_indices)

    def get_gains(self, indices: Any = None, joint_indices: Any = None, *_: Any, **__: Any) -> Any:
        return tuple(one.numpy() for one in self._view.get_dof_gains(indices=indices, dof_indices=joint_indices))

    def apply_action(self, control_actions: Any, indices: Any = None) -> None:
        for name, call in (
            ("positions", "position_targets"),
            ("velocities", "velocity_targets"),
            ("efforts", "efforts"),
        ):
            values = getattr(control_actions, f"joint_{name}")
            if values is not None:
                getattr(self._view, f"set_dof_{call}")(
                    values, indices=indices, dof_indices=control_actions.joint_indices
                )

    def get_dof_limits(self) -> Any:
        low, high = self._view.get_dof_limits()
        return np.stack([low.numpy(), high.numpy()], axis=-1)


XFormPrimView, GeometryPrimView, RigidPrimView, ArticulationView, RobotView = (
    XFormPrim,
    GeometryPrim,
    RigidPrim,
    Articulation,
    Articulation,
)
