"""The protocol of ray casting: from a bundle of rays to nearest hits."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from .triangles import TriangleHits
from .windows import RayGrid

NO_SURFACE = -1
MARGIN_RAD = 1e-4
"""Cones are widened by this angle, so that rounding loses no ray."""
NOTHING = np.uint32(2**32 - 1)
"""Object index of a miss."""


@dataclass(slots=True)
class RayMemory:
    """What a caster remembers about rays whose table is reused.

    Code that writes directions into the table, or changes the rays' offsets, calls `forget`.

    start: (3,) float32, the origin of the first `rows` rays in the table; None: not known. cast: the last cast at
    static geometry, with the start, the number of rays and whether spots were requested; met: its hits, kept from the
    second equal cast on.
    """

    start: np.ndarray | None = None
    rows: int = 0
    cast: tuple[int, bytes, int, bool] | None = None
    met: TriangleHits | None = None

    def holds(self, start: np.ndarray, count: int) -> bool:
        """Whether the first `count` rays in the table start at `start`."""
        return self.rows >= count and self.start is not None and self.start.tobytes() == start.tobytes()

    def forget(self) -> None:
        """Marks the rays as changed."""
        self.cast = self.met = None


@dataclass(slots=True)
class RayBundle:
    """Rays that look at one geometry state.

    table: (n, 6) float32, C-contiguous; its columns 3 to 5 are the unit directions, world axes; columns 0 to 2 are for
    the caster, which writes the ray origins there, relative to its scenes' anchors. origin: (3,) float64, world [m],
    near all ray origins. offsets: (n, 3) float32 [m], world axes, each ray's origin less `origin`; None if all start
    there. exclude: prim paths that are never hit, with everything below them. reach: hits
    farther from `origin` than this [m] may be left out.
    grid: a `RayGrid` that contains the bundle's directions from `first` on; only for speed. swing: the largest angle
    [rad] between a direction and its place in the grid. columns: (3, n) float32, contiguous, the same directions by
    axis; computed if not given. memory: that of the table; None if the table is not reused. parts: of a table with the
    rays of several sensors, one bundle for each, in order; all of them have `exclude`, as many rays, no offsets, and
    grids of the same directions, each turned in its own way. cone: a unit
    vector (3,), world axes, and an angle [rad] around it within which all directions lie; only for speed.
    """

    origin: np.ndarray
    table: np.ndarray
    offsets: np.ndarray | None = None
    exclude: frozenset[str] = frozenset()
    reach: float = math.inf
    grid: RayGrid | None = None
    first: int = 0
    swing: float = 0.0
    columns: np.ndarray | None = None
    memory: RayMemory | None = None
    parts: Sequence[RayBundle] = ()
    cone: tuple[np.ndarray, float] | None = None
    _spread: float | None = None

    @property
    def directions(self) -> np.ndarray:
        """(3, n) float32 unit directions, world axes, contiguous."""
        if self.columns is None:
            self.columns = np.ascontiguousarray(self.table[:, 3:6].T)
        return self.columns

    def each(self) -> Iterator[tuple[int, RayBundle]]:
        """The bundles of single sensors, each with the number of its first ray here."""
        first = 0
        for part in self.parts or (self,):
            yield first, part
            first += len(part.table)

    def may_meet(self, towards: np.ndarray, distance: np.ndarray, half: np.ndarray) -> np.ndarray:
        """(m,) bool, whether rays may go into cones about `towards` (m, 3), `distance` (m,) long, of angles `half`."""
        if self.cone is None:
            return np.ones(len(half), bool)
        axis, angle = self.cone
        between = np.arccos(np.clip(towards @ axis / distance, -1.0, 1.0))
        return np.asarray(between <= half + (angle + MARGIN_RAD))

    def spread(self) -> float:
        """Distance [m] from the bundle's origin within which all rays begin."""
        if self._spread is None:
            far = 0.0 if self.offsets is None else float(np.abs(self.offsets).max(initial=0.0))
            self._spread = math.sqrt(3) * far
        return self._spread

    def start_at(self, start: np.ndarray) -> None:
        """Writes the ray origins, `start` (3,) float32 plus the offsets; does nothing if they are already written."""
        count, memory = len(self.table), self.memory
        if self.offsets is None and memory is not None and memory.holds(start, count):
            return
        for axis in range(3):  # by columns: five times as fast as rows of three
            self.table[:, axis] = start[axis] if self.offsets is None else self.offsets[:, axis] + start[axis]
        if memory is not None:
            memory.start, memory.rows = start, count if self.offsets is None else 0


@dataclass(slots=True)
class Spots:
    """Where on their surfaces rays hit.

    triangle: (n,) uint32, its number in the surface's mesh, `NOTHING` for infinite planes, moving solids and misses.
    uv: (n, 2) float32, the shares of its second and third corner.
    """

    triangle: np.ndarray
    uv: np.ndarray

    def some(self, rows: slice) -> Spots:
        """Those of some rays; the arrays are parts of these."""
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

    def surfaces(self, rows: np.ndarray | None = None) -> np.ndarray:
        """For the rays `rows` (None: all), int32 indices into the caster's `surfaces`; `NO_SURFACE` without a hit."""
        number = self.number if rows is None else np.take(self.number, rows, mode="clip")
        return np.take(self.surface_of, number, mode="clip")


class RayCaster(Protocol):
    """Finds the first hit of each ray."""

    def cast(self, rays: RayBundle, poses: Any = None, *, normals: bool = False, spots: bool = False) -> Hits:
        """Hits against the geometry in the state `poses`; None means now.

        The same rays give the same bytes, whatever else is cast and with any number of threads.
        """
