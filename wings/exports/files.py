"""Exports a recording: chooses the topics of a format and writes their files."""

from __future__ import annotations

import csv
from collections import Counter
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from fnmatch import fnmatchcase
from pathlib import Path
from typing import TYPE_CHECKING, Any

from graph.base.errors import RunError, UserError
from graph.base.outputs import make_folder, replacing, replacing_text
from graph.recording.export import clouds, images, kitti, nuscenes, point_files, poses, tables

from .file_names import file_names
from .layouts import read_labels

if TYPE_CHECKING:
    from graph.recording.run_reader import RunReader

POINTS = ("pcd", "ply", "las")
FORMATS = (*POINTS, "kitti", "nuscenes", "npz", "csv", "png")
INDEX = ("file", "stamp_ns", "frame_id", "points", "x", "y", "z", "qx", "qy", "qz", "qw")
"""Columns of scans.csv: the pose is that of the frame at the stamp, empty where it is not recorded."""


def export(
    run: RunReader,
    form: str,
    out: Path,
    patterns: Sequence[str] = (),
    *,
    world: bool = False,
    number: int | None = None,
    scenes: nuscenes.DataSet | None = None,
) -> list[str]:
    """Writes a recording into the folder `out`; returns lines for the user.

    patterns: topics to export, * for any text (default: all that the format can hold). world: points in the root frame
    of the recorded transforms, each by the pose of its own time. number: of a run of a campaign, from 0 in order: a
    sequence of KITTI, a scene of nuScenes, else a folder of its own. scenes: the tables of nuScenes that this run
    joins, which the caller writes after the last one. Raises UserError if no topic fits.
    """
    topics = _chosen(run, form, patterns)
    if form == "las":
        point_files.load_laspy()
    make_folder(out)
    transforms = poses.read_transforms(run.read(_of_type(run, poses.TRANSFORMS)))
    if form == kitti.NAME:
        return kitti.write_kitti(run, topics, transforms, read_labels(run), out, number or 0)
    if form == nuscenes.NAME:
        tables_of_all = scenes or nuscenes.DataSet()
        lines = nuscenes.add_nuscenes(tables_of_all, run, topics, transforms, read_labels(run), out, number)
        if scenes is None:
            tables_of_all.write(out)
        return lines
    scanned = [topic for topic in topics if run.recorded[topic].type_name in clouds.TYPES]
    pictured = [topic for topic in topics if run.recorded[topic].type_name == images.IMAGE and form in ("png", "npz")]
    places = {topic: out / name for topic, name in file_names(run.recorded).items()}
    tabled = {topic: out / f"{places[topic].name}.csv" for topic in topics if topic not in (*scanned, *pictured)}
    lines = _write_scans(run, form, {topic: places[topic] for topic in scanned}, transforms, world) if scanned else []
    if pictured:
        lines += _write_images(run, form, {topic: places[topic] for topic in pictured})
    if tabled:
        tables.write_tables(run, tabled)
        lines += (f"wrote {topic} into {path}" for topic, path in tabled.items())
    return lines


def _fits(form: str, type_name: str) -> bool:
    if form in POINTS:
        return type_name in clouds.TYPES
    if form == kitti.NAME:
        return type_name == clouds.CLOUD
    if form == nuscenes.NAME:
        return type_name in (clouds.CLOUD, images.IMAGE)
    if form == "npz":
        return type_name in (*clouds.TYPES, images.IMAGE)
    return type_name == images.IMAGE if form == "png" else type_name != images.IMAGE


def named_topics(run: RunReader, patterns: Sequence[str]) -> list[str]:
    """The topics that one of the patterns fits, * for any text (no pattern: all). Raises UserError for one without."""
    wanted = [pattern if pattern.startswith(("/", "*")) else f"/{pattern}" for pattern in patterns]
    named = [name for name in run.recorded if not wanted or any(fnmatchcase(name, pattern) for pattern in wanted)]
    for pattern in wanted:
        if not any(fnmatchcase(name, pattern) for name in run.recorded):
            listed = ", ".join(run.recorded) or "no topics"
            raise UserError(f"--topic {pattern}: the recording has no such topic; it has {listed}")
    return named


