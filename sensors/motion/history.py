"""The physics states of the last scans, and the world between them."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections import deque
from collections.abc import Callable, Collection, Iterable, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import numpy as np

from graph.sim.transforms import quaternions, rigid_part, rotation_matrices, slerp

if TYPE_CHECKING:
    from graph.sim.renderer.view import WorldView
    from graph.sim.state.prim_poses import PrimPoses


class Trajectory:
    """A rigid motion through known poses, constant before the first and after the last.

    times: (m,) float64, ascending [s]; poses: (m, 4, 4) float64 rigid [m]. twists: gives the velocities at these times,
    (m, 6) float64, of the moving origin [m/s] and angular [rad/s], world axes.
    """

    def __init__(self, times: np.ndarray, poses: np.ndarray, twists: Callable[[], np.ndarray] | None = None) -> None:
        self._times, self._poses, self._twists = times, poses, twists
        self.turns = bool(np.any(poses[:, :3, :3] != poses[0, :3, :3]))
        """Whether its rotation changes."""
        self.moves = bool(np.any(poses[:, :3, 3] != poses[0, :3, 3]))
        """Whether its position changes."""
        self._quaternions = quaternions(poses[:, :3, :3]) if self.turns else None
        self._kept = np.ones(len(poses), bool)  # whether the rotation stays until the next pose
        self._kept[:-1] = np.all(poses[1:, :3, :3] == poses[:-1, :3, :3], axis=(1, 2))

    def positions(self, times: np.ndarray) -> np.ndarray:
        """(n, 3) float64 [m]."""
        if not self.moves:
            return np.broadcast_to(self._poses[0, :3, 3], (len(times), 3))
        index, share = self._between(times)
        first, second = self._poses[index, :3, 3], self._poses[np.minimum(index + 1, len(self._poses) - 1), :3, 3]
        return np.asarray(first + share[:, None] * (second - first))

    def rotations(self, times: np.ndarray) -> np.ndarray:
        """(n, 3, 3) float64."""
        if self._quaternions is None:
            return np.broadcast_to(self._poses[0, :3, :3], (len(times), 3, 3))
        index, share = self._between(times)
        second = self._quaternions[np.minimum(index + 1, len(self._poses) - 1)]
        out = np.asarray(rotation_matrices(slerp(self._quaternions[index], second, share)))
        exact = self._kept[index] | (share == 0.0)  # the known matrix itself, whatever poses follow
        out[exact] = self._poses[index[exact], :3, :3]
        return out

    def velocities(self, times: np.ndarray) -> np.ndarray:
        """(n, 6) float64, interpolated linearly: of the origin [m/s], angular [rad/s]; 0 if unknown."""
        if self._twists is None:
            return np.zeros((len(times), 6))
        twists, (index, share) = self._twists(), self._between(times)
        first, second = twists[index], twists[np.minimum(index + 1, len(twists) - 1)]
        return np.asarray(first + share[:, None] * (second - first))

    def poses(self, times: np.ndarray) -> np.ndarray:
        """(n, 4, 4) float64 rigid [m]."""
        if not (self.turns or self.moves):
            return np.repeat(self._poses[:1], len(times), axis=0)
        out = np.zeros((len(times), 4, 4))
        out[:, :3, :3] = self.rotations(times)
        out[:, :3, 3] = self.positions(times)
        out[:, 3, 3] = 1.0
        return out

    def _between(self, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The known pose at or before each time, and the fraction (0 to 1) of the way to the next."""
        known = self._times
        index = np.clip(np.searchsorted(known, times, side="right") - 1, 0, len(known) - 1)
        step = known[np.minimum(index + 1, len(known) - 1)] - known[index]
        share = np.where(step > 0, (times - known[index]) / np.where(step > 0, step, 1.0), 0.0)
        return index, np.clip(share, 0.0, 1.0)


LAST = 1000
"""Order among the subscribers of a step: it is last, so the stored state includes what the others move."""

LONGEST_UPDATE = Fraction(1, 5)
"""The past [s] that is kept before a lidar requests more: an update of a loop of 5 Hz."""


