"""Recordings and message files from strangers: read, or refused in one line, soon."""

import struct

import lz4.frame
import pytest
import zstandard
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mcap.writer import Writer

from graph.base import limits
from graph.base.errors import RunError, UserError
from graph.recording.mcap_sink import McapSink
from graph.recording.mcap_source import McapSource
from graph.recording.recorded_file import decoding
from graph.session.message_sources import open_sources
from graph.sim.messages.bus import MessageBus
from graph.sim.messages.ros_fields import from_plain
from graph.sim.messages.ros_types import least_part, register, serialize
from tests.support.costs import within
from tests.support.mcap_files import message, written

SETTINGS = settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    """The bytes of a small recording: three types, 40 messages."""
    path = tmp_path_factory.mktemp("mcap") / "run.mcap"
    bus, sink = MessageBus(), McapSink(path)
    bus.subscribe(sink)
    for number in range(40):
        for topic, name, fields in (
            ("/a", "std_msgs/msg/String", {"data": "x" * number}),
            ("/b", "geometry_msgs/msg/Twist", {"linear": {"x": number}}),
            ("/c", "sensor_msgs/msg/JointState", {"name": ["a"], "position": [number]}),
        ):
            bus.publish(topic, name, from_plain(name, fields), number * 10**7)
    bus.close()
    return path.read_bytes()


def read_all(path):
    """Reads and decodes a file, or reports what is wrong, soon."""
    said = str(path)
    with within(2):
        try:
            for entry in McapSource(path):
                entry.load()
        except (UserError, RunError) as error:
            said = str(error)
    assert "\n" not in said
    assert str(path) in said


@SETTINGS
@given(st.lists(st.tuples(st.integers(0, 2**20), st.binary(min_size=1, max_size=8)), min_size=1, max_size=6))
def test_a_damaged_recording_is_read_as_far_as_it_goes_or_refused(recording, tmp_path, changes):
    data = bytearray(recording)
    for place, content in changes:
        at = place % (len(data) - len(content))
        data[at : at + len(content)] = content
    (tmp_path / "x.mcap").write_bytes(data)
    read_all(tmp_path / "x.mcap")


@SETTINGS
@given(st.integers(0, 2**20))
def test_a_recording_that_was_cut_off_is_refused(recording, tmp_path, length):
    (tmp_path / "x.mcap").write_bytes(recording[: length % len(recording)])
    read_all(tmp_path / "x.mcap")


@pytest.mark.parametrize("opcode", range(1, 16))
def test_records_that_claim_to_be_huge_are_refused(recording, tmp_path, opcode):
    huge = bytes([opcode]) + struct.pack("<Q", 2**62) + b"\0" * 64
    (tmp_path / "x.mcap").write_bytes(recording[:8] + huge + recording[8:])
    (tmp_path / "y.mcap").write_bytes(recording[:8] + huge)
    read_all(tmp_path / "x.mcap")
    read_all(tmp_path / "y.mcap")


TEXT = '- {at: 1, topic: a, type: std_msgs/msg/String, message: {data: "x"}}\n- {at: 2, topic: a, message: {}}\n'


@SETTINGS
@given(
    st.sampled_from(["x.yaml", "x.json", "x.jsonl"]),
    st.lists(st.tuples(st.integers(0, 200), st.text(max_size=6)), max_size=4),
)
def test_a_damaged_message_file_is_read_or_refused(tmp_path, name, changes):
    text = TEXT if name == "x.yaml" else '[{"at": 1, "topic": "a", "type": "std_msgs/msg/Bool", "message": {}}]'
    text = text[1:-1] if name == "x.jsonl" else text
    for place, content in changes:
        at = place % len(text)
        text = text[:at] + content + text[at + 1 :] or " "
    (tmp_path / name).write_text(text, encoding="utf-8", errors="surrogatepass")
    said = str(tmp_path / name)
    with within(2):
        try:
            [source] = open_sources([tmp_path / name])
            for entry in source:
                entry.load()
        except UserError as error:
            said = str(error)
    assert str(tmp_path / name) in said


@pytest.mark.parametrize(
    "text",
    [
        "- " * 60_000,
        "[" * 60_000,
        "- {at: 1e999999999, topic: a, type: std_msgs/msg/Empty}",
        "- {at: 1/0, topic: a, type: std_msgs/msg/Empty}",
        "- {at: " + "9" * 20_000 + ", topic: a, type: std_msgs/msg/Empty}",
        "- {at: 1, topic: a, type: ../../etc/passwd}",
        "- {at: 1, topic: a, type: std_msgs/msg/String, message: {data: " + "[" * 90 + "]" * 90 + "}}",
        "- &a {at: 1, topic: a, type: std_msgs/msg/String, message: &b {data: *b}}",
    ],
)
def test_hostile_message_files_are_refused_in_time(tmp_path, text):
    (tmp_path / "x.yaml").write_text(text)
    with within(2), pytest.raises(UserError):
        open_sources([tmp_path / "x.yaml"])


def defined(*parts):
    """The definitions of types in a row: the first is the one asked for."""
    rule = "=" * 80
    return f"\n{rule}\n".join(text if not name else f"MSG: {name}\n{text}" for name, text in parts)


