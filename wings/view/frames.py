"""Where the recorded frames were, the boxes that detections gave, and what cameras see: the scene of the page."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from graph.recording.contents.poses import TransformLog
from graph.sim.transforms import quaternions, to_xyzw

DETECTIONS = "vision_msgs/msg/Detection3DArray"
LENS = "sensor_msgs/msg/CameraInfo"
SAMPLES, ALL_SAMPLES = 400, 24_000
"""Poses of a frame in the page, and of all frames, at most."""
MOST_BOXES = 200
"""Of a message."""


def frames(log: TransformLog) -> Iterator[dict[str, Any]]:
    """The poses of each frame in the root of its tree over time: places [m], and rotations as x, y, z, w."""
    names = log.frames()
    samples = max(20, min(SAMPLES, ALL_SAMPLES // max(1, len(names))))
    for name in names:
        span = log.span(name)
        still = span is None or span[1] <= span[0]
        times = np.array([0]) if span is None else np.linspace(*span, 1 if still else samples).round().astype(np.int64)
        poses = log.poses(name, times)
        if poses is None:
            continue
        chain = log.chain(name)
        places, turns = poses[:, :3, 3], to_xyzw(quaternions(poses[:, :3, :3]))
        if not (np.isfinite(places).all() and np.isfinite(turns).all()):
            continue
        yield {
            "name": name,
            "parent": chain[1] if len(chain) > 1 else "",
            "root": chain[-1],
            "moves": bool(np.ptp(places, axis=0).max() > 1e-6),
            "t": (times / 1e9).tolist(),
            "places": places.round(4).tolist(),
            "turns": turns.round(5).tolist(),
        }


def boxes(message: Any, stamp_ns: int, log: TransformLog) -> dict[str, Any]:
    """The boxes of a `vision_msgs/Detection3DArray` in the root of its frame: (n, 8, 3) corners, and what they are."""
    frame = message.header.frame_id
    pose = log.poses(frame, np.array([stamp_ns]))
    whole = np.eye(4) if pose is None else pose[0]
    corners, labels = [], []
    for one in message.detections[:MOST_BOXES]:
        at, turn, size = one.bbox.center.position, one.bbox.center.orientation, one.bbox.size
        rotation = _rotation(turn.x, turn.y, turn.z, turn.w)
        signs = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
        local = (signs * (size.x, size.y, size.z)) @ rotation.T + (at.x, at.y, at.z)
        placed = local @ whole[:3, :3].T + whole[:3, 3]
        if np.isfinite(placed).all():
            corners.append(placed.round(3).tolist())
            labels.append(str(one.results[0].hypothesis.class_id) if len(one.results) else str(one.id))
    root = frame if pose is None else log.chain(frame)[-1]
    return {"t": stamp_ns / 1e9, "root": root, "corners": corners, "labels": labels}


def lens(message: Any) -> dict[str, Any] | None:
    """The directions (4, 3) to the corners of a camera's image, at z = 1 of its frame; None without a focal length."""
    k = np.asarray(message.k, np.float64).reshape(3, 3)
    if not (np.isfinite(k).all() and k[0, 0] > 0 and k[1, 1] > 0 and message.width and message.height):
        return None
    columns = (np.array([0, message.width, message.width, 0]) - k[0, 2]) / k[0, 0]
    rows = (np.array([0, 0, message.height, message.height]) - k[1, 2]) / k[1, 1]
    return {"frame": message.header.frame_id, "rays": np.stack([columns, rows, np.ones(4)], 1).round(4).tolist()}


def _rotation(x: float, y: float, z: float, w: float) -> Any:
    from graph.sim.transforms import rotation_matrices

    length = (x * x + y * y + z * z + w * w) ** 0.5
    if not length > 0:
        return np.eye(3)
    return rotation_matrices(np.array([[w, x, y, z]]) / length)[0]
