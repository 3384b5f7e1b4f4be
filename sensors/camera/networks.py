"""Inputs of surface shaders: plain values, textures and primvars, through the nodes of UsdPreviewSurface."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from graph.base.records import dataclass, field

from .image_files import Image, ImageFiles, ImageProblem
from .names import numbers_of
from .textures import WRAPS, Texture, linear_table

Warn = Callable[[str, str, str], None]
OUTPUTS = {"rgb": (0, 1, 2), "r": (0, 0, 0), "g": (1, 1, 1), "b": (2, 2, 2), "a": (3, 3, 3)}
"""Outputs of a UsdUVTexture -> the channels that a colour takes."""


@dataclass(frozen=True, eq=False)
class Coordinates:
    """Where a texture is looked up: matrix (2, 3) of (s, t, 1), the primvar's value, or `fallback` without it."""

    primvar: str = "st"
    fallback: tuple[float, float] = (0.0, 0.0)
    matrix: np.ndarray = field(default_factory=lambda: np.eye(2, 3))


@dataclass(frozen=True, eq=False)
class Source:
    """Where the value of an input comes from: a texture, a primvar, or the plain value.

    plain: also counts where texture and primvar have no value. channels: of the texture's red, green, blue and alpha.
    placed: surfaces without coordinates have the plain value, and planes have coordinates of their own,
    as in an MJCF model.
    """

    plain: tuple[float, ...]
    texture: Texture | None = None
    channels: tuple[int, ...] = OUTPUTS["rgb"]
    coordinates: Coordinates = field(default_factory=Coordinates)
    primvar: str = ""
    placed: bool = False


class Networks:
    """Reads inputs of the shaders of a scene. warn: gets `material-not-modelled` and `texture-not-read`."""

    def __init__(self, files: ImageFiles, warn: Warn) -> None:
        self._files, self._warn = files, warn

    def source(self, shader: Any, name: str, default: tuple[float, ...]) -> Source:
        """What an input of a shader gives; default: of an input that is not authored."""
        given = shader.GetInput(name)
        if not given:
            return Source(default)
        node, output, value = _producer(given)
        if node is None:
            return Source(_numbers(value, len(default)) or default)
        kind = str(node.GetIdAttr().Get() or "")
        if kind == "UsdUVTexture" and output in OUTPUTS:
            return self._texture(node, output, default)
        if kind.startswith("UsdPrimvarReader_float"):
            return Source(_numbers(_value(node, "fallback"), len(default)) or default, primvar=_varname(node))
        said = f"what {name} is connected to ({kind or 'unknown'}) is not modelled: it has one plain colour"
        self._warn("material-not-modelled", _owner(shader), said)
        return Source(_numbers(_value(node, "fallback"), len(default)) or default)

    def texture(
        self, file: Any, where: str, space: str, wraps: tuple[str, str], scale: np.ndarray, bias: np.ndarray
    ) -> Texture | None:
        """The texture of an asset attribute; None, with a warning for the material `where`, if its file is not read."""
        try:
            image = self._files.read(file)
        except ImageProblem as problem:
            self._warn("texture-not-read", where, f"{problem}; its surfaces have one plain colour")
            return None
        return Texture(image, linear_table(image, space), wraps, _float32(scale), _float32(bias))

    def _texture(self, node: Any, output: str, default: tuple[float, ...]) -> Source:
        fallback = numbers_of(_value(node, "fallback"), 4)
        channels = OUTPUTS[output][: len(default)]
        plain = tuple(fallback[channel] for channel in channels) if fallback else default
        wraps = [str(_value(node, name) or "") for name in ("wrapS", "wrapT")]
        scale = np.array(numbers_of(_value(node, "scale"), 4) or (1.0,) * 4)
        bias = np.array(numbers_of(_value(node, "bias"), 4) or (0.0,) * 4)
        kind = str(_value(node, "sourceColorSpace") or "auto")
        across, down = (wrap if wrap in WRAPS else "repeat" for wrap in wraps)
        coordinates = _coordinates(node.GetInput("st"))
        if (image := _own_pixels(node.GetPrim())) is not None:
            found = Texture(image, linear_table(image, kind), (across, down), _float32(scale), _float32(bias))
            return Source(found.mean(channels), found, channels, coordinates, placed=True)
        file = node.GetInput("file")
        if not file:
            return Source(plain)
        attributes = file.GetValueProducingAttributes() or [file.GetAttr()]
        texture = self.texture(attributes[0], _owner(node), kind, (across, down), scale, bias)
        return Source(plain, texture, channels, coordinates)


