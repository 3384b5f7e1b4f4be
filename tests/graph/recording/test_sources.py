"""Messages from outside arrive when simulation time reaches them."""

from fractions import Fraction
from pathlib import Path

import pytest

from graph.base.errors import UserError
from graph.recording.mcap_sink import McapSink
from graph.recording.mcap_source import McapSource
from graph.recording.sources import MemorySource, Player
from graph.sim import App
from graph.sim.messages.bus import MemorySink, MessageBus
from graph.sim.messages.ros_fields import from_plain

STRING = "std_msgs/msg/String"


def text(data):
    return from_plain(STRING, {"data": data})


def entries(*times, topic="/said"):
    return [(time, topic, STRING, text(f"at {time}")) for time in times]


def heard_per_update(app, updates, topic="/said"):
    """(update, text) of what a subscription on `topic` finds after the physics of each update."""
    found = []
    queue = []

    def look():
        if not queue:
            queue.append(app.bus.listen(topic, STRING, depth=0))
        while (message := queue[0].take()) is not None:
            found.append((app.update_index, message.message.data))

    unsubscribe = app.on("simulation_graphs", look)
    app.update(updates)
    unsubscribe()
    if queue:
        app.bus.unlisten(queue[0])
    return found


def test_a_message_comes_in_the_first_update_whose_time_reaches_it():
    with App(physics_hz=240, loop_hz=60) as app:
        Player(app, [MemorySource(entries(0, "1/60", "0.0167", "1/30", 0.1))])
        app.play()
        found = heard_per_update(app, 8)
    # Update u ends at (u + 1) / 60 s: 1/60 s is the end of update 0, 0.0167 s just after it, 0.1 s the end of update 5.
    assert found == [(0, "at 0"), (0, "at 1/60"), (1, "at 0.0167"), (1, "at 1/30"), (5, "at 0.1")]


def test_a_message_is_there_on_its_own_physics_step():
    with App(physics_hz=240, loop_hz=60) as app:
        Player(app, [MemorySource(entries("1/120"))])
        app.play()
        heard, steps = app.bus.listen("/said", STRING), []
        app.on("physics_post_step", lambda: steps.append((app.simulation.get_num_physics_steps(), len(heard))))
        app.update()
    assert steps == [(1, 0), (2, 1), (3, 1), (4, 1)]


def test_sources_are_merged_by_time_ties_in_their_order():
    with App() as app:
        first, second = MemorySource(entries(0.02, 0.01)), MemorySource([("0.02", "said", STRING, text("second"))])
        Player(app, [first, second])
        app.play()
        assert [what for _, what in heard_per_update(app, 3)] == ["at 0.01", "at 0.02", "second"]


def test_every_play_begins_again_and_a_pause_holds_the_messages():
    with App() as app:
        Player(app, [MemorySource(entries(0.01, 0.05))])
        app.play()
        assert len(heard_per_update(app, 1)) == 1
        app.pause()
        assert heard_per_update(app, 10) == []
        app.play()
        assert len(heard_per_update(app, 3)) == 1
        app.stop()
        app.play()
        assert [what for _, what in heard_per_update(app, 4)] == ["at 0.01", "at 0.05"]


def test_topics_nobody_listens_to_are_never_decoded_and_reported():
    def load():
        raise AssertionError("decoded")

    class Lazy(MemorySource):
        def __iter__(self):
            from graph.recording.sources import Entry

            return iter([Entry(0, "/said", STRING, load)])

    with App() as app:
        sink = MemorySink()
        app.bus.subscribe(sink)
        player = Player(app, [Lazy(entries(0), name="talk.mcap")])
        app.play()
        app.update(3)
        assert sink["/said"] == []
        assert player.unheard() == [("talk.mcap", "nobody listened to any of its topics: /said")]
        app.bus.listen("/said", STRING)
        assert player.unheard() == []


def record(path, messages):
    bus = MessageBus()
    sink = McapSink(path)
    bus.subscribe(sink)
    for stamp_ns, topic, type_name, message in messages:
        bus.publish(topic, type_name, message, stamp_ns)
    bus.close()