def history_of(scene: WorldView) -> History:
    """The history of a world, shared by all its sensors. The first call starts it."""
    known: History | None = scene.shared.get("history")
    if known is None:
        known = scene.shared["history"] = History(scene)
    return known


def begin_history(scene: WorldView) -> None:
    """From now on keeps the states of at least the present update, for lidars that look back.

    A sensor that a graph makes exists from the start of that update, whose states it could not get otherwise.
    """
    history_of(scene).keep(LONGEST_UPDATE)


class BlendedPoses:
    """All bodies between two captured states, at the fraction `share` (0 to 1); has the members of `Poses`.

    matrices: (B + 1, 4, 4) rigid body poses [m], the identity last. Velocities are interpolated linearly; values that
    users wrote are those of the first state.
    """

    def __init__(self, first: Any, second: Any, share: float, matrices: np.ndarray) -> None:
        self.stamp = first.stamp
        self.layout = first.layout
        self.written = first.written
        self.matrices = matrices
        self._first, self._second, self._share = first, second, share

    def velocities(self, bodies: Iterable[str]) -> np.ndarray:
        """(n, 6) of the origins of bodies: linear [m/s], angular [rad/s], world axes."""
        bodies = tuple(bodies)
        first, second = self._first.velocities(bodies), self._second.velocities(bodies)
        return np.asarray(first + self._share * (second - first))

    def points(self, path: str) -> np.ndarray | None:
        """(p, 3) of a prim that physics deforms, in the world [m], along straight lines; None for any other prim."""
        first, second = self._first.points(path), self._second.points(path)
        return first if first is None or second is None else np.asarray(first + self._share * (second - first))


def blend(first: Sequence[Any], second: Sequence[Any], shares: np.ndarray) -> list[BlendedPoses]:
    """Interpolates each pair of states at the fractions `shares` (n,): positions along lines, rotations by slerp."""
    a, b = np.stack([state.matrices for state in first]), np.stack([state.matrices for state in second])
    out = a + shares[:, None, None, None] * (b - a)
    pair, body = np.nonzero(np.any(a[..., :3, :3] != b[..., :3, :3], axis=(2, 3)))
    if len(pair):
        ends = quaternions(np.concatenate([a[pair, body, :3, :3], b[pair, body, :3, :3]]))
        out[pair, body, :3, :3] = rotation_matrices(slerp(ends[: len(pair)], ends[len(pair) :], shares[pair]))
    return [
        BlendedPoses(one, two, float(share), matrices)
        for one, two, share, matrices in zip(first, second, shares, out, strict=True)
    ]


