"""`graph info`: what was due and what came."""

import json

import pytest

GRAPH = """\
tickgraph: 1
scene:
  prims:
    /World/Ground: {{type: Plane}}
    /World/Lidar: {{type: OmniLidar, config: Example_Rotary_2D, translate: [0, 0, 1]}}
    /World/Camera: {{type: Camera, translate: [0, 0, 1], attributes: {{"omni:sensor:tickRate": 12}}}}
clock: {{physics_hz: 240, loop_hz: {loop_hz}}}
graphs:
  /World/Graph:
    nodes:
      tick: OnPlaybackTick
      once: Once
      wait: {{type: Countdown, inputs: {{duration: 5}}}}
      time: IsaacReadSimulationTime
      clock: ROS2PublishClock
      lidar: {{type: IsaacCreateRenderProduct, inputs: {{cameraPrim: /World/Lidar}}}}
      scan: {{type: ROS2RtxLidarHelper, inputs: {{topicName: scan}}}}
      camera: {{type: IsaacCreateRenderProduct, inputs: {{cameraPrim: /World/Camera, width: 8, height: 8}}}}
      depth: {{type: ROS2CameraHelper, inputs: {{topicName: depth, type: depth}}}}
    connections:
      - tick.tick -> clock.execIn
      - time.simulationTime -> clock.timeStamp
      - tick.tick -> camera.execIn
      - camera.execOut -> depth.execIn
      - camera.renderProductPath -> depth.renderProductPath
      - tick.tick -> once.execIn
      - once.once -> wait.execIn
      - wait.finished -> lidar.execIn
      - lidar.execOut -> scan.execIn
      - lidar.renderProductPath -> scan.renderProductPath
"""


@pytest.fixture
def recorded(graph, folder):
    """Plays the graph for so many seconds at a loop rate into the folder `out`."""

    def play(loop_hz=60, duration=1):
        (folder / "small.yaml").write_text(GRAPH.format(loop_hz=loop_hz))
        assert graph("run", "small.yaml", "--duration", duration, "--out", "out").code == 0
        return folder / "out"

    return play


def lines(text):
    return dict(line.split(": ", 1) for line in text.splitlines())


def test_ticks_that_came_are_held_against_those_that_were_due(graph, recorded):
    recorded()
    done = graph("info", "out")
    assert (done.code, done.err) == (0, "")
    said = lines(done.out)
    # 10 Hz from 1 / 60 s x 5 (the countdown's end) on: the first whole turn ends at 0.2 s, so 9 of 10.
    assert said["/scan"].startswith("9 of 9 ticks, period 100 ms exact, 0.2 to 1 s (sensor_msgs/msg/LaserScan, ")
    assert said["/depth"].startswith("12 of 12 ticks, period 83.333333 ms exact, 0.083333333 to 1 s (sensor_msgs/msg/I")
    assert said["/clock"].startswith("60 messages, period 16.666667 ms exact, 0.016666667 to 1 s")
    assert said["out"].startswith("a recording of small.yaml: 81 messages in 1 file")


def test_what_is_missing_is_said_with_its_places(graph, recorded):
    # Updates end at 0.1, 0.2, ...: at 0.5 s ticks 5 and 6 (5/12 and 6/12 s) are due, 6 is rendered; so with 11 and 12.
    recorded(loop_hz=10)
    said = lines(graph("info", "out").out)["/depth"]
    assert said.startswith("10 of 12 ticks, period 83.333333 ms, stamps 0 to 66.666667 ms after the ticks, 2 missing (")
    assert "(gaps: 100 ms after 0.4 s, 100 ms after 0.9 s), 0.1 to 1 s" in said


def test_json_holds_the_same_figures(graph, recorded):
    recorded()
    found = json.loads(graph("info", "out", "--json").out)
    scan = found["topics"]["/scan"]
    expected = {
        "type": "sensor_msgs/msg/LaserScan",
        "messages": 9,
        "sensor": "/World/Lidar",
        "tick_rate_hz": 10.0,
        "due": 9,
        "ticks": 9,
        "missing": 0,
        "rate_hz": 10.0,
        "period_ns": 1e8,
        "exact": True,
        "first_ns": 200_000_000,
        "last_ns": 1_000_000_000,
        "gaps": [],
    }
    assert {name: scan[name] for name in expected} == expected
    assert found["topics"]["/clock"]["due"] is None
    assert (found["messages"], found["report"], found["notes"]) == (81, True, [])
    assert found["provenance"]["loop_hz"] == "60"
    assert found["files"][0]["finished"] is True


def test_the_recording_alone_knows_its_schedule(graph, recorded):
    out = recorded()
    (out / "report.json").unlink()
    done = graph("info", "out")
    assert done.code == 0
    assert done.err == "out/report.json: there is no report; the run was killed or goes on\n"
    assert lines(done.out)["/scan"].startswith("9 of 9 ticks, period 100 ms exact")
    (line,) = (line for line in graph("info", "out/run.mcap").out.splitlines() if line.startswith("/scan"))
    assert "9 of 9 ticks, period 100 ms exact" in line


def test_a_killed_run_is_told_in_one_line_each_and_stays_as_it_is(graph, recorded):
    out = recorded(duration=2)
    (out / "report.json").unlink()
    data = (out / "run.mcap").read_bytes()
    (out / "run.mcap").write_bytes(data[: len(data) // 2])
    done = graph("info", "out")
    assert done.code == 0
    assert done.err.splitlines() == [
        "out/report.json: there is no report; the run was killed or goes on",
        "out/run.mcap: the recording was not finished, so it has no index; rebuild it: graph recover out/run.mcap",
    ]
    assert "ticks, period 100 ms exact" in lines(done.out)["/scan"]
    assert (out / "run.mcap").read_bytes() == data[: len(data) // 2]


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("gone", None, "gone: No such file or directory; name the folder of a run or a recording"),
        ("empty.mcap", b"", "empty.mcap: the file is empty; nothing was recorded"),
        ("text.mcap", b"some text" * 20, "text.mcap: not a whole MCAP recording"),
        ("notes.txt", b"", "notes.txt: not a recording; name the folder of a run, a .mcap or a .db3 file"),
    ],
)
def test_what_is_no_recording_is_one_line(graph, folder, name, content, said):
    if content is not None:
        (folder / name).write_bytes(content)
    done = graph("info", name)
    assert (done.code, done.out) == (2, "")
    assert said in done.err
    assert len(done.err.splitlines()) == 1


def test_a_run_that_published_nothing_says_so(graph, folder):
    (folder / "still.yaml").write_text("tickgraph: 1\n")
    assert graph("run", "still.yaml", "--updates", "3", "--out", "out").code == 0
    done = graph("info", "out")
    assert (done.code, done.err) == (0, "out: no message was recorded\n")


def test_a_publisher_that_stayed_silent_has_its_line(graph, recorded):
    recorded(duration="1/60")
    assert lines(graph("info", "out").out)["/depth"] == "no messages (sensor_msgs/msg/Image)"
