"""OnClosing: one last walk when the App closes, ahead of everything that closing takes away."""

import json

import pytest

from graph import ComputeError
from graph.sim import App
from graph.testing import run_graph, run_node

GRAPH = """
tickgraph: 1
graphs:
  /World/G:
    variables: {n: {type: int, value: 0}}
    nodes:
      tick: OnPlaybackTick
      count: Counter
      write: {type: WriteVariable, inputs: {variableName: n}}
      wait: {type: Countdown, inputs: {duration: 100}}
      close: OnClosing
      read: {type: ReadVariable, inputs: {variableName: n}}
      text: ToString
      say: LogMessage
      clock: {type: ROS2PublishClock, inputs: {topicName: bye}}
    connections:
      - tick.tick -> count.execIn
      - count.count -> write.value
      - count.execOut -> write.execIn
      - tick.tick -> wait.execIn
      - close.execOut -> [say.execIn, clock.execIn]
      - read.value -> text.value
      - text.converted -> say.message
"""


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "g.yaml"
    path.write_text(GRAPH)
    return path


def test_it_fires_once_after_the_last_update_and_never_before():
    trace = run_node("OnClosing", updates=4, closes=True)
    assert trace.fired("execOut") == [4]
    assert trace.computes == 1
    assert run_node("OnClosing", updates=4).fired("execOut") == []


def test_it_sees_what_the_last_update_left_and_nothing_else_starts_then(file):
    trace = run_graph(file, updates=5, closes=True, app=True)
    assert trace.fired("close.execOut") == [5]
    assert trace.fired("tick.tick") == [0, 1, 2, 3, 4]
    assert trace.value("text.converted") == "5"
    assert trace.computes("wait") == 5
    assert [update for update, _ in trace.messages["/bye"]] == [5]


def test_an_app_that_closes_tells_it_before_it_stops_the_timeline(file):
    with App.from_file(file) as app:
        graph = app.graphs["/World/G"]
        seen = []
        app.on("closing", lambda: seen.append((app.timeline.is_playing(), graph.nodes["close"].computes)), order=1)
        app.play()
        app.update(3)
        assert graph.nodes["close"].computes == 0
    assert seen == [(True, 1)]
    app.close()
    assert graph.nodes["close"].computes == 1


def test_an_app_that_never_played_closes_all_the_same(file):
    with App.from_file(file) as app:
        graph = app.graphs["/World/G"]
    assert graph.nodes["close"].computes == 1
    assert graph.nodes["tick"].computes == 0


@pytest.mark.parametrize("stage", ["on_demand", "post_render", "pre_render"])
def test_graphs_of_every_stage_have_their_walk(file, stage):
    file.write_text(GRAPH.replace("    variables", f"    pipeline_stage: {stage}\n    variables"))
    with App.from_file(file) as app:
        graph = app.graphs["/World/G"]
        app.play()
        app.update(2)
    assert graph.nodes["say"].computes == 1


def test_a_node_that_fails_then_fails_the_close_but_hides_no_earlier_failure(tmp_path):
    file = tmp_path / "g.yaml"
    file.write_text("""
tickgraph: 1
graphs:
  /World/G:
    nodes:
      close: OnClosing
      zero: {type: ConstantInt, inputs: {value: 0}}
      loop: ForLoop
    connections: [close.execOut -> loop.execIn, zero.value -> loop.step]
""")
    with pytest.raises(ComputeError, match="loop"), App.from_file(file):
        pass
    with pytest.raises(ZeroDivisionError), App.from_file(file):
        raise ZeroDivisionError


def test_graph_run_reports_and_records_what_it_does(file, tmp_path, capfd):
    from graph.cli.main import main

    assert main(["run", str(file), "--updates", "3", "--out", str(tmp_path / "out"), "--json"]) == 0
    report = json.loads(capfd.readouterr().out)
    assert report["nodes"]["/World/G/close"]["computes"] == 1
    assert report["topics"]["/bye"]["messages"] == 1
    assert b"/bye" in (tmp_path / "out" / "run.mcap").read_bytes()
