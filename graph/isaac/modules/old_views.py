"""`isaacsim.core.prims`: views of several prims, with the calls of the former core API and arrays as results."""

from __future__ import annotations

import re
from typing import Any

import numpy as np

from graph.isaac.results import numbers
from graph.isaac.session import app

from . import articulation as new_articulation
from . import prims as new
from .old_prims import pose_of
from .old_view_properties import BodyProperties, ColliderProperties, RobotProperties
from .prim_utils import find_matching_prim_paths
from .values import DynamicsViewState, XFormPrimViewState
from .xform_prim import XformPrim

__all__ = [
    "Articulation",
    "ArticulationView",
    "GeometryPrim",
    "GeometryPrimView",
    "RigidPrim",
    "RigidPrimView",
    "RobotView",
    "XFormPrim",
    "XFormPrimView",
]


class _View:
    """The calls of views of several prims, with arrays as results."""

    _wrapper: Any = XformPrim

    def __init__(self, prim_paths_expr: Any, name: str = "xform_prim_view", *args: Any, **named: Any) -> None:
        named |= dict(zip(("positions", "translations", "orientations", "scales"), args, strict=False))
        pose = {key: value for key, value in pose_of(named, one=False).items() if value is not None}
        filters = named.get("contact_filter_prim_paths_expr")
        if filters is not None and issubclass(self._wrapper, new.RigidPrim):
            pose["contact_filter_paths"] = filters
        self._view = self._wrapper(_expression(prim_paths_expr), **pose)
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

    def get_world_poses(self, indices: Any = None, usd: bool = True) -> Any:
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


class _Moving(_View):
    """Views of bodies and robots."""

    def get_world_poses(self, indices: Any = None, clone: bool = True, usd: bool = True) -> Any:  # type: ignore[override]
        return super().get_world_poses(indices)

    def get_velocities(self, indices: Any = None, clone: bool = True) -> Any:
        return np.concatenate([one.numpy() for one in self._view.get_velocities(indices=indices)], axis=1)

    def set_velocities(self, velocities: Any = None, indices: Any = None) -> None:
        if velocities is None:
            return
        values = np.asarray(velocities)
        self._view.set_velocities(values[:, :3], values[:, 3:], indices=indices)

    def get_linear_velocities(self, indices: Any = None, clone: bool = True) -> Any:
        return self._view.get_velocities(indices=indices)[0].numpy()

    def get_angular_velocities(self, indices: Any = None, clone: bool = True) -> Any:
        return self._view.get_velocities(indices=indices)[1].numpy()

    def set_linear_velocities(self, velocities: Any = None, indices: Any = None) -> None:
        self._view.set_velocities(velocities, None, indices=indices)

    def set_angular_velocities(self, velocities: Any = None, indices: Any = None) -> None:
        self._view.set_velocities(None, velocities, indices=indices)


class XFormPrim(_View): ...


class GeometryPrim(ColliderProperties, _View):
    _wrapper: Any = new.GeomPrim

    def __init__(self, prim_paths_expr: Any, name: str = "geometry_prim_view", *args: Any, **named: Any) -> None:
        super().__init__(prim_paths_expr, name, *args, **named)
        if named.get("collisions") is not None:
            self._view.apply_collision_apis()


class RigidPrim(BodyProperties, _Moving):  # type: ignore[misc]
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


class Articulation(RobotProperties, _Moving):
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


def _expression(paths: Any) -> Any:
    """Paths as the new wrappers take them; a lone star that as an expression matches nothing stands for any text."""
    if not isinstance(paths, str):
        return [_expression(one) for one in paths]
    loose = re.sub(r"(?<![.\])}])\*", ".*", paths)
    return paths if loose == paths or find_matching_prim_paths(paths) else loose
