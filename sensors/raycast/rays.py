"""The protocol of ray casting: from a bundle of rays to nearest hits."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any, Protocol

import numpy as np

from graph.base.records import dataclass
from sensors.compiled import compiled

from .triangles import TriangleHits
from .windows import RayGrid

NO_SURFACE = -1
MARGIN_RAD = 1e-4
"""Cones are widened by this angle, so that rounding loses no ray."""
NOTHING = np.uint32(2**32 - 1)
"""Object index of a miss."""
COMMON = np.zeros((1, 3), np.float32)
"""The offsets of rays that all begin at their origin, for compiled loops."""


@dataclass(slots=True)
class RayMemory:
    """What a caster remembers about rays whose table is reused.

    Code that writes directions into the table, or changes the rays' offsets, calls `forget`.

    start: (3,) float32, the origin of `rows` rays from the one at the address `begin` in the table on; None: not known.
    cast: the last cast at static geometry, with the start, the number of rays and whether spots were requested; met:
    its hits, kept from the second equal cast on.
    """

    start: np.ndarray | None = None
    begin: int = 0
    rows: int = 0
    cast: tuple[int, bytes, int, bool] | None = None
    met: TriangleHits | None = None

    def write(self, start: np.ndarray, table: np.ndarray) -> None:
        """Remembers that the rays of a table (n, 6) start at `start`."""
        self.start, self.begin, self.rows = start, table.ctypes.data, len(table)

    def holds(self, start: np.ndarray, table: np.ndarray) -> bool:
        """Whether the rays in a table, which may be a part of the one written, start at `start`."""
        if self.start is None or self.rows < len(table) or self.begin != table.ctypes.data:
            return False
        return self.start.tobytes() == start.tobytes()

    def forget(self) -> None:
        """Marks the rays as changed."""
        self.cast = self.met = None


@dataclass(slots=True)
class RayBundle:
    """Rays that look at one geometry state, or in `spans` at several.

    table: (n, 6) float32, C-contiguous; its columns 3 to 5 are the unit directions, world axes; columns 0 to 2 are for
    the caster, which writes the ray origins there, relative to its scenes' anchors. origin: (3,) float64, world [m],
    near all ray origins. offsets: (n, 3) float32 [m], world axes, each ray's origin less `origin`; None if all start
    there. exclude: prim paths that are never hit, with everything below them. reach: hits
    farther from `origin` than this [m] may be left out.
    grid: a `RayGrid` that contains the bundle's directions, in its span of that number, from `first` on; only for
    speed. swing: the largest angle [rad] between a direction and its place in the grid. columns: (3, n) float32,
    the same directions by axis; computed if not given. memory: that of the table; None if the table is not
    reused.
    parts: of a table with the rays of several sensors, one bundle for each, in order, with no offsets. spans: of one
    whose rays look at several states, one bundle for each state, in order, with the same origin. All of them have
    `exclude`, and the same grid, each turned in its own way.
    """

    origin: np.ndarray
    table: np.ndarray
    offsets: np.ndarray | None = None
    exclude: frozenset[str] = frozenset()
    reach: float = math.inf
    grid: RayGrid | None = None
    first: int = 0
    span: int = 0
    swing: float = 0.0
    columns: np.ndarray | None = None
    memory: RayMemory | None = None
    parts: Sequence[RayBundle] = ()
    spans: Sequence[RayBundle] = ()
    _spread: float | None = None

    @property
    def directions(self) -> np.ndarray:
        """(3, n) float32 unit directions, world axes, each axis contiguous."""
        if self.columns is None:
            self.columns = np.ascontiguousarray(self.table[:, 3:6].T)
        return self.columns

    def each(self) -> Iterator[tuple[int, RayBundle]]:
        """The bundles of single sensors, each with the number of its first ray here."""
        first = 0
        for part in self.parts or (self,):
            yield first, part
            first += len(part.table)

    def by_state(self) -> Iterator[tuple[slice, RayBundle]]:
        """The bundles of single states of the world, each with its rows here."""
        first = 0
        for span in self.spans or (self,):
            yield slice(first, first + len(span.table)), span
            first += len(span.table)

    def some(self, rows: slice) -> RayBundle:
        """A bundle of some of the rays, without a grid; its arrays are parts of these."""
        return RayBundle(
            origin=self.origin,
            table=self.table[rows],
            offsets=None if self.offsets is None else self.offsets[rows],
            exclude=self.exclude,
            reach=self.reach,
            columns=None if self.columns is None else self.columns[:, rows],
            memory=self.memory,
        )

    def spread(self) -> float:
        """Distance [m] from the bundle's origin within which all rays begin."""
        if self._spread is None:
            far = 0.0 if self.offsets is None else float(np.abs(self.offsets).max(initial=0.0))
            self._spread = math.sqrt(3) * far
        return self._spread

    def start_at(self, start: np.ndarray) -> None:
        """Writes the ray origins, `start` (3,) float32 plus the offsets; does nothing if they are already written."""
        memory = self.memory
        if self.offsets is None and memory is not None and memory.holds(start, self.table):
            return
        _start(self.table, start, COMMON if self.offsets is None else self.offsets)
        if memory is not None:
            memory.write(start, self.table if self.offsets is None else self.table[:0])


