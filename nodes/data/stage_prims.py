"""Finds the prim, and the attribute, that the inputs of a stage node name."""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext
from typing import Any

from graph.base.suggest import did_you_mean
from graph.node import Attribute, Database
from graph.sim.scene.prim_paths import prim_at

PRIM = Attribute("target", "the prim, unless usePath is set", optional=True)
USE_PATH = Attribute("bool", "whether primPath names the prim instead of the input prim", default=False, optional=True)


def path_of(db: Database, name: str = "primPath") -> str:
    """The path in `prim`, or with `usePath` in the input `name`. Fails the node unless it is exactly one path."""
    inputs = db.inputs
    if inputs.usePath:
        path = getattr(inputs, name)
        if not path:
            db.lack(f"input {name} is empty; give it the path of a prim, or clear usePath")
        return str(path)
    return only_target(db, "prim", inputs.prim)


def only_target(db: Database, name: str, targets: list[str]) -> str:
    """The path in a target input. Fails the node unless it is exactly one."""
    if len(targets) != 1:
        db.lack(f"input {name} names {len(targets)} prims; give it the path of one prim")
    return str(targets[0])


def find_prim(db: Database, path: str) -> Any:
    """The prim with that path; None, with a warning, if it is missing."""
    prim = prim_at(db.app.stage, path)
    if not prim:
        db.warn("prim-missing", f"there is no prim {path or 'of an empty path'} on the stage; nothing was done")
        return None
    return prim


def find_attribute(db: Database, prim: Any, name: str) -> Any:
    """The prim's attribute of that name. Fails the node if the prim does not have it."""
    if not name:
        db.lack("input name is empty; give it the name of an attribute of the prim")
    attribute = prim.GetAttribute(name) if prim.HasAttribute(name) else None
    if not attribute:
        known = [str(one.GetName()) for one in prim.GetAttributes()]
        db.fail(f'{prim.GetPath()} has no attribute "{name}"{did_you_mean(name, known)}')
    return attribute


def edited_layer(db: Database) -> AbstractContextManager[Any]:
    """The layer that `layerIdentifier` names, as the stage's edit target. Fails the node for an unknown layer."""
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
