"""Lights of UsdLux, and how much light they bring to a surface that faces them.

Radiances are L = intensity 2^exposure colour [nit]; irradiances follow UsdLux (25.05): see `sensors/README.md`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from graph.base.records import dataclass
from graph.sim.transforms import apply, rigid_part, transformed

from .darkness import not_modelled
from .light_images import LightImages, Slide, Warn
from .names import numbers_of, text_of
from .sky import Sky

if TYPE_CHECKING:
    from pxr import Usd

BRIGHTEST = 1e20
"""Radiance [nit] beyond which lights count as that bright: float32 holds its products with what is near and large."""

STRATA = 4
"""Patches along each side of an area light."""


@dataclass(frozen=True, slots=True)
class Light:
    """One light in one state of the world.

    color: (3,) float32. place: (3,), its middle [m, from the camera]. patches: (m, 3) [m, from the camera].
    Its irradiance is the sum over the patches of color cos(incidence) / d^2. The flags change that:
    - far: color is the irradiance of a surface that faces it [lux], and place the unit direction towards it
    - flat: times the cosine at the light; `axis` (3,) points to the side that shines
    - long: times the sine of the angle to `axis`, along which the patches lie
    - carried: the camera carries it, and its irradiance is color cos(incidence)
    cone: about axis: the cosine of its half angle, its soft share, and the power of the cosine by which it fades to its
    edge; or None. shadows: whether it casts any. slide: the pattern of a projector, and (3, 3) from world axes to its
    own.
    """

    color: np.ndarray
    place: np.ndarray
    patches: np.ndarray
    axis: np.ndarray
    far: bool = False
    flat: bool = False
    long: bool = False
    carried: bool = False
    cone: tuple[float, float, float] | None = None
    shadows: bool = True
    slide: tuple[Slide, np.ndarray] | None = None


@dataclass(frozen=True, slots=True)
class Lighting:
    """All lights. sky: (3,) float32 [nit], the radiance that comes from everywhere; skies: those with an image."""

    lights: tuple[Light, ...]
    sky: np.ndarray
    skies: tuple[Sky, ...] = ()

    @property
    def dark(self) -> bool:
        """Whether there is no light at all."""
        return not (self.lights or self.skies or self.sky.any())


def light_prims(stage: Any) -> list[Any]:
    """The lights of a stage, in its order."""
    from graph.sim.usd import Usd, UsdLux

    kinds = UsdLux.BoundableLightBase, UsdLux.NonboundableLightBase
    return [
        prim
        for prim in stage.Traverse(Usd.TraverseInstanceProxies())
        if any(prim.IsA(kind) for kind in kinds) or prim.HasAPI(UsdLux.LightAPI)
    ]


def read_lighting(
    inputs: list[LightInputs],
    images: LightImages,
    matrix_of: Callable[[str], np.ndarray],
    unit: float,
    origin: np.ndarray,
    warn: Warn,
) -> Lighting:
    """The lights as they are now. matrix_of: path -> world matrix (4, 4) float64 [stage units of `unit` m].

    origin: of the camera, (3,) float64 [m]. warn: gets `light-not-modelled`, `texture-not-read`, `bad-transform`.
    """
    lights, sky, skies = [], np.zeros(3, np.float32), []
    for values in inputs:
        if not values.visible:
            continue
        prim, kind, path = values.prim, values.kind, values.path
        placed = matrix_of(path)
        if not np.isfinite(placed).all():
            warn("bad-transform", path, "its transform is not finite; it gives no light")
            continue
        if kind.startswith("DomeLight"):
            if (image := images.sky(prim, warn)) is not None:
                turn = values.pole() @ rigid_part(placed)[:3, :3].T
                skies.append(Sky(image, values.radiance(), turn))
            else:
                sky = sky + values.radiance()
            if (head := values.headlight()).any():
                nowhere = np.zeros(3, np.float32)
                lights.append(Light(head, nowhere, nowhere[None], nowhere, carried=True, shadows=False))
        elif kind == "DistantLight":
            lights.append(replace(_distant(values, rigid_part(placed)), shadows=values.shadows()))
        elif kind in _SHAPES:
            matrix = placed.copy()
            matrix[:3] *= unit
            matrix[:3, 3] -= origin
            light = replace(_SHAPES[kind](values, matrix), shadows=values.shadows())
            lights += [light] if kind != "RectLight" else _textured(light, values, matrix, images, warn)
        else:
            warn("light-not-modelled", path, not_modelled(kind))
    return Lighting(tuple(lights), sky, tuple(skies))


def irradiance(light: Light, points: np.ndarray, normals: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(1, k) float32, or (3, k) for red, green, blue of a projector, times `Light.color` [lux], and the place that it
    comes from, (3, k) or (3, 1) [m, from the camera]: of several patches their mean, each as far as it counts.

    points (3, k) [m, from the camera], normals (3, k) unit, float32.
    """
    place = light.place[:, None]
    if light.far:
        return np.maximum(_dot(light.place, normals), np.float32(0))[None], place
    if light.carried:
        cosine = (-points * normals).sum(axis=0) / np.maximum(np.sqrt((points * points).sum(axis=0)), np.float32(1e-6))
        return np.maximum(cosine, np.float32(0))[None], place
    total, mean = np.zeros(points.shape[1], np.float32), np.zeros_like(points)
    for patch in light.patches:
        way = patch[:, None] - points
        squared = np.maximum((way * way).sum(axis=0), np.float32(1e-12))
        cosine = np.maximum((way * normals).sum(axis=0), np.float32(0))
        if light.flat:
            cosine *= np.maximum(-_dot(light.axis, way), np.float32(0))
            cosine /= squared * squared
        else:
            cosine /= squared * np.sqrt(squared)
            if light.long:
                cosine *= np.sqrt(np.maximum(1 - _dot(light.axis, way) ** 2 / squared, np.float32(0)))
        total += cosine
        if len(light.patches) > 1:
            mean += cosine * patch[:, None]
    if len(light.patches) > 1:
        place = mean / np.maximum(total, np.float32(1e-30))
    if light.cone is not None:
        total *= _cone(light, points)
    if light.slide is None:
        return total[None], place
    slide, turn = light.slide
    return slide.thrown(apply(turn, points - light.place[:, None], axis=0)) * total, place


