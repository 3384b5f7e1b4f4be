"""MCAP recording: readable by others, the same bytes every time, nothing lost however the run ends."""

from __future__ import annotations

import signal
import subprocess
import textwrap
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
from mcap.exceptions import EndOfFile
from mcap.reader import NonSeekingReader, make_reader
from mcap.writer import Writer

from graph.base.errors import RunError, UserError
from graph.base.exact import nanoseconds
from graph.recording.mcap_sink import CHUNK_BYTES, CHUNK_NS, McapSink
from graph.recording.mcap_source import PROVENANCE
from graph.recording.recovery import finish
from graph.sim import App
from graph.sim.messages.bus import MessageBus
from graph.sim.messages.message import Quality
from graph.sim.messages.ros_types import definition, deserialize, serialize
from tests.support.programs import started
from tests.support.ros_messages import CLOCK, CLOUD, clock, cloud


def record(path, publish):
    bus = MessageBus()
    bus.subscribe(McapSink(path))
    publish(bus)
    bus.close()
    return path


def ten_clocks_and_clouds(bus):
    for n in range(1, 11):
        bus.publish("clock", CLOCK, clock(n * 10**8), n * 10**8)
        bus.publish("/points", CLOUD, cloud(n * 10**8, 1000), n * 10**8)


def test_the_mcap_reader_finds_topics_schemas_stamps_and_sequence_numbers(tmp_path):
    path = record(tmp_path / "run.mcap", ten_clocks_and_clouds)
    with path.open("rb") as file:
        reader = make_reader(file)
        assert reader.get_header().profile == "ros2"
        summary = reader.get_summary()
        assert {channel.topic for channel in summary.channels.values()} == {"/clock", "/points"}
        assert {schema.name: schema.encoding for schema in summary.schemas.values()} == {
            CLOCK: "ros2msg",
            CLOUD: "ros2msg",
        }
        assert summary.statistics.message_count == 20
        assert not list(reader.iter_metadata())
        messages = [(channel.topic, message) for _, channel, message in reader.iter_messages()]
    clocks = [message for topic, message in messages if topic == "/clock"]
    assert [message.log_time for message in clocks] == [n * 10**8 for n in range(1, 11)]
    assert [message.publish_time for message in clocks] == [message.log_time for message in clocks]
    assert [message.sequence for message in clocks] == list(range(1, 11))
    assert deserialize(clocks[4].data, CLOCK).clock.nanosec == 500_000_000


