"""`isaacsim.core.prims`: wrappers of one prim, with the calls of the former core API."""

from __future__ import annotations

from typing import Any

import numpy as np

from graph.isaac.session import app
from graph.sim.usd import UsdGeom

from . import prims as new
from .prim_base import attribute
from .values import DynamicState, XFormPrimState
from .xform_prim import XformPrim

__all__ = [
    "SingleGeometryPrim",
    "SingleRigidPrim",
    "SingleXFormPrim",
]


def pose_of(named: dict[str, Any], *, one: bool) -> dict[str, Any]:
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
        pose = {key: None if value is None else np.asarray(value) for key, value in pose_of(named, one=True).items()}
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
        self._view.set_world_poses(row(position), row(orientation))

    def get_local_pose(self) -> tuple[np.ndarray, np.ndarray]:
        translation, orientation = self._view.get_local_poses()
        return translation.numpy()[0], orientation.numpy()[0]

    def set_local_pose(self, translation: Any = None, orientation: Any = None) -> None:
        self._view.set_local_poses(row(translation), row(orientation))

    def get_local_scale(self) -> np.ndarray:
        out: np.ndarray = self._view.get_local_scales().numpy()[0]
        return out

    def get_world_scale(self) -> np.ndarray:
        matrix = np.array(UsdGeom.Xformable(self.prim).ComputeLocalToWorldTransform(0))
        return np.asarray(np.linalg.norm(matrix[:3, :3], axis=1))

    def set_local_scale(self, scale: Any) -> None:
        self._view.set_local_scales(row(scale))

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
        self._view.set_default_state(row(position), row(orientation))


def row(values: Any) -> Any:
    """Values of one prim as those of a wrapper of several."""
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
        getattr(self, "_geometry", self._view).apply_physics_materials(physics_material)


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
            self._view.set_velocities(row(linear), row(angular))

    def get_linear_velocity(self) -> np.ndarray:
        out: np.ndarray = self._view.get_velocities()[0].numpy()[0]
        return out

    def get_angular_velocity(self) -> np.ndarray:
        out: np.ndarray = self._view.get_velocities()[1].numpy()[0]
        return out

    def set_linear_velocity(self, velocity: Any) -> None:
        self._view.set_velocities(row(velocity), None)

    def set_angular_velocity(self, velocity: Any) -> None:
        self._view.set_velocities(None, row(velocity))

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
        attribute(self.prim, "physxRigidBody:sleepThreshold", "float", float(threshold))

    def get_com(self) -> tuple[np.ndarray, np.ndarray]:
        positions, orientations = self._view.get_coms()
        return positions.numpy()[0], orientations.numpy()[0]

    def set_com(self, position: Any, orientation: Any) -> None:
        self._view.set_coms(row(position), row(orientation))

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
        self._view.set_default_state(row(position), row(orientation), row(linear_velocity), row(angular_velocity))

    def apply_force(self, force: Any, is_global: bool = True) -> None:
        self._view.apply_forces(row(force), local_frame=not is_global)
