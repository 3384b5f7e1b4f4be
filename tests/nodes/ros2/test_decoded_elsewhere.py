"""Recordings are decoded by the readers of others: every field of every message, with the same values."""

from itertools import count

import numpy as np
import pytest

from graph.cli.main import main
from graph.recording.mcap_sink import McapSink
from graph.recording.run_reader import open_run
from graph.sim.messages.bus import MessageBus
from graph.sim.messages.ros_fields import from_plain, to_plain
from graph.sim.messages.ros_types import fields
from tests.support.places import ROOT

PUBLISHED = (
    "ackermann_msgs/msg/AckermannDriveStamped", "geometry_msgs/msg/Twist", "nav_msgs/msg/Odometry",
    "rosgraph_msgs/msg/Clock", "sensor_msgs/msg/CameraInfo", "sensor_msgs/msg/CompressedImage", "sensor_msgs/msg/Image",
    "sensor_msgs/msg/Imu", "sensor_msgs/msg/JointState", "sensor_msgs/msg/LaserScan", "sensor_msgs/msg/PointCloud2",
    "std_msgs/msg/String", "std_msgs/msg/UInt8MultiArray", "tf2_msgs/msg/TFMessage", "vision_msgs/msg/Detection2DArray",
    "vision_msgs/msg/Detection3DArray",
)  # fmt: skip
"""The types that publishers have."""


def filled(type_name, number):
    """Plain data of a message in which neighbouring fields differ; lists that may grow have two entries."""

    def value(kind, content):
        if kind == 1:
            base = content[0]
            if base == "string":
                return f"text {next(number)}"
            if base == "bool":
                return next(number) % 2 == 0
            return next(number) % 100 + 0.5 if "float" in base else next(number) % 100
        if kind == 2:
            return {name: value(*inner) for name, inner in fields(content)}
        inner, length = content
        return [value(*inner) for _ in range(length if kind == 3 else 2)]

    return value(2, type_name)


@pytest.fixture(scope="module", params=["quickstart", "camera", "every type"])
def recorded(request, tmp_path_factory):
    """The recording of an example, or of one message of every type with something in each of its fields."""
    out = tmp_path_factory.mktemp("out")
    if request.param != "every type":
        assert main(["run", str(ROOT / f"graphs/{request.param}.yaml"), "--updates", "25", "--out", str(out)]) == 0
        return out / "run.mcap"
    bus, number = MessageBus(), count(1)
    bus.subscribe(McapSink(out / "run.mcap"))
    for at, type_name in enumerate(PUBLISHED):
        message = from_plain(type_name, filled(type_name, number))
        bus.publish(f"/{type_name.rpartition('/')[2]}", type_name, message, at)
    bus.close()
    return out / "run.mcap"


def ours(file):
    """(topic, plain content) of every message by our own reader."""
    with open_run(file) as run:
        return [(entry.topic, to_plain(entry.type_name, entry.load())) for entry in run.read()]


def same(plain, other):
    """Whether a message of another library has the fields and values of our plain data."""
    if isinstance(plain, dict):
        return all(same(value, getattr(other, name)) for name, value in plain.items())
    if isinstance(plain, list) and plain and isinstance(plain[0], dict):
        return len(plain) == len(other) and all(map(same, plain, other))
    if isinstance(plain, list):
        return np.array_equal(np.asarray(plain), np.frombuffer(other, np.uint8) if isinstance(other, bytes) else other)
    return plain == other or plain != plain


def test_mcap_ros2_support_reads_every_field(recorded):
    decoder = pytest.importorskip("mcap_ros2.decoder")
    from mcap.reader import make_reader

    with recorded.open("rb") as file:
        reader = make_reader(file, decoder_factories=[decoder.DecoderFactory()])
        found = [(channel.topic, message) for _, channel, _, message in reader.iter_decoded_messages()]
    expected = ours(recorded)
    assert len(found) == len(expected) > 0
    for (topic, plain), (other_topic, message) in zip(expected, found, strict=True):
        assert topic == other_topic
        assert same(plain, message), topic


def test_rosbags_reads_every_field_by_the_definitions_in_the_file(recorded):
    from rosbags.highlevel import AnyReader

    with AnyReader([recorded]) as reader:
        found = [(one.topic, reader.deserialize(data, one.msgtype)) for one, _, data in reader.messages()]
    expected = ours(recorded)
    assert {topic for topic, _ in found} == {topic for topic, _ in expected}
    for topic in {topic for topic, _ in expected}:
        theirs = [message for name, message in found if name == topic]
        mine = [plain for name, plain in expected if name == topic]
        assert all(map(same, mine, theirs)), topic
