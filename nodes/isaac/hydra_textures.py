"""Renders products that are already in the scene."""

from __future__ import annotations

import re
from typing import Any

from graph.node import Attribute, Database, node_type
from graph.sim.scene.prim_paths import prim_at

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
