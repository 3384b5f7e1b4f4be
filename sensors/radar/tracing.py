"""Tubes followed from face to face, block by block.

Threads share the blocks of what tubes meet first: compiled loops, which need the interpreter's lock only in between.
Later blocks are few. The order of blocks is that of the tubes, so bytes do not depend on threads.
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

from .cube import Grid, Part, summed
from .glints import curved, curved_again
from .lit import LEADS, MIRRORS, Beam, lit
from .rays import Tubes
from .scattering import Arrivals, again, facing, flat, rough
from .waves import Met, Sent, Setting, Waves, in_sight, meet, next_waves, reflected

BLOCK = 100_000
"""Tubes that are worked on at once."""


@cache
def _threads(process: int, count: int) -> ThreadPoolExecutor:
    """Threads of a process, which a child does not have."""
    return ThreadPoolExecutor(count)


@dataclass(slots=True)
class _Block:
    """What became of some tubes at one face: parts of the cube, fields, powers of curved surfaces, what is sent on."""

    met: Met
    parts: list[Part] = field(default_factory=list)
    fields: list[Arrivals] = field(default_factory=list)
    glints: list[Arrivals] = field(default_factory=list)
    sent: Sent | None = None


@dataclass(frozen=True, slots=True)
class Tracer:
    """Follows tubes in one setting and puts what comes back into the cells of a grid."""

    setting: Setting
    grid: Grid

    def beam(
        self,
        first: int,
        bundle: RayBundle,
        angle: np.ndarray | None,
        *,
        skip: np.ndarray,
        owner: np.ndarray | None = None,
    ) -> Beam:
        """Casts the rays of a bundle, those of the tubes from `first` on; angle: their angle cells (`Grid.angles`).

        skip: (s + 1,) bool, surfaces that they do not meet first; owner: (n,), of each ray the only one it meets.
        """
        return Beam(first, bundle, angle, skip, owner, self.setting.cast(bundle))

    def parts(self, tubes: Tubes, beams: list[Beam]) -> list[Part]:
        """The parts of the cube that tubes bring."""
        setting = self.setting
        pieces = [piece for beam in beams for piece in beam.blocks(BLOCK, setting.seen)]
        blocks = list(self._map(lambda piece: self._first(tubes, *piece), pieces))
        found: list[Part] = []
        grouped: list[Arrivals] = []
        while blocks:
            found += [part for block in blocks for part in block.parts]
            kinds = ([one for block in blocks for one in getattr(block, kind)] for kind in ("fields", "glints"))
            grouped += [Arrivals.together(kind) for kind in kinds if kind]
            sent = [block.sent for block in blocks if block.sent is not None]
            if not any(len(one.waves) for one in sent):
                break
            waves, hits, row = next_waves(setting, blocks[0].met.waves, sent)
            rows = [row[start : start + BLOCK] for start in range(0, len(row), BLOCK)]
            blocks = [self._next(tubes, waves, hits, some) for some in rows]
            self._straight_back(tubes, blocks)
        return [*found, *(summed(self.grid, each) for each in grouped)]

    @property
    def _map(self) -> Callable[..., Iterator[Any]]:
        """`map`, on threads; what deforms is looked up in the simulation, by one thread."""
        setting = self.setting
        threads = 1 if setting.deforms else setting.world.threads or os.cpu_count() or 1
        return map if threads == 1 else _threads(os.getpid(), threads).map

    def _first(self, tubes: Tubes, beam: Beam, part: slice) -> _Block:
        """What tubes of a beam bring back from the faces that they meet first, and send on."""
        setting, seen = self.setting, lit(self.setting, tubes, beam, part)
        met = meet(setting, seen.waves, np.arange(len(seen.hit)), beam.hits, seen.hit, seen.plane)
        kind = seen.kind.take(met.each["wave"])
        block = _Block(met, self._summed(seen.scattered))
        if setting.bounces > 1:
            block.sent = reflected(setting, tubes, met, np.flatnonzero(kind & LEADS))
        mirrors = np.flatnonzero(kind & MIRRORS)
        if len(mirrors):
            block.fields.append(flat(setting, tubes, met, mirrors))
        if setting.planes.any_curved:
            block.glints += curved(setting, tubes, met)
        return block

    def _next(self, tubes: Tubes, waves: Waves, hits: Hits, row: np.ndarray) -> _Block:
        """What waves that faces have sent on bring back on the way they came, and send on."""
        setting = self.setting
        met = meet(setting, waves, row, hits, row, setting.planes.of_hits(hits, row))
        block = _Block(met, self._summed(again(setting, tubes, met)))
        if setting.planes.any_curved:
            block.glints += curved_again(setting, tubes, met)
        if waves.bounce < setting.bounces:
            block.sent = reflected(setting, tubes, met, np.arange(len(met)))
        return block

    def _straight_back(self, tubes: Tubes, blocks: list[_Block]) -> None:
        """Adds what comes straight back, of what the radar sees."""
        setting = self.setting
        for block in blocks:
            met = block.met
            ahead = facing(setting, met)
            if not len(ahead.row):
                continue
            seen = ahead.at(in_sight(setting, ahead.out, ahead.rays))
            block.parts += self._summed(rough(setting, tubes, met, seen))
            if setting.planes.any_curved:
                block.glints += curved(setting, tubes, met.at(seen.row))
            seen = seen.at(seen.mirrors)
            if len(seen.row):
                block.fields.append(flat(setting, tubes, met, seen.row, seen.back))

    def _summed(self, found: Arrivals) -> list[Part]:
        return [summed(self.grid, found)] if len(found.power) else []
