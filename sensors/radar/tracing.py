"""Tubes followed from face to face.

A second thread (`graph.base.work`) shares blocks of tubes and waves, and works out what comes back while further rays
are cast. Blocks and their order do not depend on the threads.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from typing import TypeVar

import numpy as np

from graph.base.work import Work, begin, results
from sensors.raycast.rays import Hits, RayBundle

from .again import Again, again, straight_back
from .cube import Grid, Part, summed
from .glints import curved, curved_again
from .grouping import Sums
from .lit import Beam, Lit, LitRoom, lit
from .rays import Tubes
from .scattering import Arrivals
from .setting import Setting
from .sight import NO_STEPS, Sights, Steps
from .waves import Met, Sent, Waves, next_waves

BLOCK = 40_000
"""Tubes that are worked on at once."""

WAVES = 10_000
"""Waves that are worked on at once."""

R = TypeVar("R")


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

    def parts(self, tubes: Tubes, beams: Iterable[Beam]) -> list[Part]:
        """The parts of the cube that tubes bring."""
        found, sights = self._first(tubes, beams)
        parts = [self._begin(partial(self._part_of_lit, tubes, found))]
        sent, waves, looks = Sent.together([one.sent for one in found]), Waves.none(), np.empty((0, 6), np.float32)
        part: Callable[[np.ndarray], Part] | None = None
        while len(sent.waves) or part is not None:
            hits, distance = sent.cast(self.setting, looks)
            if part is not None:
                parts.append(self._begin(partial(part, distance)))
            if not len(sent.waves):
                break
            waves = next_waves(self.setting, waves, sent)
            sent, looks, part = self._next(tubes, waves, hits, sights)
        return results(parts)

    def _first(self, tubes: Tubes, beams: Iterable[Beam]) -> tuple[list[Lit], Sights]:
        """What tubes meet first, and what the first beam sees."""
        setting, bins, fan = self.setting, self.grid.bins, 0
        works: list[Work[Lit]] = []
        for beam in beams:
            for part in blocks(len(beam.hits.distance), BLOCK):
                room = LitRoom.of(setting, tubes.leads[beam.first :][part])
                works.append(self._begin(partial(lit, setting, bins, tubes, beam, part, room)))
            fan = fan or len(works)
        found = results(works)
        plane = np.concatenate([one.plane for one in found[:fan]]) if self.steps else np.empty(0, np.int32)
        return found, Sights(self.steps or NO_STEPS, plane, setting.planes.patch)

    def _part_of_lit(self, tubes: Tubes, found: list[Lit]) -> Part:
        glints = curved(self.setting, tubes, Met.together([one.curved for one in found]))
        return self._summed([one.scattered for one in found], [one.fields for one in found], glints, 1)

    def _next(
        self, tubes: Tubes, waves: Waves, hits: Hits, sights: Sights
    ) -> tuple[Sent, np.ndarray, Callable[[np.ndarray], Part]]:
        """What waves send on that meet faces after a reflection. Rays (r, 6) from the radar tell what it sees of these:
        the function takes the distances (r,) [m] that they go, and gives what comes back.
        """
        setting, bins = self.setting, self.grid.bins

        def of(rows: slice) -> Again:
            return again(setting, tubes, waves.some(rows), hits.some(rows), bins, sights)

        parts = blocks(len(waves.each), WAVES)
        found = results([self._begin(partial(of, rows)) for rows in parts])
        ends = np.cumsum([len(one.facing.rays) for one in found])

        def part(distance: np.ndarray) -> Part:
            scattered, fields, bent = [one.scattered for one in found], [], []
            for one, rows, far in zip(found, parts, np.split(distance, ends[:-1]), strict=True):
                seen = one.facing.seen(far)
                sums, straight = straight_back(setting, tubes, waves.some(rows), one, seen, bins)
                scattered.append(sums)
                fields.append(straight)
                curve = one.facing.curved[seen]
                bent.append(one.curved.at(curve[curve >= 0]))
            glints = curved_again(setting, tubes, Met.together([one.curved for one in found]))
            glints += curved(setting, tubes, Met.together(bent))
            return self._summed(scattered, fields, glints, waves.bounce)

        return Sent.together([one.sent for one in found]), np.concatenate([one.facing.rays for one in found]), part

    def _summed(self, scattered: list[Sums], fields: list[Arrivals], glints: list[Arrivals], bounces: int) -> Part:
        grouped = [Arrivals.together(kind) for kind in (fields, glints) if kind]
        return summed(self.grid, scattered, grouped, bounces)

    def _begin(self, call: Callable[[], R]) -> Work[R]:
        """Lets a second thread work; what deforms is looked up in the simulation, by one thread."""
        return begin(1 if self.setting.deforms else self.setting.world.threads, call)


def blocks(count: int, size: int) -> list[slice]:
    """Rows in equal blocks of at most so many."""
    number = -(-count // size)
    ends = [count * block // number for block in range(number + 1)]
    return [slice(first, end) for first, end in pairwise(ends)]
