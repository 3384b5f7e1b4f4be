"""`graph run --trace`: valid trace events that say what happened when, on the wall clock and on the three clocks."""

import json

import pytest

from graph import Graph
from graph.cli.main import main
from graph.session.tracing import PHYSICS, RENDERER, TIMELINE, WALL
from graph.sim import App
from tests.support.lidar_texts import LIDAR_AND_CLOCK

FILE = LIDAR_AND_CLOCK + "clock: {physics_hz: 120, loop_hz: 60}\n"
PHASES = ["timeline_state", "timeline", "physics", "simulation_graphs", "render", "end"]


class Events(list):
    """The events of a trace file."""

    def __init__(self, path):
        super().__init__(json.loads(path.read_text(encoding="utf8")))
        self.tracks = {(e["pid"], e["tid"]): e["args"]["name"] for e in self if e["name"] == "thread_name"}

    def on(self, group, track, kind="X"):
        """The events of a track in the order of their times."""
        found = [
            e for e in self if e["ph"] == kind and (e["pid"], self.tracks.get((e["pid"], e["tid"]))) == (group, track)
        ]
        return sorted(found, key=lambda event: (event["ts"], -event.get("dur", 0)))


@pytest.fixture
def trace(tmp_path, capsys):
    """Runs the file for some updates with --trace; gives the exit code and the events."""

    def run(updates=12, text=FILE, *options):
        file, out = tmp_path / "small.yaml", tmp_path / "out" / "trace.json"
        file.write_text(text)
        code = main(["run", str(file), "--updates", str(updates), "--trace", str(out), *options])
        return code, Events(out)

    return run


def test_every_event_is_a_trace_event(trace):
    code, events = trace()
    assert code == 0
    for event in events:
        assert {"ph", "pid", "tid", "name"} <= set(event)
        assert event["ph"] in {"M", "X", "i", "C"}
        assert event["ph"] == "M" or event["ts"] >= 0
        assert event["ph"] != "X" or event["dur"] >= 0
        assert event["ph"] != "i" or event["s"] == "t"
    groups = {e["pid"]: e["args"]["name"] for e in events if e["name"] == "process_name"}
    assert groups == {WALL: "wall time", TIMELINE: "timeline", PHYSICS: "physics", RENDERER: "renderer"}


def test_updates_hold_their_phases_and_steps_on_the_wall_clock(trace):
    _, events = trace()
    on_track = events.on(WALL, "updates")
    updates = [e for e in on_track if e["name"].startswith("update ")]
    assert [e["name"] for e in updates] == [f"update {index}" for index in range(12)]
    for index, update in enumerate(updates):
        end = update["ts"] + update["dur"]
        inside = [e["name"] for e in on_track if update["ts"] <= e["ts"] and e["ts"] + e["dur"] <= end][1:]
        frames = ["post_render_graphs"] if index in (5, 11) else []
        assert inside == [*PHASES[:3], "step", "step", *PHASES[3:5], *frames, "end"]
    assert [e["name"] for e in events.on(WALL, "updates", "i")] == ["play"]


def test_nodes_stand_on_their_graphs_tracks(trace):
    _, events = trace()
    computed = events.on(WALL, "graph /World/G")
    assert [e["name"] for e in computed][:4] == ["tick", "clock", "product", "cloud"]
    assert len(computed) == 48
    assert computed[1]["args"] == {"type": "ROS2PublishClock"}
    at = [e["ts"] for e in events.on(TIMELINE, "graph /World/G", "i") if e["name"] == "tick"]
    assert at == [round((index + 1) / 60 * 1e9) / 1000 for index in range(12)]