def test_a_recording_plays_back_what_was_recorded(tmp_path):
    twist = from_plain("geometry_msgs/msg/Twist", {"linear": {"x": 0.25}})
    record(
        tmp_path / "run.mcap",
        [(20_000_000, "/said", STRING, text("one")), (30_000_000, "/cmd_vel", "geometry_msgs/msg/Twist", twist)],
    )
    source = McapSource(tmp_path / "run.mcap")
    assert source.topics() == {"/said": STRING, "/cmd_vel": "geometry_msgs/msg/Twist"}
    with App() as app:
        Player(app, [source])
        app.play()
        drive = app.bus.listen("/cmd_vel", "geometry_msgs/msg/Twist")
        assert heard_per_update(app, 3) == [(1, "one")]
        message = drive.take()
        assert message.message.linear.x == 0.25
        assert message.stamp_ns == 30_000_000


def test_recordings_of_a_wall_clock_start_together_at_zero(tmp_path):
    epoch = 1_700_000_000 * 10**9
    record(tmp_path / "a.mcap", [(epoch + 50_000_000, "/a", STRING, text("a"))])
    record(tmp_path / "b.mcap", [(epoch, "/said", STRING, text("b")), (epoch + 40_000_000, "/said", STRING, text("c"))])
    with App() as app:
        sources = [McapSource(tmp_path / "a.mcap"), McapSource(tmp_path / "b.mcap"), MemorySource(entries(0.02))]
        Player(app, sources)
        app.play()
        other = app.bus.listen("/a", STRING)
        assert heard_per_update(app, 4) == [(0, "b"), (1, "at 0.02"), (2, "c")]
        assert other.take().stamp_ns == 50_000_000


def test_types_that_only_the_recording_knows_come_from_it(tmp_path):
    from mcap.writer import Writer

    with (tmp_path / "own.mcap").open("wb") as file:
        writer = Writer(file)
        writer.start(profile="ros2", library="test")
        own = writer.register_schema("rock_msgs/msg/Rock", "ros2msg", b"float64 mass\nstring name\n")
        json = writer.register_schema("Any", "jsonschema", b"{}")
        broken = writer.register_schema("rock_msgs/msg/Heap", "ros2msg", b"rock_msgs/Gone[] rocks\n")
        payload = b"\x00\x01\x00\x00" + b"\x00\x00\x00\x00\x00\x00\x08\x40" + b"\x02\x00\x00\x00a\x00"
        rocks = writer.register_channel("/rocks", "cdr", own)
        for channel, data in (
            (rocks, payload),
            (writer.register_channel("/any", "json", json), b"{}"),
            (writer.register_channel("/heap", "cdr", broken), b""),
        ):
            writer.add_message(channel, 0, data, 0)
        writer.finish()
    source = McapSource(tmp_path / "own.mcap")
    assert source.topics() == {"/rocks": "rock_msgs/msg/Rock"}
    assert source.skipped == {
        "/any": "its messages are encoded as json, not as cdr",
        "/heap": "rock_msgs/msg/Heap: field rocks is of the unknown type rock_msgs/msg/Gone",
    }
    [entry] = source
    assert (entry.load().mass, entry.load().name) == (3.0, "a")


@pytest.mark.parametrize("content", [None, b"", b"no mcap at all", b"\x89MCAP0\r\n" + b"\x00" * 40])
def test_a_file_that_is_not_a_recording_is_refused_in_one_line(tmp_path, content):
    path = tmp_path / "x.mcap"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(UserError, match=r"x\.mcap: ") as refused:
        McapSource(path)
    assert "\n" not in str(refused.value)


def open_files(path):
    """Descriptors of this process that are open on a file, where the system lists them."""
    listed = Path("/proc/self/fd")
    return [one for one in listed.iterdir() if one.resolve() == path.resolve()] if listed.exists() else []


def test_a_player_leaves_the_app_with_it_or_before(tmp_path):
    record(tmp_path / "run.mcap", [(0, "/said", STRING, text("one")), (10**9, "/said", STRING, text("two"))])
    source = McapSource(tmp_path / "run.mcap")
    with App() as app:
        player = Player(app, [source])
        app.play()
        heard_per_update(app, 1)
        assert len(open_files(tmp_path / "run.mcap")) == 1 or not Path("/proc/self/fd").exists()
        player.close()
        player.close()
        assert heard_per_update(app, 120) == []
        assert Fraction(app.simulation.time) > 1
        assert open_files(tmp_path / "run.mcap") == []
