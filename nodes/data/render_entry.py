"""The entry node of saved render pipelines."""

from __future__ import annotations

from graph.node import Attribute, Database, node_type


@node_type(
    "omni.graph.nodes.GpuInteropRenderProductEntry",
    version=2,
    event=True,
    outputs={
        "exec": Attribute("execution", "fires where its graph is evaluated for a new frame"),
        "gpu": Attribute("uint64", "always 0: there are no addresses here"),
        "hydraTime": Attribute("double", "renderer time of the frame", unit="s"),
        "rp": Attribute("uint64", "always 0: render products are named by path"),
        "simTime": Attribute("double", "simulation time of the frame", unit="s"),
    },
)
def gpu_interop_render_product_entry(db: Database) -> bool:
    """Start the render pipeline of a saved scene; without a new frame it does nothing."""
    app = db.context.app
    if app is None or not app.rendering.new_frames:
        return False
    newest = max(product.frame.reference for product in app.rendering.new_frames)
    db.outputs.hydraTime = float(newest)
    db.outputs.simTime = app.simulation.of_frame(newest, "simulation")
    db.fire("exec")
    return True
