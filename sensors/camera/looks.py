"""The base colour, emitted light and opacity of each surface, read from the stage."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from graph.base.records import dataclass, field
from sensors.raycast.rays import Hits

from .image_files import ImageFiles
from .networks import Coordinates, Networks, Source, Warn, transform_2d
from .paints import OnPlane, Paint, Painter

GREY = (0.18, 0.18, 0.18)
"""Base colour of surfaces without one, linear; as in UsdPreviewSurface."""

CUT = 0.5
"""Opacity below which a surface is not seen where its material gives no threshold."""

BLACK = (0.0, 0.0, 0.0)
NO_LIGHT, OPAQUE = Source(BLACK), Source((1.0,))


@dataclass(frozen=True)
class Material:
    """Where the colours of a material come from. threshold: opacity below which it is not seen."""

    base: Source
    emitted: Source = NO_LIGHT
    opacity: Source = OPAQUE
    threshold: float = CUT


@dataclass(frozen=True)
class Looks:
    """One row for each surface, linear: base colour (n, 3) float32, 0 to 1, and emitted radiance (n, 3) [nit].

    hidden: (n,) bool, whether it is not seen at all; clear: paths of prims of which nothing is seen. Surfaces that vary
    have a paint by number, which counts instead; those of `opacities` come with the value below which a place is not
    seen. planes: textures that lie on planes.
    """

    base: np.ndarray
    emitted: np.ndarray
    hidden: np.ndarray
    clear: frozenset[str] = frozenset()
    bases: Mapping[int, Paint] = field(default_factory=dict)
    emissions: Mapping[int, Paint] = field(default_factory=dict)
    opacities: Mapping[int, tuple[Paint, float]] = field(default_factory=dict)
    planes: Mapping[int, OnPlane] = field(default_factory=dict)

    @property
    def vary(self) -> bool:
        """Whether it matters where on a surface a ray hits."""
        return bool(self.bases or self.emissions or self.opacities)

    @property
    def cut(self) -> bool:
        """Whether anything is not seen, at least in places."""
        return bool(self.opacities) or bool(self.hidden.any())

    @cached_property
    def emits(self) -> bool:
        """Whether any surface gives light."""
        return bool(self.emissions) or bool(self.emitted.any())

    def base_of(
        self, hits: Hits, rows: np.ndarray, surfaces: np.ndarray, places: Callable[[np.ndarray], np.ndarray]
    ) -> np.ndarray:
        """(k, 3) float32, base colours of the rays `rows` (k,), which met `surfaces` (k,).

        places: of some rays (m,), the points (m, 3) that they met, float64 world [m].
        """
        found = _painted(np.take(self.base, surfaces, axis=0), self.bases, hits, rows, surfaces)
        for surface, some in by_surface(self.planes, surfaces):
            found[some] = self.planes[surface].at(places(rows[some]))
        return np.clip(found, 0, 1, out=found) if self.bases or self.planes else found

    def emitted_of(self, hits: Hits, rows: np.ndarray, surfaces: np.ndarray) -> np.ndarray:
        """(k, 3) float32 [nit], what they emit."""
        return _painted(np.take(self.emitted, surfaces, axis=0), self.emissions, hits, rows, surfaces)

    def unseen(self, hits: Hits, rows: np.ndarray) -> np.ndarray:
        """(k,) bool, which of the rays `rows` (k,) met a place that is not seen."""
        surfaces = hits.surfaces(rows)
        found = np.take(self.hidden, surfaces)
        for surface, some in by_surface(self.opacities, surfaces):
            paint, threshold = self.opacities[surface]
            assert hits.spots is not None
            spots = hits.spots.triangle[rows[some]], hits.spots.uv[rows[some]]
            found[some] = paint.at(*spots)[:, 0] < threshold
        return np.asarray(found)


def _painted(
    colors: np.ndarray, paints: Mapping[int, Paint], hits: Hits, rows: np.ndarray, surfaces: np.ndarray
) -> np.ndarray:
    for surface, some in by_surface(paints, surfaces):
        assert hits.spots is not None
        colors[some] = paints[surface].at(hits.spots.triangle[rows[some]], hits.spots.uv[rows[some]])
    return colors


def by_surface(chosen: Mapping[int, Any], surfaces: np.ndarray) -> list[tuple[int, np.ndarray]]:
    """The chosen surfaces that are there, each with the places in `surfaces` (k,) that hold it."""
    if not chosen:
        return []
    there = np.flatnonzero(np.isin(surfaces, np.fromiter(chosen, np.int64, len(chosen))))
    order = there[np.argsort(surfaces[there], kind="stable")]
    numbers, starts = np.unique(surfaces[order], return_index=True)
    return list(zip(numbers.tolist(), np.split(order, starts[1:]), strict=False))


def read_looks(stage: Any, surfaces: Sequence[Any], files: ImageFiles, warn: Warn) -> Looks:
    """The looks of surfaces: of a bound UsdPreviewSurface or OmniPBR, else the prim's displayColor and displayOpacity,
    else grey.

    warn: gets `material-not-modelled` and `texture-not-read`, one for each material, `texture-without-st` and
    `primvar-left-out`, one for each prim.
    """
    count = len(surfaces)
    base, emitted = np.empty((count, 3), np.float32), np.zeros((count, 3), np.float32)
    hidden = np.zeros(count, bool)
    bases: dict[int, Paint] = {}
    emissions: dict[int, Paint] = {}
    opacities: dict[int, tuple[Paint, float]] = {}
    planes: dict[int, OnPlane] = {}
    networks, painter = Networks(files, warn), Painter(stage, warn)
    known: dict[str, Material | None] = {}
    for number, surface in enumerate(surfaces):
        path = surface.material
        if path and path not in known:
            known[path] = _of_material(stage.GetPrimAtPath(path), networks, warn)
        material = (known.get(path) if path else None) or _displayed(painter, surface)
        for source, plain, paints in ((material.base, base, bases), (material.emitted, emitted, emissions)):
            paint = painter.paint(source, surface)
            if isinstance(paint, tuple):
                plain[number] = paint
            else:
                plain[number], paints[number] = source.plain, paint
        if (plane := painter.on_plane(material.base, surface)) is not None:
            planes[number] = plane
        opacity = painter.paint(material.opacity, surface)
        if isinstance(opacity, tuple):
            hidden[number] = opacity[0] < material.threshold
        else:
            opacities[number] = opacity, material.threshold
    base = np.nan_to_num(base, nan=GREY[0])
    clear = _clear([str(surface.path) for surface in surfaces], hidden)
    return Looks(np.clip(base, 0.0, 1.0), np.maximum(emitted, 0.0), hidden, clear, bases, emissions, opacities, planes)


def _clear(paths: Sequence[str], hidden: np.ndarray) -> frozenset[str]:
    """The hidden surfaces below whose paths all are hidden."""
    above = {path[:end] for path, gone in zip(paths, hidden, strict=True) if not gone for end in _ends(path)}
    return frozenset(path for path, gone in zip(paths, hidden, strict=True) if gone and path not in above)


def _ends(path: str) -> list[int]:
    """Where the paths above a path end."""
    return [place for place, letter in enumerate(path) if letter in "/[" and place]


def _of_material(prim: Any, networks: Networks, warn: Warn) -> Material | None:
    """The colours of a Material; None for one without colours, such as a non-visual one."""
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
        return _preview(shader, networks)
    if str(shader.GetSourceAssetSubIdentifier("mdl") or "").startswith("OmniPBR"):
        return _omni_pbr(shader, str(prim.GetPath()), networks)
    name = identifier or str(shader.GetSourceAssetSubIdentifier("mdl") or "") or "unknown"
    warn("material-not-modelled", str(prim.GetPath()), f"a shader {name} is not modelled: its surfaces are grey")
    return Material(Source(GREY))


def _displayed(painter: Painter, surface: Any) -> Material:
    """The displayColor and displayOpacity of a prim without a material; one mean colour if they fit to no corners."""
    color = Source(_mean_color(painter, surface), primvar="displayColor")
    return Material(color, opacity=Source((1.0,), primvar="displayOpacity"))


def _preview(shader: Any, networks: Networks) -> Material:
    threshold = networks.source(shader, "opacityThreshold", (0.0,)).plain[0]
    return Material(
        networks.source(shader, "diffuseColor", GREY),
        networks.source(shader, "emissiveColor", BLACK),
        networks.source(shader, "opacity", (1.0,)),
        threshold if threshold > 0 else CUT,
    )


def _omni_pbr(shader: Any, path: str, networks: Networks) -> Material:
    """Its colour or texture, in turn brightened, tinted; and what it emits."""

    def numbers(name: str, default: tuple[float, ...]) -> tuple[float, ...]:
        return networks.source(shader, name, default).plain

    tint = np.array(numbers("diffuse_tint", (1.0,) * 3))
    plain = tuple((np.array(numbers("diffuse_color_constant", (0.2,) * 3)) * tint).tolist())
    emitted = BLACK
    switch = shader.GetInput("enable_emission")
    if switch and switch.Get():
        strength = numbers("emissive_intensity", (40.0,))[0]
        emitted = tuple(strength * part for part in numbers("emissive_color", (1.0, 0.1, 0.1)))  # type: ignore[assignment]
    clear = shader.GetInput("enable_opacity")
    opacity = Source(numbers("opacity_constant", (1.0,)) if clear and clear.Get() else (1.0,))
    file = shader.GetInput("diffuse_texture")
    if not file or not str(getattr(file.Get(), "path", "") or ""):
        return Material(Source(plain), Source(emitted), opacity)
    scale = np.append(tint * numbers("albedo_brightness", (1.0,))[0], 1.0)
    bias = np.append(tint * numbers("albedo_add", (0.0,))[0], 0.0)
    space = str(file.GetAttr().GetColorSpace() or "auto")
    texture = networks.texture(file.GetAttr(), path, space, ("repeat", "repeat"), scale, bias)
    turn, move = numbers("texture_rotate", (0.0,))[0], numbers("texture_translate", (0.0, 0.0))
    place = transform_2d(numbers("texture_scale", (1.0, 1.0)), turn, move)
    return Material(Source(plain, texture, coordinates=Coordinates(matrix=place)), Source(emitted), opacity)


def _mean_color(painter: Painter, surface: Any) -> tuple[float, ...]:
    """The mean of primvars:displayColor (linear) at the prim or the nearest above that has it, else grey."""
    from graph.sim.usd import UsdGeom

    prim = painter.gprim(surface)
    primvar = UsdGeom.PrimvarsAPI(prim).FindPrimvarWithInheritance("displayColor") if prim else None
    try:
        values = np.array(primvar.Get() if primvar and primvar.HasValue() else [], np.float64).reshape(-1, 3)
    except (TypeError, ValueError):  # a primvar of another type
        return GREY
    return tuple(values.mean(axis=0).tolist()) if len(values) and np.isfinite(values).all() else GREY
