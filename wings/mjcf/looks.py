"""Mirrors the lights of a model as prims of UsdLux, and the textures of its materials as UsdPreviewSurface networks.

MuJoCo's lights have no units: a white surface that faces one of diffuse 1 is white. Here it is white too, at the
exposure that RTX gives a camera which authors none. Its lights do not get weaker with distance unless `attenuation`
says so, those of UsdLux do; both agree at the centre of the model.

The pixels of a texture are on its prim. MuJoCo puts flat textures on planes across x and y, and on meshes by their
texture coordinates; there they are mirrored. Elsewhere, and for textures around a cube, a surface has the mean colour.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from graph.sim.physics.mujoco.library import mujoco
from graph.sim.scene.stage import Warn
from graph.sim.usd import Gf, Vt

from .authoring import Author
from .naming import Paths

PIXELS, SIZE = "mjc:pixels", "mjc:size"
"""Attributes of a texture's prim: bytes, row by row from the top, as many a pixel as they make; width and height."""
ST = "mjc:st"
"""Attribute of a plane's prim: a, b, c, d of s = a x + b and t = c y + d, [m] in the plane's own axes."""
FLAT = mujoco.mjtTexture.mjTEXTURE_2D
RGB = mujoco.mjtTextureRole.mjTEXROLE_RGB


def texture_of(model: Any, material: int) -> int:
    """The number of the colour texture of a material; -1 without one."""
    return int(model.mat_texid[material, RGB])


def mirror_texture(model: Any, material: int, path: str, author: Author, tint: tuple[float, float, float]) -> None:
    """Writes the network of a textured material below its prim; tint: (3,), linear, multiplies its colours."""
    texture = texture_of(model, material)
    width, height, channels = (int(getattr(model, f"tex_{name}")[texture]) for name in ("width", "height", "nchannel"))
    start = int(model.tex_adr[texture])
    pixels = np.array(model.tex_data[start : start + width * height * channels])
    kinds = "UsdPreviewSurface", "UsdUVTexture", "UsdTransform2d", "UsdPrimvarReader_float2"
    names = "Surface", "Texture", "Repeat", "Reader"
    surface, image, repeat, reader = (author.prim(f"{path}/{name}", "Shader") for name in names)
    for spec, kind in zip((surface, image, repeat, reader), kinds, strict=True):
        author.set(spec, "info:id", "Token", kind)
    author.set(reader, "inputs:varname", "String", "st")
    author.set(image, PIXELS, "UCharArray", Vt.UCharArray.FromNumpy(pixels))
    author.set(image, SIZE, "Int2", Gf.Vec2i(width, height))
    author.set(image, "inputs:sourceColorSpace", "Token", "sRGB")
    author.set(image, "inputs:scale", "Float4", Gf.Vec4f(*tint, 1.0))
    for side in "ST":
        author.set(image, f"inputs:wrap{side}", "Token", "repeat")
    if model.tex_type[texture] == FLAT:
        across, down = map(float, model.mat_texrepeat[material])  # from the top: t is 1 - down (1 - t)
        author.set(repeat, "inputs:scale", "Float2", Gf.Vec2f(across, down))
        author.set(repeat, "inputs:translation", "Float2", Gf.Vec2f(0, 1 - down))
        author.connect(repeat, "inputs:in", "Float2", f"{path}/Reader.outputs:result")
        author.connect(image, "inputs:st", "Float2", f"{path}/Repeat.outputs:result")
    author.connect(surface, "inputs:diffuseColor", "Color3f", f"{path}/Texture.outputs:rgb")
    for spec in (reader, repeat):
        author.set(spec, "outputs:result", "Float2", None)
    author.set(image, "outputs:rgb", "Float3", None)
    author.set(surface, "outputs:surface", "Token", None)
    author.connect(author.layer.GetPrimAtPath(path), "outputs:surface", "Token", f"{path}/Surface.outputs:surface")


def plane_coordinates(model: Any, geom: int) -> Any:
    """The value of `ST` for a plane with a flat texture; None for others.

    With texuniform `texrepeat` counts in half metres of the plane, else in its whole side; one without an end is
    as if it were 2 m long.
    """
    material = int(model.geom_matid[geom])
    if material < 0 or texture_of(model, material) < 0 or model.tex_type[texture_of(model, material)] != FLAT:
        return None
    size = model.geom_size[geom][:2]
    half = size if (size > 0).all() else np.ones(2)
    times = model.mat_texrepeat[material] * (half if model.mat_texuniform[material] else 1.0)
    a, c = times / (2 * half)
    return Vt.DoubleArray([float(a), float(times[0] / 2), float(c), float(1 - times[1] / 2)])


def mesh_coordinates(model: Any, mesh: int) -> Any:
    """Texture coordinates of a mesh's corners, face by face, as USD has them (t upwards); None without any."""
    start = int(model.mesh_texcoordadr[mesh])
    if start < 0:
        return None
    face, faces = int(model.mesh_faceadr[mesh]), int(model.mesh_facenum[mesh])
    found = np.array(model.mesh_texcoord[start:])[model.mesh_facetexcoord[face : face + faces].ravel()]
    found[:, 1] = 1 - found[:, 1]
    return Vt.Vec2fArray.FromNumpy(np.ascontiguousarray(found, np.float32))


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
