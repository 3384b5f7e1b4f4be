"""Transforms of prims as matrices: row vectors, the translation in the last row, stage units."""

from __future__ import annotations

from typing import Any

from graph import Attribute, node_type

from .stage_prims import find_prim, only_target

PATH = Attribute("token", "path of the prim where usePath is set", default="")


@node_type(
    "omni.graph.nodes.ReadPrimLocalTransform",
    version=1,
    volatile=True,
    inputs={"prim": Attribute("target", "the prim to look at")},
    outputs={"value": Attribute("matrixd[4]", "its place in its parent")},
)
def read_prim_local_transform(db: Any) -> bool:
    """Read where a prim is in its parent, at this moment; a missing prim leaves the output as it is."""
    import numpy as np

    prim = find_prim(db, only_target(db, "prim", db.inputs.prim))
    if prim is None:
        return False
    fabric, parent = db.app.fabric, prim.GetParent()
    world = fabric.world_matrix(str(prim.GetPath()))
    if parent and not parent.IsPseudoRoot() and not _resets(prim):
        world = np.linalg.inv(fabric.world_matrix(str(parent.GetPath()))) @ world
    db.outputs.value = world.T.copy()
    return True


@node_type(
    "omni.graph.nodes.GetPrimLocalToWorldTransform",
    version=2,
    volatile=True,
    inputs={
        "prim": Attribute("target", "the prim, unless usePath is set", optional=True),
        "primPath": PATH,
        "usePath": Attribute("bool", "whether primPath names the prim instead of the input prim", default=True),
    },
    outputs={"localToWorldTransform": Attribute("matrixd[4]", "its place in the world")},
)
def get_prim_local_to_world_transform(db: Any) -> bool:
    """Read where a prim is in the world, at this moment; a missing prim leaves the output as it is."""
    from .stage_prims import path_of

    prim = find_prim(db, path_of(db))
    if prim is None:
        return False
    db.outputs.localToWorldTransform = db.app.fabric.world_matrix(str(prim.GetPath())).T.copy()
    return True


def _resets(prim: Any) -> bool:
    from graph.sim.usd import UsdGeom

    return bool(prim.IsA(UsdGeom.Xformable) and UsdGeom.Xformable(prim).GetResetXformStack())
