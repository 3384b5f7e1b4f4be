"""One reader opens whatever a run left behind."""

import json
import os
from pathlib import Path

import pytest

from graph.base.errors import UserError
from graph.recording.mcap_sink import McapSink
from graph.recording.run_reader import open_run
from graph.sim.messages.bus import MessageBus
from tests.support.ros_messages import CLOCK, clock

STRING = "std_msgs/msg/String"


def record(path, *stamps_ns, topic="/clock", close=True):
    """A recording of clocks with these stamps."""
    bus, sink = MessageBus(), McapSink(path, {"file": "a.yaml"})
    bus.subscribe(sink)
    for stamp_ns in stamps_ns:
        bus.publish(topic, CLOCK, clock(stamp_ns), stamp_ns)
    if not close:
        sink.flush()
        torn = path.read_bytes()
    bus.close()
    if not close:
        path.write_bytes(torn)
    return path


def report(folder, **content):
    (folder / "report.json").write_text(json.dumps(content))


def opened():
    """The names of the files that this process has open."""
    folder = Path("/proc/self/fd")
    return [Path(os.readlink(one)).name for one in folder.iterdir() if one.is_symlink() and os.path.lexists(one)]


def stamps(run, topics=None):
    return [(entry.topic, entry.stamp_ns) for entry in run.read(topics)]


def test_a_run_folder_says_its_topics_and_gives_its_messages_by_time(tmp_path):
    record(tmp_path / "run.mcap", 10, 20, 30)
    report(tmp_path, updates=3, recording=["run.mcap"])
    with open_run(tmp_path) as run:
        (topic,) = run.recorded.values()
        assert (topic.name, topic.type_name, topic.messages) == ("/clock", CLOCK, 3)
        assert "offered_qos_profiles" in topic.metadata
        assert run.report["updates"] == 3
        assert run.provenance == {"file": "a.yaml"}
        assert run.notes == []
        assert stamps(run) == [("/clock", 10), ("/clock", 20), ("/clock", 30)]
        (first, *_) = run.read()
        assert first.load().clock.nanosec == 10
        assert first.size == 12  # 4 bytes of encapsulation, sec, nanosec


def test_parts_follow_one_another_by_their_numbers_and_are_opened_one_at_a_time(tmp_path):
    record(tmp_path / "run_10.mcap", 70, 80)
    record(tmp_path / "run_2.mcap", 10, 20)
    record(tmp_path / "run_9.mcap", 30, 60)
    report(tmp_path, updates=3)
    with open_run(tmp_path) as run:
        assert [one.name.rpartition("/")[2] for one in run.files] == ["run_2.mcap", "run_9.mcap", "run_10.mcap"]
        assert [at for _, at in stamps(run)] == [10, 20, 30, 60, 70, 80]
        assert run.recorded["/clock"].messages == 6
        reading = run.read()
        next(reading)
        assert [name for name in opened() if name.endswith(".mcap")] == ["run_2.mcap"]


def test_files_that_overlap_are_merged_and_topics_are_chosen(tmp_path):
    record(tmp_path / "a.mcap", 10, 30, topic="/a")
    record(tmp_path / "b.mcap", 20, 30, topic="/b")
    with open_run(tmp_path) as run:
        assert stamps(run) == [("/a", 10), ("/b", 20), ("/a", 30), ("/b", 30)]
        assert stamps(run, ["/b"]) == [("/b", 20), ("/b", 30)]
        assert stamps(run, []) == []


def test_a_killed_run_is_read_as_far_as_its_chunks_go_and_left_as_it_is(tmp_path):
    path = record(tmp_path / "run.mcap", 10, 20, close=False)
    before = path.read_bytes()
    with pytest.raises(UserError, match="graph recover"):
        open_run(path)
    with open_run(tmp_path, whole=False) as run:
        assert [at for _, at in stamps(run)] == [10, 20]
        assert run.recorded["/clock"].messages == 2
        assert [line.partition(": ")[2] for line in run.notes] == [
            "there is no report; the run was killed or goes on",
            f"the recording was not finished, so it has no index; rebuild it: graph recover {path}",
        ]
    assert path.read_bytes() == before


def test_a_part_that_cannot_be_read_is_a_note_and_the_others_are_read(tmp_path):
    record(tmp_path / "run_0.mcap", 10)
    (tmp_path / "run_1.mcap").write_bytes(b"")
    report(tmp_path)
    with open_run(tmp_path, whole=False) as run:
        assert [at for _, at in stamps(run)] == [10]
        assert run.notes == [f"{tmp_path}/run_1.mcap: the file is empty; nothing was recorded"]
    with pytest.raises(UserError, match="the file is empty"):
        open_run(tmp_path)


def test_files_of_an_earlier_run_are_not_read(tmp_path):
    record(tmp_path / "run.previous.mcap", 10)
    record(tmp_path / "run.mcap", 20)
    with open_run(tmp_path) as run:
        assert [at for _, at in stamps(run)] == [20]


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("{", "the report cannot be read"),
        ("[1]", "the report is not a JSON object"),
        ("[" * 100_000, "the report cannot be read"),
    ],
)
def test_a_report_that_is_broken_is_a_note(tmp_path, content, said):
    record(tmp_path / "run.mcap", 10)
    (tmp_path / "report.json").write_text(content)
    with open_run(tmp_path) as run:
        assert said in run.notes[0]
        assert run.report is None
        assert len(stamps(run)) == 1


@pytest.mark.parametrize("name", ["../x.mcap", "/etc/passwd", 3])
def test_a_report_names_no_files_outside_its_folder(tmp_path, name):
    report(tmp_path, recording=[name])
    with pytest.raises(UserError, match="is not a file of this folder"):
        open_run(tmp_path)


def test_a_run_that_published_nothing_has_a_report_alone(tmp_path):
    report(tmp_path, updates=3)
    with open_run(tmp_path, whole=False) as run:
        assert stamps(run) == []
        assert run.notes == [f"{tmp_path}: no message was recorded"]
    with pytest.raises(UserError, match="no recording is in this folder"):
        open_run(tmp_path)
    (tmp_path / "report.json").unlink()
    with pytest.raises(UserError, match="no recording is in this folder"):
        open_run(tmp_path, whole=False)


def test_a_folder_of_runs_is_refused_with_the_names_of_its_runs(tmp_path):
    for name in ("c", "a", "d", "b"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "run.mcap").touch()
    (tmp_path / "0").mkdir()
    with pytest.raises(UserError) as refused:
        open_run(tmp_path)
    assert str(refused.value).endswith(f" files, such as {tmp_path / 'a'} or {tmp_path / 'b'} or {tmp_path / 'c'}")
