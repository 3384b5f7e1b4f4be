"""Properties of the views of `isaacsim.core.prims`: calls of the present wrappers by their former names."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from .values import JointsState

Call = Callable[..., Any]
OF_JOINTS = {
    "applied_joint_efforts": "dof_efforts",
    "armatures": "dof_armatures",
    "coriolis_and_centrifugal_forces": "dof_coriolis_and_centrifugal_compensation_forces",
    "generalized_gravity_forces": "dof_gravity_compensation_forces",
    "joint_max_velocities": "dof_max_velocities",
    "max_efforts": "dof_max_efforts",
}
SET_OF_JOINTS = {
    "armatures": "dof_armatures",
    "max_efforts": "dof_max_efforts",
    "max_joint_velocities": "dof_max_velocities",
}
OF_BODIES = {"body_masses": "link_masses", "body_inertias": "link_inertias"}
"""Former names of what is read, and set, by joint or by link; the present ones."""
OF_ROBOTS = ("enabled_self_collisions", "sleep_thresholds", "stabilization_thresholds")
OF_TENDONS = ("dampings", "limit_stiffnesses", "limits", "offsets", "rest_lengths", "stiffnesses")


def plain(found: Any) -> Any:
    """Arrays of NumPy."""
    return tuple(one.numpy() for one in found) if isinstance(found, tuple) else found.numpy()


def column(values: Any) -> Any:
    """One number each, as (n, 1); a single number stays."""
    return values if np.ndim(values) == 0 else np.reshape(values, (-1, 1))


def _joint_reader(name: str) -> Call:
    def read(
        self: Any, indices: Any = None, joint_indices: Any = None, joint_names: Any = None, clone: bool = True
    ) -> Any:
        chosen = self._joints(joint_indices, joint_names)
        return plain(getattr(self._view, f"get_{name}")(indices=indices, dof_indices=chosen))

    return read


def _joint_writer(name: str) -> Call:
    def write(self: Any, values: Any, indices: Any = None, joint_indices: Any = None, joint_names: Any = None) -> None:
        chosen = self._joints(joint_indices, joint_names)
        getattr(self._view, f"set_{name}")(values, indices=indices, dof_indices=chosen)

    return write


def _body_reader(name: str, **options: Any) -> Call:
    def read(self: Any, indices: Any = None, body_indices: Any = None, clone: bool = True) -> Any:
        return plain(getattr(self._view, f"get_{name}")(indices=indices, link_indices=body_indices, **options))

    return read


def _reader(name: str, *options: str) -> Call:
    """Of whole robots or bodies; options: "clone" where the former call takes it, "inverse", "column": one number."""
    given = {"inverse": True} if "inverse" in options else {}

    def read(self: Any, indices: Any = None, clone: bool = True) -> Any:
        found = plain(getattr(self._view, f"get_{name}")(indices=indices, **given))
        return found[:, 0] if "column" in options else found

    def read_now(self: Any, indices: Any = None) -> Any:
        return read(self, indices)

    return read if "clone" in options else read_now


class RobotProperties:
    """Of joints, links and whole robots."""

    _view: Any

    def _joints(self, joint_indices: Any, joint_names: Any) -> Any:
        return self._view.get_dof_indices(joint_names) if joint_names is not None else joint_indices

    def set_body_masses(self, values: Any, indices: Any = None, body_indices: Any = None) -> None:
        self._view.set_link_masses(values, indices=indices, link_indices=body_indices)

    def get_body_disable_gravity(self, indices: Any = None, body_indices: Any = None, clone: bool = True) -> Any:
        return ~plain(self._view.get_link_enabled_gravities(indices=indices, link_indices=body_indices)).astype(bool)

    def set_body_disable_gravity(self, values: Any, indices: Any = None, body_indices: Any = None) -> None:
        enabled = ~np.asarray(values, bool)
        self._view.set_link_enabled_gravities(enabled, indices=indices, link_indices=body_indices)

    def set_enabled_self_collisions(self, flags: Any, indices: Any = None) -> None:
        self._view.set_enabled_self_collisions(flags, indices=indices)

    def set_sleep_thresholds(self, thresholds: Any, indices: Any = None) -> None:
        self._view.set_sleep_thresholds(column(thresholds), indices=indices)

    def set_stabilization_thresholds(self, thresholds: Any, indices: Any = None) -> None:
        self._view.set_stabilization_thresholds(column(thresholds), indices=indices)

    def get_solver_position_iteration_counts(self, indices: Any = None) -> Any:
        return plain(self._view.get_solver_iteration_counts(indices=indices))[0][:, 0]

    def get_solver_velocity_iteration_counts(self, indices: Any = None) -> Any:
        return plain(self._view.get_solver_iteration_counts(indices=indices))[1][:, 0]

    def set_solver_position_iteration_counts(self, counts: Any, indices: Any = None) -> None:
        self._view.set_solver_iteration_counts(column(counts), None, indices=indices)

    def set_solver_velocity_iteration_counts(self, counts: Any, indices: Any = None) -> None:
        self._view.set_solver_iteration_counts(None, column(counts), indices=indices)

    def get_jacobian_shape(self) -> Any:
        return np.array(self._view.get_jacobian_matrices().shape[1:])

    def get_mass_matrix_shape(self) -> Any:
        return np.array(self._view.get_mass_matrices().shape[1:])

    def get_dof_types(self, dof_names: Any = None) -> list[str]:
        types = self._view.dof_types
        return [types[row] for row in plain(self._view.get_dof_indices(dof_names))] if dof_names else list(types)

    def get_drive_types(self) -> Any:
        return np.array(self._view.get_dof_drive_types())

    def get_articulation_body_count(self) -> int:
        return int(self._view.num_links)

    def get_joint_index(self, joint_name: str) -> int:
        return int(plain(self._view.get_dof_indices(joint_name))[0])

    def get_body_index(self, body_name: str) -> int:
        return int(plain(self._view.get_link_indices(body_name))[0])

    def get_link_index(self, link_name: str) -> int:
        return self.get_body_index(link_name)

    def switch_control_mode(
        self, mode: str, indices: Any = None, joint_indices: Any = None, joint_names: Any = None
    ) -> None:
        chosen = self._joints(joint_indices, joint_names)
        self._view.switch_dof_control_mode(mode, indices=indices, dof_indices=chosen)

    def switch_dof_control_mode(self, mode: str, dof_index: int, indices: Any = None) -> None:
        self._view.switch_dof_control_mode(mode, indices=indices, dof_indices=[dof_index])

    def get_joints_state(self) -> JointsState:
        view = self._view
        return JointsState(*map(plain, (view.get_dof_positions(), view.get_dof_velocities(), view.get_dof_efforts())))

    def get_joints_default_state(self) -> JointsState:
        kept = self._view.get_default_state()[4:]
        return JointsState(*(None if one is None else plain(one) for one in kept))

    def set_joints_default_state(self, positions: Any = None, velocities: Any = None, efforts: Any = None) -> None:
        self._view.set_default_state(dof_positions=positions, dof_velocities=velocities, dof_efforts=efforts)

    def is_physics_handle_valid(self) -> bool:
        return bool(self._view.is_physics_tensor_entity_valid())


class BodyProperties:
    """Of rigid bodies."""

    _view: Any

    def set_masses(self, masses: Any, indices: Any = None) -> None:
        self._view.set_masses(column(masses), indices=indices)

    def set_densities(self, densities: Any, indices: Any = None) -> None:
        self._view.set_densities(column(densities), indices=indices)

    def get_densities(self, indices: Any = None) -> Any:
        return plain(self._view.get_densities(indices=indices))[:, 0]

    def set_coms(self, positions: Any = None, orientations: Any = None, indices: Any = None) -> None:
        self._view.set_coms(positions, orientations, indices=indices)

    def set_inertias(self, values: Any, indices: Any = None) -> None:
        self._view.set_inertias(values, indices=indices)

    def set_sleep_thresholds(self, thresholds: Any, indices: Any = None) -> None:
        self._view.set_sleep_thresholds(column(thresholds), indices=indices)

    def enable_gravities(self, indices: Any = None) -> None:
        self._view.set_enabled_gravities(True, indices=indices)

    def disable_gravities(self, indices: Any = None) -> None:
        self._view.set_enabled_gravities(False, indices=indices)

    def enable_rigid_body_physics(self, indices: Any = None) -> None:
        self._view.set_enabled_rigid_bodies(True, indices=indices)

    def disable_rigid_body_physics(self, indices: Any = None) -> None:
        self._view.set_enabled_rigid_bodies(False, indices=indices)

    def apply_forces_and_torques_at_pos(
        self,
        forces: Any = None,
        torques: Any = None,
        positions: Any = None,
        indices: Any = None,
        is_global: bool = True,
    ) -> None:
        self._view.apply_forces_and_torques_at_pos(
            forces, torques, positions=positions, indices=indices, local_frame=not is_global
        )

    def set_default_state(
        self,
        positions: Any = None,
        orientations: Any = None,
        linear_velocities: Any = None,
        angular_velocities: Any = None,
        indices: Any = None,
    ) -> None:
        self._view.set_default_state(positions, orientations, linear_velocities, angular_velocities, indices=indices)

    def is_physics_handle_valid(self) -> bool:
        return bool(self._view.is_physics_tensor_entity_valid())


class ColliderProperties:
    """Of colliders."""

    _view: Any

    def apply_collision_apis(self, indices: Any = None) -> None:
        self._view.apply_collision_apis(indices=indices)

    def enable_collision(self, indices: Any = None) -> None:
        self._view.set_enabled_collisions(True, indices=indices)

    def disable_collision(self, indices: Any = None) -> None:
        self._view.set_enabled_collisions(False, indices=indices)

    def set_contact_offsets(self, offsets: Any, indices: Any = None) -> None:
        self._view.set_offsets(column(offsets), None, indices=indices)

    def set_rest_offsets(self, offsets: Any, indices: Any = None) -> None:
        self._view.set_offsets(None, column(offsets), indices=indices)

    def get_contact_offsets(self, indices: Any = None) -> Any:
        return plain(self._view.get_offsets(indices=indices))[0][:, 0]

    def get_rest_offsets(self, indices: Any = None) -> Any:
        return plain(self._view.get_offsets(indices=indices))[1][:, 0]

    def set_torsional_patch_radii(self, radii: Any, indices: Any = None) -> None:
        self._view.set_torsional_patch_radii(column(radii), indices=indices)

    def set_min_torsional_patch_radii(self, radii: Any, indices: Any = None) -> None:
        self._view.set_torsional_patch_radii(column(radii), indices=indices, minimum=True)

    def get_min_torsional_patch_radii(self, indices: Any = None) -> Any:
        return plain(self._view.get_torsional_patch_radii(indices=indices, minimum=True))[:, 0]

    def set_collision_approximations(self, approximation_types: Any, indices: Any = None) -> None:
        self._view.set_collision_approximations(approximation_types, indices=indices)

    def get_collision_approximations(self, indices: Any = None) -> list[str]:
        return list(self._view.get_collision_approximations(indices=indices))


_ROBOT = {f"get_{former}": _joint_reader(name) for former, name in OF_JOINTS.items()}
_ROBOT |= {f"set_{former}": _joint_writer(name) for former, name in SET_OF_JOINTS.items()}
_ROBOT |= {f"get_{former}": _body_reader(name) for former, name in OF_BODIES.items()}
_ROBOT |= {
    f"get_{former.replace('_', '_inv_', 1)}": _body_reader(name, inverse=True) for former, name in OF_BODIES.items()
}
_ROBOT |= {f"get_{name}": _reader(name, "column") for name in OF_ROBOTS}
_ROBOT |= {f"get_fixed_tendon_{name}": _reader(f"fixed_tendon_{name}", "clone") for name in OF_TENDONS}
_ROBOT |= {
    "get_jacobians": _reader("jacobian_matrices", "clone"),
    "get_mass_matrices": _reader("mass_matrices", "clone"),
}
_BODY = {
    "get_coms": _reader("coms", "clone"),
    "get_inertias": _reader("inertias", "clone"),
    "get_inv_inertias": _reader("inertias", "clone", "inverse"),
    "get_inv_masses": _reader("masses", "clone", "inverse", "column"),
    "get_sleep_thresholds": _reader("sleep_thresholds", "column"),
}
_COLLIDER = {
    "get_torsional_patch_radii": _reader("torsional_patch_radii", "column"),
    "is_collision_enabled": _reader("enabled_collisions", "column"),
}
for _class, _calls in ((RobotProperties, _ROBOT), (BodyProperties, _BODY), (ColliderProperties, _COLLIDER)):
    for _name, _call in _calls.items():
        _call.__name__ = _call.__qualname__ = _name
        setattr(_class, _name, _call)
