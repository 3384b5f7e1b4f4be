"""What surfaces look like: base colour and emitted light of each, read from the stage."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from .stage_values import numbers_of

GREY = (0.18, 0.18, 0.18)
"""Base colour of what nothing says, linear; as in UsdPreviewSurface."""

Warn = Callable[[str, str, str], None]


@dataclass(frozen=True)
class Looks:
    """One row for each surface, linear: base colour (n, 3) float32, 0 to 1, and emitted radiance (n, 3) [nit]."""

    base: np.ndarray
    emitted: np.ndarray

    @property
    def emits(self) -> bool:
        """Whether any surface gives light."""
        return bool(self.emitted.any())


def read_looks(stage: Any, surfaces: Sequence[Any], warn: Warn) -> Looks:
    """The looks of surfaces: of a bound UsdPreviewSurface or OmniPBR, else the prim's displayColor, else grey.

    warn: gets `material-not-modelled`, one for each material.
    """
    base, emitted = np.empty((len(surfaces), 3), np.float32), np.zeros((len(surfaces), 3), np.float32)
    known: dict[str, tuple[tuple[float, ...], tuple[float, ...]] | None] = {}
    for number, surface in enumerate(surfaces):
        path = surface.material
        if path and path not in known:
            known[path] = _of_material(stage.GetPrimAtPath(path), warn)
        look = known.get(path) if path else None
        if look is None:
            base[number] = _display_color(stage, str(surface.source or surface.path))
        else:
            base[number], emitted[number] = look
    return Looks(np.clip(base, 0.0, 1.0), np.maximum(emitted, 0.0))


def _of_material(prim: Any, warn: Warn) -> tuple[tuple[float, ...], tuple[float, ...]] | None:
    """Base colour and emission of a Material; None for one that says nothing of colours, such as a non-visual one."""
    from graph.sim.usd import UsdShade

    material = UsdShade.Material(prim)
    if not material:
        return None
    shader, _, _ = material.ComputeSurfaceSource()
    if not shader:
        shader, _, _ = material.ComputeSurfaceSource("mdl")
    if not shader:
        return None
    identifier = str(shader.GetIdAttr().Get() or "")
    if identifier == "UsdPreviewSurface":
        return _preview(shader, str(prim.GetPath()), warn)
    if str(shader.GetSourceAssetSubIdentifier("mdl") or "").startswith("OmniPBR"):
        return _omni_pbr(shader, str(prim.GetPath()), warn)
    name = identifier or str(shader.GetSourceAssetSubIdentifier("mdl") or "") or "unknown"
    warn("material-not-modelled", str(prim.GetPath()), f"a shader {name} is not modelled: its surfaces are grey")
    return GREY, (0.0, 0.0, 0.0)


def _preview(shader: Any, path: str, warn: Warn) -> tuple[tuple[float, ...], tuple[float, ...]]:
    return _color(shader, "diffuseColor", GREY, path, warn), _color(shader, "emissiveColor", (0.0,) * 3, path, warn)


def _omni_pbr(shader: Any, path: str, warn: Warn) -> tuple[tuple[float, ...], tuple[float, ...]]:
    if shader.GetInput("diffuse_texture") and shader.GetInput("diffuse_texture").Get():
        warn("material-not-modelled", path, "its diffuse_texture is not modelled: surfaces have its plain colour")
    base = _color(shader, "diffuse_color_constant", (0.2,) * 3, path, warn)
    tint = _color(shader, "diffuse_tint", (1.0,) * 3, path, warn)
    emitted: tuple[float, ...] = (0.0,) * 3
    if shader.GetInput("enable_emission") and shader.GetInput("enable_emission").Get():
        strength = shader.GetInput("emissive_intensity")
        scale = float(strength.Get() or 0.0) if strength else 40.0
        emitted = tuple(scale * part for part in _color(shader, "emissive_color", (1.0, 0.1, 0.1), path, warn))
    return tuple(a * b for a, b in zip(base, tint, strict=True)), emitted


def _color(shader: Any, name: str, default: tuple[float, ...], path: str, warn: Warn) -> tuple[float, ...]:
    """The plain value of a colour; of a textured one the texture's fallback."""
    from graph.sim.usd import UsdShade

    given = shader.GetInput(name)
    if not given:
        return default
    for attribute in UsdShade.Utils.GetValueProducingAttributes(given):
        owner = UsdShade.Shader(attribute.GetPrim())
        if UsdShade.Utils.GetType(attribute.GetName()) == UsdShade.AttributeType.Output and owner:
            fallback = owner.GetInput("fallback")
            warn("material-not-modelled", path, f"what {name} is connected to is not modelled: it has one plain colour")
            found = fallback.Get() if fallback else None
            return (numbers_of(found, 4) or (numbers_of(found, 3) or default))[:3]
        if (value := numbers_of(attribute.Get(), 3)) is not None:
            return value
    return numbers_of(given.Get(), 3) or default


def _display_color(stage: Any, path: str) -> tuple[float, ...]:
    """The mean of primvars:displayColor (linear) at the prim or the nearest above that has it, else grey."""
    from graph.sim.usd import UsdGeom

    prim = stage.GetPrimAtPath(path)
    if prim and not prim.IsA(UsdGeom.Imageable):
        prim = prim.GetParent()
    primvar = UsdGeom.PrimvarsAPI(prim).FindPrimvarWithInheritance("displayColor") if prim else None
    try:
        values = np.array(primvar.Get() if primvar and primvar.HasValue() else [], np.float64).reshape(-1, 3)
    except (TypeError, ValueError):  # a primvar of another type
        return GREY
    return tuple(values.mean(axis=0).tolist()) if len(values) and np.isfinite(values).all() else GREY
