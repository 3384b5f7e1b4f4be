"""Tests of nodes and graphs, in Python and as data.

    from graph.testing import run_node, run_graph

    trace = run_node("Countdown", inputs={"duration": 10, "period": 3}, pulses={"execIn": [0]}, updates=12)
    assert trace.fired("tick") == [3, 6, 9]

    trace = run_graph("graphs/quickstart.yaml", updates=6)
    assert trace.fired("tick.tick") == [0, 1, 2, 3, 4, 5]

The same tests can be data in `*.test.yaml` files: `graph.testing.case_forms` describes them, `graph test` and pytest
run them. Names are imported at their first use.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from graph.base.lazy_names import lazy_names

if TYPE_CHECKING:
    from .graphs import run_graph
    from .node import Trace, run_node
    from .trace import GraphTrace

__all__ = ["GraphTrace", "Trace", "run_graph", "run_node"]

_HOMES = {"GraphTrace": "trace", "Trace": "node", "run_graph": "graphs", "run_node": "node"}

__getattr__, __dir__ = lazy_names(__name__, _HOMES)
