"""The layout of nuScenes (https://www.nuscenes.org/nuscenes#data-format): tables of JSON, and the files they name.

The scans of one lidar are the samples; pictures of cameras join the sample that is next to them in time. Tokens are
computed from names, so that the same recording gives the same files. There are no boxes: `sample_annotation` is empty;
semantic classes are in the tables of nuScenes-lidarseg.
"""

from __future__ import annotations

import hashlib
import json
from bisect import bisect_left
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from graph.base.errors import RunError, UserError
from graph.base.outputs import make_folder, write
from graph.recording.contents.clouds import intensity, xyz
from graph.recording.contents.images import IMAGE, write_png
from graph.recording.contents.poses import TransformLog, transforms_of
from graph.recording.contents.scans import scans
from graph.sim.transforms import Floats, quaternion

from .layouts import CAMERA_INFO, Labels, class_ids, one_cloud, read_labels

if TYPE_CHECKING:
    from graph.recording.run_reader import RunReader

NAME = "nuscenes"
VERSION = "v1.0-tickgraph"
LIDAR = "LIDAR_TOP"
_TABLES = (
    "attribute", "calibrated_sensor", "category", "ego_pose", "instance", "log", "map", "sample", "sample_annotation",
    "sample_data", "scene", "sensor", "visibility", "lidarseg",
)  # fmt: skip
_PICTURES = ("rgb8", "bgr8", "mono8")

Row = dict[str, Any]


def token(*names: object) -> str:
    """32 hexadecimal digits that belong to these names."""
    return hashlib.md5("\0".join(map(str, names)).encode(), usedforsecurity=False).hexdigest()