def doubling(depth, base="int32 a"):
    """T0 has two T1, T1 two T2, ...: 2**depth values of `base` in a few lines."""
    parts = [(f"b{depth}_msgs/T{i}", f"T{i + 1} a\nT{i + 1} b") for i in range(depth)]
    return defined(("", parts[0][1]), *parts[1:], (f"b{depth}_msgs/T{depth}", base))


def test_types_that_double_are_counted_once_each():
    # 2**19 = 524,288 values are within the limit of 1,000,000, 2**20 = 1,048,576 beyond.
    register("b19_msgs/msg/T0", doubling(19))
    with pytest.raises(ValueError, match=r"holds 1,048,576 values; the limit is 1,000,000 values; raise it with"):
        register("b20_msgs/msg/T0", doubling(20))
    with within(2), pytest.raises(ValueError, match=r"--limit recording\.type=N"):
        register("b90_msgs/msg/T0", doubling(90))


def test_types_within_types_nest_100_deep_and_no_deeper():
    def chain(name, depth):
        return defined(
            ("", "T1 a"), *((f"{name}/T{i}", f"T{i + 1} a") for i in range(1, depth)), (f"{name}/T{depth}", "")
        )

    register("c_msgs/msg/T0", chain("c_msgs", 99))
    with pytest.raises(ValueError, match="types within types, 101 deep"):
        register("d_msgs/msg/T0", chain("d_msgs", 100))
    with pytest.raises(ValueError, match="makes the type hold itself"):
        register("e_msgs/msg/T0", defined(("", "T1 a"), ("e_msgs/T1", "T0[] a")))


PACKED = {"": bytes, "lz4": lz4.frame.compress, "zstd": zstandard.compress}


@pytest.mark.parametrize("compression", PACKED)
def test_a_chunk_unpacks_to_the_limit_and_no_further(tmp_path, compression):
    # A message is 31 bytes and its data: opcode 1, length 8, channel 2, sequence 4, two times of 8.
    whole = message(1000 - 31)
    pack = PACKED[compression]
    path = written(tmp_path / "x.mcap", pack(whole), compression=compression, size=1000)
    with limits.raised({"recording.record": 1100}):  # the record of a chunk is more than what it holds
        assert len(list(McapSource(path))) == 1
    with limits.raised({"recording.record": 999}), pytest.raises((UserError, RunError), match=r"recording\.record=N"):
        list(McapSource(path))


@pytest.mark.parametrize("compression", ["lz4", "zstd"])
def test_a_bomb_of_packed_zeros_is_refused_at_the_limit(tmp_path, compression):
    bomb = PACKED[compression](bytes(200 * 2**20))
    assert len(bomb) < 2**20
    path = written(tmp_path / "x.mcap", bomb, compression=compression, size=1000)
    with pytest.raises(
        RunError, match=r"unpacks to more than 67,108,864 bytes; the limit is .*--limit recording\.record"
    ):
        list(McapSource(path))


def test_chunks_that_overlap_wait_up_to_the_limit(tmp_path):
    path = written(tmp_path / "x.mcap", message(600), compression="", starts=(0,) * 10)
    # Ten times the same chunk at time 0: all are held before the first message leaves, 400 bytes for each beside 600.
    with limits.raised({"recording.waiting": 10_000}):
        assert len(list(McapSource(path))) == 10
    with (
        limits.raised({"recording.waiting": 9_999}),
        pytest.raises(RunError, match=r"can wait; .*recording\.waiting=N"),
    ):
        list(McapSource(path))


def test_a_message_of_too_many_parts_is_not_decoded():
    assert least_part("sensor_msgs/msg/JointState") == 5  # an empty name: its length and a zero
    assert least_part("sensor_msgs/msg/Image") == 0
    data = serialize(from_plain("sensor_msgs/msg/JointState", {"name": ["a", "b"]}), "sensor_msgs/msg/JointState")
    load = decoding(data, "sensor_msgs/msg/JointState", "x")
    parts = len(data) // 5
    with limits.raised({"recording.parts": parts}):
        assert load().name == ["a", "b"]
    with limits.raised({"recording.parts": parts - 1}), pytest.raises(RunError, match=rf"may hold {parts} texts"):
        load()


def test_definitions_are_read_up_to_a_limit_together(tmp_path):
    """Three types of 80 bytes of definition each, and room for 160."""
    path = tmp_path / "three.mcap"
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start(profile="ros2", library="test")
        for number in range(3):
            text = b"int32 a\n".ljust(79, b"#") + b"\n"
            schema = writer.register_schema(f"f_msgs/msg/T{number}", "ros2msg", text)
            writer.add_message(writer.register_channel(f"/t{number}", "cdr", schema), 0, b"\0" * 8, 0)
        writer.finish()
    with limits.raised({"recording.definitions": 160}):
        source = McapSource(path)
    assert list(source.topics()) == ["/t0", "/t1"]
    [(topic, why)] = source.skipped.items()
    assert topic == "/t2"
    assert why.endswith("raise it with --limit recording.definitions=N")