def test_the_three_clocks_show_simulated_time(trace):
    _, events = trace()
    updates = events.on(TIMELINE, "updates")
    assert [(e["ts"], e["dur"]) for e in updates[:2]] == [(0.0, 16666.667), (16666.667, 16666.666)]
    steps = events.on(PHYSICS, "steps")
    assert [e["name"] for e in steps] == [f"step {index}" for index in range(1, 25)]
    assert (steps[-1]["ts"], steps[-1]["dur"]) == (191666.667, 8333.333)
    frames = events.on(RENDERER, "sensor /World/Lidar")
    assert [(e["ts"], e["dur"], e["args"]["stamp_ns"]) for e in frames] == [(0, 1e5, 0), (1e5, 1e5, 100_000_000)]
    assert [e["args"]["elements"] for e in events.on(WALL, "sensor /World/Lidar")] == [
        e["args"]["elements"] for e in frames
    ]
    curves = [e["args"] for e in events if e["ph"] == "C"]
    assert curves[-1] == {"timeline": 0.2, "physics": 0.2, "renderer": 0.2}
    assert len(curves) == 12


def test_messages_are_noted(trace):
    _, events = trace()
    messages = [(e["name"], e["args"]["stamp_ns"]) for e in events.on(WALL, "messages", "i")]
    assert [one for one in messages if one[0] == "/points"] == [("/points", 100_000_000), ("/points", 200_000_000)]
    assert sum(name == "/clock" for name, _ in messages) == 12


def test_a_run_that_fails_leaves_a_whole_trace(trace):
    text = FILE.replace(
        "- tick.tick ->", "- less.value -> wait.duration\n      - tick.tick -> wait.execIn\n      - tick.tick ->"
    ).replace(
        "      clock:",
        "      less: {type: ConstantInt, inputs: {value: -1}}\n      wait: {type: Countdown}\n      clock:",
    )
    code, events = trace(12, text)
    assert code == 1
    [failed] = [e for e in events if "error" in e.get("args", {})]
    assert failed["name"] == "wait"
    unfinished = [e["name"] for e in events if e.get("args", {}).get("unfinished")]
    assert sorted(unfinished) == ["simulation_graphs", "update 0"]


def test_a_trace_that_cannot_be_written_is_reported_before_anything_runs(tmp_path, capsys):
    file = tmp_path / "small.yaml"
    file.write_text(FILE)
    assert main(["run", str(file), "--trace", str(tmp_path)]) == 2
    assert f"--trace {tmp_path}: Is a directory; name a file that can be written" in capsys.readouterr().err


def test_a_full_disk_ends_the_trace_and_not_the_run(tmp_path, capsys):
    file = tmp_path / "small.yaml"
    file.write_text(FILE)
    assert main(["run", str(file), "--updates", "12", "--trace", "/dev/full"]) == 0
    assert "warning trace-cut-off: trace: the trace ends early: No space left on device" in capsys.readouterr().err


def test_without_a_trace_nothing_is_installed(tmp_path, monkeypatch):
    file = tmp_path / "small.yaml"
    file.write_text(FILE)
    observed = []
    monkeypatch.setattr(Graph, "observe", lambda self, wrap: observed.append(self))
    with App.from_file(file) as app:
        assert not app.simulation.pre_step
        assert not app.simulation.post_step
        app.play()
        app.update()
    assert not observed


def test_a_traced_run_does_the_same(tmp_path, capsys):
    file = tmp_path / "small.yaml"
    file.write_text(FILE)
    recordings = []
    for extra in ([], ["--trace", str(tmp_path / "trace.json")]):
        out = tmp_path / f"out{len(recordings)}"
        assert main(["run", str(file), "--updates", "20", "--out", str(out), *extra]) == 0
        recordings.append((out / "run.mcap").read_bytes())
    assert recordings[0] == recordings[1]


def test_nodes_that_an_edit_adds_are_traced_and_the_others_only_once(tmp_path):
    from graph import Controller
    from graph.session.tracing import Tracer

    file, out = tmp_path / "small.yaml", tmp_path / "trace.json"
    file.write_text(FILE)
    with App.from_file(file) as app:
        tracer = Tracer(app, app.graphs.values(), out.open("w"))
        app.play()
        app.update()
        keys = Controller.Keys
        Controller.edit(
            "/World/G",
            {keys.CREATE_NODES: [("count", "Counter")], keys.CONNECT: [("tick.outputs:tick", "count.inputs:execIn")]},
        )
        app.update()
        tracer.close()
    computed = [e["name"] for e in Events(out).on(WALL, "graph /World/G")]
    assert computed == ["tick", "clock", "product", "cloud", "tick", "clock", "product", "cloud", "count"]