class _Tables:
    """The rows of every table, linked as they are added."""

    def __init__(self, transforms: TransformLog, run: str, number: int | None = None) -> None:
        self.number = number
        self.rows: dict[str, list[Row]] = {name: [] for name in _TABLES}
        self.transforms = transforms
        self.scene = self.token("scene", run)
        self._last: dict[str, Row] = {}
        self._counts = Counter[str]()
        self._ego = ""

    def token(self, *names: object) -> str:
        """A token of this recording; of a campaign, each run has its own."""
        return token(*names) if self.number is None else token("run", self.number, *names)

    @property
    def prefix(self) -> str:
        """What the names of files begin with, so that runs share folders."""
        return "" if self.number is None else f"{self.number:04d}_"

    def add_data(self, channel: str, frame: str, stamp_ns: int, sample: str, file: str, size: tuple[int, int]) -> Row:
        """A row of sample_data with its ego pose; the calibrated sensor is added with the first row of a channel."""
        name = self.token("data", channel, self._counts[channel])
        self._counts[channel] += 1
        row: Row = {
            "token": name, "sample_token": sample, "ego_pose_token": name,
            "calibrated_sensor_token": self.token("calibrated", channel), "timestamp": stamp_ns // 1000,
            "fileformat": "png" if channel.startswith("CAM") else "pcd", "is_key_frame": True,
            "height": size[0], "width": size[1], "filename": file, "prev": "", "next": "",
        }  # fmt: skip
        if (before := self._last.get(channel)) is not None:
            row["prev"], before["next"] = before["token"], name
        self._last[channel] = row
        self.rows["sample_data"].append(row)
        pose = self._pose(self.ego(frame), stamp_ns, None)
        self.rows["ego_pose"].append({"token": name, "timestamp": stamp_ns // 1000, **_placed(pose)})
        return row

    def add_sensor(self, channel: str, frame: str, stamp_ns: int, intrinsic: list[list[float]]) -> None:
        """The rows of a channel's sensor and of its calibration: its pose in the ego frame at this time."""
        sensor = token("sensor", channel)
        modality = "camera" if channel.startswith("CAM") else "lidar"
        self.rows["sensor"].append({"token": sensor, "channel": channel, "modality": modality})
        pose = self._pose(frame, stamp_ns, self.ego(frame))
        self.rows["calibrated_sensor"].append(
            {
                "token": self.token("calibrated", channel),
                "sensor_token": sensor,
                **_placed(pose),
                "camera_intrinsic": intrinsic,
            }
        )

    def ego(self, frame: str) -> str:
        """The frame of the vehicle: the one below the root that carries the first sensor."""
        if not self._ego:
            chain = self.transforms.chain(frame)
            self._ego = chain[-2] if len(chain) > 1 else frame
        return self._ego

    def _pose(self, frame: str, stamp_ns: int, root: str | None) -> Floats:
        found = self.transforms.poses(frame, np.array([stamp_ns]), root)
        if found is None:
            where = f"in {root!r} " if root else ""
            raise RunError(
                f"--format {NAME} needs the pose of frame {frame!r} {where}at {stamp_ns / 1e9:.9f} s, which no "
                "recorded transform gives; publish TF of it in the graph"
            )
        pose: Floats = found[0]
        return pose


class DataSet:
    """The tables of a data set: rows by token, of one recording or of many, a scene each. An `Exporter`."""

    def __init__(self) -> None:
        self._rows: dict[str, dict[str, Row]] = {name: {} for name in _TABLES}

    def add(self, run: RunReader, topics: list[str], out: Path, *, world: bool, number: int | None) -> list[str]:
        """Writes a recording as a scene; see `add_nuscenes`."""
        return add_nuscenes(self, run, topics, transforms_of(run), read_labels(run), out, number)

    def add_rows(self, tables: Mapping[str, Sequence[Row]]) -> None:
        """Adds the rows of a recording; those that several have (sensors, categories, the map) are there once."""
        for name, rows in tables.items():
            known = self._rows[name]
            for row in rows:
                first = known.setdefault(row["token"], row)
                if first is not row and "log_tokens" in row:
                    first["log_tokens"] += row["log_tokens"]

    def finish(self, out: Path) -> None:
        """Writes the tables into a data set's folder. Raises OSError."""
        folder = make_folder(out, VERSION)
        for name, rows in self._rows.items():
            if rows or name != "lidarseg":
                write(folder / f"{name}.json", json.dumps([*rows.values()], indent=1) + "\n")


def add_nuscenes(
    data_set: DataSet,
    run: RunReader,
    topics: list[str],
    transforms: TransformLog,
    labels: Labels,
    out: Path,
    number: int | None = None,
) -> list[str]:
    """Writes the scans and pictures of a recording and adds its rows to the tables; returns lines for the user.

    number: of a run that is one scene of many, in order from 0. Raises UserError unless there is one cloud, RunError
    without its transforms.
    """
    topic = one_cloud(run, topics, NAME)
    tables = _Tables(transforms, run.name, number)
    samples = make_folder(out, "samples", LIDAR)
    stamps: list[int] = []
    classes = labels.classes.get(topic, {})
    for scan in scans(run, [topic], transforms):
        if not stamps:
            tables.add_sensor(LIDAR, scan.frame_id, scan.stamp_ns, [])
        sample = tables.token("sample", scan.index)
        name = f"{tables.prefix}{scan.index:06d}.pcd.bin"
        file = f"samples/{LIDAR}/{name}"
        names = scan.points.dtype.names or ()
        ring = scan.points["ring"] if "ring" in names else np.zeros(len(scan.points))
        points = np.column_stack([xyz(scan.points), intensity(scan.points), ring]).astype("<f4")
        write(samples / name, points.tobytes())
        row = tables.add_data(LIDAR, scan.frame_id, scan.stamp_ns, sample, file, (0, 0))
        numbers = class_ids(scan.points)
        if numbers is not None and (not len(numbers) or numbers.max() < 256):
            path = f"lidarseg/{VERSION}/{row['token']}_lidarseg.bin"
            made = make_folder(out, "lidarseg", VERSION)
            write(made / Path(path).name, numbers.astype(np.uint8).tobytes())
            tables.rows["lidarseg"].append({"token": row["token"], "sample_data_token": row["token"], "filename": path})
        stamps.append(scan.stamp_ns)
    if not stamps:
        raise UserError(f"{topic} has no message; nothing to export")
    shown, notes = _add_cameras(run, topics, tables, stamps, out)
    _add_samples(tables, run, stamps)
    tables.rows["category"] += (
        {"token": token("category", number), "name": _class_name(name), "description": "", "index": number}
        for number, name in sorted(classes.items())
    )
    data_set.add_rows(tables.rows)
    return [*notes, f"wrote {', '.join([topic, *shown])} into {out} ({NAME})"]


def _add_samples(tables: _Tables, run: RunReader, stamps: list[int]) -> None:
    names = [tables.token("sample", index) for index in range(len(stamps))]
    log = tables.token("log", run.name)
    for index, (name, at) in enumerate(zip(names, stamps, strict=True)):
        before = names[index - 1] if index else ""
        after = names[index + 1] if index + 1 < len(names) else ""
        tables.rows["sample"].append(
            {"token": name, "timestamp": at // 1000, "prev": before, "next": after, "scene_token": tables.scene}
        )
    scene = {
        "token": tables.scene,
        "log_token": log,
        "name": f"scene-{(tables.number or 0) + 1:04d}",
        "nbr_samples": len(names),
    }
    scene |= {"first_sample_token": names[0], "last_sample_token": names[-1]}
    tables.rows["scene"].append({**scene, "description": run.provenance.get("file", "")})
    # Simulation has no date and no place.
    tables.rows["log"].append(
        {"token": log, "logfile": "", "vehicle": "tickgraph", "date_captured": "1970-01-01", "location": "simulation"}
    )
    tables.rows["map"].append(
        {"token": token("map"), "log_tokens": [log], "category": "semantic_prior", "filename": ""}
    )


def _add_cameras(
    run: RunReader, topics: list[str], tables: _Tables, stamps: list[int], out: Path
) -> tuple[list[str], list[str]]:
    """Pictures, one for each sample: the nearest in time to the lidar's scan. Returns their topics, and notes."""
    pictures = [topic for topic in topics if run.recorded[topic].type_name == IMAGE]
    infos = [topic.name for topic in run.recorded.values() if topic.type_name == CAMERA_INFO]
    matrices: dict[str, list[list[float]]] = {}
    for topic in infos:
        info = next((entry.load() for entry in run.read([topic])), None)
        if info is not None:
            matrices[info.header.frame_id] = np.asarray(info.k, float).reshape(3, 3).tolist()
    shown: list[str] = []
    notes: list[str] = []
    for topic in pictures:
        first = next((entry.load() for entry in run.read([topic])), None)
        if first is None:
            continue
        if first.encoding not in _PICTURES:
            notes.append(f"{topic}: left out: {NAME} holds pictures of {', '.join(_PICTURES)}, not {first.encoding}")
            continue
        frame = first.header.frame_id
        if frame not in matrices or not tables.transforms.knows(frame):
            missing = "CameraInfo" if frame not in matrices else "transform"
            notes.append(f"{topic}: left out: the recording has no {missing} of frame {frame!r}")
            continue
        channel = f"CAM_{len(shown)}" if shown else "CAM_FRONT"
        samples = make_folder(out, "samples", channel)
        why = ""
        for sample, stamp, message in _nearest(run, topic, stamps):
            name = f"{tables.prefix}{sample:06d}.png"
            try:
                write_png(samples / name, message)
            except ValueError as error:
                why = why or str(error)
                continue
            if topic not in shown:
                shown.append(topic)
                tables.add_sensor(channel, frame, stamp, matrices[frame])
            file, size = f"samples/{channel}/{name}", (message.height, message.width)
            tables.add_data(channel, frame, stamp, tables.token("sample", sample), file, size)
        if why:
            notes.append(f"{topic}: images are left out: {why}")
    return shown, notes


def _nearest(run: RunReader, topic: str, stamps: list[int]) -> list[tuple[int, int, Any]]:
    """(sample, stamp, message) of the message nearest to each sample; a message belongs to one sample."""
    best: dict[int, tuple[int, int]] = {}
    for entry in run.read([topic]):
        at = entry.time_ns if entry.stamp_ns is None else entry.stamp_ns
        place = bisect_left(stamps, at)
        sample = min(
            (one for one in (place - 1, place) if 0 <= one < len(stamps)), key=lambda one: abs(stamps[one] - at)
        )
        if sample not in best or abs(stamps[sample] - at) < abs(stamps[sample] - best[sample][0]):
            best[sample] = (at, entry.time_ns)
    chosen = {log: (sample, at) for sample, (at, log) in best.items()}
    found = []
    for entry in run.read([topic]):
        if entry.time_ns in chosen:
            sample, at = chosen.pop(entry.time_ns)
            found.append((sample, at, entry.load()))
    return found


def _placed(pose: Floats) -> Row:
    return {"translation": pose[:3, 3].tolist(), "rotation": [float(one) for one in quaternion(pose[:3, :3])]}


def _class_name(labels: Any) -> str:
    return str(labels.get("class", next(iter(labels.values()), ""))) if isinstance(labels, dict) else str(labels)