@compiled
def turn(local: np.ndarray, rotation: np.ndarray, columns: np.ndarray, table: np.ndarray) -> None:
    """Directions (3, n) turned by `rotation` (3, 3): into `columns` (3, n), and 3 to 5 of `table` (n, 6), float32."""
    for ray in range(local.shape[1]):
        x, y, z = local[0, ray], local[1, ray], local[2, ray]
        for axis in range(3):
            turned = rotation[axis, 0] * x + rotation[axis, 1] * y + rotation[axis, 2] * z
            columns[axis, ray] = table[ray, 3 + axis] = turned


@compiled
def _start(table: np.ndarray, start: np.ndarray, offsets: np.ndarray) -> None:
    for ray in range(len(table)):
        own = min(ray, len(offsets) - 1)
        for axis in range(3):
            table[ray, axis] = offsets[own, axis] + start[axis]


@dataclass(slots=True)
class Spots:
    """Where on their surfaces rays hit.

    triangle: (n,) uint32, its number in the surface's mesh, `NOTHING` for infinite planes, moving solids and misses.
    uv: (n, 2) float32, the shares of its second and third corner.
    """

    triangle: np.ndarray
    uv: np.ndarray

    def some(self, rows: slice | np.ndarray) -> Spots:
        """Those of some rays; of a slice, the arrays are parts of these."""
        return Spots(self.triangle[rows], self.uv[rows])


@dataclass(slots=True)
class Hits:
    """Nearest hits of a bundle.

    distance: (n,) float32 [m], inf without a hit. normals: (n, 3) float32, unit, world axes, by the winding of the
    surface, or None if not requested. number: (n,) uint32 of the hit, `NOTHING` without a hit; surface_of: (m,) int32,
    the surface of each number, the last being `NO_SURFACE`. spots: None if not requested.
    """

    distance: np.ndarray
    normals: np.ndarray | None
    number: np.ndarray
    surface_of: np.ndarray
    spots: Spots | None = None

    def some(self, rows: slice | np.ndarray) -> Hits:
        """Those of some rays; of a slice, the arrays are parts of these."""
        normals = None if self.normals is None else self.normals[rows]
        spots = None if self.spots is None else self.spots.some(rows)
        return Hits(self.distance[rows], normals, self.number[rows], self.surface_of, spots)

    def surfaces(self, rows: np.ndarray | None = None) -> np.ndarray:
        """For the rays `rows` (None: all), int32 indices into the caster's `surfaces`; `NO_SURFACE` without a hit."""
        number = self.number if rows is None else np.take(self.number, rows, mode="clip")
        return np.take(self.surface_of, number, mode="clip")


class RayCaster(Protocol):
    """Finds the first hit of each ray."""

    def cast(self, rays: RayBundle, poses: Any = None, *, normals: bool = False, spots: bool = False) -> Hits:
        """Hits against the geometry in the state `poses`, None means now; of rays in spans a state for each span.

        The same rays give the same bytes, whatever else is cast and with any number of threads.
        """


def cast_ranged(
    caster: RayCaster,
    origins: np.ndarray,
    directions: np.ndarray,
    ranges: tuple[float, float],
    poses: Any = None,
    exclude: frozenset[str] = frozenset(),
    *,
    normals: bool = False,
) -> Hits:
    """Hits of rays that start at the first of two ranges [m] ahead of their origins, so that nothing nearer is hit.

    Distances count from that start; hits beyond the second range may be left out.
    origins: (n, 3) or (3,) float64, world [m]; directions: (n, 3), unit, world axes.
    """
    nearest, farthest = ranges
    starts = origins + nearest * directions
    middle = starts.mean(axis=0)
    table = np.zeros((len(directions), 6), np.float32)
    table[:, 3:] = directions
    bundle = RayBundle(middle, table, (starts - middle).astype(np.float32), exclude)
    bundle.reach = bundle.spread() + farthest * (1 + 1e-6)
    return caster.cast(bundle, poses, normals=normals)
