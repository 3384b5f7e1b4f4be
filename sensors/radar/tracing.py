"""Tubes followed from face to face: block by block on all cores, in an order that does not depend on their number."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from sensors.raycast.rays import RayBundle

from .cube import Grid, Part, summed
from .rays import Tubes
from .scattering import Arrivals, again, curved, facing, flat, rough
from .waves import Met, Setting, Waves, first_waves, in_sight, meet, next_waves, reflected

BLOCK = 32_768
"""Tubes that are worked on at once: their numbers fit into a core's cache."""

Each = Callable[[Callable[[Any], Any], Iterable[Any]], Iterable[Any]]
"""`map`, or that of a pool of threads."""


@dataclass(slots=True)
class _Block:
    """What became of some tubes at one bounce: parts of the cube, fields, and waves that go on with their starts."""

    parts: list[Part]
    fields: list[Arrivals]
    on: tuple[Waves, np.ndarray] | None


@dataclass(frozen=True, slots=True)
class Tracer:
    """Follows tubes in one setting and puts what comes back into the cells of a grid."""

    setting: Setting
    grid: Grid
    each: Each = map

    def parts(self, tubes: Tubes, bundle: RayBundle, skip: np.ndarray | None, directions: np.ndarray) -> list[Part]:
        """The parts of the cube that tubes bring; the arguments are those of `first_waves`."""
        waves, hits, row = first_waves(self.setting, tubes, bundle, skip, directions)
        thinned = tubes.thinned()
        found: list[Part] = []
        for bounce in range(1, self.setting.bounces + 1):
            if not len(row):
                break
            rows = [row[start : start + BLOCK] for start in range(0, len(row), BLOCK)]
            if bounce == 1:
                blocks = list(self.each(partial(self._first, tubes, waves, hits), rows))
            else:
                met = list(self.each(partial(self._met, thinned, bounce, waves, hits), rows))
                seen = self._seen([(each, towards) for each, towards, _ in met])
                found += [part for *_, parts in met for part in parts]
                jobs = [(each, at) for (each, *_), at in zip(met, seen, strict=True)]
                blocks = list(self.each(partial(self._again, thinned, bounce), jobs))
            found += [part for block in blocks for part in block.parts]
            fields = [each for block in blocks for each in block.fields]
            if fields:
                found.append(summed(self.grid, Arrivals.together(fields)))
            on = [block.on for block in blocks if block.on is not None and len(block.on[0].row)]
            if not on:
                break
            waves, hits, row = next_waves(self.setting, on)
        return found

    def _first(self, tubes: Tubes, waves: Waves, hits: Any, row: np.ndarray) -> _Block:
        met = meet(self.setting, waves.at(row), hits, row)
        return self._sent(tubes, 1, met, met)

    def _met(
        self, tubes: Tubes, bounce: int, waves: Waves, hits: Any, row: np.ndarray
    ) -> tuple[Met, np.ndarray, list[Part]]:
        """The faces that waves meet, the rows of those that may be seen, and what comes back as it came."""
        met = meet(self.setting, waves.at(row), hits, row)
        return met, facing(self.setting, met), self._summed(bounce, again(self.setting, tubes, met))

    def _seen(self, facing: list[tuple[Met, np.ndarray]]) -> list[np.ndarray]:
        """The rows of each block that the radar sees."""
        out = np.concatenate([met.out[rows] for met, rows in facing])
        back = np.concatenate([met.back[:, rows] for met, rows in facing], axis=1)
        seen = in_sight(self.setting, out, back) if len(out) else np.zeros(0, bool)
        ends = np.cumsum([len(rows) for _, rows in facing])
        return [rows[part] for (_, rows), part in zip(facing, np.split(seen, ends[:-1]), strict=True)]

    def _again(self, tubes: Tubes, bounce: int, job: tuple[Met, np.ndarray]) -> _Block:
        met, seen = job
        return self._sent(tubes, bounce, met, met.at(seen))

    def _sent(self, tubes: Tubes, bounce: int, met: Met, seen: Met) -> _Block:
        """What faces send back and on."""
        setting = self.setting
        parts = [*rough(setting, tubes, seen), *curved(setting, tubes, seen)]
        fields = list(flat(setting, tubes, seen))
        for each in fields:
            each.bounces = bounce
        on = reflected(setting, tubes, met) if bounce < setting.bounces else None
        return _Block(self._summed(bounce, parts), fields, on)

    def _summed(self, bounce: int, found: Iterable[Arrivals]) -> list[Part]:
        parts = []
        for one in found:
            one.bounces = bounce
            parts.append(summed(self.grid, one))
        return parts
