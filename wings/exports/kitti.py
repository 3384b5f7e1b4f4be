"""The layout of KITTI odometry, with the labels of SemanticKITTI.

sequences/00/velodyne/000000.bin   float32 x, y, z, intensity
sequences/00/labels/000000.label   uint32: semantic class, and the number of the object in the upper half
sequences/00/times.txt             seconds since the first scan
sequences/00/calib.txt             P0 to P3 (3 x 4, the camera's where one is recorded), Tr (lidar to camera)
poses/00.txt                       3 x 4, the camera's frame in that of the first scan (http://www.cvlibs.net/datasets/kitti)
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from graph.base.exact import NANOSECONDS
from graph.base.outputs import make_folder, write
from graph.recording.contents.clouds import intensity, xyz
from graph.recording.contents.poses import TransformLog, transforms_of
from graph.recording.contents.scans import Scan, scans
from graph.sim.transforms import Floats, inverse_rigid

from .layouts import CAMERA_INFO, Labels, class_ids, object_ids, one_cloud, read_labels

if TYPE_CHECKING:
    from graph.recording.run_reader import RunReader

NAME = "kitti"
TO_CAMERA = np.array([[0.0, -1, 0, 0], [0, 0, -1, 0], [1, 0, 0, 0], [0, 0, 0, 1]])
"""From x ahead, y left, z up to x right, y down, z ahead."""


class Kitti:
    """Writes the layout, a sequence for each recording: an `Exporter`."""

    def add(self, run: RunReader, topics: list[str], out: Path, *, world: bool, number: int | None) -> list[str]:
        """Writes a recording as the sequence of its number. Raises UserError unless there is one cloud."""
        return write_kitti(run, topics, transforms_of(run), read_labels(run), out, number or 0)

    def finish(self, out: Path) -> None:
        """Every file is written."""


def write_kitti(
    run: RunReader, topics: list[str], transforms: TransformLog, labels: Labels, out: Path, number: int = 0
) -> list[str]:
    """Writes the layout as the sequence of this number; returns lines for the user.

    Raises UserError unless there is one cloud.
    """
    topic = one_cloud(run, topics, NAME)
    name_of_sequence = f"{number:02d}"
    sequence = make_folder(out, "sequences", name_of_sequence)
    velodyne = make_folder(sequence, "velodyne")
    times, poses, numbers = [], [], dict[int, int]()
    first_ns: int | None = None
    to_camera: Floats | None = None
    camera = next((topic.name for topic in run.recorded.values() if topic.type_name == CAMERA_INFO), None)
    info = next((entry.load() for entry in run.read([camera])), None) if camera else None
    labelled = False
    for scan in scans(run, [topic], transforms):
        first_ns = scan.stamp_ns if first_ns is None else first_ns
        if to_camera is None:
            to_camera = _to_camera(scan, info, transforms)
        name = f"{scan.index:06d}"
        points = np.column_stack([xyz(scan.points).astype("<f4"), intensity(scan.points)]).astype("<f4")
        write(velodyne / f"{name}.bin", points.tobytes())
        labelled |= _write_labels(sequence, f"{name}.label", scan, numbers)
        times.append((scan.stamp_ns - first_ns) / NANOSECONDS)
        poses.append(scan.pose)
    write(sequence / "times.txt", "".join(f"{at:.9e}\n" for at in times))
    camera_from_lidar = TO_CAMERA if to_camera is None else to_camera
    projection = [*map(float, info.p)] if info is not None else [1.0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0]
    lines = [
        *(f"P{number}: {_numbers(projection)}" for number in range(4)),
        f"Tr: {_numbers(camera_from_lidar[:3].ravel())}",
    ]
    write(sequence / "calib.txt", "\n".join(lines) + "\n")
    if labelled:
        _write_names(sequence / "labels.json", labels, topic, numbers)
    wrote = f"wrote {topic} into {out} ({NAME})"
    if any(pose is None for pose in poses):
        return [
            f"{topic}: the recording has no transforms of its frame, so there is no poses/{name_of_sequence}.txt",
            wrote,
        ]
    placed = [pose for pose in poses if pose is not None]
    start = inverse_rigid(placed[0]) if placed else np.eye(4)
    back = inverse_rigid(camera_from_lidar)
    rows = [_numbers((camera_from_lidar @ start @ pose @ back)[:3].ravel()) for pose in placed]
    write(make_folder(out, "poses") / f"{name_of_sequence}.txt", "".join(f"{row}\n" for row in rows))
    return [wrote]


def _to_camera(scan: Scan, info: Any, transforms: TransformLog) -> Floats:
    """(4, 4) from the lidar to the recorded camera; without one, to the axes of a camera at the lidar."""
    if info is not None and scan.pose is not None:
        camera = transforms.poses(info.header.frame_id, np.array([scan.stamp_ns]))
        if camera is not None:
            found: Floats = inverse_rigid(camera[0]) @ scan.pose
            return found
    return TO_CAMERA


def _write_labels(sequence: Path, name: str, scan: Scan, numbers: dict[int, int]) -> bool:
    classes, ids = class_ids(scan.points), object_ids(scan.points)
    if classes is None and ids is None:
        return False
    values = np.zeros(len(scan.points), np.uint32) if classes is None else np.minimum(classes, 0xFFFF)
    if ids is not None:
        known = np.array([numbers.setdefault(one, len(numbers) + 1) for one in ids], np.uint32)
        values = values | (np.minimum(known, 0xFFFF) << np.uint32(16))
    write(make_folder(sequence, "labels") / name, values.astype("<u4").tobytes())
    return True


def _write_names(path: Path, labels: Labels, topic: str, numbers: dict[int, int]) -> None:
    """What the two halves of a label mean."""
    objects = {str(number): labels.objects.get(one, str(one)) for one, number in numbers.items()}
    classes = {str(number): name for number, name in sorted(labels.classes.get(topic, {}).items())}
    write(path, json.dumps({"classes": classes, "objects": objects}, indent=1) + "\n")


def _numbers(values: Any) -> str:
    return " ".join(f"{float(one):.12e}" for one in values)
