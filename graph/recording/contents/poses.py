"""Poses over time from recorded transforms: where each frame was, in the frame at the root of its tree."""

from __future__ import annotations

from array import array
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from graph.sim.transforms import Floats, from_xyzw, inverse_rigid, pose_matrices, slerp

if TYPE_CHECKING:
    from graph.recording.run_reader import RunReader

TRANSFORMS = "tf2_msgs/msg/TFMessage"
STATIC = "_static"
REACH_NS = 100_000_000
"""Time beyond the first or last transform for which these are still used [ns]."""
FARTHEST = 1e9
"""Distance from which on a transform or a point is left out, like one without a number [m]."""
_DEEPEST = 200


@dataclass(slots=True)
class _Edge:
    """The poses of a frame in its parent. Times [ns] ascend; values are x, y, z, qx, qy, qz, qw."""

    parent: str
    static: bool
    times: array[int] = field(default_factory=lambda: array("q"))
    values: array[float] = field(default_factory=lambda: array("d"))


class TransformLog:
    """Recorded transforms: `add` takes TFMessages in the order of their times, `poses` gives frames in their root."""

    def __init__(self) -> None:
        self._edges: dict[str, _Edge] = {}

    def add(self, message: Any, topic: str) -> None:
        """Takes the transforms of a message.

        Left out are those with an earlier stamp than the last of their frame and, as tf2 does, those with a position
        that is not finite or a quaternion far from unit length.
        """
        static = topic.endswith(STATIC)
        for one in message.transforms:
            stamp = one.header.stamp.sec * 10**9 + one.header.stamp.nanosec
            at, turn = one.transform.translation, one.transform.rotation
            place, rotation = (at.x, at.y, at.z), (turn.x, turn.y, turn.z, turn.w)
            if not all(abs(one) < FARTHEST for one in place) or not 0.25 < sum(one * one for one in rotation) < 4:
                continue
            edge = self._edges.get(one.child_frame_id)
            if edge is None or (edge.static and not static):
                edge = self._edges[one.child_frame_id] = _Edge(one.header.frame_id, static)
            if edge.parent != one.header.frame_id or (edge.times and stamp < edge.times[-1]):
                continue
            if edge.times and stamp == edge.times[-1]:
                continue
            edge.times.append(stamp)
            edge.values.extend((*place, *rotation))

    def chain(self, frame: str) -> list[str]:
        """The frame and those above it, up to the root."""
        found = [frame]
        while (edge := self._edges.get(found[-1])) is not None and edge.parent not in found and len(found) < _DEEPEST:
            found.append(edge.parent)
        return found

    def frames(self) -> list[str]:
        """The frames whose transforms are recorded, in the order in which they came."""
        return list(self._edges)

    def span(self, frame: str) -> tuple[int, int] | None:
        """The times [ns] between which all moving transforms above a frame are recorded; None without a moving one."""
        moving = [edge for name in self.chain(frame) if (edge := self._edges.get(name)) and not edge.static]
        if not moving:
            return None
        return max(edge.times[0] for edge in moving), min(edge.times[-1] for edge in moving)

    def knows(self, frame: str) -> bool:
        """Whether a pose of the frame is recorded, or of a frame below it."""
        return frame in self._edges or any(edge.parent == frame for edge in self._edges.values())

    def poses(self, frame: str, times: NDArray[np.int64], root: str | None = None) -> Floats | None:
        """(n, 4, 4) poses of a frame at these times [ns], in the frame `root` (default: that at the top of its tree).

        Between two transforms positions are interpolated linearly and rotations on the shorter arc. None if the frame
        or a transform within `REACH_NS` of a time is not recorded, or `root` is not in the frame's tree.
        """
        if not self.knows(frame):
            return None
        chain = self.chain(frame)
        if root is None or root in chain:
            return self._above(chain[: -1 if root is None else chain.index(root)], times)
        branch = self.chain(root)
        if branch[-1] != chain[-1]:
            return None
        top_frame, top_root = self._above(chain[:-1], times), self._above(branch[:-1], times)
        return None if top_frame is None or top_root is None else inverse_rigid(top_root) @ top_frame

    def _above(self, names: list[str], times: NDArray[np.int64]) -> Floats | None:
        """(n, 4, 4) poses of the first frame in the parent of the last; each frame is in the next."""
        whole = np.broadcast_to(np.eye(4), (len(times), 4, 4))
        for name in names:
            step = _at(self._edges[name], times)
            if step is None:
                return None
            whole = step @ whole
        return whole


def _at(edge: _Edge, times: NDArray[np.int64]) -> Floats | None:
    known = np.frombuffer(edge.times, np.int64)
    values = np.frombuffer(edge.values, np.float64).reshape(-1, 7)
    if edge.static:
        last = values[-1:]
        return np.broadcast_to(pose_matrices(last[:, :3], from_xyzw(last[:, 3:])), (len(times), 4, 4))
    if len(times) and (times.min() < known[0] - REACH_NS or times.max() > known[-1] + REACH_NS):
        return None
    after = np.searchsorted(known, times).clip(1, max(1, len(known) - 1))
    before = after - 1
    after = after.clip(0, len(known) - 1)
    span = np.maximum(known[after] - known[before], 1)
    share = ((times - known[before]) / span).clip(0.0, 1.0)
    first, second = values[before], values[after]
    places = first[:, :3] + share[:, None] * (second[:, :3] - first[:, :3])
    turns = slerp(from_xyzw(first[:, 3:]), from_xyzw(second[:, 3:]), share)
    return pose_matrices(places, turns)


def read_transforms(entries: Iterable[Any]) -> TransformLog:
    """The log of a recording's TFMessages (entries of a reader)."""
    log = TransformLog()
    for entry in entries:
        log.add(entry.load(), entry.topic)
    return log


def transforms_of(run: RunReader) -> TransformLog:
    """All transforms of a recording."""
    return read_transforms(run.read([topic.name for topic in run.recorded.values() if topic.type_name == TRANSFORMS]))
