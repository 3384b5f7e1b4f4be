"""CSV tables of topics: a row for each message, or for each transform of a TFMessage."""

from __future__ import annotations

import csv
import json
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

from graph.base.outputs import replacing_text
from graph.recording.contents.poses import TRANSFORMS

if TYPE_CHECKING:
    from collections.abc import Mapping

    from graph.recording.run_reader import RunReader

_TRANSFORM = ("parent", "child", "x", "y", "z", "qx", "qy", "qz", "qw")


def write_tables(run: RunReader, files: Mapping[str, Path]) -> None:
    """Writes the messages of topics into their files: log time and stamp [ns], then every field by its path.

    Lists are JSON.
    """
    from graph.sim.messages.ros_fields import leaves

    with ExitStack() as held:
        writers: dict[str, Any] = {}
        for topic, path in files.items():
            writers[topic] = csv.writer(held.enter_context(replacing_text(path)))
            type_name = run.recorded[topic].type_name
            names = _TRANSFORM if type_name == TRANSFORMS else [leaf.name for leaf in leaves(type_name)]
            writers[topic].writerow(["log_ns", "stamp_ns", *names])
        for entry in run.read(files):
            for row in _rows(entry.type_name, entry.load()):
                stamp = entry.time_ns if entry.stamp_ns is None else entry.stamp_ns
                writers[entry.topic].writerow([entry.time_ns, stamp, *row])


def _rows(type_name: str, message: Any) -> list[list[Any]]:
    from graph.sim.messages.ros_fields import unpack

    if type_name != TRANSFORMS:
        return [[_cell(value) for value in unpack(type_name, message)]]
    rows = []
    for one in message.transforms:
        at, turn = one.transform.translation, one.transform.rotation
        rows.append([one.header.frame_id, one.child_frame_id, at.x, at.y, at.z, turn.x, turn.y, turn.z, turn.w])
    return rows


def _cell(value: Any) -> Any:
    if hasattr(value, "tolist"):
        value = value.tolist()
    return json.dumps(value) if isinstance(value, list) else value
