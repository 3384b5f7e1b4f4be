"""Files for each topic: of scans, of pictures, and tables of everything else."""

from __future__ import annotations

import csv
from collections import Counter
from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

from graph.base.errors import RunError
from graph.base.outputs import make_folder, replacing, replacing_text
from graph.recording.contents import clouds, images, poses
from graph.recording.contents.file_names import file_names

from . import point_files, tables

if TYPE_CHECKING:
    from graph.recording.run_reader import RunReader

INDEX = ("file", "stamp_ns", "frame_id", "points", "x", "y", "z", "qx", "qy", "qz", "qw")
"""Columns of scans.csv: the pose is that of the frame at the stamp, empty where it is not recorded."""


class Files:
    """Writes the files of one format: an `Exporter`. Raises UserError without the library that a format needs."""

    def __init__(self, form: str) -> None:
        self._form = form
        if form == "las":
            point_files.load_laspy()

    def add(self, run: RunReader, topics: list[str], out: Path, *, world: bool, number: int | None) -> list[str]:
        """Writes the topics of a recording; returns lines for the user."""
        form, transforms = self._form, poses.transforms_of(run)
        scanned = [topic for topic in topics if run.recorded[topic].type_name in clouds.TYPES]
        pictured = [
            topic for topic in topics if run.recorded[topic].type_name == images.IMAGE and form in ("png", "npz")
        ]
        places = {topic: out / name for topic, name in file_names(run.recorded).items()}
        tabled = {topic: out / f"{places[topic].name}.csv" for topic in topics if topic not in (*scanned, *pictured)}
        lines = (
            _write_scans(run, form, {topic: places[topic] for topic in scanned}, transforms, world) if scanned else []
        )
        if pictured:
            lines += _write_images(run, form, {topic: places[topic] for topic in pictured})
        if tabled:
            tables.write_tables(run, tabled)
            lines += (f"wrote {topic} into {path}" for topic, path in tabled.items())
        return lines

    def finish(self, out: Path) -> None:
        """Every file is written."""


def _write_scans(
    run: RunReader, form: str, folders: Mapping[str, Path], transforms: poses.TransformLog, world: bool
) -> list[str]:
    from graph.recording.contents.scans import scans

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
