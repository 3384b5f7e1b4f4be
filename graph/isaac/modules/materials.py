"""`isaacsim.core.experimental.materials` and the materials of the former core API."""

from __future__ import annotations

from typing import Any

from graph.isaac.outcomes import tell_inert
from graph.isaac.results import Result, numbers, result, rows, words
from graph.sim.scene.nonvisual import PREFIX
from graph.sim.usd import Sdf, UsdPhysics, UsdShade
from sensors.inertial import attribute_of

from .objects import define
from .prim_base import Prim
from .prims import attribute
from .stage import get_current_stage

__all__ = [
    "NonVisualMaterial",
    "OmniGlass",
    "OmniGlassMaterial",
    "OmniPBR",
    "OmniPbrMaterial",
    "PhysicsMaterial",
    "PreviewSurface",
    "PreviewSurfaceMaterial",
    "RigidBodyMaterial",
    "SurfaceDeformableMaterial",
    "VisualMaterial",
    "VolumeDeformableMaterial",
    "apply_nonvisual_material",
    "get_material_id",
]


class NonVisualMaterial(Prim):
    def __init__(self, paths: Any, *, bases: Any = None, coatings: Any = None, attributes: Any = None) -> None:
        super().__init__(define(paths, "Material"), resolve_paths=False)
        for name, values in (("base", bases), ("coating", coatings), ("attributes", attributes)):
            if values is None:
                continue
            for prim, value in zip(self.prims, words(values, len(self)), strict=True):
                attribute(prim, f"{PREFIX}:{name}", "token", str(value))

    @property
    def materials(self) -> list[Any]:
        return [UsdShade.Material(prim) for prim in self.prims]

    @staticmethod
    def encode_material_ids(prims: Any) -> Result:
        from sensors.surfaces.materials import material_of

        if isinstance(prims, NonVisualMaterial):
            prims = prims.prims
        listed = prims if isinstance(prims, (list, tuple)) else [prims]
        stage = get_current_stage()
        paths = [one if isinstance(one, str) else str(one.GetPath()) for one in listed]
        return result([[material_of(stage, path)] for path in paths], int)


def apply_nonvisual_material(
    prim: Any, base: str = "none", coating: str = "none", attribute: str = "none", attributes: Any = None
) -> bool:
    """Puts the names on a Material prim, or binds a material of these names to another prim."""
    from graph.sim.scene import nonvisual

    found = get_current_stage().GetPrimAtPath(prim) if isinstance(prim, str) else prim
    kept = attributes if attributes is not None else attribute
    names = nonvisual.parse({"base": base, "coating": coating, "attributes": kept})
    if found.IsA(UsdShade.Material):
        for name, value in zip(("base", "coating", "attributes"), names, strict=True):
            found.CreateAttribute(f"{PREFIX}:{name}", Sdf.ValueTypeNames.Token).Set(value)
    else:
        nonvisual.bind(get_current_stage(), found, names)
    return True


def get_material_id(prim: Any) -> int:
    return int(NonVisualMaterial.encode_material_ids(prim)[0, 0])


class VisualMaterial(Prim):
    def __init__(self, paths: Any, *_: Any, **__: Any) -> None:
        super().__init__(define(paths, "Material"), resolve_paths=False)
        self.materials = [UsdShade.Material(prim) for prim in self.prims]

    def set_input_values(self, name: str, values: Any, *, indices: Any = None) -> None:
        tell_inert(f"isaacsim.core.experimental.materials.{type(self).__name__}.set_input_values")

    def get_input_values(self, name: str, *, indices: Any = None) -> Any:
        tell_inert(f"isaacsim.core.experimental.materials.{type(self).__name__}.get_input_values")


class OmniPbrMaterial(VisualMaterial): ...


class OmniGlassMaterial(VisualMaterial): ...


class PreviewSurfaceMaterial(VisualMaterial): ...


class _OldVisual(VisualMaterial):
    def __init__(self, prim_path: str, name: str = "visual_material", *_: Any, **__: Any) -> None:
        super().__init__(prim_path)
        self.name, self.prim_path, self.prim, self.material = name, prim_path, self.prims[0], self.materials[0]

    def __getattr__(self, name: str) -> Any:
        if name.startswith("set_"):
            return lambda *_, **__: tell_inert(f"{type(self).__name__}.{name}")
        raise AttributeError(name)


class OmniPBR(_OldVisual): ...


class OmniGlass(_OldVisual): ...


class PreviewSurface(_OldVisual): ...


