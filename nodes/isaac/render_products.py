"""Render products: the link between a sensor prim and whatever consumes its frames."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sized
from typing import Any

from graph.base.errors import UserError
from graph.base.records import dataclass
from graph.node import Attribute, Database, node_type
from graph.node.at_load import NodeAtLoad
from graph.sim.scene.prim_paths import prim_at


@dataclass(slots=True)
class _Made:
    wanted: tuple[str, int, int] | None = None
    path: str = ""
    own: bool = False


def _one_prim(found: Sized) -> str:
    return f"names {len(found)} prims; give it the path of one sensor prim"


def _check(node: NodeAtLoad) -> Iterator[tuple[str, str]]:
    """More than one sensor, and a size without pixels, where the file gives all of it."""
    from graph.sim.scene.prim_paths import prim_at
    from sensors.camera import names
    from sensors.camera.config import checked_size

    db = node.db
    if any(db.connected(f"inputs:{name}") for name in ("width", "height", "cameraPrim", "renderProductPrim")):
        return
    cameras = [str(path) for path in db.inputs.cameraPrim]
    if len(cameras) > 1:
        yield "cameraPrim", _one_prim(cameras)
    given = next((name for name in ("width", "height") if name in node.given), None)
    if given is None or len(cameras) != 1:
        return
    camera = prim_at(node.stage, cameras[0])
    if not camera or camera.GetTypeName() != names.PRIM_TYPE:  # a missing prim is reported as such
        return
    try:
        checked_size(cameras[0], (db.inputs.width, db.inputs.height))
    except UserError as error:
        yield given, str(error)


@node_type(
    "isaacsim.core.nodes.IsaacCreateRenderProduct",
    version=3,
    check=_check,
    needs=(("cameraPrim", "renderProductPrim"),),
    inputs={
        "execIn": Attribute("execution", "makes the product, or finds the one there is"),
        "width": Attribute("uint", "image width; a lidar does not use it", default=1280, unit="px"),
        "height": Attribute("uint", "image height; a lidar does not use it", default=720, unit="px"),
        "cameraPrim": Attribute("target", "the prim of the sensor that the product renders", role="sensor"),
        "enabled": Attribute("bool", "if not, the node does nothing", default=True),
        "renderProductPrim": Attribute("target", "an existing product to use instead of a new one"),
    },
    outputs={
        "renderProductPath": Attribute("token", "path of the product", role="product"),
        "execOut": Attribute("execution", "follows every compute of an enabled node"),
    },
    memory=_Made,
)
def create_render_product(db: Database) -> bool:
    """Create a sensor's render product; a later change of camera or size creates another one."""
    inputs, memory = db.inputs, db.memory
    if not inputs.enabled:
        return False
    rendering = db.app.rendering
    if inputs.renderProductPrim:
        memory.path, memory.own = inputs.renderProductPrim[0], False
        if memory.path not in rendering.products:
            db.lack(f"there is no render product {memory.path}; clear renderProductPrim or correct it")
    else:
        if len(inputs.cameraPrim) != 1:
            db.lack(f"input cameraPrim {_one_prim(inputs.cameraPrim)}")
        wanted = (str(inputs.cameraPrim[0]), inputs.width, inputs.height)
        if wanted != memory.wanted or memory.path not in rendering.products:
            _make(db, wanted)
    db.outputs.renderProductPath = memory.path
    db.fire("execOut")
    return True


def _make(db: Database, wanted: tuple[str, int, int]) -> None:
    from sensors.products import remove_product, render_product

    rendering, memory = db.app.rendering, db.memory
    if memory.own and memory.path in rendering.products:
        remove_product(db.app.world, rendering.products[memory.path])
    camera, width, height = wanted
    before = set(rendering.products)
    product = render_product(db.app, camera, resolution=(width, height))
    memory.wanted, memory.path, memory.own = wanted, product.path, product.path not in before


VARS = "/Render/Vars"


@node_type(
    "isaacsim.core.nodes.IsaacAttachHydraTexture",
    version=1,
    needs=(("renderProductPrim",),),
    inputs={
        "execIn": Attribute("execution", "attaches the product"),
        "renderProductPrim": Attribute("target", "a RenderProduct prim of the stage"),
        "renderVars": Attribute(
            "token[]", "names of what the product is to hold, written to its orderedVars", default=[]
        ),
        "enabled": Attribute("bool", "if not, the product renders nothing", default=True),
    },
    outputs={
        "renderProductPath": Attribute("token", "path of the product", role="product"),
        "execOut": Attribute("execution", "follows every compute of an enabled node"),
    },
)
def attach_hydra_texture(db: Database) -> bool:
    """Make a RenderProduct prim render its camera at its resolution.

    Render variables are written to the session layer.
    """
    inputs, app = db.inputs, db.app
    if len(inputs.renderProductPrim) != 1:
        db.lack(f"input renderProductPrim names {len(inputs.renderProductPrim)} prims; give it one RenderProduct")
    path = str(inputs.renderProductPrim[0])
    product = app.rendering.products.get(path)
    if not inputs.enabled:
        if product is not None:
            product.enabled = False
        return False
    if product is None:
        product = _attached(db, path)
    product.enabled = True
    _add_variables(app.stage, path, inputs.renderVars)
    db.outputs.renderProductPath = path
    db.fire("execOut")
    return True


def _attached(db: Database, path: str) -> Any:
    from graph.sim.usd import UsdRender
    from sensors.products import place_product

    prim = UsdRender.Product(prim_at(db.app.stage, path))
    if not prim:
        db.fail(f"{path} is not a RenderProduct prim on the stage; correct renderProductPrim")
    cameras = prim.GetCameraRel().GetTargets()
    if not cameras:
        db.fail(f"{path} has no camera; set its camera relationship")
    width, height = prim.GetResolutionAttr().Get()
    return place_product(db.app.world, path, str(cameras[0]), (int(width), int(height)))


def _add_variables(stage: Any, path: str, names: Any) -> None:
    from graph.sim.usd import Usd, UsdRender

    if not len(names):
        return
    with Usd.EditContext(stage, stage.GetSessionLayer()):
        ordered = UsdRender.Product(stage.GetPrimAtPath(path)).CreateOrderedVarsRel()
        known = {str(target) for target in ordered.GetTargets()}
        for name in filter(None, names):
            place = f"{VARS}/{re.sub(r'[^A-Za-z0-9_]', '_', name)}"
            if place not in known:
                known.add(place)
                UsdRender.Var.Define(stage, place).CreateSourceNameAttr().Set(str(name))
                ordered.AddTarget(place, Usd.ListPositionBackOfAppendList)
