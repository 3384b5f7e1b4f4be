"""`record:` of a graph file: parts and chosen topics, from the run to its report."""

import json

import pytest

GRAPH = """\
tickgraph: 1
clock: {{physics_hz: 60, loop_hz: 60}}
record: {{{record}}}
graphs:
  /World/Graph:
    nodes:
      tick: OnPlaybackTick
      time: IsaacReadSimulationTime
      clock: ROS2PublishClock
      other: {{type: ROS2PublishClock, inputs: {{topicName: other}}}}
    connections:
      - tick.tick -> clock.execIn
      - tick.tick -> other.execIn
      - time.simulationTime -> clock.timeStamp
      - time.simulationTime -> other.timeStamp
"""


@pytest.fixture
def play(graph, folder):
    def run(record, duration=2):
        (folder / "g.yaml").write_text(GRAPH.format(record=record))
        done = graph("run", "g.yaml", "--duration", duration, "--out", "out")
        assert done.code == 0, done.err
        return done

    return run


def files(folder):
    return sorted(one.name for one in (folder / "out").iterdir())


def test_the_report_names_the_parts_and_a_later_run_replaces_them(graph, folder, play):
    done = play("split_seconds: 1")
    # [0, 1) has the updates 1 to 59, [1, 2) 60 to 119, [2, 3) the last.
    assert files(folder) == ["report.json", "run_0.mcap", "run_1.mcap", "run_2.mcap"]
    assert "wrote out/run_0.mcap to run_2.mcap (240 messages" in done.out
    report = json.loads((folder / "out/report.json").read_text())
    assert report["recording"] == ["run_0.mcap", "run_1.mcap", "run_2.mcap"]
    assert "/clock: 120 messages, period 16.666667 ms exact" in graph("info", "out").out
    play("mcap: run.mcap", duration=1)
    assert files(folder) == ["report.json", "run.mcap"]
    assert "/clock: 60 messages" in graph("info", "out").out


def test_topics_that_are_left_out_are_said_by_info(graph, folder, play):
    play("exclude: [/oth*]")
    said = graph("info", "out").out
    assert "/clock: 120 messages" in said
    assert "/other: not recorded, 120 messages were published" in said


def test_a_pattern_without_a_topic_is_said_by_the_run(play):
    assert "record: /cloc matches no topic of this run" in play("topics: [/clock, /cloc]").out


def test_recover_mends_the_parts_of_a_folder(graph, folder, play):
    play("split_seconds: 1")
    last = folder / "out/run_1.mcap"
    last.write_bytes(last.read_bytes()[:-50])
    (folder / "out/report.json").unlink()
    done = graph("recover", "out")
    assert done.code == 0
    assert [line.partition(": ")[2] for line in done.out.splitlines()] == [
        "the recording is finished, nothing was changed (118 messages)",
        "index rebuilt over 120 messages, up to 1.983333333 s",
        "the recording is finished, nothing was changed (2 messages)",
    ]
    assert graph("recover", "out", "--out", "x.mcap").code == 2
    assert "/clock: 120 messages" in graph("info", "out").out


def test_recover_removes_a_last_part_that_was_killed_before_its_first_byte(graph, folder, play):
    play("split_seconds: 1")
    (folder / "out/report.json").unlink()
    (folder / "out/run_3.mcap").write_bytes(b"")
    done = graph("recover", "out")
    assert done.code == 0
    assert done.out.startswith("out/run_3.mcap: the run was killed when it began this part; the empty file is removed")
    assert not (folder / "out/run_3.mcap").exists()
    assert graph("info", "out").code == 0


@pytest.mark.parametrize(
    ("record", "said"),
    [
        ("split_size: 10", "g.yaml:3:22: record.split_size: 10 bytes; give 10,000 or more"),
        ("split_size: 1.5", "g.yaml:3:22: record.split_size must be a whole number"),
        ("split_seconds: 0", "g.yaml:3:25: record.split_seconds must be above 0"),
        (
            "split_seconds: 1/2",
            "g.yaml:3:25: record.split_seconds must be a time in seconds such as 60, 1 or more, found",
        ),
        ("topics: []", "g.yaml:3:18: record.topics: the list is empty; leave it out for all"),
        ("split_seconds: soon", "g.yaml:3:25: record.split_seconds"),
        ("topics: /a", "g.yaml:3:18: record.topics must be a list"),
        ("exclude: ['']", "g.yaml:3:19: record.exclude: a topic is empty"),
        ("splitsize: 3", 'unknown key "splitsize" in record; did you mean "split_size"?'),
    ],
)
def test_what_cannot_be_is_one_line_at_its_place(graph, folder, record, said):
    (folder / "g.yaml").write_text(GRAPH.format(record=record))
    done = graph("check", "g.yaml")
    assert done.code == 2
    assert said in done.err + done.out
