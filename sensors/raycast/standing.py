"""Standing geometry: one scene for all rays about a place, without what is excluded or out of their reach."""

from __future__ import annotations

import itertools
import math
from collections import OrderedDict
from collections.abc import Sequence
from functools import cached_property

import numpy as np

from graph.base.paths import at_or_below
from graph.sim.geometry.surfaces import Mesh, Plane, Solid

from .enclosed import Enclosed, enclosing
from .rays import NO_SURFACE, RayBundle
from .triangles import TriangleHits, TriangleScene, shared_scene

CELLS = 4
"""How many sides of a cell of space make the power of two below the reach. A sensor that moves gets another scene in
another cell only, and its reach is rounded up to whole sides; so its scene depends on nothing but its place.
"""
MOST_CELLS = 4096
"""Cells whose surfaces are remembered."""


class Regions:
    """The boxes around m surfaces, (m, 2, 3) float64 world [m]: the least and the greatest coordinates."""

    def __init__(self, boxes: np.ndarray) -> None:
        self._boxes = boxes
        whole = boxes[:, 0].min(axis=0, initial=np.inf), boxes[:, 1].max(axis=0, initial=-np.inf)
        self._low, self._high = (tuple(map(float, ends)) for ends in whole)
        self._known: dict[tuple[float, ...], bytes | None] = {}

    def within(self, origin: np.ndarray, reach: float) -> bytes | None:
        """Which surfaces may be hit within `reach` [m] of any place in the cell of `origin` (3,) [m].

        One byte for each, as of a bool array; None for all of them.
        """
        if not math.isfinite(reach):
            return None
        place = origin.tolist()
        farthest = sum(max(x - low, high - x) ** 2 for x, low, high in zip(place, self._low, self._high, strict=True))
        if not reach > 0 or farthest <= reach * reach:
            return None
        side = 2.0 ** math.floor(math.log2(reach)) / CELLS
        reach = math.ceil(reach / side) * side
        cell = reach, *(math.floor(x / side) for x in place)
        if cell not in self._known:
            if len(self._known) >= MOST_CELLS:
                self._known.clear()
            self._known[cell] = self._near(np.array(cell[1:]) * side, side, reach)
        return self._known[cell]

    def _near(self, corner: np.ndarray, side: float, reach: float) -> bytes | None:
        gaps = np.maximum(0.0, np.maximum(self._boxes[:, 0] - (corner + side), corner - self._boxes[:, 1]))
        near = (gaps * gaps).sum(axis=1) <= reach * reach
        return None if near.all() else near.tobytes()


KEPT_SCENES = 32
"""Scenes kept; the least recently used is dropped first."""
IDLE_CASTS = 128
"""Casts after which a scene of a part of the world that none of them used makes room for another: a sensor has left."""

_numbers = itertools.count()


def excluded(path: str, exclude: frozenset[str]) -> bool:
    """Whether a surface is an excluded prim, is below one, or is a copy of one (a point instancer)."""
    return any(at_or_below(path, other) or path.startswith(f"{other}[") for other in exclude)


class Standing:
    """The surfaces of a world that neither move nor deform, and the scenes made of them.

    surfaces: of the whole world; stands: which of them (s,) bool belong here; formulas: whether rays meet solids by
    their closed forms.
    """

    def __init__(
        self,
        surfaces: Sequence[Mesh | Plane],
        stands: Sequence[bool],
        *,
        formulas: bool,
    ) -> None:
        self.surfaces, self.formulas = surfaces, formulas
        self.numbers = [number for number, one in enumerate(stands) if one]
        """The standing surfaces."""
        self._sets: OrderedDict[tuple[bytes, frozenset[str], bytes | None], StandingScene] = OrderedDict()
        self._casts = 0

    def scene(self, anchor: np.ndarray, exclude: frozenset[str], origin: np.ndarray, reach: float) -> StandingScene:
        """The scene of what rays about `origin` may reach [m], around an anchor, both (3,) float64 [m]."""
        self._casts += 1
        return self._scene(anchor, exclude, self._regions.within(origin, reach))

    def beyond(self, origin: np.ndarray, reach: float) -> list[int]:
        """The surfaces that are in no scene of rays about `origin` (3,) with this reach, both [m]."""
        within = self._regions.within(origin, reach)
        if within is None:
            return []
        return [number for number, near in zip(self.numbers, np.frombuffer(within, bool), strict=True) if not near]

    def mesh(self, number: int) -> Mesh:
        """A standing surface."""
        found = self.surfaces[number]
        assert isinstance(found, Mesh)
        return found

    def build(self, vertices: np.ndarray, triangles: np.ndarray) -> TriangleScene:
        """A scene of triangles (m, 3) uint32 with vertices (v, 3) float32; one that this process has already."""
        return shared_scene(vertices, triangles)

    @cached_property
    def _regions(self) -> Regions:
        boxes = []
        for number in self.numbers:
            one = self.mesh(number)
            if self.formulas and isinstance(one, Solid):
                boxes.append(one.form.bounds())
            else:
                ends = one.vertices.min(axis=0, initial=np.inf), one.vertices.max(axis=0, initial=-np.inf)
                boxes.append(ends)
        return Regions(np.array(boxes, np.float64).reshape(-1, 2, 3))

    def _scene(self, anchor: np.ndarray, exclude: frozenset[str], within: bytes | None) -> StandingScene:
        key = (anchor.tobytes(), exclude, within)
        found = self._sets.get(key)
        if found is None:
            self._make_room()
            found = self._sets[key] = StandingScene(self, anchor, exclude, within)
        else:
            self._sets.move_to_end(key)
        found.used = self._casts
        return found

    def _make_room(self) -> None:
        for key in [key for key, one in self._sets.items() if key[2] and one.used < self._casts - IDLE_CASTS]:
            del self._sets[key]
        while len(self._sets) >= KEPT_SCENES:
            self._sets.popitem(last=False)


