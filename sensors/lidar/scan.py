"""The ideal lidar: from poses, geometry and a firing pattern to channel arrays, independent of clocks and the stage."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from graph.base.records import dataclass, field
from sensors.output_frame import custom_frame
from sensors.raycast.rays import Hits, RayBundle, RayMemory
from sensors.raycast.windows import FULL_SPANS, RayGrid
from sensors.raycast.world import CastWorld, anchor_of
from sensors.surfaces.optics import Optics

from .aim import Aim, Output, aim_rays, moving_aim, turned_back
from .config import LidarConfig
from .echoes import MISS, Candidates, SubRays, form_echoes, separation
from .noise import Noise
from .pattern import Pattern
from .receiver import Receiver, returned
from .returns import Met, Returns, Shot, Targets

MOST_SURFACES = 8
"""Most surfaces that a ray meets; all but the last are transparent."""

STEP_M = 5e-4
"""How far behind a transparent surface a ray continues [m]."""

STEADY_DIGITS = 9
"""A sensor on a body at rest trembles by 1e-13 rad. Its rays are turned by a rotation rounded to so many digits, a
hundredth of what float32 shows of a direction; so they stay the same, and what they met is kept.
"""

MOST_KEPT_BYTES = 64 << 20
"""Directions of sub-rays are computed once and kept, up to this size."""


@dataclass(slots=True)
class _Part:
    """Rows of the ray table that are one slice of the pattern.

    turned_by: the rotation of its directions; casts: how often it was cast; grids: of its directions only, by the
    starts of the spans it was cut into; of a slice in a few spans, once it is cast repeatedly.
    """

    memory: RayMemory = field(default_factory=RayMemory)
    turned_by: bytes | None = None
    casts: int = 0
    grids: dict[tuple[int, ...], RayGrid] = field(default_factory=dict)


class Scanner:
    """Measures with one pattern. Its arrays are allocated once; the caller owns the results.

    The frame of reference of `config`: SENSOR gives points, angles, normals and velocities in the sensor frame of each
    shot, WORLD in world axes about the world's origin, CUSTOM in the frame that `config` describes. Firings without a
    return between the near and far gates are left out, unless its skipDroppingInvalidPoints is set: then they stay with
    distance 0, scalar 0 and without the VALID flag. Ranges and angles are exact without `noise`; the gates apply to
    reported ranges. Each beam is `subrays` rays. A beam of several rays, or one that meets transparent surfaces, may
    have several returns, by the echo settings of `config`.
    """

    def __init__(
        self,
        pattern: Pattern,
        config: LidarConfig,
        *,
        exclude: frozenset[str] = frozenset(),
        noise: Noise | None = None,
        subrays: int = 1,
    ) -> None:
        self.pattern = pattern
        self._config = config
        self._in_world = config.output_frame_of_reference == "WORLD"
        self._custom = custom_frame(config.output_frame_of_reference, config.custom_frame_of_reference_trafo)
        self._exclude = exclude
        self._receiver, self._noise = Receiver(config), noise
        self._sub = SubRays(config, subrays)
        count = len(pattern)
        self._columns = pattern.columns
        self._table = np.empty((count, 6), np.float32)
        self._parts: dict[tuple[int, int], _Part] = {}
        self._kept: dict[int, np.ndarray] = {}
        margin = 0.0 if noise is None else noise.margin
        self._reach = float(pattern.far_m.max(initial=0.0)) * (1 + 1e-6) + margin

    def scan(self, shot: Shot, targets: Targets) -> dict[str, np.ndarray]:
        """The requested channels, each with one row per return, in the order of the pattern. Always has "count".

        Whatever a ray meets passes the range error, the gates and the receiver. Only where a beam may meet several
        surfaces, as it is several rays or passes glass, are they then grouped into echoes.
        """
        receiver, sub = self._receiver, self._sub
        optics, channels, world = targets.optics, targets.channels, targets.world
        several = optics is not None and (len(sub) > 1 or optics.has_glass)
        least = 0.0 if several else receiver.least
        if not (several or least > 0 or "scalar" in channels):
            optics = None
        normals = optics is not None or "hitNormals" in channels
        columns, origins, swing, exact = self._beams(shot)
        met: list[Met] = []
        for number in range(len(sub)):
            beams = self._sub_beams(number, shot.rows) if exact else sub.directions(number, columns)
            aim = self._aim(shot, beams, origins, exact and len(sub) == 1)
            met += self._surfaces(world, shot, aim, swing + sub.swing, optics, least, normals=normals)
        if len(sub) > 1:
            aim = self._aim(shot, columns, origins, exact)
        seen = self._echoes(met, shot) if several else met[0]
        if self._config.skip_dropping_invalid_points:
            seen.add_dark_beams(shot.rows.stop - shot.rows.start)
        return Returns(
            pattern=self.pattern,
            shot=shot,
            met=seen,
            aim=aim,
            output=Output(self._in_world, None if self._in_world else shot.common, self._custom),
            targets=targets,
            receiver=None if optics is None else receiver,
        ).arrays(channels)

    def _surfaces(
        self,
        world: CastWorld,
        shot: Shot,
        aim: Aim,
        swing: float,
        optics: Optics | None,
        least: float,
        *,
        normals: bool,
    ) -> Iterator[Met]:
        """What an aim's rays meet: the first surface of each, then the next ones while light passes.

        least: the least energy that is detected, of the light of a ray, which is a part of its beam's.
        """
        bundle = self._bundle(shot, aim, swing)
        states = [span.poses for span in shot.spans] or shot.poses
        beams: slice | np.ndarray = slice(None)
        light: np.ndarray | np.float32 = np.float32(1.0 / len(self._sub))
        travelled: np.ndarray | np.float32 = np.float32(0.0)
        for _ in range(MOST_SURFACES):
            hits = world.cast(bundle, states, normals=normals)
            distance = hits.distance + travelled
            ranges = self._reported(distance, shot, beams)
            index, back = returned(bundle.table, hits, ranges, self._gates(shot.rows, beams), optics, least)
            back *= light[index] if isinstance(light, np.ndarray) else light
            yield Met(hits, distance, ranges, _some(beams, index), index, back)
            if optics is None or not optics.has_glass:
                return
            passing = np.take(optics.passing, hits.surfaces(), mode="clip") * np.isfinite(hits.distance)
            on = np.flatnonzero((passing > 0) & (distance < self._reach))
            if not len(on):
                return
            light = (light[on] if isinstance(light, np.ndarray) else light) * passing[on]
            beams, travelled = _some(beams, on), distance[on] + np.float32(STEP_M)
            table = np.zeros((len(on), 6), np.float32)
            table[:, 3:6] = aim.table[beams, 3:6]
            offsets = table[:, 3:6] * travelled[:, None]
            if aim.offsets is not None:
                offsets += aim.offsets[beams]
            bundle = RayBundle(aim.pose[:3, 3], table, offsets, self._exclude, bundle.reach)
            if shot.spans:
                ends = np.searchsorted(beams, [span.rows.stop - shot.rows.start for span in shot.spans])
                bundle.spans = [bundle.some(slice(*each)) for each in pairwise([0, *ends])]

    def _echoes(self, met: list[Met], shot: Shot) -> Met:
        """The surfaces that beams meet, grouped into echoes; behind them a miss, for beams without any."""
        echoes = form_echoes(
            Candidates.joined([one.candidates() for one in met]),
            separation=separation(self._config),
            least=self._receiver.least,
            most=self._config.max_returns,
        )
        count, beam, light = len(echoes.beam), echoes.beam, echoes.light
        echoes = Candidates.joined([echoes, MISS])
        hits = Hits(echoes.distance, echoes.normals, np.arange(count + 1, dtype=np.uint32), echoes.surface)
        ranges = self._reported(echoes.distance, shot, echoes.beam)
        return Met(hits, echoes.distance, ranges, beam, np.arange(count), light)

    def _reported(self, distance: np.ndarray, shot: Shot, beams: slice | np.ndarray) -> np.ndarray:
        """The ranges that are reported for true ones (n,) float32 [m] of some beams of a shot."""
        if self._noise is None:
            return distance
        rows = shot.rows if isinstance(beams, slice) else shot.rows.start + beams
        return self._noise.measured(distance, rows, shot.turn)

    def _sub_beams(self, number: int, rows: slice) -> np.ndarray:
        """(3, n) directions of a sub-ray of the pattern's own beams; kept up to `MOST_KEPT_BYTES`."""
        sub = self._sub
        if len(sub) * self._columns.nbytes > MOST_KEPT_BYTES:
            return sub.directions(number, self._columns[:, rows])
        if number not in self._kept:
            self._kept[number] = sub.directions(number, self._columns)
        return self._kept[number][:, rows]

    def _aim(self, shot: Shot, columns: np.ndarray, origins: np.ndarray | None, exact: bool) -> Aim:
        """Turns beams (3, n) to world axes, also in the table. exact: whether they are the pattern's own."""
        rows, part = shot.rows, self._part(shot.rows)
        table = self._table[rows]
        if self._noise is not None and origins is not None:
            part.memory.forget()
        if shot.moves is not None:
            part.turned_by = None
            part.memory.forget()
            return moving_aim(shot.pose, shot.moves, columns, origins, table)
        rotation = np.round(shot.pose[:3, :3], STEADY_DIGITS)
        key = rotation.tobytes() if exact else None
        if key is None or key != part.turned_by:
            start = (shot.pose[:3, 3] - anchor_of(shot.pose[:3, 3])).astype(np.float32)
            aim_rays(np.ascontiguousarray(columns), rotation.astype(np.float32), start, table)
            part.turned_by = key
            part.memory.forget()
            part.memory.write(start, table)
        offsets = None if origins is None else turned_back(origins, rotation.T.astype(np.float32))
        return Aim(shot.pose, table, offsets)

    def _part(self, rows: slice) -> _Part:
        """The known data of these rows of the table; empty if other rows that overlap have been written since."""
        key = rows.start, rows.stop
        if key not in self._parts:
            if any(start < rows.stop and rows.start < stop for start, stop in self._parts):
                self._parts.clear()
            self._parts[key] = _Part()
        return self._parts[key]

    def _bundle(self, shot: Shot, aim: Aim, swing: float) -> RayBundle:
        """The rays of a shot. swing: the largest angle [rad] between a beam and its place in the pattern."""
        part = self._part(shot.rows)
        bundle = RayBundle(
            origin=aim.pose[:3, 3],
            table=aim.table,
            offsets=aim.offsets,
            exclude=self._exclude,
            reach=self._reach,
            memory=part.memory,
        )
        bundle.reach += bundle.spread()
        begin, looks = shot.rows.start, shot.looks
        cuts = [slice(look.rows.start - begin, look.rows.stop - begin) for look in looks]
        if shot.spans:
            bundle.spans = [bundle.some(rows) for rows in cuts]
        grid, own = self._grid_of(part, shot.rows, tuple(rows.start for rows in cuts))
        for number, one in enumerate(bundle.spans or [bundle]):
            pose = looks[number].pose
            one.grid = grid.turned(pose[:3, :3])
            one.first, one.span = (cuts[number].start, number) if own else (looks[number].rows.start, 0)
            one.swing = swing + (0.0 if shot.moves is None else shot.moves.part(cuts[number]).swing(pose))
        return bundle

    def _beams(self, shot: Shot) -> tuple[np.ndarray, np.ndarray | None, float, bool]:
        """Directions (3, n) and origins (n, 3) of the shot's beams in the sensor frame.

        Also the largest angle [rad] between a direction and the pattern's, and whether they are the pattern's own.
        """
        rows, noise, pattern = shot.rows, self._noise, self.pattern
        columns = self._columns[:, rows]
        if noise is None:
            return columns, None if pattern.origins is None else pattern.origins[rows], 0.0, True
        off = noise.directions(rows, shot.turn)
        origins = noise.origins(rows, shot.turn)
        return (columns, origins, 0.0, True) if off is None else (off[0], origins, off[1], False)

    def _grid_of(self, part: _Part, rows: slice, starts: tuple[int, ...]) -> tuple[RayGrid, bool]:
        """The grid that finds the rays of a slice of the pattern, and whether it is cut as they are, else not at all.

        starts: of the spans that the slice is cut into, counted from its first ray.
        """
        if rows.stop - rows.start == len(self.pattern):
            return self.pattern.grid(starts), True
        part.casts += 1
        if starts not in part.grids and (part.casts > 2 or len(starts) > FULL_SPANS):
            part.grids[starts] = RayGrid(self.pattern.directions[rows], starts)
        own = part.grids.get(starts)
        return (self.pattern.grid(), False) if own is None else (own, True)

    def _gates(self, rows: slice, beams: slice | np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The least and the greatest range [m] of some of the firings `rows`, or of all."""
        near, far = self.pattern.near_m, self.pattern.far_m
        return (near[rows][beams], far[rows][beams]) if near.ndim else (near, far)


def _some(beams: slice | np.ndarray, rows: np.ndarray) -> np.ndarray:
    """The numbers of the beams of some rays, which are those of all beams or of `beams`."""
    return rows if isinstance(beams, slice) else beams[rows]
