"""Old module paths of this package (see `graph.base.forwarding`).

Only modules of the former flat layout are here; what the manual names has not moved.
"""

from __future__ import annotations

MOVED = {
    "graph.assembly": "graph.session.open",
    "graph.brief": "graph.base.shorten",
    "graph.cli.silence": "graph.cli.silent_outputs",
    "graph.context": "graph.node.context",
    "graph.controller.errors": "graph.editing.errors",
    "graph.controller.graph_set": "graph.editing.graph_set",
    "graph.controller.model": "graph.editing.model",
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
    "graph.sim.mjcf.flexes": "graph.sim.physics.mujoco.flexes",
    "graph.sim.physics.inertial": "sensors.inertial",
    "graph.sim.renderer.rendering": "graph.sim.managers.rendering",
    "graph.sim.scene.animation": "graph.sim.live.animation",
    "graph.sim.scene.deletions": "graph.sim.live.deletions",
    "graph.sim.scene.editing": "graph.sim.live.editing",
    "graph.sim.scene.live_attributes": "graph.sim.live.live_attributes",
    "graph.sim.scene.live_stage": "graph.sim.live.live_stage",
    "graph.sim.scene.playing_world": "graph.sim.state.playing_world",
    "graph.sim.scene.roles": "graph.sim.live.roles",
    "graph.sim.scene.stage_watch": "graph.sim.live.stage_watch",
    "graph.sim.state.articulation": "graph.sim.physics.articulation",
    "graph.sim.state.inertial": "sensors.inertial",
    "graph.sim.state.reset": "graph.sim.live.reset",
    "graph.staging": "graph.session.stage",
    "graph.suggest": "graph.base.suggest",
    "graph.tracing": "graph.session.tracing",
    "graph.types": "graph.values.types",
    "graph.variables": "graph.node.variables",
}
"""Old dotted path to the present one."""
