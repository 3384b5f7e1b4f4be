"""Old module paths of this package (see `graph.base.forwarding`).

Only modules of the former flat layout are here; what the README names has not moved.
"""

from __future__ import annotations

MOVED = {
    "graph.controller.errors": "graph.editing.errors",
    "graph.controller.graph_set": "graph.editing.graph_set",
    "graph.controller.model": "graph.editing.model",
    "graph.assembly": "graph.session.open",
    "graph.brief": "graph.base.shorten",
    "graph.cli.silence": "graph.cli.silent_outputs",
    "graph.context": "graph.node.context",
    "graph.conversion": "graph.values.conversion",
    "graph.db": "graph.node.database",
    "graph.declaration": "graph.node",
    "graph.errors": "graph.base.errors",
    "graph.evaluate.errors": "graph.evaluate",
    "graph.evaluate.familiar": "graph.evaluate.omnigraph_names",
    "graph.events": "graph.node.events",
    "graph.exact": "graph.base.exact",
    "graph.leniency": "graph.session.partial_compile",
    "graph.loading": "graph.session.load",
    "graph.migration": "graph.spec.migration",
    "graph.overrides": "graph.session.overrides",
    "graph.registry": "graph.node.registry",
    "graph.runner": "graph.session.runner",
    "graph.sim.state.articulation": "graph.sim.physics.articulation",
    "graph.sim.state.inertial": "graph.sim.physics.inertial",
    "graph.staging": "graph.session.stage",
    "graph.suggest": "graph.base.suggest",
    "graph.tracing": "graph.session.tracing",
    "graph.types": "graph.values.types",
    "graph.variables": "graph.node.variables",
}
"""Old dotted path to the present one."""
