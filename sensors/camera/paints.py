"""Colours that vary over a surface: by a texture, or from corner to corner."""

from __future__ import annotations

from functools import cached_property
from typing import Any, Protocol

import numpy as np

from graph.base.records import dataclass, field
from graph.sim.geometry.corners import Corners, corners_of, primvar_at_corners
from graph.sim.geometry.surfaces import Mesh
from graph.sim.transforms import apply

from .names import numbers_of
from .networks import Coordinates, Source, Warn
from .textures import Texture


class Paint(Protocol):
    """What a surface shows in some of its places."""

    def at(self, triangle: np.ndarray, uv: np.ndarray) -> np.ndarray:
        """(k, n) float32; triangle (k,), uv (k, 2): as in `sensors.raycast.rays.Spots`."""


@dataclass(frozen=True, eq=False)
class ByCorner:
    """values: (m, 3, n) float32, at the corners of each triangle."""

    values: np.ndarray

    def at(self, triangle: np.ndarray, uv: np.ndarray) -> np.ndarray:
        """The corners' values, weighted."""
        return np.asarray(self.columns(triangle, uv).T)

    def columns(self, triangle: np.ndarray, uv: np.ndarray) -> np.ndarray:
        """The same as (n, k)."""
        out = np.empty((self.values.shape[2], len(triangle)), np.float32)
        u, v = np.ascontiguousarray(uv.T)
        for row, (start, along_u, along_v) in zip(out, self._planes, strict=True):
            np.take(start, triangle, out=row, mode="clip")
            row += np.take(along_u, triangle, mode="clip") * u
            row += np.take(along_v, triangle, mode="clip") * v
        return out

    @cached_property
    def _planes(self) -> np.ndarray:
        """(n, 3, m): values at the first corner, and what the way to the second and to the third adds."""
        first, second, third = np.moveaxis(self.values, 1, 0)
        return np.ascontiguousarray(np.stack([first, second - first, third - first]).transpose(2, 0, 1))


@dataclass(frozen=True, eq=False)
class Textured:
    """places: (m, 3, 2) float32, the texture's coordinates of each corner. channels: of the texture."""

    texture: Texture
    places: ByCorner
    channels: tuple[int, ...]

    def at(self, triangle: np.ndarray, uv: np.ndarray) -> np.ndarray:
        """The texture there."""
        return self.texture.at(self.places.columns(triangle, uv), self.channels)


@dataclass(frozen=True, eq=False)
class OnPlane:
    """A texture on a plane. places: (2, 4) float64, of (x, y, z, 1) in the world [m]. channels: of it."""

    texture: Texture
    places: np.ndarray
    channels: tuple[int, ...]

    def at(self, points: np.ndarray) -> np.ndarray:
        """(k, n) float32 at points (k, 3) float64 in the world [m]."""
        st = apply(self.places[:, :3], points.T, axis=0) + self.places[:, 3:]
        return self.texture.at((st - np.floor(st)).astype(np.float32), self.channels)


