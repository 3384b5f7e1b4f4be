"""Prims of the stage: searched, named, tested."""

from __future__ import annotations

from fnmatch import fnmatchcase
from typing import Any

from graph.node import Attribute, Database, node_type

from .stage_prims import find_prim

PATHS = Attribute("target", "the prims")


@node_type(
    "omni.graph.nodes.GetPrimPath",
    version=3,
    inputs={"prim": Attribute("target", "the prim; of several the first")},
    outputs={
        "path": Attribute("path", "its path; empty without a prim"),
        "primPath": Attribute("token", "its path as a token"),
    },
)
def get_prim_path(db: Database) -> None:
    """Give the path of a prim."""
    targets = db.inputs.prim
    db.outputs.path = db.outputs.primPath = str(targets[0]) if targets else ""


@node_type(
    "omni.graph.nodes.GetPrimPaths",
    version=1,
    inputs={"prims": PATHS},
    outputs={"primPaths": Attribute("token[]", "their paths, in order")},
)
def get_prim_paths(db: Database) -> None:
    """Give the paths of prims."""
    db.outputs.primPaths = list(db.inputs.prims)


@node_type(
    "omni.graph.nodes.ToTarget",
    version=1,
    inputs={
        "value": Attribute(("path", "string", "token", "token[]"), "one path or an array; empty ones do not count")
    },
    outputs={"converted": Attribute("target", "the prims of these paths")},
)
def to_target(db: Database) -> None:
    """Make a target from paths; a path that is not absolute fails."""
    value = db.inputs.value
    paths = [value] if isinstance(value, str) else list(value)
    for path in paths:
        if path and not path.startswith("/"):
            db.fail(f'input value holds "{path}", which is not an absolute path; begin it with /')
    db.outputs.converted = [path for path in paths if path]


@node_type(
    "omni.graph.nodes.IsPrimActive",
    version=1,
    volatile=True,
    inputs={
        "prim": Attribute("path", "path of the prim", default="", deprecated="use primTarget"),
        "primTarget": Attribute("target", "the prim"),
    },
    outputs={"active": Attribute("bool", "whether it is active; a prim that is not there is not")},
)
def is_prim_active(db: Database) -> None:
    """Give whether a prim is active on the stage."""
    path = db.inputs.primTarget[0] if db.inputs.primTarget else db.inputs.prim
    prim = find_prim(db, str(path))
    db.outputs.active = prim is not None and bool(prim.IsActive())


@node_type(
    "omni.graph.nodes.FindPrims",
    version=1,
    volatile=True,
    inputs={
        "ignoreSystemPrims": Attribute("bool", "whether to leave out graphs and their nodes", default=False),
        "namePrefix": Attribute("token", "how their names begin", default=""),
        "pathPattern": Attribute(
            "token", "their paths, as patterns with * and ?; ^ before one leaves it out", default=""
        ),
        "recursive": Attribute("bool", "whether to look below the root's children too", default=False),
        "requiredAttributes": Attribute("string", "attributes that they must have, with spaces between", default=""),
        "requiredRelationship": Attribute("token", "a relationship that they must have", default=""),
        "requiredRelationshipTarget": Attribute("string", "a path that the relationship must name", default=""),
        "requiredTarget": Attribute("target", "what the relationship must name, before requiredRelationshipTarget"),
        "rootPrim": Attribute("target", "below which prim to look, before rootPrimPath"),
        "rootPrimPath": Attribute(
            "token", "below which prim to look; empty means the whole stage", default="", role="prim"
        ),
        "type": Attribute("token", "their types, as patterns with * and ?; ^ before one leaves it out", default=""),
    },
    outputs={
        "primPaths": Attribute("token[]", "their paths, in the order of the stage"),
        "prims": Attribute("target", "the prims, in the same order"),
    },
)
def find_prims(db: Database) -> None:
    """Find the prims that meet all conditions; an empty input is not a condition."""
    from graph.sim.usd import Usd

    inputs, stage = db.inputs, db.app.stage
    path = str(inputs.rootPrim[0]) if inputs.rootPrim else inputs.rootPrimPath
    root = find_prim(db, path) if path else stage.GetPseudoRoot()
    found: list[Any] = []
    if root is not None:
        found = [one for one in Usd.PrimRange(root) if one != root] if inputs.recursive else root.GetChildren()
    paths = [str(one.GetPath()) for one in found if _fits(one, inputs)]
    db.outputs.primPaths, db.outputs.prims = paths, list(paths)


_SYSTEM = ("OmniGraph", "OmniGraphNode", "ComputeGraph", "ComputeGraphSettings", "ComputeNode")


def _fits(prim: Any, wanted: Any) -> bool:
    return (
        prim.GetName().startswith(wanted.namePrefix)
        and not (wanted.ignoreSystemPrims and str(prim.GetTypeName()) in _SYSTEM)
        and _matches(str(prim.GetTypeName()), wanted.type.split())
        and _matches(str(prim.GetPath()), wanted.pathPattern.split())
        and all(prim.HasAttribute(name) for name in wanted.requiredAttributes.split())
        and (not wanted.requiredRelationship or _related(prim, wanted))
    )


def _matches(name: str, patterns: list[str]) -> bool:
    unwanted = [one[1:] for one in patterns if one.startswith("^")]
    allowed = [one for one in patterns if not one.startswith("^")]
    if any(fnmatchcase(name, one) for one in unwanted):
        return False
    return not allowed or any(fnmatchcase(name, one) for one in allowed)


def _related(prim: Any, wanted: Any) -> bool:
    if not prim.HasRelationship(wanted.requiredRelationship):
        return False
    targets = [str(path) for path in prim.GetRelationship(wanted.requiredRelationship).GetTargets()]
    needed = list(wanted.requiredTarget) or [wanted.requiredRelationshipTarget]
    return needed == [""] or all(path in targets for path in needed)
