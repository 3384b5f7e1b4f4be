"""Recordings in parts, and of chosen topics."""

from itertools import pairwise

import pytest
from mcap.reader import make_reader

from graph.base.errors import RunError
from graph.recording.recorder import Recorder
from graph.recording.run_reader import open_run
from graph.sim.messages.bus import MessageBus
from tests.support.ros_messages import CLOCK, CLOUD, clock, cloud

SECOND = 10**9


def record(recorder, stamps_ns, topic="/clock"):
    bus = MessageBus()
    bus.subscribe(recorder)
    for at in stamps_ns:
        bus.publish(topic, CLOCK, clock(at), at)
    bus.close()


def log_times(path):
    with path.open("rb") as file:
        return [message.log_time for _, _, message in make_reader(file, validate_crcs=True).iter_messages()]


def names(folder):
    return sorted(one.name for one in folder.iterdir())


def test_a_part_has_the_messages_of_its_span(tmp_path):
    recorder = Recorder(tmp_path / "run.mcap", {"file": "a.yaml"}, split_ns=SECOND)
    record(recorder, [k * SECOND // 4 for k in (1, 3, 4, 7, 20)])
    # Spans [0, 1), [1, 2) and [5, 6); those without messages have no part.
    assert [log_times(one) for one in recorder.files] == [
        [SECOND // 4, 3 * SECOND // 4], [SECOND, 7 * SECOND // 4], [5 * SECOND],
    ]  # fmt: skip
    assert names(tmp_path) == ["run_0.mcap", "run_1.mcap", "run_2.mcap"]
    assert recorder.messages == 5
    with open_run(tmp_path / "run_1.mcap") as part:
        assert part.provenance == {"file": "a.yaml", "part": "1"}


def test_a_part_ends_with_the_chunk_that_reaches_its_size(tmp_path):
    recorder = Recorder(tmp_path / "run.mcap", split_bytes=50_000)
    bus = MessageBus()
    bus.subscribe(recorder)
    for at in range(1000):
        bus.publish("/points", CLOUD, cloud(at, 1000), at)  # 16 kB each, of which lz4 leaves little
    bus.close()
    sizes = [one.stat().st_size for one in recorder.files]
    assert len(sizes) > 1
    # Chunks hold at most 50,000 bytes before compression; the index adds some.
    assert all(50_000 <= size < 110_000 for size in sizes[:-1])
    assert [at for one in recorder.files for at in log_times(one)] == list(range(1000))
    with open_run(tmp_path) as run:
        assert [entry.stamp_ns for entry in run.read()] == list(range(1000))


def test_log_times_go_on_over_parts_when_time_starts_again(tmp_path):
    recorder = Recorder(tmp_path / "run.mcap", split_ns=SECOND)
    record(recorder, [SECOND // 2, 3 * SECOND // 2, SECOND // 2, SECOND])
    times = [at for one in recorder.files for at in log_times(one)]
    assert times == [SECOND // 2, 3 * SECOND // 2, 3 * SECOND // 2, 2 * SECOND]
    assert all(a <= b for a, b in pairwise(times))


@pytest.mark.parametrize(
    ("topics", "exclude", "kept"),
    [
        ((), (), ["/a/one", "/a/two", "/b"]),
        (("/a/*",), (), ["/a/one", "/a/two"]),
        (("a/one", "/b"), (), ["/a/one", "/b"]),
        ((), ("/a/t*",), ["/a/one", "/b"]),
        (("/a/*",), ("*/two",), ["/a/one"]),
    ],
)
def test_only_chosen_topics_are_recorded(tmp_path, topics, exclude, kept):
    recorder = Recorder(tmp_path / "run.mcap", topics=topics, exclude=exclude)
    bus = MessageBus()
    bus.subscribe(recorder)
    for topic in ("/a/one", "/a/two", "/b"):
        bus.publish(topic, CLOCK, clock(1), 1)
    bus.close()
    with open_run(tmp_path) as run:
        assert sorted(run.recorded) == kept
    assert recorder.messages == len(kept)
    assert recorder.notes == []


def test_a_pattern_that_matches_nothing_is_said(tmp_path):
    recorder = Recorder(tmp_path / "run.mcap", topics=["/clok"])
    record(recorder, [1])
    assert recorder.notes == ["record: /clok matches no topic of this run"]
    assert names(tmp_path) == []


def test_parts_of_an_earlier_recording_are_known_by_their_own_number(tmp_path):
    recorder = Recorder(tmp_path / "run.mcap", split_ns=SECOND)
    record(recorder, [0, SECOND])
    (tmp_path / "run_7.mcap").write_bytes((tmp_path / "run_1.mcap").read_bytes())  # a user's copy
    (tmp_path / "run_8.mcap").write_bytes(b"no recording")
    other = Recorder(tmp_path / "run.mcap")
    assert [one.name for one in other.earlier_parts()] == ["run_0.mcap", "run_1.mcap"]


def test_a_folder_that_is_removed_meanwhile_is_made_again_and_lost_parts_are_said(tmp_path):
    folder = tmp_path / "out"
    folder.mkdir()
    recorder = Recorder(folder / "run.mcap", split_ns=SECOND)
    bus = MessageBus()
    bus.subscribe(recorder)
    for at in (0, SECOND):
        bus.publish("/clock", CLOCK, clock(at), at)
    recorder.flush()
    for one in folder.iterdir():
        one.unlink()
    folder.rmdir()
    bus.publish("/clock", CLOCK, clock(2 * SECOND), 2 * SECOND)
    bus.close()
    # Part 0 was closed and is lost; part 1 was open, and is written again.
    assert names(folder) == ["run_1.mcap", "run_2.mcap"]
    assert recorder.messages == 2
    assert recorder.notes == [
        f"{folder}/run_0.mcap: it was deleted; lost messages: 1",
        f"{folder}/run_1.mcap: it was deleted while it was recorded; it is written again, whole",
    ]


def test_on_a_full_disk_the_last_chunk_goes_then_the_last_part(tmp_path):
    recorder = Recorder(tmp_path / "run.mcap", split_ns=SECOND)
    bus = MessageBus()
    bus.subscribe(recorder)
    for at in (0, SECOND, SECOND + 1):
        bus.publish("/clock", CLOCK, clock(at), at)
        recorder.flush()
    bus.close()
    assert recorder.give_up_chunk()
    assert (recorder.messages, recorder.given_up) == (2, 1)
    assert recorder.give_up_chunk()
    assert (recorder.messages, recorder.given_up) == (1, 2)
    assert not recorder.give_up_chunk()
    assert names(tmp_path) == ["run_0.mcap"]


def test_a_message_after_the_end_is_refused(tmp_path):
    recorder = Recorder(tmp_path / "run.mcap")
    record(recorder, [1])
    bus = MessageBus()
    bus.subscribe(recorder)
    with pytest.raises(RunError, match="came too late"):
        bus.publish("/clock", CLOCK, clock(2), 2)
