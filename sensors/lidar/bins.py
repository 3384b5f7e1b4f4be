"""`lidar.motion` continuous: a scan is cut into spans of time, each cast with the world as in its middle."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from graph.base.exact import nanoseconds
from graph.base.records import dataclass
from sensors.motion.history import Trajectory, history_of
from sensors.raycast.world import CastWorld

from .aim import RayPoses
from .returns import Shot, Span

if TYPE_CHECKING:
    from .runtime import LidarRuntime


MOST_SPANS = 64
"""Spans that are cast together, at most."""


@dataclass(slots=True)
class _Moves:
    """How a sensor moves during firings of a turn: at any time since its begin, at each firing, and its first place."""

    track: Trajectory
    rays: RayPoses
    place: np.ndarray


class Bins:
    """The shots of a continuous scan.

    A turn is cut into `lidar.bins` equal spans. Every firing has its own time and starts from the sensor's pose at that
    time, interpolated between the neighbouring physics states (positions along lines, rotations by slerp). For a whole
    span, bodies have their poses of its middle, and points of deformable prims their places: the position error of a
    surface is at most (v + w r) T / (2 bins), with v and w the speeds of its body [m/s, rad/s], r its distance from the
    body's origin [m] and T the time of a turn [s]. Interpolating adds at most a dt^2 / 8 for a body that accelerates by
    a [m/s^2] in physics steps of dt [s]. If nothing moves during a scan, there is one span and neither error.
    """

    def __init__(self, lidar: LidarRuntime) -> None:
        self._path, self._turns = lidar.path, lidar.turns
        self._count = lidar.scene.fidelity.lidar_bins
        self._history = history_of(lidar.scene)

    def ends(self, start: Fraction, end: Fraction) -> tuple[np.ndarray, np.ndarray]:
        """The sensor's poses (4, 4) float64 [m] at two times [s]."""
        return self._history.ends(self._path, start, end)

    def shots(
        self, world: CastWorld, start: Fraction, end: Fraction, slices: list[tuple[int, slice]]
    ) -> tuple[list[Shot], np.ndarray, np.ndarray]:
        """The shots of the firings of `slices` in [start, end) [s], and the sensor's poses at both ends."""
        still = not (world.bodies or world.soft) or self._history.rests(start, end, world.soft)
        pieces = [
            (turn, low, high, piece)
            for turn, rows in slices
            for low, high, piece in self._pieces(start, end, turn, rows, 1 if still else self._count)
        ]
        first, last = self.ends(start, end)
        if not pieces:
            return [], first, last
        middles = [(low + high) / 2 for _, low, high, _ in pieces]
        states = self._history.at(middles)
        shots: list[Shot] = []
        for turn, rows in slices:
            begin = turn * self._turns.period
            base_ns = nanoseconds(begin) - nanoseconds(start)
            own = [number for number, piece in enumerate(pieces) if piece[0] == turn]
            ahead = self._moves(start, end, turn, rows)
            if isinstance(ahead, _Moves):
                poses = ahead.track.poses(np.array([float(middles[number] - begin) for number in own]))
                poses[:, :3, 3] = ahead.place
            else:
                poses = np.broadcast_to(ahead, (len(own), 4, 4))
            spans = [Span(pieces[number][3], pose, states[number]) for number, pose in zip(own, poses, strict=True)]
            for some in (spans[at : at + MOST_SPANS] for at in range(0, len(spans), MOST_SPANS)):
                part = slice(some[0].rows.start, some[-1].rows.stop)
                moves = None
                if isinstance(ahead, _Moves):
                    moves = ahead.rays.part(slice(part.start - rows.start, part.stop - rows.start))
                shots.append(Shot(part, some[0].pose, None, base_ns, moves, turn, spans=some))
        return shots, first, last

    def _moves(self, start: Fraction, end: Fraction, turn: int, rows: slice) -> _Moves | np.ndarray:
        """The sensor's motion during the firings of a turn in [start, end), or its pose if it is stationary.

        The firings of a part of the turn are computed from the same numbers as those of the whole turn, so that they
        give the same bytes: their times and the place they refer to count from the begin of the turn.
        """
        begin = turn * self._turns.period
        track = self._history.trajectory(self._path, start, end, begin)
        if not (track.moves or track.turns):
            return np.asarray(track.poses(np.zeros(1))[0])
        offsets = self._turns.pattern(turn).offset_ns[rows]  # ascending
        new = np.diff(offsets, prepend=offsets[:1] - 1) != 0
        times = offsets[new] * 1e-9
        rays = RayPoses(
            track.rotations(times),
            track.positions(times),
            np.cumsum(new) - 1,
            track.turns,
            cache(lambda: track.velocities(times)),
        )
        if start > begin:
            return _Moves(track, rays, self._history.ends(self._path, begin, begin)[0][:3, 3])
        return _Moves(track, rays, track.positions(np.zeros(1))[0])

    def _pieces(
        self, start: Fraction, end: Fraction, turn: int, rows: slice, count: int
    ) -> Iterator[tuple[Fraction, Fraction, slice]]:
        """(from, to, firings) of the part of each span of a turn in [start, end)."""
        begin, width = turn * self._turns.period, self._turns.period / count
        first, pattern, before = rows.start, self._turns.pattern(turn), begin
        for number in range(count):
            after = (number + 1) * width
            last = rows.stop if number == count - 1 else pattern.index_at(after)
            last = min(max(last, first), rows.stop)
            after += begin
            low, high = max(start, before), min(end, after)
            if last > first and low < high:
                yield low, high, slice(first, last)
                first = last
            before = after