def _chosen(run: RunReader, form: str, patterns: Sequence[str]) -> list[str]:
    named = named_topics(run, patterns)
    topics = [name for name in named if _fits(form, run.recorded[name].type_name)]
    if not topics:
        listed = ", ".join(f"{name} ({run.recorded[name].type_name})" for name in named) or "no topics"
        raise UserError(f"--format {form} fits no topic of the recording: {listed}")
    return topics


def _of_type(run: RunReader, type_name: str) -> list[str]:
    return [topic.name for topic in run.recorded.values() if topic.type_name == type_name]


def _write_scans(
    run: RunReader, form: str, folders: Mapping[str, Path], transforms: poses.TransformLog, world: bool
) -> list[str]:
    from .scans import scans

    write, placed = point_files.WRITERS[form], Counter[str]()
    with ExitStack() as held:
        indexes: dict[str, Any] = {}
        for topic, folder in folders.items():
            make_folder(folder.parent, folder.name)
            file = held.enter_context(replacing_text(folder / "scans.csv"))
            indexes[topic] = csv.writer(file)
            indexes[topic].writerow(INDEX)
        counts = Counter[str]()
        for scan in scans(run, [*folders], transforms):
            name = f"{scan.index:06d}.{form}"
            write(folders[scan.topic] / name, scan, scan.moved_to_world() if world else scan.points)
            pose = [""] * 7 if scan.pose is None else point_files.pose_numbers(scan.pose)
            indexes[scan.topic].writerow([name, scan.stamp_ns, scan.frame_id, len(scan.points), *pose])
            counts[scan.topic] += 1
            placed[scan.topic] += scan.pose is not None
    lines = []
    for topic, folder in folders.items():
        count, with_pose = counts[topic], placed[topic]
        posed = "with the poses" if with_pose == count else f"with {_counted(with_pose, 'pose')}"
        lines.append(f"wrote {_counted(count, 'scan')} of {topic} into {folder}, {posed} in scans.csv")
        if with_pose < count:
            what = _counted(count - with_pose, "scan")
            lines.append(f"{topic}: {what} without a pose: no transform of its frame is recorded at that time")
    return lines


def _write_images(run: RunReader, form: str, folders: Mapping[str, Path]) -> list[str]:
    import numpy as np

    counts, failed = Counter[str](), dict[str, str]()
    with ExitStack() as held:
        indexes: dict[str, Any] = {}
        for topic, folder in folders.items():
            make_folder(folder.parent, folder.name)
            file = held.enter_context(replacing_text(folder / "images.csv"))
            indexes[topic] = csv.writer(file)
            indexes[topic].writerow(["file", "stamp_ns", "frame_id"])
        for entry in run.read([*folders]):
            message = entry.load()
            name = f"{counts[entry.topic]:06d}.{form}"
            path = folders[entry.topic] / name
            stamp = message.header.stamp.sec * 10**9 + message.header.stamp.nanosec
            try:
                if form == "png":
                    images.write_png(path, message)
                else:
                    image = images.pixels(message)
                    with replacing(path) as stream:
                        np.savez_compressed(stream, image=image, stamp_ns=np.int64(stamp))
            except ValueError as error:
                failed.setdefault(entry.topic, str(error))
                continue
            indexes[entry.topic].writerow([name, stamp, message.header.frame_id])
            counts[entry.topic] += 1
    if failed and not any(counts.values()):
        topic, why = next(iter(failed.items()))
        raise RunError(f"{run.name}: {topic}: {why}")
    lines = [f"wrote {_counted(counts[topic], 'image')} of {topic} into {folder}" for topic, folder in folders.items()]
    return lines + [f"{topic}: images are left out: {why}" for topic, why in failed.items()]


def _counted(number: int, what: str) -> str:
    return f"{number:,} {what}" if number == 1 else f"{number:,} {what}s"
