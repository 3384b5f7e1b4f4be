"""Viewports without windows: a name that stands for a render product, whose camera and size can be set."""

from __future__ import annotations

import re
import weakref
from typing import TYPE_CHECKING, Any

from graph.base.records import dataclass
from graph.node import Attribute, Database, node_type

if TYPE_CHECKING:
    from graph.sim.app import App

DEFAULT = "Viewport"
"""The viewport that is always there."""

SIZE = (1280, 720)

PERSPECTIVE = "/OmniverseKit_Persp"
"""The camera of a viewport that was given none, on stages that have it: those of `graph exec`."""


@dataclass(slots=True)
class Viewport:
    """A viewport; its render product is made at first use."""

    path: str
    size: tuple[int, int] = SIZE
    camera: str = ""


_viewports: weakref.WeakKeyDictionary[Any, dict[str, Viewport]] = weakref.WeakKeyDictionary()


def viewports_of(app: App) -> dict[str, Viewport]:
    """The App's viewports by name."""
    found = _viewports.get(app)
    if found is None:
        found = _viewports[app] = {}
        open_viewport(app, DEFAULT)
    return found


def open_viewport(app: App, name: str) -> Viewport:
    """The viewport of a name; a missing one is created."""
    from sensors.products import ROOT

    viewports = viewports_of(app) if app in _viewports else _viewports.setdefault(app, {})
    if name not in viewports:
        base = f"{ROOT}/{re.sub(r'[^A-Za-z0-9_]', '_', name) or 'viewport'}"
        taken = {one.path for one in viewports.values()}
        numbered = (f"{base}_{number:02}" for number in range(1, len(taken) + 1))
        path = next(path for path in (base, *numbered) if path not in taken)
        viewports[name] = Viewport(path)
    return viewports[name]


def product_of(app: App, viewport: Viewport) -> Any:
    """The viewport's render product; a missing one is created."""
    from sensors.products import place_product

    product = app.rendering.products.get(viewport.path)
    if product is not None and (product.camera_path or not app.stage.GetPrimAtPath(PERSPECTIVE)):
        return product
    if not viewport.camera and app.stage.GetPrimAtPath(PERSPECTIVE):
        viewport.camera = PERSPECTIVE
    return place_product(app.world, viewport.path, viewport.camera, viewport.size)


def named_viewport(db: Database) -> Viewport | None:
    """The viewport that input `viewport` names (empty: the default one); None, with a warning, if it does not exist."""
    name = db.inputs.viewport or DEFAULT
    found = viewports_of(db.app).get(name)
    if found is None:
        db.warn("viewport-missing", f'there is no viewport "{name}"; make it with IsaacCreateViewport')
    return found


@dataclass(slots=True)
class _Title:
    name: str = ""


@node_type(
    "isaacsim.core.nodes.IsaacCreateViewport",
    version=2,
    inputs={
        "execIn": Attribute("execution", "makes the viewport, or finds it"),
        "name": Attribute("token", "name of the viewport"),
        "viewportId": Attribute("uint", "used as its name where name is empty; 0 is the default viewport"),
    },
    outputs={
        "viewport": Attribute("token", "name of the viewport"),
        "execOut": Attribute("execution", "follows every compute"),
    },
    memory=_Title,
)
def create_viewport(db: Database) -> None:
    """Make a viewport: a render product of 1280 x 720 pixels without a window; the first name after play stays."""
    memory, number = db.memory, db.inputs.viewportId
    if not memory.name:
        memory.name = db.inputs.name or (str(number) if number else DEFAULT)
        viewports_of(db.app)
        open_viewport(db.app, memory.name)
    db.outputs.viewport = memory.name
    db.fire("execOut")


@node_type(
    "isaacsim.core.nodes.IsaacGetViewportRenderProduct",
    version=1,
    inputs={
        "execIn": Attribute("execution", "looks the product up"),
        "viewport": Attribute("token", "name of the viewport; empty is the default one"),
    },
    outputs={
        "renderProductPath": Attribute("token", "path of its render product", role="product"),
        "execOut": Attribute("execution", "follows when there is such a viewport"),
    },
)
def get_viewport_render_product(db: Database) -> bool:
    """Find a viewport's render product; it renders the perspective camera, if there is one, until another is set."""
    viewport = named_viewport(db)
    if viewport is None:
        return False
    db.outputs.renderProductPath = product_of(db.app, viewport).path
    db.fire("execOut")
    return True


@node_type(
    "isaacsim.core.nodes.IsaacSetViewportResolution",
    version=1,
    inputs={
        "execIn": Attribute("execution", "sets the size"),
        "viewport": Attribute("token", "name of the viewport; empty is the default one"),
        "width": Attribute("uint", "width of its render product", default=1280, unit="px"),
        "height": Attribute("uint", "height of its render product", default=720, unit="px"),
    },
    outputs={"execOut": Attribute("execution", "follows when there is such a viewport")},
)
def set_viewport_resolution(db: Database) -> bool:
    """Give a viewport's render product another size."""
    from sensors.products import place_product

    viewport, size = named_viewport(db), (db.inputs.width, db.inputs.height)
    if viewport is None:
        return False
    if not all(size):
        db.fail(f"{size[0]} x {size[1]} pixels are not a size; give width and height above 0")
    viewport.size = size
    product = product_of(db.app, viewport)
    if product.resolution != size:
        place_product(db.app.world, viewport.path, viewport.camera, size)
    db.fire("execOut")
    return True


@node_type(
    "isaacsim.core.nodes.IsaacSetCameraOnRenderProduct",
    version=1,
    inputs={
        "execIn": Attribute("execution", "sets the camera"),
        "renderProductPath": Attribute("token", "path of the render product", role="product"),
        "cameraPrim": Attribute("target", "the sensor prim that it renders from now on", role="sensor"),
    },
    outputs={"execOut": Attribute("execution", "follows every compute")},
)
def set_camera_on_render_product(db: Database) -> None:
    """Make a render product render another sensor prim."""
    from sensors.products import place_product

    inputs, app = db.inputs, db.app
    if len(inputs.cameraPrim) != 1:
        db.lack(f"input cameraPrim names {len(inputs.cameraPrim)} prims; give it the path of one sensor prim")
    product = app.rendering.products.get(inputs.renderProductPath)
    if product is None:
        db.lack(f"there is no render product {inputs.renderProductPath or '(empty path)'}; connect one")
    camera = str(inputs.cameraPrim[0])
    if product.camera_path != camera:
        place_product(app.world, product.path, camera, product.resolution)
        for viewport in viewports_of(app).values():
            if viewport.path == product.path:
                viewport.camera = camera
    db.fire("execOut")
