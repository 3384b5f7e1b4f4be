"""Recovering a recording: whatever byte it ends at, what is whole is kept and the file opens."""

import random

import pytest
from mcap.reader import make_reader

from graph.base.errors import UserError
from graph.recording.mcap_sink import McapSink
from graph.recording.mcap_source import McapSource
from graph.recording.recovery import MAGIC, finish
from graph.sim.messages.bus import MessageBus
from graph.sim.messages.message import Quality
from graph.sim.messages.ros_types import message_type

STRING = "std_msgs/msg/String"
CHUNKS, EACH = 8, 5


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """A recording of 8 chunks of 5 messages on two topics, and where each chunk ends."""
    path = tmp_path_factory.mktemp("whole") / "run.mcap"
    bus, sink = MessageBus(), McapSink(path, {"seed": "0"})
    bus.subscribe(sink)
    text = random.Random(0)
    ends = []
    for chunk in range(CHUNKS):
        for n in range(EACH):
            content = message_type(STRING)("".join(text.choices("abcdef", k=200)))
            bus.publish(("/a", "/b")[n % 2], STRING, content, chunk * 100 + n)
        sink.flush()
        with path.open("rb") as file:
            data = file.read()
        ends.append(len(data))
    bus.close()
    return path.read_bytes(), ends


def stamps(path):
    with path.open("rb") as file:
        return [message.log_time for _, _, message in make_reader(file, validate_crcs=True).iter_messages()]


def expected(chunks):
    return [chunk * 100 + n for chunk in range(chunks) for n in range(EACH)]


def test_cut_at_any_byte_the_whole_chunks_are_kept(recorded, tmp_path):
    """A chunk counts as soon as its record is whole: its message indexes, 2 × (9 + 6 + 16 n) bytes, are made again."""
    data, ends = recorded
    path = tmp_path / "torn.mcap"
    indexes = 2 * (9 + 6) + 16 * EACH
    offsets = {*range(len(MAGIC), len(data), 61), *ends, *(end - 1 for end in ends), len(data) - 1}
    offsets |= {end - indexes + more for end in ends for more in (-1, 0, 1)}
    for size in sorted(offsets):
        path.write_bytes(data[:size])
        left = finish(path)
        whole = sum(end - indexes <= size for end in ends)
        assert (left.messages, left.chunks, left.whole) == (EACH * whole, whole, False), size
        assert stamps(path) == expected(whole), size


def test_a_recovered_file_is_finished_and_is_left_alone(recorded, tmp_path):
    data, ends = recorded
    path = tmp_path / "torn.mcap"
    path.write_bytes(data[: ends[2] + 7])
    assert finish(path).cut == 7
    mended = path.read_bytes()
    again = finish(path)
    assert (again.whole, again.messages) == (True, 3 * EACH)
    assert path.read_bytes() == mended
    assert mended[: ends[2]] == data[: ends[2]]  # the message indexes are those that the writer had made


def test_zeros_at_the_end_as_after_a_power_cut_are_cut_off(recorded, tmp_path):
    data, ends = recorded
    path = tmp_path / "torn.mcap"
    path.write_bytes(data[: ends[1]] + bytes(5000))
    assert finish(path).cut == 5000
    assert stamps(path) == expected(2)


def test_a_damaged_chunk_in_the_middle_stays_outside_the_index(recorded, tmp_path):
    data, ends = recorded
    broken = bytearray(data[: ends[5]])
    broken[ends[1] + 300] ^= 0xFF
    path = tmp_path / "broken.mcap"
    path.write_bytes(broken)
    left = finish(path)
    assert (left.damaged, left.messages) == (1, 5 * EACH)
    assert stamps(path) == [stamp for stamp in expected(6) if stamp // 100 != 2]
    assert path.read_bytes()[: ends[4]] == bytes(broken[: ends[4]])


@pytest.mark.parametrize("content", [b"", MAGIC[:5], b"tickgraph: 1\n" * 10])
def test_what_is_not_a_recording_is_the_users_error_and_stays(tmp_path, content):
    path = tmp_path / "other.mcap"
    path.write_bytes(content)
    with pytest.raises(UserError, match="not an MCAP recording"):
        finish(path)
    assert path.read_bytes() == content


def test_messages_outside_chunks_are_for_another_tool(tmp_path):
    from mcap.writer import Writer

    path = tmp_path / "other.mcap"
    with path.open("wb") as file:
        writer = Writer(file, use_chunking=False)
        writer.start()
        writer.add_message(writer.register_channel("/a", "cdr", 0), 1, b"abc", 1)
    before = path.read_bytes()
    with pytest.raises(UserError, match="mcap recover"):
        finish(path)
    assert path.read_bytes() == before


@pytest.mark.parametrize("name", ["metadata", "chunk", "end"])
def test_playing_a_torn_file_names_the_command_that_mends_it(recorded, tmp_path, name):
    data, ends = recorded
    path = tmp_path / "torn.mcap"
    path.write_bytes(data[: {"metadata": 60, "chunk": ends[3] - 200, "end": len(data) - 3}[name]])
    with pytest.raises(UserError, match="not finished, so it has no index; rebuild it: graph recover"):
        McapSource(path)
    finish(path)
    with_index = McapSource(path)
    assert set(with_index.topics()) == (set() if name == "metadata" else {"/a", "/b"})


def test_the_quality_of_a_topic_is_in_the_recovered_index_too(tmp_path):
    path = tmp_path / "run.mcap"
    bus, sink = MessageBus(), McapSink(path)
    bus.subscribe(sink)
    bus.advertise("/latched", STRING, "", Quality(durability="transientLocal"))
    bus.publish("/latched", STRING, message_type(STRING)("x"), 1)
    sink.flush()
    finish(path)
    with path.open("rb") as file:
        (channel,) = make_reader(file).get_summary().channels.values()
    assert "durability: 1" in channel.metadata["offered_qos_profiles"]
