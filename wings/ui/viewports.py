"""Cameras and frames of viewports, which are render products without windows."""

from __future__ import annotations

from typing import TYPE_CHECKING

from graph.base.records import dataclass
from graph.node import Attribute, Database, node_type
from nodes.data.stage_prims import find_prim

if TYPE_CHECKING:
    from nodes.isaac.viewports import Viewport

VIEWPORT = Attribute("token", "name of the viewport; empty is the default one", default="")


def _named(db: Database) -> Viewport | None:
    """The viewport that input `viewport` names; None, with a warning, if it does not exist."""
    from nodes.isaac.viewports import named_viewport

    return named_viewport(db)


@node_type(
    "omni.graph.ui_nodes.GetActiveViewportCamera",
    version=1,
    volatile=True,
    inputs={"viewport": VIEWPORT},
    outputs={
        "camera": Attribute("token", "path of its camera; empty before it has one"),
        "cameraPrim": Attribute("target", "the camera; empty before it has one"),
    },
)
def get_active_viewport_camera(db: Database) -> bool:
    """Give the camera of a viewport; viewports are render products without windows."""
    viewport = _named(db)
    if viewport is None:
        return False
    db.outputs.camera, db.outputs.cameraPrim = viewport.camera, [viewport.camera] if viewport.camera else []
    return True


@node_type(
    "omni.graph.ui_nodes.SetActiveViewportCamera",
    version=1,
    inputs={
        "execIn": Attribute("execution", "sets the camera"),
        "primPath": Attribute("token", "path of the camera", default="", role="prim"),
        "viewport": VIEWPORT,
    },
    outputs={"execOut": Attribute("execution", "follows once it is done")},
)
def set_active_viewport_camera(db: Database) -> bool:
    """Make a viewport show another camera."""
    from graph.sim.usd import UsdGeom
    from sensors.products import place_product

    app, viewport, path = db.app, _named(db), db.inputs.primPath
    prim = None if viewport is None else find_prim(db, path)
    if viewport is None or prim is None:
        return False
    if not prim.IsA(UsdGeom.Camera):
        db.fail(f"{path} is a {prim.GetTypeName() or 'prim without type'}; a viewport shows a Camera")
    if viewport.camera != path:
        viewport.camera = path
        if viewport.path in app.rendering.products:
            place_product(app.world, viewport.path, path, viewport.size)
    db.fire("execOut")
    return True


@dataclass(slots=True)
class _Seen:
    """How many frames there were at the last evaluation."""

    frames: int = 0


@node_type(
    "omni.graph.ui_nodes.OnNewFrame",
    version=1,
    event=True,
    inputs={"viewport": VIEWPORT},
    outputs={
        "execOut": Attribute("execution", "fires in the first evaluation after a frame"),
        "frameNumber": Attribute("int", "number of the frame, from 1"),
    },
    memory=_Seen,
)
def on_new_frame(db: Database) -> bool:
    """Fire when a viewport's render product has a new frame; a graph of the simulation stage runs one update later."""
    viewport = _named(db)
    product = None if viewport is None else db.app.rendering.products.get(viewport.path)
    if product is None or product.frames in (0, db.memory.frames):
        return False
    db.memory.frames = db.outputs.frameNumber = product.frames
    db.fire("execOut")
    return True
