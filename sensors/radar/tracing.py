"""Tubes followed from face to face.

Threads share blocks of the first faces: compiled loops, which need the interpreter's lock only in between. The order of
blocks is that of the tubes, so bytes do not depend on threads. What is met later is little.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from functools import cache
from typing import Any

import numpy as np

from sensors.raycast.rays import Hits, RayBundle

from .again import again, straight_back
from .cube import Grid, Part, summed
from .glints import curved, curved_again
from .grouping import Sums
from .lit import Beam, Lit, LitRoom, lit
from .rays import Tubes
from .scattering import Arrivals
from .setting import Setting
from .sight import NO_STEPS, Sights, Steps
from .waves import Met, Sent, Waves, next_waves

BLOCK = 100_000
"""Tubes that are worked on at once."""


@cache
def _threads(process: int, count: int) -> ThreadPoolExecutor:
    """Threads of a process, which a child does not have."""
    return ThreadPoolExecutor(count)


@dataclass(slots=True)
class _Brought:
    """What tubes bring back after as many faces: powers in cells, fields, and powers of curved surfaces."""

    bounces: int
    scattered: list[Sums] = field(default_factory=list)
    fields: list[Arrivals] = field(default_factory=list)
    glints: list[Arrivals] = field(default_factory=list)

    def part(self, grid: Grid) -> Part:
        """Its part of the cube."""
        grouped = [Arrivals.together(kind) for kind in (self.fields, self.glints) if kind]
        return summed(grid, self.scattered, grouped, self.bounces)


@dataclass(frozen=True, slots=True)
class Tracer:
    """Follows tubes in one setting and puts what comes back into the cells of a grid.

    steps: of the first tubes, which tell what the radar sees (`sight`); None: rays of their own do.
    """

    setting: Setting
    grid: Grid
    steps: Steps | None = None

    def beam(self, first: int, bundle: RayBundle, *, skip: np.ndarray, owner: np.ndarray | None = None) -> Beam:
        """Casts the rays of a bundle, those of the tubes from `first` on.

        skip: (s + 1,) bool, surfaces that they do not meet first; owner: (n,), of each ray the only one it meets.
        """
        return Beam(first, skip, owner, self.setting.cast(bundle))

    def parts(self, tubes: Tubes, beams: list[Beam]) -> list[Part]:
        """The parts of the cube that tubes bring."""
        brought, sent, sights = self._first(tubes, beams)
        found, waves, looks = [brought], Waves.none(), np.empty((0, 6), np.float32)
        straight: Callable[[np.ndarray], None] | None = None
        while len(sent.waves) or len(looks) or straight is not None:
            hits, distance = sent.cast(self.setting, looks)
            if straight is not None:
                straight(distance)
            if not len(sent.waves):
                break
            waves = next_waves(self.setting, waves, sent)
            brought, sent, looks, straight = self._next(tubes, waves, hits, sights)
            found.append(brought)
        return [one.part(self.grid) for one in found]

    def _first(self, tubes: Tubes, beams: list[Beam]) -> tuple[_Brought, Sent, Sights]:
        """What comes back of the faces that tubes meet first, what these send on, and what the fan sees."""
        setting, bins = self.setting, self.grid.bins

        def work(beam: Beam, part: slice, room: LitRoom) -> tuple[Lit, list[Arrivals]]:
            seen = lit(setting, bins, tubes, beam, part, room)
            return seen, curved(setting, tubes, seen.curved)

        blocks = [block for beam in beams for block in beam.blocks(BLOCK)]
        rooms = [LitRoom.of(setting, tubes.leads[beam.first :][part]) for beam, part in blocks]
        brought, sent, planes = _Brought(1), [], []
        for (beam, _), (seen, glints) in zip(blocks, self._map(work, *zip(*blocks, strict=True), rooms), strict=True):
            brought.scattered.append(seen.scattered)
            brought.fields.append(seen.fields)
            brought.glints += glints
            sent.append(seen.sent)
            if beam is beams[0] and self.steps:
                planes.append(seen.plane)
        plane = np.concatenate(planes) if planes else np.empty(0, np.int32)
        return brought, Sent.together(sent), Sights(self.steps or NO_STEPS, plane, setting.planes.patch)

    def _next(
        self, tubes: Tubes, waves: Waves, hits: Hits, sights: Sights
    ) -> tuple[_Brought, Sent, np.ndarray, Callable[[np.ndarray], None]]:
        """What comes back of the faces that waves meet after a reflection, but for what comes straight back, and what
        these send on. Rays (r, 6) from the radar tell what it sees of them: the function takes the distances (r,) [m]
        that these go, and adds what comes straight back.
        """
        setting, bins = self.setting, self.grid.bins
        found, faces = again(setting, tubes, waves, hits, bins, sights)
        met = Met(waves.bounce, waves.images, faces, found.curved)
        brought = _Brought(waves.bounce, [found.scattered], glints=curved_again(setting, tubes, met))

        def straight(distance: np.ndarray) -> None:
            seen = found.facing.seen(distance)
            scattered, fields = straight_back(setting, tubes, waves, faces, found.facing, seen, bins)
            bent = found.facing.curved[seen]
            brought.scattered.append(scattered)
            brought.fields.append(fields)
            brought.glints += curved(setting, tubes, met.at(bent[bent >= 0]))

        return brought, found.sent, found.facing.rays, straight

    @property
    def _map(self) -> Callable[..., Iterator[Any]]:
        """`map`, on threads; what deforms is looked up in the simulation, by one thread."""
        setting = self.setting
        threads = 1 if setting.deforms else setting.world.threads or os.cpu_count() or 1
        return map if threads == 1 else _threads(os.getpid(), threads).map