class RigidBodyMaterial(Prim):
    def __init__(
        self,
        paths: Any,
        *,
        static_frictions: Any = None,
        dynamic_frictions: Any = None,
        restitutions: Any = None,
        densities: Any = None,
    ) -> None:
        super().__init__(define(paths, "Material"), resolve_paths=False)
        self.materials = [UsdShade.Material(prim) for prim in self.prims]
        for prim in self.prims:
            UsdPhysics.MaterialAPI.Apply(prim)
        self.set_friction_coefficients(static_frictions, dynamic_frictions)
        self._each("Restitution", restitutions)
        self._each("Density", densities)

    def _each(self, name: str, values: Any, indices: Any = None) -> None:
        chosen = numbers(indices, len(self))
        given = rows(values, len(chosen), None, name)
        for one, value in zip(chosen, () if given is None else given, strict=False):
            getattr(UsdPhysics.MaterialAPI(self.prims[one]), f"Create{name}Attr")().Set(float(value))

    def _all(self, name: str, indices: Any = None) -> Result:
        chosen = numbers(indices, len(self))
        return result([[getattr(UsdPhysics.MaterialAPI(self.prims[n]), f"Get{name}Attr")().Get()] for n in chosen])

    def set_friction_coefficients(
        self, static_frictions: Any = None, dynamic_frictions: Any = None, *, indices: Any = None
    ) -> None:
        self._each("StaticFriction", static_frictions, indices)
        self._each("DynamicFriction", dynamic_frictions, indices)

    def get_friction_coefficients(self, *, indices: Any = None) -> tuple[Result, Result]:
        return self._all("StaticFriction", indices), self._all("DynamicFriction", indices)

    def set_restitution_coefficients(self, restitutions: Any, *, indices: Any = None) -> None:
        self._each("Restitution", restitutions, indices)

    def get_restitution_coefficients(self, *, indices: Any = None) -> Result:
        return self._all("Restitution", indices)

    def set_densities(self, densities: Any, *, indices: Any = None) -> None:
        self._each("Density", densities, indices)

    def get_densities(self, *, indices: Any = None) -> Result:
        return self._all("Density", indices)


class PhysicsMaterial(RigidBodyMaterial):
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
        self._each("StaticFriction", friction)

    def set_dynamic_friction(self, friction: float) -> None:
        self._each("DynamicFriction", friction)

    def set_restitution(self, restitution: float) -> None:
        self._each("Restitution", restitution)


class _DeformableMaterial(RigidBodyMaterial):
    """Stores the elastic constants by `OmniPhysicsDeformableMaterialAPI`, which the engine reads at play."""

    _poisson: float

    def __init__(self, paths: Any, *, youngs_moduli: Any = None, poissons_ratios: Any = None, **rest: Any) -> None:
        super().__init__(paths, **rest)
        for prim in self.prims:
            prim.AddAppliedSchema("OmniPhysicsDeformableMaterialAPI")
        self.set_youngs_moduli(youngs_moduli)
        self.set_poissons_ratios(poissons_ratios)

    def _store(self, name: str, values: Any, indices: Any = None) -> None:
        chosen = numbers(indices, len(self))
        given = rows(values, len(chosen), None, name)
        for one, value in zip(chosen, () if given is None else given, strict=False):
            attribute(self.prims[one], f"omniphysics:{name}", "float", float(value))

    def _stored(self, name: str, default: float, indices: Any = None) -> Result:
        return result(
            [[attribute_of(self.prims[n], f"omniphysics:{name}", default)] for n in numbers(indices, len(self))]
        )

    def _each(self, name: str, values: Any, indices: Any = None) -> None:
        super()._each(name, values, indices)
        if name in ("Density", "DynamicFriction"):
            self._store(name[0].lower() + name[1:], values, indices)

    def set_youngs_moduli(self, youngs_moduli: Any, *, indices: Any = None) -> None:
        self._store("youngsModulus", youngs_moduli, indices)

    def get_youngs_moduli(self, *, indices: Any = None) -> Result:
        return self._stored("youngsModulus", 5e5, indices)

    def set_poissons_ratios(self, poissons_ratios: Any, *, indices: Any = None) -> None:
        self._store("poissonsRatio", poissons_ratios, indices)

    def get_poissons_ratios(self, *, indices: Any = None) -> Result:
        return self._stored("poissonsRatio", self._poisson, indices)


class VolumeDeformableMaterial(_DeformableMaterial):
    _poisson = 0.45


class SurfaceDeformableMaterial(_DeformableMaterial):
    _poisson = 0.3

    def __init__(self, paths: Any, *, surface_thicknesses: Any = None, **rest: Any) -> None:
        super().__init__(paths, **rest)
        for prim in self.prims:
            prim.AddAppliedSchema("OmniPhysicsSurfaceDeformableMaterialAPI")
        self._store("surfaceThickness", surface_thicknesses)