def test_rosbags_opens_the_bare_file_and_decodes_the_clouds(tmp_path):
    from rosbags.highlevel import AnyReader
    from rosbags.typesys import Stores, get_typestore

    path = record(tmp_path / "run.mcap", ten_clocks_and_clouds)
    with AnyReader([path], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as reader:
        assert {connection.topic: connection.msgtype for connection in reader.connections} == {
            "/clock": CLOCK,
            "/points": CLOUD,
        }
        clouds = [
            (ns, reader.deserialize(data, connection.msgtype))
            for connection, ns, data in reader.messages()
            if connection.topic == "/points"
        ]
    assert [ns for ns, _ in clouds] == [n * 10**8 for n in range(1, 11)]
    assert clouds[0][1].width == 1000
    assert np.array_equal(clouds[0][1].data, np.arange(16_000, dtype=np.uint8))


def test_definitions_carry_their_dependencies():
    text = definition(CLOUD)
    assert "std_msgs/Header header" in text
    for dependency in ("std_msgs/Header", "builtin_interfaces/Time", "sensor_msgs/PointField"):
        assert f"MSG: {dependency}\n" in text


def test_cdr_round_trips():
    message = cloud(1_500_000_000, 3)
    back = deserialize(serialize(message, CLOUD), CLOUD)
    assert (back.header.stamp.sec, back.header.stamp.nanosec) == (1, 500_000_000)
    assert back.fields == message.fields


def test_two_recordings_of_the_same_messages_have_the_same_bytes(tmp_path):
    first = record(tmp_path / "a.mcap", ten_clocks_and_clouds)
    second = record(tmp_path / "b.mcap", ten_clocks_and_clouds)
    assert first.read_bytes() == second.read_bytes()


def chunk_sizes(path):
    with path.open("rb") as file:
        return [index.uncompressed_size for index in make_reader(file).get_summary().chunk_indexes]


def test_chunks_hold_at_most_a_megabyte(tmp_path):
    def publish(bus):
        for n in range(40):
            bus.publish("/points", CLOUD, cloud(n, 10_000), n)  # 160 kB each

    sizes = chunk_sizes(record(tmp_path / "run.mcap", publish))
    assert len(sizes) == 7  # six fit in 1 MB
    assert max(sizes) <= CHUNK_BYTES


def test_a_message_above_the_limit_gets_a_chunk_of_its_own(tmp_path):
    def publish(bus):
        bus.publish("/clock", CLOCK, clock(1), 1)
        bus.publish("/points", CLOUD, cloud(2, 100_000), 2)
        bus.publish("/clock", CLOCK, clock(3), 3)

    sizes = chunk_sizes(record(tmp_path / "run.mcap", publish))
    assert [size > CHUNK_BYTES for size in sizes] == [False, True, False]


def test_chunks_are_in_the_file_before_it_is_closed(tmp_path):
    path = tmp_path / "run.mcap"
    sink, bus = McapSink(path), MessageBus()
    bus.subscribe(sink)
    for n in range(20):
        bus.publish("/points", CLOUD, cloud(n, 10_000), n)
    unfinished = path.read_bytes()
    sink.close()
    read = []
    with pytest.raises(EndOfFile):  # noqa: PT012
        for _, _, message in NonSeekingReader(BytesIO(unfinished)).iter_messages(log_time_order=False):
            read.append(message.sequence)
    assert read == list(range(1, 19))  # three chunks of six


def test_the_file_appears_with_the_first_message(tmp_path):
    path = tmp_path / "run.mcap"
    record(path, lambda bus: bus.advertise("/points", CLOUD))
    assert not path.exists()


def test_a_closed_recording_takes_no_more(tmp_path):
    sink = McapSink(tmp_path / "run.mcap")
    bus = MessageBus()
    bus.subscribe(sink)
    sink.close()
    sink.close()
    with pytest.raises(RunError, match="closed"):
        bus.publish("/clock", CLOCK, clock(1), 1)


def test_a_file_that_cannot_be_made_is_the_users_error(tmp_path):
    with pytest.raises(UserError, match=r"nowhere/run\.mcap: No such file"):
        record(tmp_path / "nowhere" / "run.mcap", ten_clocks_and_clouds)


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
def test_a_full_disk_is_a_run_error():
    with pytest.raises(RunError, match="No space left"):
        record(Path("/dev/full"), ten_clocks_and_clouds)


@contextmanager
def no_file_above(size):
    resource = pytest.importorskip("resource")
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def noise(ns, points):
    message = cloud(ns, points)
    message.data[:] = np.random.default_rng(ns).integers(0, 256, 16 * points, np.uint8)  # nothing to compress
    return message


def test_a_file_that_takes_no_more_is_finished_after_its_last_whole_chunk(tmp_path):
    path = tmp_path / "run.mcap"
    sink, bus = McapSink(path), MessageBus()
    bus.subscribe(sink)
    with no_file_above(2_400_000):  # clouds of 160 kB: two chunks of six fit, the third tears at 0.47 MB
        for n in range(1, 19):
            bus.publish("/points", CLOUD, noise(n, 10_000), n)
        with pytest.raises(RunError, match="File too large; its first 12 messages are kept, 6 later ones lost"):
            bus.publish("/points", CLOUD, noise(19, 10_000), 19)
        with pytest.raises(RunError, match="File too large"):
            bus.publish("/clock", CLOCK, clock(1), 1)
        sink.close()
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        assert [message.sequence for _, _, message in reader.iter_messages()] == list(range(1, 13))
    with path.open("rb") as file:
        statistics = make_reader(file).get_summary().statistics
    assert (statistics.message_count, statistics.chunk_count) == (12, 2)
    assert (statistics.message_start_time, statistics.message_end_time) == (1, 12)


def test_a_file_finished_after_tearing_is_the_file_of_what_fitted(tmp_path):
    def publish(count):
        def run(bus):
            for n in range(1, count + 1):
                bus.publish("/points", CLOUD, noise(n, 10_000), n)

        return run

    whole = record(tmp_path / "whole.mcap", publish(12))
    with no_file_above(2_400_000), pytest.raises(RunError):
        record(tmp_path / "torn.mcap", publish(13 + 6))
    torn = tmp_path / "torn.mcap"

    def read(path):
        with path.open("rb") as file:
            reader = make_reader(file)
            summary = reader.get_summary()
            return summary.chunk_indexes, summary.channels, summary.schemas, summary.statistics

    assert read(torn) == read(whole)


def test_a_file_that_takes_no_chunk_at_all_is_a_recording_of_nothing(tmp_path):
    with no_file_above(100_000), pytest.raises(RunError, match="File too large"):
        record(tmp_path / "run.mcap", lambda bus: bus.publish("/points", CLOUD, noise(1, 70_000), 1))
    with (tmp_path / "run.mcap").open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        assert reader.get_header().profile == "ros2"
        assert list(reader.iter_messages()) == []


def test_where_not_even_the_summary_fits_the_whole_chunks_are_left(tmp_path):
    path = tmp_path / "run.mcap"
    sink, bus = McapSink(path), MessageBus()
    bus.subscribe(sink)
    for n in range(1, 8):
        bus.publish("/points", CLOUD, noise(n, 10_000), n)
    size = path.stat().st_size
    with no_file_above(size + 100), pytest.raises(RunError, match="no room; make room, then: graph recover"):
        sink.close()
    read = []
    with pytest.raises(EndOfFile), path.open("rb") as file:  # noqa: PT012
        for _, _, message in NonSeekingReader(file).iter_messages(log_time_order=False):
            read.append(message.sequence)
    assert read == list(range(1, 7))
    finish(path)
    with path.open("rb") as file:
        assert [message.sequence for _, _, message in make_reader(file).iter_messages()] == list(range(1, 7))


def test_the_last_chunk_makes_room_for_the_summary(tmp_path):
    path = tmp_path / "run.mcap"
    sink, bus = McapSink(path), MessageBus()
    bus.subscribe(sink)
    for n in range(1, 14):
        bus.publish("/points", CLOUD, noise(n, 10_000), n)  # two chunks of six are in the file
    with no_file_above(path.stat().st_size + 100), pytest.raises(RunError, match="first 6 messages are kept, 7 later"):
        sink.close()
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        assert [message.sequence for _, _, message in reader.iter_messages()] == list(range(1, 7))
    assert sink.messages == 6


def test_a_closed_recording_gives_up_its_last_chunk_but_not_its_only_one(tmp_path):
    path = tmp_path / "run.mcap"
    sink, bus = McapSink(path), MessageBus()
    bus.subscribe(sink)
    for n in range(1, 14):
        bus.publish("/points", CLOUD, noise(n, 10_000), n)
    assert not sink.give_up_chunk()  # still open
    sink.close()
    assert sink.give_up_chunk()  # 1 message
    assert sink.give_up_chunk()  # 6
    assert not sink.give_up_chunk()
    with path.open("rb") as file:
        assert [message.sequence for _, _, message in make_reader(file).iter_messages()] == list(range(1, 7))


def test_an_interrupt_between_or_inside_writes_leaves_a_finished_file(tmp_path):
    path = tmp_path / "run.mcap"
    program = textwrap.dedent(f"""
        import sys
        from graph.sim.messages.bus import MessageBus
        from graph.recording.mcap_sink import McapSink
        from tests.support.ros_messages import CLOUD, cloud
        bus = MessageBus(); bus.subscribe(McapSink({str(path)!r}))
        print("go", flush=True)
        n = 0
        try:
            while True:
                n += 1
                bus.publish("/points", CLOUD, cloud(n, 10_000), n)
        except KeyboardInterrupt:
            bus.close()
            sys.exit(130)
    """)
    with started("-c", program, stdout=subprocess.PIPE) as process:
        process.stdout.readline()
        while not path.exists():
            assert process.poll() is None
        process.send_signal(signal.SIGINT)
        assert process.wait(timeout=20) == 130
    with path.open("rb") as file:
        sequence = [message.sequence for _, _, message in make_reader(file).iter_messages()]
    assert sequence == list(range(1, len(sequence) + 1))
    assert sequence


@pytest.fixture
def interruptible():
    """SIGINT raises KeyboardInterrupt here, even if the process that started the tests ignores it (`nohup`)."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("interruptible")
def test_an_interrupt_during_a_flush_is_honoured_after_it(tmp_path, monkeypatch):
    sink = McapSink(tmp_path / "run.mcap")
    bus = MessageBus()
    bus.subscribe(sink)
    bus.publish("/clock", CLOCK, clock(1), 1)
    add_message = Writer.add_message

    def interrupted(*given, **options):
        signal.raise_signal(signal.SIGINT)
        return add_message(*given, **options)

    monkeypatch.setattr(Writer, "add_message", interrupted)
    with pytest.raises(KeyboardInterrupt):
        sink.flush()
    monkeypatch.undo()
    sink.close()
    with (tmp_path / "run.mcap").open("rb") as file:
        assert [message.log_time for _, _, message in make_reader(file).iter_messages()] == [1]


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_a_signal_that_ends_the_process_waits_until_the_file_is_finished(tmp_path, number):
    path = tmp_path / "run.mcap"
    program = textwrap.dedent(f"""
        import signal, sys
        from mcap.writer import Writer
        from graph.sim.messages.bus import MessageBus
        from graph.recording.mcap_sink import McapSink
        from tests.support.ros_messages import CLOCK, clock
        sink = McapSink({str(path)!r})
        bus = MessageBus(); bus.subscribe(sink)
        bus.publish("/clock", CLOCK, clock(1), 1)
        add = Writer.add_message
        Writer.add_message = lambda *given, **more: (signal.raise_signal({int(number)}), add(*given, **more))[1]
        sink.close()
        sys.exit("went on")
    """)
    with started("-c", program) as process:
        assert process.wait(timeout=20) == -number
    with path.open("rb") as file:
        assert [message.log_time for _, _, message in make_reader(file).iter_messages()] == [1]


def test_stop_then_play_records_the_bytes_of_the_first_play(tmp_path):
    with App() as app:

        def publish():
            ns = nanoseconds(app.simulation.time)
            app.bus.publish("/clock", CLOCK, clock(ns), ns)

        app.on("simulation_graphs", publish)
        for name in ("first", "second"):
            sink = McapSink(tmp_path / name)
            app.bus.subscribe(sink)
            app.play()
            app.update(20)
            app.stop()
            app.bus.unsubscribe(sink)
            sink.close()
    assert (tmp_path / "first").read_bytes() == (tmp_path / "second").read_bytes()


def test_an_interrupted_app_closes_its_recording(tmp_path):
    path = tmp_path / "run.mcap"
    program = textwrap.dedent(f"""
        from graph.base.exact import nanoseconds
        from graph.sim import App
        from graph.recording.mcap_sink import McapSink
        from tests.support.ros_messages import CLOUD, cloud
        with App() as app:
            app.bus.subscribe(McapSink({str(path)!r}))
            def publish():
                ns = nanoseconds(app.simulation.time)
                app.bus.publish("/points", CLOUD, cloud(ns, 10_000), ns)
            app.on("simulation_graphs", publish)
            app.play()
            app.update(10)
            print("go", flush=True)
            app.update(10**9)
    """)
    with started("-c", program, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        process.stdout.readline()
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=20)
    assert b"KeyboardInterrupt" in errors
    with path.open("rb") as file:
        stamps = [message.log_time for _, _, message in make_reader(file).iter_messages()]
    assert len(stamps) >= 10
    assert stamps == [round(n * 1e9 / 60) for n in range(1, len(stamps) + 1)]


def test_the_log_time_is_when_a_message_was_sent_the_publish_time_its_stamp(tmp_path):
    """60 updates a second: a scan of the turn that began at 0.1 s is sent in the update that ends at 0.2 s."""
    path = tmp_path / "run.mcap"
    with App() as app:
        app.bus.subscribe(McapSink(path))

        def publish():
            if app.update_index == 11:
                app.bus.publish("/points", CLOUD, cloud(10**8, 10), 10**8)
            app.bus.publish("/clock", CLOCK, clock(nanoseconds(app.simulation.time)), nanoseconds(app.simulation.time))

        app.on("simulation_graphs", publish)
        app.play()
        app.update(20)
    with path.open("rb") as file:
        found = [(c.topic, m.log_time, m.publish_time) for _, c, m in make_reader(file).iter_messages()]
    assert ("/points", 2 * 10**8, 10**8) in found
    assert [log for _, log, _ in found] == sorted(log for _, log, _ in found)
    assert all(log == published for topic, log, published in found if topic == "/clock")


def test_the_log_goes_on_when_time_begins_again(tmp_path):
    """Three updates of 1/60 s, stop, three more: the second play's messages follow the first one's."""
    path = tmp_path / "run.mcap"
    with App() as app:
        app.bus.subscribe(McapSink(path))
        app.on("simulation_graphs", lambda: app.bus.publish("/clock", CLOCK, clock(1), 1))
        for _ in range(2):
            app.play()
            app.update(3)
            app.stop()
    with path.open("rb") as file:
        found = [round(message.log_time * 60 / 1e9, 6) for _, _, message in make_reader(file).iter_messages()]
    assert found[:3] == [1, 2, 3]
    assert found[3:] == [3, 4, 5]


def test_a_chunk_is_written_after_half_a_second_of_simulation_however_little_comes(tmp_path):
    """One message at update 1 (1/60 s); after update 31 half a second has passed, which update 32 notices."""
    path = tmp_path / "run.mcap"
    with App() as app:
        app.bus.subscribe(McapSink(path))
        app.play()
        app.update()
        app.bus.publish("/clock", CLOCK, clock(1), 1)
        app.update(30)
        assert not path.exists()
        app.update()
        kept = path.read_bytes()
        assert CHUNK_NS == 10**9 // 2
    with pytest.raises(EndOfFile):
        list(NonSeekingReader(BytesIO(kept)).iter_messages(log_time_order=False))
    assert kept == path.read_bytes()[: len(kept)]


def test_channels_say_the_quality_of_service_that_rosbags_reads(tmp_path):
    from rosbags.highlevel import AnyReader
    from rosbags.interfaces import QosDurability, QosHistory, QosReliability

    path = tmp_path / "run.mcap"
    bus = MessageBus()
    bus.subscribe(McapSink(path))
    bus.advertise("/tf_static", CLOCK, "/G/tf", Quality(depth=1, durability="transientLocal"))
    bus.publish("/tf_static", CLOCK, clock(1), 1)
    bus.publish("/clock", CLOCK, clock(1), 1)
    bus.close()
    with AnyReader([path]) as reader:
        found = {one.topic: one.ext.offered_qos_profiles[0] for one in reader.connections}
    latched, usual = found["/tf_static"], found["/clock"]
    assert (latched.durability, latched.depth) == (QosDurability.TRANSIENT_LOCAL, 1)
    assert (usual.durability, usual.history, usual.depth) == (QosDurability.VOLATILE, QosHistory.KEEP_LAST, 10)
    assert usual.reliability == QosReliability.RELIABLE


def test_provenance_is_metadata_of_the_file_also_of_a_recovered_one(tmp_path):
    path, said = tmp_path / "run.mcap", {"file": "a.yaml", "seed": "3"}
    bus = MessageBus()
    bus.subscribe(McapSink(path, said))
    ten_clocks_and_clouds(bus)
    bus.close()
    torn = tmp_path / "torn.mcap"
    torn.write_bytes(path.read_bytes()[:-20])
    finish(torn)
    for file in (path, torn):
        with file.open("rb") as stream:
            assert [(one.name, one.metadata) for one in make_reader(stream).iter_metadata()] == [(PROVENANCE, said)]


def test_a_recording_deleted_while_it_grows_is_written_again(tmp_path):
    path = tmp_path / "out" / "run.mcap"
    path.parent.mkdir()
    sink, bus = McapSink(path), MessageBus()
    bus.subscribe(sink)
    bus.publish("/clock", CLOCK, clock(1), 1)
    sink.flush()
    path.unlink()
    path.parent.rmdir()
    bus.publish("/clock", CLOCK, clock(2), 2)
    sink.close()
    with path.open("rb") as file:
        assert [message.log_time for _, _, message in make_reader(file).iter_messages()] == [1, 2]
    assert sink.notes == [f"{path}: it was deleted while it was recorded; it is written again, whole"]
