"""Looks prims up by path, as Replicator's graphs do."""

from __future__ import annotations

from graph.node import Attribute, Database, node_type
from nodes.data.stage_prims import find_prim


@node_type(
    "omni.replicator.core.OgnGetPrimAtPath",
    version=1,
    inputs={
        "execIn": Attribute("execution", "looks the prims up"),
        "paths": Attribute("token[]", "absolute paths of prims", role="prim"),
    },
    outputs={
        "execOut": Attribute("execution", "follows unless a prim is missing"),
        "prims": Attribute("target", "the prims of these paths"),
    },
)
def get_prim_at_path(db: Database) -> bool:
    """Make a target from paths of prims that are on the stage; with a missing one nothing follows."""
    paths = [str(path) for path in db.inputs.paths]
    if None in [find_prim(db, path) for path in paths]:
        return False
    db.outputs.prims = paths
    db.fire("execOut")
    return True
