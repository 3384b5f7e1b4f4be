"""Scans of a recording with their poses: what the writers of point formats take."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from graph.base.errors import RunError
from graph.sim.transforms import Floats

from .clouds import Points, points_of, times_of, xyz
from .poses import TransformLog

if TYPE_CHECKING:
    from graph.recording.run_reader import RunReader
    from graph.recording.sources import Entry


@dataclass(frozen=True, slots=True)
class Scan:
    """The points of one message, in the sensor's frame, and where that frame was.

    index: its number on its topic, from 0. pose: (4, 4) of the frame at the header's stamp, in the root of the recorded
    transforms; None if these do not say it. times_ns: (n,) of each point. point_poses: (n, 4, 4) of the frame at the
    time of each point; None without times or poses.
    """

    topic: str
    index: int
    stamp_ns: int
    frame_id: str
    points: Points
    pose: Floats | None
    times_ns: NDArray[np.int64] | None
    point_poses: Floats | None

    def in_world(self) -> Floats | None:
        """(n, 3) the points in the root frame [m], each by the pose of its own time; None without a pose."""
        poses = self.pose if self.point_poses is None else self.point_poses
        if poses is None:
            return None
        found: Floats = (poses[..., :3, :3] @ xyz(self.points)[:, :, None])[..., 0] + poses[..., :3, 3]
        return found

    def moved_to_world(self) -> Points:
        """The points with x, y, z in the root frame as float64. Raises RunError without a pose."""
        places = self.in_world()
        if places is None:
            raise RunError(
                f"{self.topic}: the recording has no transforms of frame {self.frame_id!r}; publish TF in the graph, "
                "or leave out --world"
            )
        rest = [name for name in self.points.dtype.names or () if name not in "xyz"]
        found = np.empty(
            len(self.points), [*((axis, "<f8") for axis in "xyz"), *((name, self.points.dtype[name]) for name in rest)]
        )
        for name in rest:
            found[name] = self.points[name]
        found["x"], found["y"], found["z"] = places.T
        return found


def scans(run: RunReader, topics: Collection[str], transforms: TransformLog) -> Iterator[Scan]:
    """The scans on these topics, by time. Raises RunError for a message that contradicts itself."""
    counts: Counter[str] = Counter()
    for entry in run.read(topics):
        try:
            yield scan_of(entry, counts[entry.topic], transforms)
        except ValueError as error:
            stamp = entry.time_ns if entry.stamp_ns is None else entry.stamp_ns
            raise RunError(f"{run.name}: {entry.topic} at {stamp / 1e9:.9f} s: {error}") from None
        counts[entry.topic] += 1


def scan_of(entry: Entry, index: int, transforms: TransformLog) -> Scan:
    """The scan of a recorded message. Raises ValueError for one that contradicts itself."""
    message = entry.load()
    stamp = message.header.stamp.sec * 10**9 + message.header.stamp.nanosec
    points = points_of(message, entry.type_name)
    frame = message.header.frame_id
    pose = transforms.poses(frame, np.array([stamp]))
    times = times_of(points, stamp)
    point_poses = None
    if times is not None and pose is not None and len(times):
        different, place = np.unique(times, return_inverse=True)
        known = transforms.poses(frame, different)
        point_poses = None if known is None else known[place]
    return Scan(entry.topic, index, stamp, frame, points, None if pose is None else pose[0], times, point_poses)