def _cone(light: Light, points: np.ndarray) -> np.ndarray:
    """The share of a spot's light that reaches points: 1 within the cone, falling to 0 over its soft part. A focus
    weakens it away from the axis.
    """
    assert light.cone is not None
    way = points - light.place[:, None]
    cosine = _dot(light.axis, way) / np.maximum(np.sqrt((way * way).sum(axis=0)), np.float32(1e-6))
    edge, soft, focus = light.cone
    inner = np.cos(np.arccos(edge) * (1 - soft))
    share = np.clip((cosine - edge) / max(inner - edge, 1e-6), 0, 1)
    share = share * share * (3 - 2 * share)
    return np.asarray(share * np.maximum(cosine, 0) ** focus if focus else share, np.float32)


def _dot(axis: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    return np.asarray(axis[0] * vectors[0] + axis[1] * vectors[1] + axis[2] * vectors[2])


def _distant(values: LightInputs, pose: np.ndarray) -> Light:
    """Shines along its -z. Without `omni:rtx:usdluxVersion` from 2505 on its intensity is in lux, as RTX has it."""
    color = values.radiance()
    if not values.normalized() and values.number("omni:rtx:usdluxVersion") >= 2505:
        color = color * np.float32(np.pi * np.sin(np.deg2rad(values.input("angle", 0.53)) / 2) ** 2)
    towards = pose[:3, 2].astype(np.float32)
    return Light(color, towards, towards[None], towards, far=True)


def _sphere(values: LightInputs, matrix: np.ndarray) -> Light:
    """pi L (r / d)^2 cos: a point of intensity pi L r^2."""
    radius = values.input("radius", 0.5) * _lengths(matrix).mean()
    area = 4 * np.pi * radius**2
    power = np.pi * radius**2 / (area if values.normalized() and area else 1.0)
    place, axis = matrix[:3, 3].astype(np.float32), -_unit(matrix[:3, 2])
    return Light(values.radiance() * np.float32(power), place, place[None], axis, cone=values.cone())


def _rect(values: LightInputs, matrix: np.ndarray) -> Light:
    width, height = values.input("width", 1.0), values.input("height", 1.0)
    steps = (np.arange(STRATA) + 0.5) / STRATA - 0.5
    local = np.array([(x * width, y * height, 0.0) for y in steps for x in steps])
    lengths = _lengths(matrix)
    return _area(values, matrix, local, width * height * lengths[0] * lengths[1])


def _disk(values: LightInputs, matrix: np.ndarray) -> Light:
    """Rings of equal area, each of as many patches."""
    radius = values.input("radius", 0.5)
    rings = radius * np.sqrt((np.arange(STRATA) + 0.5) / STRATA)
    turns = 2 * np.pi * (np.arange(2 * STRATA) + 0.5) / (2 * STRATA)
    local = np.array([(r * np.cos(a), r * np.sin(a), 0.0) for r in rings for a in turns])
    lengths = _lengths(matrix)
    return _area(values, matrix, local, np.pi * radius**2 * lengths[0] * lengths[1])


def _cylinder(values: LightInputs, matrix: np.ndarray) -> Light:
    """Points along its axis (x), each as bright as the strip that a piece of it is from the side; its ends are dark."""
    radius, length = values.input("radius", 0.5), values.input("length", 1.0)
    lengths = _lengths(matrix)
    radius, whole = radius * float(lengths[1:].mean()), length * float(lengths[0])
    area = 2 * np.pi * radius * whole
    power = 2 * radius * whole / (area if values.normalized() and area else 1.0)
    local = np.array([(length * ((step + 0.5) / STRATA - 0.5), 0.0, 0.0) for step in range(STRATA)])
    color = values.radiance() * np.float32(power / STRATA)
    place = matrix[:3, 3].astype(np.float32)
    return Light(color, place, _placed(matrix, local), _unit(matrix[:3, 0]), long=True)


def _area(values: LightInputs, matrix: np.ndarray, local: np.ndarray, area: float) -> Light:
    share = np.float32((1.0 if values.normalized() else area) / len(local))
    place, axis = matrix[:3, 3].astype(np.float32), -_unit(matrix[:3, 2])
    return Light(values.radiance() * share, place, _placed(matrix, local), axis, flat=True, cone=values.cone())


_SHAPES = {"SphereLight": _sphere, "RectLight": _rect, "DiskLight": _disk, "CylinderLight": _cylinder}


def _textured(light: Light, values: LightInputs, matrix: np.ndarray, images: LightImages, warn: Warn) -> list[Light]:
    """A rectangle with its texture: a projector throws it, any other shines as its mean does."""
    if values.projects():
        slide = images.slide(values.prim, warn)
        if slide is None:
            return []
        turn = rigid_part(matrix)[:3, :3].T.astype(np.float32)
        whole = light.color * np.float32(len(light.patches))
        return [replace(light, color=whole, patches=light.place[None], slide=(slide, turn))]
    mean = images.mean(values.prim, warn)
    return [light if mean is None else replace(light, color=light.color * mean)]


def _placed(matrix: np.ndarray, local: np.ndarray) -> np.ndarray:
    return np.asarray(transformed(matrix, local), np.float32)


def _lengths(matrix: np.ndarray) -> np.ndarray:
    return np.asarray(np.linalg.norm(matrix[:3, :3], axis=0))


def _unit(vector: np.ndarray) -> np.ndarray:
    return np.asarray(vector / max(float(np.linalg.norm(vector)), 1e-12), np.float32)


_Z_ON_TOP = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])


