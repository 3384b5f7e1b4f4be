"""Mirrors a model's lights as prims of UsdLux.

MuJoCo's lights have no units: a white surface that faces one of diffuse 1 is white. Here it is white too, at the
exposure that RTX gives a camera which authors none. Its lights do not get weaker with distance unless `attenuation`
says so, those of UsdLux do; both agree at the centre of the model.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from graph.sim.physics.mujoco.library import mujoco
from graph.sim.scene.stage import Warn
from graph.sim.usd import Gf

from .authoring import Author
from .naming import Paths

WHITE = 25 / 0.02
"""Radiance [nit] that a pixel shows white: the reverse of 0.02 s at f/5, ISO 100."""
HEADLIGHT = "mjc:headlight"
"""What each camera lights a surface with that faces it [lux], whatever its distance; without shadows."""
_KIND = mujoco.mjtLightType
NEAREST = 0.1
"""Lights closer to the centre of the model [m] are as bright there as at this distance."""


def mirror_lights(model: Any, data: Any, paths: Paths, author: Author, warn: Warn) -> None:
    """Writes a prim for each light, and one for the ambient light of all, which also holds the headlight's."""
    for number, path in enumerate(paths.lights):
        _light(model, data, number, path, author, warn)
    active = model.light_active.astype(bool)
    ambient = model.light_ambient[active].sum(axis=0)
    head = model.vis.headlight
    if head.active:
        ambient = ambient + head.ambient
    if ambient.any() or head.active:
        spec = author.prim(paths.headlight, "DomeLight")
        _radiance(author, spec, ambient, WHITE)
        if head.active:  # each camera carries it, which no light of UsdLux does
            author.set(spec, HEADLIGHT, "Color3f", Gf.Vec3f(*(float(math.pi * WHITE * each) for each in head.diffuse)))


def _light(model: Any, data: Any, number: int, path: str, author: Author, warn: Warn) -> None:
    kind = _KIND(int(model.light_type[number]))
    spot = kind == _KIND.mjLIGHT_SPOT
    types = {_KIND.mjLIGHT_DIRECTIONAL: "DistantLight", _KIND.mjLIGHT_IMAGE: "DomeLight"}
    spec = author.prim(path, types.get(kind, "SphereLight"), ("ShadowAPI", *(("ShapingAPI",) if spot else ())))
    author.place(spec, model.light_pos[number], _towards(model.light_dir[number]))
    color, candela = model.light_diffuse[number], float(model.light_intensity[number])
    if kind == _KIND.mjLIGHT_IMAGE:
        _radiance(author, spec, color, WHITE)
    elif kind == _KIND.mjLIGHT_DIRECTIONAL:
        _radiance(author, spec, color, math.pi * WHITE)
    else:
        radius = max(float(model.light_bulbradius[number]), 1e-3)
        distance = max(float(np.linalg.norm(data.light_xpos[number] - model.stat.center)), NEAREST)
        fading = float(model.light_attenuation[number] @ (1.0, distance, distance**2))
        at_centre = candela or math.pi * WHITE * distance**2 / max(fading, 1e-6)
        _radiance(author, spec, color, at_centre / (math.pi * radius**2))
        author.set(spec, "inputs:radius", "Float", radius)
    if spot:
        author.set(spec, "inputs:shaping:cone:angle", "Float", float(model.light_cutoff[number]))
        author.set(spec, "inputs:shaping:focus", "Float", float(model.light_exponent[number]))
    author.set(spec, "inputs:shadow:enable", "Bool", bool(model.light_castshadow[number]))
    if not model.light_active[number]:
        author.set(spec, "visibility", "Token", "invisible")
    if model.light_mode[number] != mujoco.mjtCamLight.mjCAMLIGHT_FIXED:
        warn("mjcf-light-fixed", path, "it follows something in the model; here it stays fixed to its body")


def _radiance(author: Author, spec: Any, color: Any, scale: float) -> None:
    author.set(spec, "inputs:color", "Color3f", Gf.Vec3f(*map(float, color)))
    author.set(spec, "inputs:intensity", "Float", scale)


def _towards(direction: Any) -> Any:
    """w, x, y, z of the turn that takes -Z to a direction."""
    way = np.asarray(direction, np.float64)
    length = float(np.linalg.norm(way))
    if not length:
        return 1.0, 0.0, 0.0, 0.0
    quaternion = Gf.Rotation(Gf.Vec3d(0, 0, -1), Gf.Vec3d(*(way / length).tolist())).GetQuat()
    return quaternion.GetReal(), *quaternion.GetImaginary()