class History:
    """The states after the latest physics steps, with their exact external times.

    It begins with the state before the first recorded step; before that, the world is taken as unchanged. A body that
    is placed elsewhere between two steps moves there within that step.
    """

    def __init__(self, scene: WorldView) -> None:
        self._scene = scene
        self._times: deque[Fraction] = deque()
        self._states: deque[Any] = deque()
        self._span = Fraction(0)
        self._full = 3
        """The number of states at which old ones are dropped."""
        self._asked: tuple[tuple[Any, ...], Trajectory] | None = None
        """The latest trajectory, and what was asked for: a scan asks more than once."""
        for event, handler, order in (
            ("physics_pre_step", self._begin, -LAST),
            ("physics_post_step", self._record, LAST),
            ("stop", self._forget, 0),
        ):
            scene.on(event, handler, order)

    def __len__(self) -> int:
        return len(self._times)

    def keep(self, span: Fraction) -> None:
        """Keeps at least this much of the past [s]."""
        self._span = max(self._span, span)

    def at(self, times: Sequence[Fraction]) -> list[Any]:
        """All bodies at each of some times [s], interpolated between the neighbouring states."""
        self._begin()
        last = len(self._times) - 1
        number = [min(max(bisect_right(self._times, time) - 1, 0), last) for time in times]
        after = [min(index + 1, last) for index in number]
        shares = [
            min(max(float((time - self._times[one]) / (self._times[two] - self._times[one])), 0.0), 1.0)
            if two > one
            else 0.0
            for time, one, two in zip(times, number, after, strict=True)
        ]
        return list(
            blend([self._states[one] for one in number], [self._states[two] for two in after], np.array(shares))
        )

    def rests(self, start: Fraction, end: Fraction, soft: Collection[str] = ()) -> bool:
        """Whether no body, and no point of the deformable prims `soft`, moves at any time from `start` to `end` [s]."""
        _, (first, *later) = self._around(start, end)
        return all(
            np.array_equal(first.matrices, state.matrices)
            and all(np.array_equal(first.points(path), state.points(path)) for path in soft)
            for state in later
        )

    def trajectory(self, path: str, start: Fraction, end: Fraction, origin: Fraction | None = None) -> Trajectory:
        """The motion of a prim from `start` to `end` [s]; its times are seconds after `origin` (default: `start`)."""
        self._begin()
        zero = start if origin is None else origin
        asked = path, start, end, zero, self._states[0], self._states[-1]
        if self._asked is None or self._asked[0] != asked:
            self._asked = asked, self._trajectory(path, start, end, zero)
        return self._asked[1]

    def _trajectory(self, path: str, start: Fraction, end: Fraction, zero: Fraction) -> Trajectory:
        fabric = self._scene.fabric
        times, states = self._around(start, end)
        if fabric.body_of(path) is None and all(state.written is states[0].written for state in states):
            times, states = times[:1], states[:1]  # it did not move
        poses = np.stack([rigid_part(fabric.world_matrix(path, state)) for state in states])
        poses[:, :3, 3] *= fabric.meters_per_unit

        def twists() -> np.ndarray:
            return _twists(fabric, path, states, poses[:, :3, 3])

        return Trajectory(np.array([float(time - zero) for time in times]), poses, twists)

    def ends(self, path: str, start: Fraction, end: Fraction) -> tuple[np.ndarray, np.ndarray]:
        """The poses of a prim at `start` and at `end`: (4, 4) float64 rigid poses [m]."""
        first, last = self.trajectory(path, start, end).poses(np.array([0.0, float(end - start)]))
        return first, last

    def _around(self, start: Fraction, end: Fraction) -> tuple[list[Fraction], list[Any]]:
        """The states from the last one at or before `start` to the first one at or after `end`."""
        self._begin()
        first = max(0, bisect_right(self._times, start) - 1)
        last = min(bisect_left(self._times, end, first), len(self._times) - 1)
        times, states = list(self._times), list(self._states)
        return times[first : last + 1], states[first : last + 1]

    def _begin(self) -> None:
        if not self._times:
            self._record()

    def _record(self) -> None:
        time, state = self._scene.rendering.time, self._scene.fabric.capture()
        if self._states and self._states[-1].layout is not state.layout:  # other bodies: nothing to interpolate with
            self._forget()
        while self._times and self._times[-1] >= time:
            self._times.pop()
            self._states.pop()
        self._times.append(time)
        self._states.append(state)
        if len(self._times) >= self._full:
            self._drop(time - self._span)

    def _drop(self, oldest: Fraction) -> None:
        """Drops the states that end before `oldest` [s]; next when there are twice as many as are left."""
        while len(self._times) > 2 and self._times[1] <= oldest:
            self._times.popleft()
            self._states.popleft()
        self._full = 2 * len(self._times)

    def _forget(self) -> None:
        self._times.clear()
        self._states.clear()
        self._asked = None


def _twists(fabric: PrimPoses, path: str, states: Sequence[Any], places: np.ndarray) -> np.ndarray:
    """(m, 6) velocities of a prim at its places (m, 3) [m] in some states: those of the body that carries it."""
    carrier = fabric.body_of(path)
    if carrier is None:
        return np.zeros((len(states), 6))
    out = np.concatenate([state.velocities((carrier,)) for state in states])
    origins = np.stack([fabric.rigid_matrices((carrier,), state)[0, :3, 3] for state in states])
    out[:, :3] += np.cross(out[:, 3:], places - origins)
    return out
