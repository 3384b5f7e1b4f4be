"""Nodes that sleep: when they compute, and what a trigger does to them."""

from __future__ import annotations

from tests.support.evaluations import run


def waiting(build, updates=2, **more):
    return build(
        {"tick": "test.Tick", "wait": ("test.Wait", {"updates": updates}), "done": "test.Count", "tock": "test.Count"},
        ["tick.tick -> wait.execIn", "wait.finished -> done.execIn", "wait.tick -> tock.execIn"],
        **more,
    )


def finishes(graph, context, updates):
    found, before = [], 0
    for update in range(updates):
        run(graph, context)
        now = graph.node("done").computes
        found += [update] * (now - before)
        before = now
    return found


def test_a_trigger_is_ignored_while_asleep_and_in_the_update_of_waking(build, playing):
    # Started in 0, wakes in 5 and ignores that update's tick, starts again in 6.
    assert finishes(waiting(build, 5), playing, 20) == [5, 11, 17]


def test_a_sleeping_node_computes_in_every_evaluation_before_the_events(build, journal, playing):
    graph = waiting(build)
    run(graph, playing)
    assert journal.take() == ["tick", "wait"]
    run(graph, playing)
    assert journal.take() == ["wait", "tock", "tick"]
    run(graph, playing)
    assert journal.take() == ["wait", "tock", "done", "tick"]
    run(graph, playing)
    assert journal.take() == ["tick", "wait"]


def test_sleeping_nodes_compute_in_file_order(build, journal, playing):
    graph = build(
        {"tick": "test.Tick", "first": "test.Wait", "second": "test.Wait"},
        ["tick.tick -> second.execIn", "tick.tick -> first.execIn"],
    )
    run(graph, playing)
    journal.clear()
    run(graph, playing)
    assert journal == ["first", "second", "tick"]


def test_interrupts_start_a_sleeping_node_again(build, playing):
    graph = waiting(build)
    graph.interrupts = True
    # A new trigger in every update: it never comes to its end.
    assert finishes(graph, playing, 10) == []


def test_a_stop_wakes_everybody_without_a_trace(build, journal, playing):
    graph = waiting(build, 3)
    run(graph, playing, 2)
    graph.reset()
    journal.clear()
    run(graph, playing)
    assert journal == ["tick", "wait"]
    assert graph.node("wait").db.memory.left == 3


def test_execution_may_lead_back_through_a_latent_node(build, journal, playing):
    graph = build(
        {"wait": ("test.Wait", {"updates": 1}), "a": "test.Step"},
        ["wait.finished -> a.execIn", "a.execOut -> wait.execIn"],
    )
    graph.evaluate(playing, [("wait", "execIn")])
    run(graph, playing, 3)
    # The trigger that comes back in the update of waking is ignored, as any other.
    assert journal == ["wait", "wait", "a"]


def test_a_latent_node_behind_a_sequence_does_not_hold_up_the_next_output(build, journal, playing):
    graph = build(
        {"tick": "test.Tick", "seq": "test.Sequence", "wait": "test.Wait", "b": "test.Step"},
        ["tick.tick -> seq.execIn", "seq.output0 -> wait.execIn", "seq.output1 -> b.execIn"],
    )
    run(graph, playing)
    assert journal == ["tick", "seq", "wait", "b"]


def test_data_is_pulled_when_a_node_wakes_up(build, journal, playing):
    graph = build(
        {"go": "test.Step", "two": ("test.Inc", {"a": 0}), "wait": "test.Wait"},
        ["go.execOut -> wait.execIn", "two.y -> wait.updates"],
    )
    graph.evaluate(playing, [("go", "execIn")])
    run(graph, playing)
    assert journal == ["go", "two", "wait", "two", "wait"]
