"""`needs` of a node type: `graph check` warns of exactly the inputs without which a run would do nothing."""

import pytest

from graph.node import registry
from graph.sim import App
from graph.sim.messages.bus import CountingSink
from graph.testing import run_node

NEEDING = [one for one in registry.all() if one.needs and one.short_name != "SurfaceGripper"]
"""Without its prim a SurfaceGripper is idle, as in the product."""


@pytest.mark.parametrize("node_type", NEEDING, ids=lambda one: one.short_name)
def test_a_node_without_what_it_needs_says_so_at_its_first_trigger(node_type):
    entries = [name for name, attribute in node_type.inputs.items() if attribute.is_execution]
    with App() as app:
        app.bus.subscribe(CountingSink())  # publishers make nothing for nobody
        trace = run_node(node_type.id, pulses={name: [0] for name in entries[:1]}, updates=2, app=app, catch=True)
        assert trace.error is not None or trace.warnings
