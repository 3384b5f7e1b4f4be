"""`isaacsim.core.api.objects`: cuboids, spheres and others of the former core API."""

from __future__ import annotations

from inspect import Parameter, Signature
from typing import Any

import numpy as np

from graph.isaac.session import app
from graph.sim.usd import UsdGeom, UsdPhysics

from . import ground_planes
from .old_prims import SingleGeometryPrim, SingleRigidPrim, SingleXFormPrim
from .prims import GeomPrim, RigidPrim

__all__ = [
    "DynamicCapsule",
    "DynamicCone",
    "DynamicCuboid",
    "DynamicCylinder",
    "DynamicSphere",
    "FixedCapsule",
    "FixedCone",
    "FixedCuboid",
    "FixedCylinder",
    "FixedSphere",
    "GroundPlane",
    "VisualCapsule",
    "VisualCone",
    "VisualCuboid",
    "VisualCylinder",
    "VisualSphere",
]
_DEFAULTS = {
    "Cube": {"size": 1.0},
    "Sphere": {"radius": 1.0},
    "Cylinder": {"radius": 1.0, "height": 1.0},
    "Cone": {"radius": 1.0, "height": 1.0},
    "Capsule": {"radius": 1.0, "height": 1.0},
}


class _Visual(SingleGeometryPrim):
    """A shape that sensors see and bodies do not touch."""

    kind = "Cube"

    shown = "visual_cube"

    def __init__(self, prim_path: str, name: str | None = None, *args: Any, **named: Any) -> None:
        bound = type(self).__signature__.bind(prim_path, name, *args, **named)  # type: ignore[attr-defined]
        named = {key: value for key, value in bound.arguments.items() if key not in ("prim_path", "name")}
        sizes = {one: named.pop(one, None) for one in _DEFAULTS[self.kind]}
        color, material = named.pop("color", None), named.pop("visual_material", None)
        physics = named.pop("physics_material", None)
        stage = app().stage
        new = not stage.GetPrimAtPath(prim_path)
        prim = stage.DefinePrim(prim_path, self.kind)
        for one, value in sizes.items():
            if value is not None or new:
                prim.GetAttribute(one).Set(float(_DEFAULTS[self.kind][one] if value is None else value))
        if color is not None:
            shade = tuple(map(float, np.asarray(color).reshape(-1)[:3]))
            UsdGeom.Gprim(prim).CreateDisplayColorAttr().Set([shade])
        if new and named.get("position") is None and named.get("translation") is None:
            named["translation"] = (0.0, 0.0, 0.0)
        self._take(prim_path, name or self.shown, named)
        if material is not None:
            self.apply_visual_material(material)
        if physics is not None:
            self._geometry.apply_physics_materials(physics)

    def _take(self, prim_path: str, name: str, named: dict[str, Any]) -> None:
        SingleXFormPrim.__init__(self, prim_path, name, **_known(named))
        self._geometry = GeomPrim(prim_path, resolve_paths=False)

    def get_size(self) -> float:
        return float(self.prim.GetAttribute("size").Get())

    def set_size(self, size: float) -> None:
        self.prim.GetAttribute("size").Set(float(size))

    def get_radius(self) -> float:
        return float(self.prim.GetAttribute("radius").Get())

    def set_radius(self, radius: float) -> None:
        self.prim.GetAttribute("radius").Set(float(radius))

    def get_height(self) -> float:
        return float(self.prim.GetAttribute("height").Get())

    def set_height(self, height: float) -> None:
        self.prim.GetAttribute("height").Set(float(height))


def _known(named: dict[str, Any]) -> dict[str, Any]:
    return {key: named[key] for key in ("position", "translation", "orientation", "scale", "visible") if key in named}


class _Fixed(_Visual):
    """A shape that does not move."""

    def _take(self, prim_path: str, name: str, named: dict[str, Any]) -> None:
        super()._take(prim_path, name, named)
        self._geometry.apply_collision_apis()


class _Dynamic(_Fixed, SingleRigidPrim):
    """A shape that moves by physics."""

    _wrapper: Any = RigidPrim

    def _take(self, prim_path: str, name: str, named: dict[str, Any]) -> None:
        super()._take(prim_path, name, named)
        if named.get("mass") is not None:
            self.set_mass(float(named["mass"]))
        else:
            UsdPhysics.MassAPI.Apply(self.prim)
            if named.get("density") is None:
                self.set_mass(0.02 if self.kind == "Cube" else 1.0)
        if named.get("density") is not None:
            self.set_density(float(named["density"]))
        linear, angular = named.get("linear_velocity"), named.get("angular_velocity")
        if linear is not None or angular is not None:
            self._view.set_velocities(linear, angular)


def _made(base: Any, word: str, kind: str) -> Any:
    """A class such as DynamicCuboid, with the parameters of the original."""
    usual = f"{word}_{kind}".lower()
    sizes = tuple(_DEFAULTS[kind])
    moving = ("mass", "density", "linear_velocity", "angular_velocity") if base is _Dynamic else ()
    words = ("position", "translation", "orientation", "scale", "visible", "color", *sizes, "visual_material")
    listed = [Parameter("prim_path", Parameter.POSITIONAL_OR_KEYWORD)]
    for name in ("name", *words, *(("physics_material",) if base is not _Visual else ()), *moving):
        default = usual if name == "name" else None
        listed.append(Parameter(name, Parameter.POSITIONAL_OR_KEYWORD, default=default))
    body = {"kind": kind, "shown": usual, "__signature__": Signature(listed), "__module__": "isaacsim.core.api.objects"}
    return type(f"{word}{'Cuboid' if kind == 'Cube' else kind}", (base,), body)


VisualCuboid, VisualSphere, VisualCylinder = (_made(_Visual, "Visual", one) for one in ("Cube", "Sphere", "Cylinder"))
VisualCone, VisualCapsule = (_made(_Visual, "Visual", one) for one in ("Cone", "Capsule"))
FixedCuboid, FixedSphere, FixedCylinder = (_made(_Fixed, "Fixed", one) for one in ("Cube", "Sphere", "Cylinder"))
FixedCone, FixedCapsule = (_made(_Fixed, "Fixed", one) for one in ("Cone", "Capsule"))
DynamicCuboid, DynamicSphere = (_made(_Dynamic, "Dynamic", one) for one in ("Cube", "Sphere"))
DynamicCylinder, DynamicCone, DynamicCapsule = (
    _made(_Dynamic, "Dynamic", one) for one in ("Cylinder", "Cone", "Capsule")
)


class GroundPlane(SingleXFormPrim):
    def __init__(
        self,
        prim_path: str,
        name: str = "ground_plane",
        size: float | None = None,
        z_position: float | None = None,
        scale: Any = None,
        visible: bool | None = None,
        color: Any = None,
        physics_material: Any = None,
        visual_material: Any = None,
    ) -> None:
        plane = ground_planes.GroundPlane(prim_path, sizes=100.0 if size is None else size, colors=color)
        super().__init__(prim_path, name, visible=visible, scale=scale)
        if z_position is not None:
            self.set_local_pose(translation=(0.0, 0.0, float(z_position)))
        if physics_material is not None:
            plane.apply_physics_materials(physics_material)
        self.collision_geometry_prim = SingleGeometryPrim(f"{prim_path}/collisionPlane", f"{name}_collision")
