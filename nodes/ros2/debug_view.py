"""The debug view of helpers: a picture of each cloud, in the folder of the run."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from graph.node.database import Database
    from graph.sim.renderer.products import RenderProduct


def debug_view(db: Database, product: RenderProduct, writer: str, frame_attribute: str) -> Any:
    """The attached writer of the debug view; None if it is disabled, or if the run writes no files.

    writer: its name in Replicator's registry. frame_attribute: the attribute of the sensor's prim that says in which
    frame its points are; those in WORLD are drawn as they are.
    """
    from sensors.replicator import get_writer

    if not db.inputs.showDebugView:
        return None
    folder = db.app.output_folder
    if folder is None:
        db.warn("debug-view-unavailable", "showDebugView draws into the run's folder; give the run one with --out")
        return None
    frame = db.app.stage.GetPrimAtPath(product.camera_path).GetAttribute(frame_attribute).Get()
    options = {"doTransform": frame != "WORLD", "output_dir": folder / "debug_view"}
    return get_writer(writer, options, app=db.app).attach(product)