class LightInputs:
    """The attributes of a light, each read from the stage once."""

    def __init__(self, prim: Usd.Prim) -> None:
        self.prim = self._prim = prim
        self.kind, self.path = str(prim.GetTypeName()), str(prim.GetPath())
        self._known: dict[str, Any] = {}

    def _get(self, name: str) -> Any:
        if name not in self._known:
            attribute = self._prim.GetAttribute(name)
            self._known[name] = attribute.Get() if attribute else None
        return self._known[name]

    def number(self, name: str, default: float = 0.0) -> float:
        """The value of an attribute; the default without one."""
        found = numbers_of(self._get(name), 1)
        return found[0] if found else default

    def text(self, name: str) -> str:
        """The text of a token or an asset."""
        return text_of(self._prim.GetAttribute(name))

    def input(self, name: str, default: float) -> float:
        """The value of an input of UsdLux."""
        return self.number(f"inputs:{name}", default)

    def projects(self) -> bool:
        """Whether it throws its texture as a picture."""
        return bool(self._get("isProjector"))

    def normalized(self) -> bool:
        """Whether its intensity is that of the whole light, whatever its size."""
        return bool(self._get("inputs:normalize"))

    def pole(self) -> np.ndarray:
        """(3, 3), from world axes to those of the dome where nothing turns it: its +Y is on top, as `poleAxis` says."""
        from graph.sim.usd import UsdGeom

        pole = self.text("poleAxis")
        if pole == "scene":
            pole = str(UsdGeom.GetStageUpAxis(self._prim.GetStage()))
        return _Z_ON_TOP if pole == "Z" else np.eye(3)

    def headlight(self) -> np.ndarray:
        """(3,) float32 [lux]: that of an MJCF model."""
        found = np.array(numbers_of(self._get("mjc:headlight"), 3) or (0.0,) * 3)
        return np.asarray(np.clip(found, 0.0, BRIGHTEST), np.float32)

    @cached_property
    def visible(self) -> bool:
        """Whether it is not hidden."""
        from graph.sim.usd import UsdGeom

        imageable = UsdGeom.Imageable(self._prim)
        return not imageable or imageable.ComputeVisibility() != UsdGeom.Tokens.invisible

    def radiance(self) -> np.ndarray:
        """(3,) float32: intensity 2^exposure colour, and the colour of its temperature where that is switched on."""
        from graph.sim.usd import UsdLux

        color = np.array(numbers_of(self._get("inputs:color"), 3) or (1.0, 1.0, 1.0))
        if self._get("inputs:enableColorTemperature"):
            color = color * np.array(UsdLux.BlackbodyTemperatureAsRgb(self.input("colorTemperature", 6500.0)))
        with np.errstate(over="ignore"):
            scale = self.input("intensity", 1.0) * np.exp2(self.input("exposure", 0.0)) * self.input("diffuse", 1.0)
        return np.asarray(np.clip(color * scale, 0.0, BRIGHTEST), np.float32)

    def shadows(self) -> bool:
        """Whether it casts shadows; it does if nothing is said."""
        return self._get("inputs:shadow:enable") is not False

    def cone(self) -> tuple[float, float, float] | None:
        """Of a spot: the cosine of half its opening angle, the soft share of it, and its focus."""
        angle = min(self.number("inputs:shaping:cone:angle", 180.0), 180.0)
        focus = min(max(self.number("inputs:shaping:focus"), 0.0), 1e4)
        if angle >= 180.0 and not focus:
            return None
        soft = min(max(self.number("inputs:shaping:cone:softness"), 0.0), 1.0)
        return float(np.cos(np.deg2rad(angle))), soft, focus
