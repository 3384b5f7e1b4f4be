"""Graphs that run inside every physics step."""

from fractions import Fraction

import pytest

from graph import compile_graphs
from graph.session.runner import GraphRunner
from graph.spec.file_spec import ConnectionSpec, GraphSpec, NodeSpec
from graph.testing import run_node


@pytest.fixture
def running(world):
    """A function that binds a graph of the given nodes and connections to a 240 Hz world of 60 Hz updates."""
    runners = []

    def run(nodes, connections, stage="on_demand", **options):
        app = world(**{"physics_hz": 240, "loop_hz": 60, **options})
        links = tuple(ConnectionSpec(*pair.split(" ")) for pair in connections)
        spec = GraphSpec("/World/G", tuple(NodeSpec(*node) for node in nodes), links, "execution", stage)
        runner = GraphRunner(app, compile_graphs([spec]))
        runners.append(runner)
        return app, runner.graphs["/World/G"]

    yield run
    for runner in runners:
        runner.close()


COUNTED = [("physics", "OnPhysicsStep"), ("count", "Counter"), ("time", "IsaacReadSimulationTime")]
FIRES = ["physics.step count.execIn"]


def test_it_fires_in_every_physics_step(running):
    app, graph = running(COUNTED, FIRES)
    app.play()
    app.update(3)
    assert graph.nodes["count"].get("count") == 12
    assert graph.nodes["physics"].get("deltaSimulationTime") == 1 / 240


def test_every_node_of_a_graph_fires_in_the_same_evaluation(running):
    nodes = [*COUNTED, ("other", "OnPhysicsStep")]
    app, graph = running(nodes, [*FIRES, "other.step count.execIn"])
    app.play()
    app.update(1)
    assert [graph.nodes[name].computes for name in ("physics", "other", "count")] == [4, 4, 8]


def test_a_node_behind_it_reads_the_time_of_the_step(running):
    nodes = [COUNTED[0], COUNTED[2], ("clock", "ROS2PublishClock")]
    app, _ = running(nodes, ["physics.step clock.execIn", "time.simulationTime clock.timeStamp"])
    app.play()
    app.update(2)
    assert [one.stamp_ns for one in app.sink["/clock"]] == [round(Fraction(10**9 * k, 240)) for k in range(1, 9)]


def test_an_evaluation_between_two_steps_leaves_it_silent(running):
    app, graph = running(COUNTED, FIRES)
    graph.context.follow(app)
    graph.evaluate(graph.context)
    app.play()
    app.update(1)
    graph.evaluate(graph.context)
    assert graph.nodes["count"].get("count") == 4


def test_a_direct_step_counts_and_a_second_play_begins_again(running):
    app, graph = running(COUNTED, FIRES)
    app.play()
    app.simulation.step(steps=3)
    assert graph.nodes["count"].get("count") == 3
    app.stop()
    app.play()
    app.update(1)
    assert graph.nodes["count"].get("count") == 4


def test_a_per_frame_event_beside_it_fires_in_each_step_while_playing(running):
    nodes = [*COUNTED, ("frame", "OnPlaybackTick"), ("frames", "Counter")]
    app, graph = running(nodes, [*FIRES, "frame.tick frames.execIn"])
    app.play()
    app.update(1)
    assert graph.nodes["frames"].get("count") == 4


def test_in_a_graph_of_another_stage_it_warns_once_and_never_fires(running):
    app, graph = running(COUNTED, FIRES, stage="simulation")
    app.play()
    app.update(3)
    assert graph.nodes["count"].get("count") == 0
    assert [(one.code, one.count) for one in app.warnings] == [("physics-step-stage", 1)]


def test_the_wall_time_between_steps_is_in_whole_microseconds(world):
    app = world(physics_hz=60, loop_hz=60)
    trace = run_node("OnPhysicsStep", updates=3, app=app, phase="physics_post_step")
    assert trace.fired("step") == [0, 1, 2]
    # The virtual wall clock moves by 1/60 s an update: 16666.67 us, of which the whole ones are given.
    assert trace.values("deltaSystemTime") == [0.0, 0.016666, 0.016666]
