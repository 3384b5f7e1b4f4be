"""How nodes of the stage find the prim, and the attribute, that their inputs name."""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext
from typing import Any

from graph.base.suggest import did_you_mean
from graph.node import Attribute, Database
from graph.sim.scene.prim_paths import prim_at

PRIM = Attribute("target", "the prim, unless usePath is set", optional=True)
USE_PATH = Attribute("bool", "whether primPath names the prim instead of the input prim", default=False, optional=True)


def path_of(db: Database, name: str = "primPath") -> str:
    """The path that `prim`, or with `usePath` the input `name`, names. Fails the node where that is not just one."""
    inputs = db.inputs
    if inputs.usePath:
        path = getattr(inputs, name)
        if not path:
            db.lack(f"input {name} is empty; give it the path of a prim, or clear usePath")
        return str(path)
    return only_target(db, "prim", inputs.prim)


def only_target(db: Database, name: str, targets: list[str]) -> str:
    """The path that a target input names. Fails the node where it does not name just one."""
    if len(targets) != 1:
        db.lack(f"input {name} names {len(targets)} prims; give it the path of one prim")
    return str(targets[0])


def find_prim(db: Database, path: str) -> Any:
    """The prim of that path; None, with a warning, where there is none."""
    prim = prim_at(db.app.stage, path)
    if not prim:
        db.warn("prim-missing", f"there is no prim {path or 'of an empty path'} on the stage; nothing was done")
        return None
    return prim


def find_attribute(db: Database, prim: Any, name: str) -> Any:
    """The prim's attribute of that name. Fails the node where it has none."""
    if not name:
        db.lack("input name is empty; give it the name of an attribute of the prim")
    attribute = prim.GetAttribute(name) if prim.HasAttribute(name) else None
    if not attribute:
        known = [str(one.GetName()) for one in prim.GetAttributes()]
        db.fail(f'{prim.GetPath()} has no attribute "{name}"{did_you_mean(name, known)}')
    return attribute


def edited_layer(db: Database) -> AbstractContextManager[Any]:
    """The layer that `layerIdentifier` names as the stage's edit target. Fails the node where there is none such."""
    from graph.sim.usd import Usd

    stage, wanted = db.app.stage, db.inputs.layerIdentifier
    named = {"<Session Layer>": stage.GetSessionLayer(), "<Root Layer>": stage.GetRootLayer()}
    if not wanted:
        return nullcontext()
    layers = [one for one in stage.GetLayerStack() if wanted in (one.identifier, one.GetDisplayName())]
    layer = named.get(wanted) or next(iter(layers), None)
    if layer is None:
        db.fail(f'input layerIdentifier is "{wanted}", which is not a layer of the stage; clear it or correct it')
    edit: AbstractContextManager[Any] = Usd.EditContext(stage, Usd.EditTarget(layer))
    return edit