def _producer(given: Any) -> tuple[Any, str, Any]:
    """(shader, its output, None) that an input is connected to, or (None, "", its value)."""
    from graph.sim.usd import UsdShade

    for attribute in UsdShade.Utils.GetValueProducingAttributes(given):
        name, kind = UsdShade.Utils.GetBaseNameAndType(attribute.GetName())
        node = UsdShade.Shader(attribute.GetPrim())
        if kind == UsdShade.AttributeType.Output and node:
            return node, str(name), None
        return None, "", attribute.Get()
    return None, "", given.Get()


def _value(node: Any, name: str) -> Any:
    given = node.GetInput(name)
    return _producer(given)[2] if given else None


def _numbers(value: Any, count: int) -> tuple[float, ...] | None:
    """The value as so many numbers; of four the first three."""
    found = numbers_of(value, count)
    return found if found is not None else (numbers_of(value, 4) or ())[:count] or None


def _varname(node: Any) -> str:
    return str(_value(node, "varname") or "")


def _coordinates(given: Any) -> Coordinates:
    """Through any number of UsdTransform2d: first scaled, then turned, then moved."""
    matrix = np.eye(2, 3)
    for _ in range(MOST_TRANSFORMS):
        node, _, value = _producer(given) if given else (None, "", None)
        kind = str(node.GetIdAttr().Get() or "") if node is not None else ""
        if kind == "UsdPrimvarReader_float2":
            fallback = numbers_of(_value(node, "fallback"), 2) or (0.0, 0.0)
            return Coordinates(_varname(node), (fallback[0], fallback[1]), matrix)
        if node is None or kind != "UsdTransform2d":
            found = numbers_of(value, 2) or (0.0, 0.0)
            return Coordinates("", (found[0], found[1]), matrix)
        one = transform_2d(
            numbers_of(_value(node, "scale"), 2) or (1.0, 1.0),
            (numbers_of(_value(node, "rotation"), 1) or (0.0,))[0],
            numbers_of(_value(node, "translation"), 2) or (0.0, 0.0),
        )
        matrix = matrix @ np.vstack([one, (0.0, 0.0, 1.0)])
        given = node.GetInput("in")
    return Coordinates("", (0.0, 0.0), matrix)


MOST_TRANSFORMS = 64
"""Most UsdTransform2d in a chain; longer ones, such as circles, give one place."""


def transform_2d(scale: tuple[float, ...], degrees: float, translation: tuple[float, ...]) -> np.ndarray:
    """(2, 3): coordinates scaled, then turned counter-clockwise, then moved."""
    cos, sin = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    turn = np.array([[cos, -sin], [sin, cos]])
    return np.column_stack([turn * np.array(scale), np.array(translation)])


def _own_pixels(prim: Any) -> Image | None:
    """The image whose pixels are on the prim of a texture: that of an MJCF model."""
    size = numbers_of(prim.GetAttribute("mjc:size").Get(), 2) if prim.HasAttribute("mjc:size") else None
    if size is None:
        return None
    pixels = np.array(prim.GetAttribute("mjc:pixels").Get(), np.uint8).reshape(int(size[1]), int(size[0]), -1)
    return Image(np.ascontiguousarray(np.moveaxis(pixels, 2, 0)))


def _float32(values: np.ndarray) -> np.ndarray:
    return values.astype(np.float32)


def _owner(shader: Any) -> str:
    """The material of a shader, for messages."""
    from graph.sim.usd import UsdShade

    prim = shader.GetPrim()
    while prim and not prim.IsPseudoRoot():
        if prim.IsA(UsdShade.Material):
            return str(prim.GetPath())
        prim = prim.GetParent()
    return str(shader.GetPath())
