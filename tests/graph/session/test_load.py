"""From a file to graphs that run."""

from __future__ import annotations

import pytest

from graph import Context, UserError, load_graph

GOOD = """\
tickgraph: 1
graphs:
  /World/G:
    nodes:
      tick: OnPlaybackTick
      wait: {type: Countdown, inputs: {duration: 5, period: 1}}
      count: Counter
    connections:
      - tick.tick -> wait.execIn
      - wait.finished -> count.execIn
"""


def test_a_file_becomes_graphs_that_run(tmp_path):
    path = tmp_path / "good.yaml"
    path.write_text(GOOD)
    loaded = load_graph(path)
    graph, context = loaded.graph("/World/G"), Context.standalone()
    fired = []
    for update in range(20):
        context.advance()
        before = graph.node("count").computes
        graph.evaluate(context)
        fired += [update] * (graph.node("count").computes - before)
    # design: OnPlaybackTick -> Countdown (5, 1) finishes in u = 5, 11, 17
    assert fired == [5, 11, 17]
    with pytest.raises(KeyError, match=r'no graph "/World/H"; did you mean "/World/G"'):
        loaded.graph("/World/H")


def test_mistakes_of_the_file_and_of_its_graphs_come_together(tmp_path):
    path = tmp_path / "bad.yaml"
    path.write_text(GOOD.replace("Counter", "Cuonter").replace("tick.tick ->", "tick.tock ->") + "clocks: {}\n")
    with pytest.raises(UserError) as caught:
        load_graph(path)
    text = str(caught.value)
    assert 'node "count": no node type "Cuonter"; did you mean "Counter"?' in text
    assert 'node "tick" (OnPlaybackTick) has no output "tock"; did you mean "tick"?' in text
    assert "clocks" in text
