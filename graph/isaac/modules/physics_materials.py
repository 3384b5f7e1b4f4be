"""Physics materials of `isaacsim.core.experimental.materials`."""

from __future__ import annotations

from typing import Any, ClassVar

from graph.isaac.results import Result, result
from graph.sim.usd import UsdShade

from .accessors import number, texts, together
from .own_schemas import applied, take_own_schemas
from .prim_base import Prim, define, prims_of

__all__ = ["PhysicsMaterial", "RigidBodyMaterial", "SurfaceDeformableMaterial", "VolumeDeformableMaterial"]


class PhysicsMaterial(Prim):
    """A Material with the schemas of a kind."""

    schemas: ClassVar[tuple[str, ...]] = ()

    def __init__(self, paths: Any, **values: Any) -> None:
        take_own_schemas()
        super().__init__(define(paths, "Material"), resolve_paths=False)
        for prim in self.prims:
            for schema in self.schemas:
                prim.AddAppliedSchema(schema)
        self.set_friction_coefficients(values.pop("static_frictions", None), values.pop("dynamic_frictions", None))
        for name, given in values.items():
            if given is not None:
                getattr(self, f"set_{name}")(given)

    set_friction_coefficients: ClassVar[Any]

    @property
    def materials(self) -> list[Any]:
        return [UsdShade.Material(prim) for prim in self.prims]

    @classmethod
    def _kinds(cls) -> list[Any]:
        return [cls, *(kind for below in cls.__subclasses__() for kind in below._kinds())]

    @classmethod
    def _kind_of(cls, prim: Any) -> Any:
        """The class of a prim: that with the most of its schemas among itself and those below; None for others."""
        have = set(applied(prim))
        fitting = [kind for kind in cls._kinds() if kind.schemas and have.issuperset(kind.schemas)]
        return max(fitting, key=lambda kind: len(kind.schemas), default=None)

    @classmethod
    def are_of_type(cls, paths: Any) -> Result:
        return result([cls._kind_of(prim) is not None for prim in prims_of(paths)], bool)

    @classmethod
    def fetch_instances(cls, paths: Any) -> list[Any]:
        kinds = [(prim, cls._kind_of(prim)) for prim in prims_of(paths)]
        return [None if kind is None else kind(str(prim.GetPath())) for prim, kind in kinds]


class RigidBodyMaterial(PhysicsMaterial):
    schemas = ("PhysicsMaterialAPI",)
    set_friction_coefficients, get_friction_coefficients = together(
        ("physics:staticFriction", "physics:dynamicFriction"),
        "friction_coefficients",
        ("static_frictions", "dynamic_frictions"),
        (0.0, 0.0),
    )
    set_restitution_coefficients, get_restitution_coefficients = number(
        "physics:restitution", "restitution_coefficients", argument="restitutions"
    )
    set_densities, get_densities = number("physics:density", "densities")
    set_combine_modes, get_combine_modes = texts(
        [f"physxMaterial:{name}CombineMode" for name in ("friction", "restitution", "damping")],
        "combine_modes",
        ("frictions", "restitutions", "dampings"),
        "average",
    )
    set_enabled_compliant_contacts, get_enabled_compliant_contacts = number(
        "physxMaterial:compliantContactAccelerationSpring", "enabled_compliant_contacts", "bool", argument="enabled"
    )
    set_compliant_contact_gains, get_compliant_contact_gains = together(
        [f"physxMaterial:compliantContact{name}" for name in ("Stiffness", "Damping")],
        "compliant_contact_gains",
        ("stiffnesses", "dampings"),
        (0.0, 0.0),
    )

    def __init__(
        self,
        paths: Any,
        *,
        static_frictions: Any = None,
        dynamic_frictions: Any = None,
        restitutions: Any = None,
        densities: Any = None,
    ) -> None:
        super().__init__(
            paths,
            static_frictions=static_frictions,
            dynamic_frictions=dynamic_frictions,
            restitution_coefficients=restitutions,
            densities=densities,
        )


class _Deformable(PhysicsMaterial):
    """The elastic constants, which the engine reads at play."""

    set_friction_coefficients, get_friction_coefficients = together(
        ("omniphysics:staticFriction", "omniphysics:dynamicFriction"),
        "friction_coefficients",
        ("static_frictions", "dynamic_frictions"),
        (0.0, 0.0),
    )
    set_youngs_moduli, get_youngs_moduli = number("omniphysics:youngsModulus", "youngs_moduli", default=5e5)
    set_densities, get_densities = number("omniphysics:density", "densities")

    def __init__(
        self,
        paths: Any,
        *,
        static_frictions: Any = None,
        dynamic_frictions: Any = None,
        youngs_moduli: Any = None,
        poissons_ratios: Any = None,
        densities: Any = None,
        **rest: Any,
    ) -> None:
        super().__init__(
            paths,
            static_frictions=static_frictions,
            dynamic_frictions=dynamic_frictions,
            youngs_moduli=youngs_moduli,
            poissons_ratios=poissons_ratios,
            densities=densities,
            **rest,
        )


class VolumeDeformableMaterial(_Deformable):
    schemas = ("OmniPhysicsDeformableMaterialAPI",)
    set_poissons_ratios, get_poissons_ratios = number("omniphysics:poissonsRatio", "poissons_ratios", default=0.45)


class SurfaceDeformableMaterial(_Deformable):
    schemas = ("OmniPhysicsDeformableMaterialAPI", "OmniPhysicsSurfaceDeformableMaterialAPI")
    set_poissons_ratios, get_poissons_ratios = number("omniphysics:poissonsRatio", "poissons_ratios", default=0.3)
    set_surface_thicknesses, get_surface_thicknesses = number(
        "omniphysics:surfaceThickness", "surface_thicknesses", default=0.001
    )
    set_surface_stiffnesses, get_surface_stiffnesses = together(
        [f"omniphysics:surface{name}Stiffness" for name in ("Stretch", "Shear", "Bend")],
        "surface_stiffnesses",
        ("stretch_stiffnesses", "shear_stiffnesses", "bend_stiffnesses"),
        (0.0, 0.0, 0.0),
    )
