"""Tubes followed from face to face, block by block.

Blocks are not shared out to threads: what each does to its arrays is so short that handing over the interpreter's lock
took longer than the second core saved.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from sensors.raycast.rays import RayBundle

from .cube import Grid, Part, summed
from .images import Images
from .lit import Beam, bent, heights, leading, lit, mirrors, scattered
from .rays import Tubes
from .scattering import Arrivals, again, curved, curved_again, facing, flat, mirrored, rough
from .waves import Met, Sent, Setting, Waves, cast_first, first_waves, in_sight, meet, next_waves, reflected

BLOCK = 65_536
"""Tubes that are worked on at once: their numbers fit into a core's cache."""


@dataclass(slots=True)
class _Block:
    """What became of some tubes at one bounce: parts of the cube, fields, powers of curved surfaces, what goes on."""

    parts: list[Part]
    fields: list[Arrivals]
    glints: list[Arrivals]
    on: Sent | None


@dataclass(frozen=True, slots=True)
class Tracer:
    """Follows tubes in one setting and puts what comes back into the cells of a grid."""

    setting: Setting
    grid: Grid

    def beam(
        self,
        first: int,
        bundle: RayBundle,
        angle: np.ndarray,
        *,
        skip: np.ndarray | None = None,
        owner: np.ndarray | None = None,
    ) -> Beam:
        """Casts the rays of a bundle, those of the tubes from `first` on; angle: their angle cells (`Grid.angles`).

        skip: (s,) bool, surfaces that they do not meet first; owner: (n,), of each ray the only one it meets.
        """
        setting = self.setting
        return Beam(first, bundle, angle, heights(setting, skip), owner, cast_first(setting, bundle))

    def parts(self, tubes: Tubes, beams: list[Beam]) -> list[Part]:
        """The parts of the cube that tubes bring."""
        setting = self.setting
        blocks = [self._first(tubes, *piece) for beam in beams for piece in beam.blocks(BLOCK, setting.seen)]
        found: list[Part] = []
        grouped: list[Arrivals] = []
        images = Images.none()
        for bounce in range(1, setting.bounces + 1):
            found += [part for block in blocks for part in block.parts]
            kinds = ([each for block in blocks for each in getattr(block, kind)] for kind in ("fields", "glints"))
            grouped += [Arrivals.together(kind) for kind in kinds if kind]
            on = [block.on for block in blocks if block.on is not None and len(block.on.row)]
            if not on:
                break
            waves, hits, row = next_waves(setting, images, on)
            images = waves.images
            if not len(row):
                break
            rows = [row[start : start + BLOCK] for start in range(0, len(row), BLOCK)]
            met = [self._met(tubes, bounce + 1, waves, hits, some) for some in rows]
            seen = self._seen([(each, towards) for each, towards, _ in met])
            found += [part for *_, parts in met for part in parts]
            blocks = [self._again(tubes, bounce + 1, each, at) for (each, *_), at in zip(met, seen, strict=True)]
        return [*found, *(summed(self.grid, each) for each in grouped)]

    def _first(self, tubes: Tubes, beam: Beam, part: slice) -> _Block:
        setting, seen = self.setting, lit(self.setting, beam, part)
        back = [scattered(setting, tubes, beam, seen)] if setting.reflections.scatters else []

        def met(rows: np.ndarray) -> Met:
            waves = first_waves(tubes, rows + seen.tubes.start)
            return meet(setting, waves, beam.hits, rows + seen.part.start, np.take(seen.plane, rows))

        glints = list(curved(setting, tubes, met(bent(setting, seen)))) if setting.planes.any_curved else []
        fields = list(flat(setting, tubes, met(mirrors(setting, tubes, seen))))
        on = reflected(setting, met(leading(setting, tubes, seen))) if setting.bounces > 1 else None
        return _Block(self._summed(1, back), fields, glints, on)

    def _met(
        self, tubes: Tubes, bounce: int, waves: Waves, hits: Any, row: np.ndarray
    ) -> tuple[Met, np.ndarray, list[Part]]:
        """The faces that waves meet, the rows of those that may be seen, and what comes back as it came."""
        met = meet(self.setting, waves.at(row), hits, row, self.setting.planes.of_hits(hits, row))
        return met, facing(self.setting, met), self._summed(bounce, again(self.setting, tubes, met))

    def _seen(self, facing: list[tuple[Met, np.ndarray]]) -> list[np.ndarray]:
        """The rows of each block that the radar sees."""
        out = np.concatenate([met.out[rows] for met, rows in facing])
        back = np.concatenate([met.back[:, rows] for met, rows in facing], axis=1)
        seen = in_sight(self.setting, out, back) if len(out) else np.zeros(0, bool)
        ends = np.cumsum([len(rows) for _, rows in facing])
        return [rows[part] for (_, rows), part in zip(facing, np.split(seen, ends[:-1]), strict=True)]

    def _again(self, tubes: Tubes, bounce: int, met: Met, rows: np.ndarray) -> _Block:
        setting, seen = self.setting, met.at(rows)
        fields = list(flat(setting, tubes, seen.at(mirrored(setting, seen))))
        glints: list[Arrivals] = []
        if setting.planes.any_curved:
            glints = [*curved(setting, tubes, seen), *curved_again(setting, tubes, met)]
        for each in (*fields, *glints):
            each.bounces = bounce
        on = reflected(setting, met) if bounce < setting.bounces else None
        return _Block(self._summed(bounce, rough(setting, tubes, seen)), fields, glints, on)

    def _summed(self, bounce: int, found: Iterable[Arrivals]) -> list[Part]:
        parts = [one for one in found if len(one.power)]
        if not parts:
            return []
        one = Arrivals.together(parts)
        one.bounces = bounce
        return [summed(self.grid, one)]
