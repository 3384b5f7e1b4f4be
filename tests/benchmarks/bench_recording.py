"""Recording of clouds, against mcap's own writer of the same bytes at the same compression."""

import io
import tempfile
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from mcap.writer import CompressionType, Writer
from measure import Row, ratio

from graph.recording.recorder import Recorder
from graph.sim.messages.bus import MessageBus
from graph.sim.messages.ros_types import definition, serialize
from nodes.ros2.point_clouds import POINT_CLOUD, point_cloud

TITLE = "recording: clouds of 57,600 points"
POINTS = 57_600
MESSAGES = 20


def clouds() -> list[Any]:
    """Clouds with the coordinates and intensities of a rough surface."""
    generator = np.random.default_rng(0)
    angle = np.linspace(0, 2 * np.pi, POINTS, dtype=np.float32)
    found = []
    for _ in range(MESSAGES):
        reach = (10 + generator.normal(0, 0.02, POINTS)).astype(np.float32)
        points = np.stack([reach * np.cos(angle), reach * np.sin(angle), np.zeros(POINTS, np.float32)], axis=1)
        strength = generator.random(POINTS, np.float32)
        found.append(point_cloud(points, {"Intensity": strength, "Ring": np.arange(POINTS) % 32}, 0, "lidar"))
    return found


def measure(quick: bool) -> Iterable[Row]:
    """One file on the file system for temporary files, and in memory."""
    messages = clouds()
    data = [serialize(message, POINT_CLOUD) for message in messages]
    with tempfile.TemporaryDirectory() as folder:

        def record() -> None:
            bus = MessageBus()
            bus.subscribe(Recorder(Path(folder) / "ours.mcap"))
            for number, message in enumerate(messages):
                bus.publish("/points", POINT_CLOUD, message, number * 100_000_000)
            bus.close()

        def write(to: io.BufferedWriter | io.BytesIO) -> None:
            writer = Writer(to, compression=CompressionType.LZ4)
            writer.start("ros2")
            schema = writer.register_schema(POINT_CLOUD, "ros2msg", definition(POINT_CLOUD).encode())
            channel = writer.register_channel("/points", "cdr", schema)
            for number, one in enumerate(data):
                writer.add_message(channel, number * 100_000_000, one, number * 100_000_000)
            writer.finish()

        def plain() -> None:
            with (Path(folder) / "plain.mcap").open("wb") as file:
                write(file)

        rounds = 1 if quick else 25
        yield Row("messages recorded / their bytes by mcap's add_message, lz4", ratio(record, plain, rounds), bound=1.3)
