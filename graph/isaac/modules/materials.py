"""Materials of the former core API."""

from __future__ import annotations

from typing import Any

from graph.isaac.outcomes import tell_inert

from . import physics_materials, visual_materials

__all__ = ["OmniGlass", "OmniPBR", "PhysicsMaterial", "PreviewSurface"]


class _OldVisual(visual_materials.VisualMaterial):
    def __init__(self, prim_path: str, name: str = "visual_material", *_: Any, **__: Any) -> None:
        super().__init__(prim_path)
        self.name, self.prim_path, self.prim, self.material = name, prim_path, self.prims[0], self.materials[0]

    def __getattr__(self, name: str) -> Any:
        if name.startswith("set_"):
            return lambda *_, **__: tell_inert(f"{type(self).__name__}.{name}")
        raise AttributeError(name)


class OmniPBR(_OldVisual):
    identity = visual_materials.OmniPbrMaterial.identity


class OmniGlass(_OldVisual):
    identity = visual_materials.OmniGlassMaterial.identity


class PreviewSurface(_OldVisual):
    identity = visual_materials.PreviewSurfaceMaterial.identity


class PhysicsMaterial(physics_materials.RigidBodyMaterial):
    def __init__(
        self,
        prim_path: str,
        name: str = "physics_material",
        static_friction: float | None = None,
        dynamic_friction: float | None = None,
        restitution: float | None = None,
    ) -> None:
        super().__init__(
            prim_path, static_frictions=static_friction, dynamic_frictions=dynamic_friction, restitutions=restitution
        )
        self.name, self.prim_path, self.prim, self.material = name, prim_path, self.prims[0], self.materials[0]

    def set_static_friction(self, friction: float) -> None:
        self.set_friction_coefficients(friction)

    def set_dynamic_friction(self, friction: float) -> None:
        self.set_friction_coefficients(None, friction)

    def set_restitution(self, restitution: float) -> None:
        self.set_restitution_coefficients(restitution)