@dataclass
class Painter:
    """Makes the paints of a stage's surfaces; warn: gets `texture-without-st` and `primvar-left-out`."""

    stage: Any
    warn: Warn
    _corners: dict[tuple[str, int], Corners | None] = field(default_factory=dict)
    _values: dict[tuple[str, int, str], np.ndarray | None] = field(default_factory=dict)

    def paint(self, source: Source, surface: Any) -> Paint | tuple[float, ...]:
        """What an input gives on a surface; plain numbers where it is the same everywhere."""
        if source.placed and not self._has_places(source, surface):
            return source.plain
        if source.texture is not None:
            places = self._places(source.coordinates, surface)
            if places.shape[0] == 1:
                return tuple(source.texture.at(places[0, :1].T, source.channels)[0].tolist())
            return Textured(source.texture, ByCorner(places), source.channels)
        if source.primvar:
            found = self.primvar(surface, source.primvar, len(source.plain))
            return source.plain if found is None else _plain(found)
        return source.plain

    def on_plane(self, source: Source, surface: Any) -> OnPlane | None:
        """What a texture gives on a plane that says where it lies on it (`mjc:st`) and does not move."""
        from graph.sim.usd import UsdGeom

        prim = self.gprim(surface)
        if source.texture is None or surface.body is not None:
            return None
        given = prim.GetAttribute("mjc:st").Get() if prim and prim.HasAttribute("mjc:st") else None
        numbers = numbers_of(given, 4)
        if numbers is None:
            return None
        a, b, c, d = numbers
        world = np.array(UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(0)).T  # MJCF stages are in metres
        x, y, _, one = np.linalg.inv(world)
        return OnPlane(source.texture, np.stack([a * x + b * one, c * y + d * one]), source.channels)

    def _has_places(self, source: Source, surface: Any) -> bool:
        name = source.coordinates.primvar
        return bool(name) and self.primvar(surface, name, 2) is not None

    def primvar(self, surface: Any, name: str, width: int) -> np.ndarray | None:
        """(m, 3, width) float32 at the surface's corners, (1, 3, width) for one value; None without such a primvar."""
        from graph.sim.usd import UsdGeom

        prim = self.gprim(surface)
        primvar = UsdGeom.PrimvarsAPI(prim).FindPrimvarWithInheritance(name) if prim else None
        if not primvar or not primvar.HasValue():
            return None
        if str(primvar.GetInterpolation()) == "constant":
            return _constant(primvar, width)
        if not isinstance(surface, Mesh):
            return None
        key = self._key(surface)
        if (*key, name) not in self._values:
            corners = self.corners(surface)
            self._values[*key, name] = (
                None
                if corners is None
                else primvar_at_corners(
                    primvar, corners, width, lambda message: self.warn("primvar-left-out", str(prim.GetPath()), message)
                )
            )
        return self._values[*key, name]

    def corners(self, surface: Mesh) -> Corners | None:
        """The surface's triangles by the arrays of its prim; instances and copies share them."""
        key = self._key(surface)
        if key not in self._corners:
            self._corners[key] = corners_of(self.stage.GetPrimAtPath(surface.source), surface)
        return self._corners[key]

    def _key(self, surface: Mesh) -> tuple[str, int]:
        prim = self.gprim(surface)
        origin = prim.GetPrimInPrototype() if prim.IsInstanceProxy() else prim
        return f"{origin.GetPath()}|{surface.source.rpartition('/')[2]}", id(surface.triangles)

    def _places(self, coordinates: Coordinates, surface: Any) -> np.ndarray:
        found = self.primvar(surface, coordinates.primvar, 2) if coordinates.primvar else None
        if found is None:
            if coordinates.primvar:
                said = (
                    f"its texture shows one pixel: it is not a mesh with primvars:{coordinates.primvar} that fit to it"
                )
                self.warn("texture-without-st", str(surface.path), said)
            found = np.full((1, 3, 2), coordinates.fallback, np.float32)
        return np.asarray(apply(coordinates.matrix[:, :2], found) + coordinates.matrix[:, 2], np.float32)

    def gprim(self, surface: Any) -> Any:
        """The prim of a surface, for subsets the mesh."""
        from graph.sim.usd import UsdGeom

        prim = self.stage.GetPrimAtPath(str(surface.source))
        return prim.GetParent() if prim and not prim.IsA(UsdGeom.Imageable) else prim


def _constant(primvar: Any, width: int) -> np.ndarray | None:
    value = primvar.ComputeFlattened()
    found = numbers_of(value, width)
    if found is None and hasattr(value, "__getitem__"):  # an array: its first element
        found = numbers_of(value[:1], width)
    return None if found is None else np.full((1, 3, width), found, np.float32)


def _plain(values: np.ndarray) -> Paint | tuple[float, ...]:
    return tuple(values[0, 0].tolist()) if len(values) == 1 else ByCorner(values)