class StandingScene:
    """The scene of some standing surfaces about one anchor.

    exclude: prims that are left out; within: which of the standing surfaces are in it, as of a bool array, None: all.
    """

    def __init__(
        self, standing: Standing, anchor: np.ndarray, exclude: frozenset[str], within: bytes | None = None
    ) -> None:
        surfaces = standing.surfaces
        self.used = 0
        """Number of the last cast that used it."""
        self._number = next(_numbers)  # distinguishes it from all others, also from deleted ones
        self.skip = frozenset(i for i, s in enumerate(surfaces) if exclude and excluded(str(s.path), exclude))
        """All surfaces that are excluded, standing or not."""
        near = [True] * len(standing.numbers) if within is None else np.frombuffer(within, bool)
        numbers = [
            number
            for number, in_reach in zip(standing.numbers, near, strict=True)
            if in_reach and number not in self.skip and len(standing.mesh(number).triangles)
        ]
        if standing.formulas:
            numbers.sort(key=lambda number: isinstance(surfaces[number], Solid))  # the solids' triangles come last
        meshes = [standing.mesh(number) for number in numbers]
        solids = [one for one in meshes if standing.formulas and isinstance(one, Solid)]
        flat = meshes[: len(meshes) - len(solids)]
        self.static: TriangleScene | None = None
        """Its triangles; None without any."""
        counts = [len(one.triangles) for one in meshes]
        self.triangles = sum(counts)
        self._enclosed = Enclosed(solids, sum(counts[: len(flat)])) if solids else None
        self.starts = np.zeros(max(len(surfaces), 1), np.uint32)
        """(s,), the first triangle of each surface."""
        self.starts[numbers] = np.cumsum([0, *counts])[:-1]
        self.surface_of = np.concatenate(
            [np.repeat(np.array(numbers, np.int32), counts), np.arange(len(surfaces), dtype=np.int32), [NO_SURFACE]],
            dtype=np.int32,
        )
        """The surface of each triangle, then all surfaces, then `NO_SURFACE`."""
        if meshes:
            places = [*(np.asarray(one.vertices, np.float64) for one in flat), *enclosing(solids)]
            vertices = [(place - anchor).astype(np.float32) for place in places]
            starts = np.cumsum([0, *(len(v) for v in vertices)]).astype(np.uint32)
            triangles = [np.asarray(s.triangles, np.uint32) + at for s, at in zip(meshes, starts, strict=False)]
            self.static = standing.build(np.concatenate(vertices), np.concatenate(triangles))
        self._masks: dict[bytes, np.ndarray] = {}

    def left_out(self, surfaces: np.ndarray) -> np.ndarray | None:
        """Which of some surfaces (m,) are excluded, (m,) bool; None if no surface is."""
        if not self.skip:
            return None
        key = surfaces.tobytes()
        if key not in self._masks:
            self._masks[key] = np.isin(surfaces, list(self.skip))
        return self._masks[key]

    def cast(
        self, static: TriangleScene, rays: RayBundle, start: np.ndarray, threads: int, *, uv: bool
    ) -> tuple[TriangleHits, bool]:
        """Hits of rays from `start` (3,) float32 on static geometry, and whether they are kept.

        From the second time on that the same rays come from the same place, their hits are kept: a stationary sensor
        does not cast at static geometry again.
        """
        memory = rays.memory
        cast = self._number, start.tobytes(), len(rays.table), uv
        again = memory is not None and memory.cast == cast
        if again and memory is not None and memory.met is not None:
            return memory.met, True
        rays.start_at(start)
        found = static.cast(rays.table, threads, uv=uv)
        if self._enclosed is not None:
            for first, part in rays.each():
                self._enclosed.correct(static, part, found.some(slice(first, first + len(part.table))), threads)
        if memory is not None:
            memory.cast, memory.met = cast, found if again else None
        return found, again
