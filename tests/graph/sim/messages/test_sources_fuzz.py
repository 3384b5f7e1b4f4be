"""Recordings and message files from strangers: read, or refused in one line, soon."""

import struct
import time

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from graph.base.errors import RunError, UserError
from graph.cli.playing import open_sources
from graph.sim.messages.bus import MessageBus
from graph.sim.messages.mcap_source import McapSource
from graph.sim.messages.recording import McapSink
from graph.sim.messages.ros_fields import from_plain

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
    """Reads and decodes a file, or is told what is wrong; how long that took [s]."""
    started, said = time.process_time(), str(path)
    try:
        for entry in McapSource(path):
            entry.load()
    except (UserError, RunError) as error:
        said = str(error)
    elapsed = time.process_time() - started
    assert "\n" not in said
    assert str(path) in said
    return elapsed


@SETTINGS
@given(st.lists(st.tuples(st.integers(0, 2**20), st.binary(min_size=1, max_size=8)), min_size=1, max_size=6))
def test_a_damaged_recording_is_read_as_far_as_it_goes_or_refused(recording, tmp_path, changes):
    data = bytearray(recording)
    for place, content in changes:
        at = place % (len(data) - len(content))
        data[at : at + len(content)] = content
    (tmp_path / "x.mcap").write_bytes(data)
    assert read_all(tmp_path / "x.mcap") < 2


@SETTINGS
@given(st.integers(0, 2**20))
def test_a_recording_that_was_cut_off_is_refused(recording, tmp_path, length):
    (tmp_path / "x.mcap").write_bytes(recording[: length % len(recording)])
    assert read_all(tmp_path / "x.mcap") < 2


@pytest.mark.parametrize("opcode", range(1, 16))
def test_records_that_claim_to_be_huge_are_refused(recording, tmp_path, opcode):
    huge = bytes([opcode]) + struct.pack("<Q", 2**62) + b"\0" * 64
    (tmp_path / "x.mcap").write_bytes(recording[:8] + huge + recording[8:])
    (tmp_path / "y.mcap").write_bytes(recording[:8] + huge)
    assert read_all(tmp_path / "x.mcap") < 2
    assert read_all(tmp_path / "y.mcap") < 2


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
    started, said = time.process_time(), str(tmp_path / name)
    try:
        [source] = open_sources([tmp_path / name])
        for entry in source:
            entry.load()
    except UserError as error:
        said = str(error)
    assert str(tmp_path / name) in said
    assert time.process_time() - started < 2


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
    started = time.process_time()
    with pytest.raises(UserError):
        open_sources([tmp_path / "x.yaml"])
    assert time.process_time() - started < 2
