"""Recordings of many types and the folders of their runs, spoiled in messages, times, names, records and bytes."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from io import BytesIO
from pathlib import Path
from random import Random
from typing import Any

from tests.robustness import mutations

TIMES = (0, 1, 10**9, 2**31, 2**53, 2**63 - 1, 2**63, 2**64 - 1)
NAMES = (
    *("/a", "/a.csv", "/A", "/" + "x" * 300, "/..", "/../../x", "/<b>x</b>", "/<a href=https://a.b>x</a>", "/\x1b[2J"),
    *("/&lt;", "/a_labels", "/tf", "/clock", "", "/", "/\u202e", "/a\nb", "/%{x}", "/$x$"),
)
SPOILT = ("rich.mcap", "rich.db3", "report.json", "metadata.yaml")
"""What is spoiled of a run."""
FORMATS = ("pcd", "ply", "las", "kitti", "nuscenes", "npz", "csv", "png")
LINKS = ("view", "view/view.html", "out", "out/a.csv", "report.json", "metadata.yaml", "run.mcap")
"""Places of a run at which a link lies now and then."""
REPORT = {
    "updates": 30,
    "loop_hz": "60",
    "physics_hz": "60",
    "physics_steps": 30,
    "topics": {"/points": {"due": 3, "messages": 3}},
    "warnings": [{"code": "x", "where": "/W", "message": "y"}],
    "recording": ["rich.mcap"],
}


@dataclass(frozen=True)
class Said:
    """A message of a recording."""

    topic: str
    type_name: str
    data: bytes
    log_ns: int
    stamp_ns: int


@cache
def messages() -> tuple[Said, ...]:
    """Three messages of each of the types that a page or an export draws."""
    import numpy as np

    from graph.sim.messages.ros_fields import from_plain
    from graph.sim.messages.ros_types import fields as fields_of
    from graph.sim.messages.ros_types import serialize

    points: Any = np.zeros(240, [("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("radial", "<f4"), ("ring", "<u2")])
    points["x"], points["y"] = np.cos(np.arange(240) / 38), np.sin(np.arange(240) / 38)
    points["z"], points["ring"] = np.arange(240) % 4 / 4 - 0.5, np.arange(240) % 4
    kinds = {"<f4": 7, "<u2": 4}
    fields = [
        {"name": name, "offset": points.dtype.fields[name][1], "datatype": kinds[points.dtype[name].str], "count": 1}
        for name in points.dtype.names
    ]
    cloud = {"fields": fields, "height": 1, "width": 240, "point_step": points.itemsize, "is_dense": True}
    cloud |= {"row_step": points.nbytes, "data": list(points.tobytes())}
    scan = {"angle_min": -1.0, "angle_max": 1.0, "angle_increment": 0.1, "range_max": 9.0, "ranges": [1.0] * 21}
    image = {"height": 4, "width": 4, "encoding": "rgb8", "step": 12, "data": list(range(48))}
    move = {"header": {"frame_id": "map"}, "child_frame_id": "lidar", "transform": {"rotation": {"w": 1.0}}}
    box = {"bbox": {"center": {"orientation": {"w": 1.0}}, "size": {"x": 1.0, "y": 1.0, "z": 1.0}}}
    contents: dict[str, tuple[str, dict[str, Any]]] = {
        "/points": ("sensor_msgs/msg/PointCloud2", cloud),
        "/scan": ("sensor_msgs/msg/LaserScan", scan),
        "/image": ("sensor_msgs/msg/Image", image),
        "/camera_info": ("sensor_msgs/msg/CameraInfo", {"k": [9.0, 0, 2, 0, 9, 2, 0, 0, 1], "width": 4, "height": 4}),
        "/range": ("sensor_msgs/msg/Range", {"range": float("inf")}),
        "/imu": ("sensor_msgs/msg/Imu", {"linear_acceleration": {"z": 9.81}}),
        "/joints": ("sensor_msgs/msg/JointState", {"name": ["a", "b"], "position": [1.0, 2.0]}),
        "/odom": ("nav_msgs/msg/Odometry", {"child_frame_id": "base"}),
        "/tf": ("tf2_msgs/msg/TFMessage", {"transforms": [move]}),
        "/points_labels": ("std_msgs/msg/String", {"data": '{"0": {"class": "x"}}'}),
        "/boxes": ("vision_msgs/msg/Detection3DArray", {"detections": [box]}),
        "/clock": ("rosgraph_msgs/msg/Clock", {}),
    }
    said = []
    for number in range(3):
        for topic, (type_name, content) in contents.items():
            stamp = number * 10**8
            header = {"stamp": {"sec": 0, "nanosec": stamp}, "frame_id": "lidar"}
            has_header = any(name == "header" for name, _ in fields_of(type_name))
            stamped = {"header": header, **content} if has_header else _moved(content, header, number)
            data = serialize(from_plain(type_name, stamped), type_name)
            said.append(Said(topic, type_name, bytes(data), stamp, stamp))
    return tuple(said)


def _moved(content: dict[str, Any], header: dict[str, Any], number: int) -> dict[str, Any]:
    """Transforms with a stamp, moved by so many metres; anything else as it is."""
    if "transforms" not in content:
        return content
    (move,) = content["transforms"]
    moved = {**move["transform"], "translation": {"x": float(number)}}
    return {"transforms": [{**move, "header": {**header, "frame_id": "map"}, "transform": moved}]}


def made(name: str, said: Sequence[Said], random: Random, *, right: bool = False) -> bytes:
    """The bytes of a file of a run."""
    if name == "report.json":
        return json.dumps(REPORT).encode()
    if name == "metadata.yaml":
        return b"rosbag2_bagfile_information:\n  compression_mode: ''\n"
    return _mcap(said, random, right) if name.endswith(".mcap") else _database(said, random, right)


def spoiled(name: str, random: Random) -> bytes:
    """A file of a run, spoiled in what it holds, in its records, or in its bytes."""
    if name in ("report.json", "metadata.yaml"):
        return mutations.spoiled(made(name, (), random), Path(name).suffix, random)
    said = list(messages())
    how = random.random()
    if how < 0.75:
        for _ in range(random.choice((1, 1, 2, 4, 12))):
            place = random.randrange(len(said))
            said[place] = _changed(said[place], random)
    data = made(name, said, random, right=how >= 0.75)
    return mutations.spoiled(data, ".mcap", random) if how >= 0.6 else data


def _changed(one: Said, random: Random) -> Said:
    what = random.random()
    if what < 0.6:
        data = one.data
        for _ in range(random.choice((1, 1, 3))):
            data = random.choice((_doubles, _doubles, mutations.changed_bytes, mutations.cut))(data, random)
        return replace(one, data=data)
    if what < 0.75:
        return replace(one, topic=random.choice(NAMES))
    if what < 0.9:
        return replace(one, log_ns=random.choice(TIMES), stamp_ns=random.choice(TIMES))
    return replace(one, type_name=random.choice(messages()).type_name)


def _doubles(data: bytes, random: Random) -> bytes:
    """A number of 4 or 8 bytes replaced by an extreme one."""
    import struct

    form = random.choice("fd")
    size = struct.calcsize(form)
    place = 4 + size * random.randrange(max(1, (min(len(data), 400) - 4) // size))
    numbers = [float("inf"), float("-inf"), float("nan"), 3e38, -3e38, 1e-45] + [1e308] * (form == "d")
    number = random.choice(numbers)
    return data[:place] + struct.pack("<" + form, number) + data[place + size :]


def _mcap(said: Sequence[Said], random: Random, right: bool) -> bytes:
    from mcap.writer import CompressionType, Writer

    from graph.sim.messages.ros_types import definition

    stream = BytesIO()
    packing = CompressionType.LZ4 if right else random.choice([*CompressionType])
    writer = Writer(stream, chunk_size=1_000_000 if right else random.choice((100, 10_000)), compression=packing)
    writer.start(profile="ros2", library="tickgraph")
    source = "x.yaml" if right else random.choice(("x.yaml", *mutations.WORDS, "a\nb"))
    writer.add_metadata("tickgraph", {"file": source.encode("utf-8", "replace").decode()})
    channels: dict[tuple[str, str], int] = {}
    for one in said:
        key = (one.topic, one.type_name)
        if key not in channels:
            schema = writer.register_schema(one.type_name, "ros2msg", definition(one.type_name).encode())
            about = {"sensor": "/World/Lidar", "rate_hz": "10" if right else random.choice(mutations.NUMBERS)}
            channels[key] = writer.register_channel(one.topic, "cdr", schema, about)
        writer.add_message(channels[key], one.log_ns, one.data, one.stamp_ns)
    writer.finish()
    return stream.getvalue()


def _database(said: Sequence[Said], random: Random, right: bool) -> bytes:
    with sqlite3.connect(":memory:") as database:
        database.execute(
            "CREATE TABLE topics(id INTEGER PRIMARY KEY, name, type, serialization_format, offered_qos_profiles)"
        )
        database.execute("CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id, timestamp, data)")
        topics: dict[tuple[str, str], int] = {}
        for one in said:
            key = (one.topic, one.type_name)
            if key not in topics:
                topics[key] = len(topics) + 1
                database.execute("INSERT INTO topics VALUES (?, ?, ?, 'cdr', '')", (topics[key], *key))
            row: list[Any] = [topics[key], min(one.log_ns, 2**63 - 1), one.data]
            if not right and random.random() < 0.02:
                row[random.randrange(3)] = random.choice((None, 1e300, "x", 7, b"", -1))
            database.execute("INSERT INTO messages(topic_id, timestamp, data) VALUES (?, ?, ?)", row)
        if not right and random.random() < 0.1:
            database.execute(
                random.choice(("CREATE VIEW v AS SELECT 1", "CREATE TABLE t(a, b AS (zeroblob(900000000)))"))
            )
        database.commit()
        return database.serialize()
