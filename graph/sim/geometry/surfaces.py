"""The surfaces that rays can hit: meshes, infinite planes, and meshes whose points physics moves."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import replace
from functools import cached_property
from typing import Self

import numpy as np
from numpy.typing import NDArray

from graph.base.records import dataclass
from graph.sim.transforms import Floats

from .closed_forms import ClosedForm
from .tessellation import Triangles


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles of one prim, of one of its subsets, or of one instance of these.

    path: of the prim or subset; "/World/Rocks[7]" for copy 7 of a point instancer, "/World/Rocks[7]/Lid" if it has
    several prims. vertices: (n, 3) float64 [m]; in the world if `body` is None, else in the rigid frame of that body
    (its pose without scale: `Fabric.rigid_matrices`). triangles: (m, 3) uint32, normals facing out. material: path of
    the bound material. source: the prim or subset from which the shape was read: `path`, except for copies. frame:
    (4, 4), from the prim's own space to that of the vertices [m].
    """

    path: str
    body: str | None
    vertices: Floats
    triangles: Triangles
    material: str | None = None
    source: str = ""
    frame: Floats | None = None

    def __post_init__(self) -> None:
        if not self.source:
            object.__setattr__(self, "source", self.path)

    @cached_property
    def unique_key(self) -> bytes:
        """Equal for meshes with equal vertices and triangles, which share one ray-casting scene."""
        digest = hashlib.blake2b(self.vertices.tobytes(), digest_size=16)
        digest.update(self.triangles.tobytes())
        return digest.digest()

    def bound_to(self, material: str | None) -> Self:
        """The same surface with a material."""
        return replace(self, material=material)


class Solid(Mesh):
    """A mesh that stands for a solid with a closed form, which rays meet; it is made for those who read its triangles.

    form: in the frame of the mesh. make: gives the mesh's vertices and triangles.
    """

    form: ClosedForm

    def __init__(
        self,
        path: str,
        body: str | None,
        form: ClosedForm,
        make: Callable[[], tuple[Floats, Triangles]],
        source: str = "",
        frame: Floats | None = None,
        material: str | None = None,
    ) -> None:
        self.__dict__ |= {"path": path, "body": body, "form": form, "_make": make}
        self.__dict__ |= {"material": material, "source": source or path, "frame": frame}

    @cached_property
    def _facets(self) -> tuple[Floats, Triangles]:
        made: tuple[Floats, Triangles] = self.__dict__["_make"]()
        return made

    @property
    def vertices(self) -> Floats:
        """As of a `Mesh`."""
        return self._facets[0]

    @property
    def triangles(self) -> Triangles:
        """As of a `Mesh`."""
        return self._facets[1]

    def bound_to(self, material: str | None) -> Self:
        """The same solid with a material."""
        return type(self)(self.path, self.body, self.form, lambda: self._facets, self.source, self.frame, material)


@dataclass(frozen=True, eq=False)
class Plane:
    """An infinite plane: a point on it [m] and its unit normal, in the world or the rigid frame of `body`."""

    path: str
    body: str | None
    origin: Floats
    normal: Floats
    material: str | None = None
    source: str = ""

    def __post_init__(self) -> None:
        if not self.source:
            object.__setattr__(self, "source", self.path)

    def bound_to(self, material: str | None) -> Self:
        """The same plane with a material."""
        return replace(self, material=material)


_CHUNK = 5_000_000


class Following:
    """Vertices (n, 3), each at a constant offset from the nearest of the points (p, 3) in their initial positions."""

    def __init__(self, vertices: Floats, points: Floats) -> None:
        self._nearest = _nearest(vertices, points)
        self._offsets: Floats = vertices - points[self._nearest]

    def vertices(self, points: Floats) -> Floats:
        """(n, 3) the vertices for the present points."""
        out: Floats = points[self._nearest] + self._offsets
        return out

    def velocities(self, points: Floats) -> Floats:
        """(n, 3) of the vertices, from those of the points (p, 3)."""
        out: Floats = points[self._nearest]
        return out


def _nearest(vertices: Floats, points: Floats) -> NDArray[np.intp]:
    """The number of the point nearest to each vertex."""
    out = np.empty(len(vertices), dtype=np.intp)
    rows = max(_CHUNK // max(len(points), 1), 1)
    square = (points**2).sum(axis=1)
    for low in range(0, len(vertices), rows):
        part = vertices[low : low + rows]
        out[low : low + rows] = np.argmin(square - 2 * part @ points.T, axis=1)
    return out
