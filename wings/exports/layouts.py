"""What the data set layouts share: which topics they take, and the labels of points."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from graph.base.errors import UserError
from graph.recording.contents.clouds import CLOUD, Points

if TYPE_CHECKING:
    from graph.recording.run_reader import RunReader

STRING = "std_msgs/msg/String"
CAMERA_INFO = "sensor_msgs/msg/CameraInfo"
_OBJECT_ID = tuple(f"object_id_{word}" for word in range(4))


@dataclass(slots=True)
class Labels:
    """Names behind numbers: semantic classes by topic of their cloud, objects by 128-bit id."""

    classes: dict[str, dict[int, Any]] = field(default_factory=dict)
    objects: dict[int, str] = field(default_factory=dict)


def read_labels(run: RunReader) -> Labels:
    """The label tables of a recording: `<cloud>_labels` topics of classes, and maps of object ids."""
    labels = Labels()
    for entry in run.read([topic.name for topic in run.recorded.values() if topic.type_name == STRING]):
        try:
            content = json.loads(entry.load().data)
        except (ValueError, RecursionError):
            continue
        if not isinstance(content, dict):
            continue
        ids = content.get("id_to_labels")
        if isinstance(ids, dict):
            labels.objects |= {int(number): str(path) for number, path in ids.items() if number.isdecimal()}
        elif entry.topic.endswith("_labels"):
            table = labels.classes.setdefault(entry.topic.removesuffix("_labels"), {})
            table |= {int(number): name for number, name in content.items() if number.isdecimal()}
    return labels


def object_ids(points: Points) -> list[int] | None:
    """The 128-bit object id of each point; None without its columns."""
    names = points.dtype.names or ()
    if any(name not in names for name in _OBJECT_ID):
        return None
    words = [points[name].tolist() for name in _OBJECT_ID]
    return [a | b << 32 | c << 64 | d << 96 for a, b, c, d in zip(*words, strict=True)]


def class_ids(points: Points) -> NDArray[np.uint32] | None:
    """The semantic class of each point; None without the column class_id."""
    return points["class_id"].astype(np.uint32) if "class_id" in (points.dtype.names or ()) else None


def one_cloud(run: RunReader, topics: list[str], layout: str) -> str:
    """The topic of the lidar of a layout. Raises UserError unless exactly one of `topics` is a point cloud."""
    clouds = [topic for topic in topics if run.recorded[topic].type_name == CLOUD]
    if len(clouds) != 1:
        listed = ", ".join(clouds) or "no cloud"
        raise UserError(f"--format {layout} takes the cloud of one lidar, found {listed}; choose it with --topic")
    return clouds[0]
