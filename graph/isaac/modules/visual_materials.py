"""Visual materials of `isaacsim.core.experimental.materials`: Material prims with a shader and its inputs."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np

from graph.isaac.results import array, numbers, result, words
from graph.sim.usd import Sdf, UsdShade

from .prim_base import Prim, define, prims_of

__all__ = ["OmniGlassMaterial", "OmniPbrMaterial", "PreviewSurfaceMaterial", "VisualMaterial"]

_PREVIEW = {
    "Float3": "diffuseColor emissiveColor specularColor normal",
    "Int": "useSpecularWorkflow",
    "Float": "metallic roughness clearcoat clearcoatRoughness opacity opacityThreshold ior displacement",
}
_SHARED = {
    "Bool": "flip_tangent_u flip_tangent_v enable_opacity project_uvw world_or_object",
    "Int": "uv_space_index",
    "Float": "geometry_normal_roughness_strength opacity_threshold texture_rotate",
    "Float2": "texture_translate texture_scale",
}
_GLASS = {
    "Color3f": "glass_color reflection_color",
    "Asset": "glass_color_texture roughness_texture reflection_color_texture normal_map_texture cutout_opacity_texture",
    "Float": "depth frosting_roughness roughness_texture_influence glass_ior normal_map_strength cutout_opacity",
    "Bool": "thin_walled",
    "Int": "cutout_opacity_mono_source",
}
_PBR = {
    "Color3f": "diffuse_color_constant diffuse_tint emissive_color",
    "Asset": "diffuse_texture reflectionroughness_texture metallic_texture ORM_texture ao_texture "
    "emissive_color_texture emissive_mask_texture opacity_texture normalmap_texture detail_normalmap_texture",
    "Float": "albedo_desaturation albedo_add albedo_brightness reflection_roughness_constant "
    "reflection_roughness_texture_influence metallic_constant metallic_texture_influence specular_level ao_to_diffuse "
    "emissive_intensity opacity_constant bump_factor detail_bump_factor detail_texture_rotate round_edges_radius "
    "round_edges_roundness",
    "Bool": "enable_ORM_texture enable_emission enable_opacity_texture round_edges_across_materials",
    "Int": "opacity_mode",
    "Float2": "detail_texture_translate detail_texture_scale",
}
_WIDTHS = {"Float2": 2, "Float3": 3, "Color3f": 3}
_DTYPES = {"Bool": bool, "Int": np.int32}


def _inputs(*tables: dict[str, str]) -> dict[str, str]:
    """Names of types by input."""
    return {name: kind for table in tables for kind, names in table.items() for name in names.split()}


class VisualMaterial(Prim):
    inputs: ClassVar[dict[str, str]] = {}
    """The type of each input of the shader."""
    identity: ClassVar[tuple[str, str]] = ("", "")
    """The attribute that says which shader it is, and its value."""

    def __init__(self, paths: Any, *, resolve_paths: bool = True) -> None:
        super().__init__(define(paths, "Material"), resolve_paths=False)
        self.materials = [UsdShade.Material(prim) for prim in self.prims]
        self.shaders = [shader_of(one) or self._author(one) for one in self.materials]

    def _author(self, material: Any) -> Any:
        """A shader of the kind below a material, as its surface."""
        made = UsdShade.Shader.Define(material.GetPrim().GetStage(), material.GetPath().AppendChild("Shader"))
        kind, value = self.identity
        if kind == "id":
            made.CreateIdAttr(value)
            material.CreateSurfaceOutput().ConnectToSource(made.ConnectableAPI(), "surface")
        elif value:
            made.SetSourceAsset(Sdf.AssetPath(f"{value}.mdl"), "mdl")
            made.SetSourceAssetSubIdentifier(value, "mdl")
            material.CreateSurfaceOutput("mdl").ConnectToSource(made.ConnectableAPI(), "out")
        return made

    def _kind(self, name: str) -> str:
        if name not in self.inputs:
            raise ValueError(f"{name!r} is not an input of {type(self).__name__}; it has {', '.join(self.inputs)}")
        return self.inputs[name]

    def set_input_values(self, name: str, values: Any, *, indices: Any = None) -> None:
        kind, chosen = self._kind(name), numbers(indices, len(self))
        if kind == "Asset":
            given = [Sdf.AssetPath(str(one)) for one in words(values, len(chosen))]
        else:
            width = {"Float2": 2, "Float3": 3, "Color3f": 3}.get(kind, 1)
            held = np.broadcast_to(
                array(values).reshape(-1, width) if array(values).size > 1 else array(values), (len(chosen), width)
            )
            given = [tuple(map(float, row)) if width > 1 else row[0].item() for row in held]
        for one, value in zip(chosen, given, strict=True):
            self.shaders[one].CreateInput(name, getattr(Sdf.ValueTypeNames, kind)).Set(value)

    def get_input_values(self, name: str, *, indices: Any = None) -> Any:
        """(N, width) of an input, or lists of files; what nothing authored is 0."""
        kind, chosen = self._kind(name), numbers(indices, len(self))
        width = _WIDTHS.get(kind, 1)
        found = [self.shaders[one].GetInput(name) for one in chosen]
        values = [one.Get() if one else None for one in found]
        if kind == "Asset":
            return [one.path if one else "" for one in values]
        return result([[0] * width if one is None else np.reshape(one, width) for one in values], _DTYPES.get(kind))

    @classmethod
    def _kind_of(cls, prim: Any) -> Any:
        shader = shader_of(UsdShade.Material(prim)) if prim and prim.IsA(UsdShade.Material) else None
        kinds = [] if shader is None else [kind for kind in _KINDS if kind.identity == identity_of(shader)]
        return next((kind for kind in kinds if issubclass(kind, cls)), None)

    @classmethod
    def are_of_type(cls, paths: Any) -> Any:
        return result([cls._kind_of(prim) is not None for prim in prims_of(paths)], bool)

    @classmethod
    def fetch_instances(cls, paths: Any) -> list[Any]:
        kinds = [(prim, cls._kind_of(prim)) for prim in prims_of(paths)]
        return [None if kind is None else kind(str(prim.GetPath())) for prim, kind in kinds]


def shader_of(material: Any) -> Any:
    """The shader below a material; None without one."""
    below = (UsdShade.Shader(child) for child in material.GetPrim().GetChildren())
    return next((one for one in below if one), None)


def identity_of(shader: Any) -> tuple[str, str]:
    """Which shader it is: ("id", its name), or ("mdl", its material's name)."""
    if source := shader.GetSourceAsset("mdl"):
        return "mdl", source.path.rpartition("/")[2].removesuffix(".mdl")
    return "id", str(shader.GetIdAttr().Get() or "")


class OmniPbrMaterial(VisualMaterial):
    inputs, identity = _inputs(_PBR, _SHARED), ("mdl", "OmniPBR")


class OmniGlassMaterial(VisualMaterial):
    inputs, identity = _inputs(_GLASS, _SHARED), ("mdl", "OmniGlass")


class PreviewSurfaceMaterial(VisualMaterial):
    inputs, identity = _inputs(_PREVIEW), ("id", "UsdPreviewSurface")


_KINDS = (OmniPbrMaterial, OmniGlassMaterial, PreviewSurfaceMaterial)
