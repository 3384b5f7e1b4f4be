"""`isaacsim.core.api.scenes`: the objects of a World by name."""

from __future__ import annotations

from typing import Any

import numpy as np

from graph.isaac.outcomes import inert
from graph.isaac.parameters import renamed
from graph.isaac.session import app
from graph.sim.scene.lamps import sphere_light

from .old_objects import GroundPlane

__all__ = ["Scene", "SceneRegistry"]


class Scene:
    def __init__(self) -> None:
        self._objects: dict[str, Any] = {}

    @property
    def stage(self) -> Any:
        return app().stage

    def add(self, obj: Any) -> Any:
        if obj.name in self._objects:
            raise Exception(f"Cannot add the object {obj.name} to the scene since its name is not unique")
        self._objects[obj.name] = obj
        return obj

    def get_object(self, name: str) -> Any:
        return self._objects.get(name)

    def object_exists(self, name: str) -> bool:
        return name in self._objects

    def remove_object(self, name: str, registry_only: bool = False) -> None:
        found = self._objects.pop(name, None)
        if found is not None and not registry_only:
            app().stage.RemovePrim(found.prim_path)

    def clear(self, registry_only: bool = False) -> None:
        for name in list(self._objects):
            self.remove_object(name, registry_only)

    def add_ground_plane(
        self,
        size: float | None = None,
        z_position: float = 0,
        name: str = "ground_plane",
        prim_path: str = "/World/groundPlane",
        static_friction: float = 0.5,
        dynamic_friction: float = 0.5,
        restitution: float = 0.8,
        color: Any = None,
    ) -> GroundPlane:
        from .materials import PhysicsMaterial

        if name in self._objects:
            return self._objects[name]  # type: ignore[no-any-return]
        material = PhysicsMaterial(
            f"{prim_path}/material", "ground_material", static_friction, dynamic_friction, restitution
        )
        made = GroundPlane(prim_path, name, size, z_position, color=color, physics_material=material)
        self.add(made)
        return made

    def add_default_ground_plane(
        self,
        z_position: float = 0,
        name: str = "default_ground_plane",
        prim_path: str = "/World/defaultGroundPlane",
        static_friction: float = 0.5,
        dynamic_friction: float = 0.5,
        restitution: float = 0.8,
    ) -> GroundPlane:
        made = self.add_ground_plane(None, z_position, name, prim_path, static_friction, dynamic_friction, restitution)
        lamp = f"{made.prim_path}/SphereLight"
        if not self.stage.GetPrimAtPath(lamp):
            sphere_light(self.stage, lamp)
        return made

    def compute_object_AABB(self, name: str) -> tuple[np.ndarray, np.ndarray]:
        from .prim_utils import compute_aabb

        box = compute_aabb(self._objects[name].prim_path)
        return box[:3], box[3:]

    @inert("isaacsim.core.api")
    def enable_bounding_boxes_computations(self) -> None:
        return None

    @inert("isaacsim.core.api")
    def disable_bounding_boxes_computations(self) -> None: ...

    def post_reset(self) -> None:
        for one in self._objects.values():
            one.post_reset()

    def initialize(self) -> None:
        """Gives every object its physics."""
        for one in self._objects.values():
            one.initialize(None)


_KINDS = {
    "rigid_object": "rigid_objects",
    "rigid_prim_view": "rigid_prim_views",
    "rigid_contact_view": "rigid_contact_views",
    "articulated_system": "articulated_systems",
    "articulated_view": "articulated_views",
    "geometry_object": "geometry_objects",
    "geometry_prim_view": "geometry_prim_views",
    "robot": "robots",
    "robot_view": "robot_views",
    "xform_view": "xform_prim_views",
    "deformable": "deformable_prims",
    "deformable_view": "deformable_prim_views",
    "deformable_material": "deformable_materials",
    "deformable_material_view": "deformable_material_views",
    "cloth": "cloth_prims",
    "cloth_view": "cloth_prim_views",
    "particle_system": "particle_systems",
    "particle_system_view": "particle_system_views",
    "particle_material": "particle_materials",
    "particle_material_view": "particle_material_views",
    "xform": "xforms",
    "sensor": "sensors",
}
"""Objects of each kind by what `add_...` calls them; their property."""


class SceneRegistry:
    """Objects by name, each in one category."""

    def __init__(self) -> None:
        self._by_kind: dict[str, dict[str, Any]] = {kind: {} for kind in _KINDS.values()}

    def _add(self, kind: str, name: str, one: Any) -> None:
        if self.name_exists(name):
            raise ValueError(f"Cannot add the object {name} to the scene since its name is not unique")
        self._by_kind[kind][name] = one

    def name_exists(self, name: str) -> bool:
        return any(name in objects for objects in self._by_kind.values())

    def get_object(self, name: str) -> Any:
        return next((objects[name] for objects in self._by_kind.values() if name in objects), None)

    def remove_object(self, name: str) -> None:
        if not self.name_exists(name):
            raise Exception(f"Cannot remove object {name} from the scene since it doesn't exist")
        for objects in self._by_kind.values():
            objects.pop(name, None)


def _categories() -> None:
    for singular, kind in _KINDS.items():

        def add(self: SceneRegistry, name: str, one: Any, kind: str = kind) -> None:
            self._add(kind, name, one)

        def objects(self: SceneRegistry, kind: str = kind) -> dict[str, Any]:
            return self._by_kind[kind]

        given = kind.removesuffix("s") if kind.endswith("_views") else singular
        setattr(SceneRegistry, f"add_{singular}", renamed(add, f"add_{singular}", "name", given))
        if kind != "geometry_objects":
            setattr(SceneRegistry, kind, property(objects))


_categories()
