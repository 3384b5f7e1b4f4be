"""Transforms of prims as matrices: row vectors, translation in the last row, stage units."""

from __future__ import annotations

from typing import Any

from graph.node import Attribute, Database, node_type

from .stage_prims import find_prim, only_target

_IDENTITY = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]]
PATH = Attribute("token", "path of the prim where usePath is set", default="", role="prim")
ONE_PRIM = {
    "prim": Attribute("target", "the prim, unless usePath is set", optional=True),
    "primPath": PATH,
    "usePath": Attribute("bool", "whether primPath names the prim instead of the input prim", default=True),
}


@node_type(
    "omni.graph.nodes.ReadPrimLocalTransform",
    version=1,
    volatile=True,
    inputs={"prim": Attribute("target", "the prim to look at")},
    outputs={"value": Attribute("matrixd[4]", "its place in its parent")},
)
def read_prim_local_transform(db: Database) -> bool:
    """Read a prim's present transform relative to its parent; for a missing prim the output keeps its value."""
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
    inputs=ONE_PRIM,
    outputs={"localToWorldTransform": Attribute("matrixd[4]", "its place in the world")},
)
def get_prim_local_to_world_transform(db: Database) -> bool:
    """Read a prim's present transform to the world; for a missing prim the output keeps its value."""
    from .stage_prims import path_of

    prim = find_prim(db, path_of(db))
    if prim is None:
        return False
    db.outputs.localToWorldTransform = db.app.fabric.world_matrix(str(prim.GetPath())).T.copy()
    return True


@node_type(
    "omni.graph.nodes.WritePrimLocalTransform",
    version=1,
    inputs={
        "execIn": Attribute("execution", "moves the prim"),
        "prim": Attribute("target", "the prim to move"),
        "value": Attribute("matrixd[4]", "its new place in its parent", default=_IDENTITY),
    },
    outputs={"execOut": Attribute("execution", "follows once it is moved")},
)
def write_prim_local_transform(db: Database) -> bool:
    """Set a prim's transform relative to its parent; a missing prim is skipped, a transform with shear fails.

    The prim's transform operations become translate, orient and scale. A moving body moves there and keeps its
    velocity.
    """
    import numpy as np

    from graph.sim import transforms
    from graph.sim.scene.prim_attributes import set_transform

    prim = find_prim(db, only_target(db, "prim", db.inputs.prim))
    if prim is None:
        return False
    matrix = db.inputs.value.T
    if not transforms.usable(matrix):
        db.fail("input value is not a place: it is flat, not affine, or holds a number that is not finite")
    rigid = transforms.rigid_part(matrix)
    rest = (transforms.inverse_rigid(rigid) @ matrix)[:3, :3]
    if np.abs(rest - np.diag(np.diag(rest))).max() > 1e-9 * np.abs(rest).max():
        db.fail("input value is sheared, which translate, orient and scale cannot say")
    orient, scale = transforms.quaternion(rigid[:3, :3]).tolist(), np.diag(rest).tolist()
    try:
        set_transform(prim, translate=rigid[:3, 3].tolist(), orient=orient, scale=scale)
    except ValueError as error:
        db.fail(f"{prim.GetPath()}: {error}")
    failure = db.app.live.take_failure() if db.app.live is not None else None
    if failure is not None:
        db.fail(str(failure))
    db.fire("execOut")
    return True


_DIRECTIONS = {"right": 0, "up": 1, "backward": 2}
_OPPOSITES = {"right": "left", "up": "down", "backward": "forward"}


@node_type(
    "omni.graph.nodes.GetPrimDirectionVector",
    version=2,
    volatile=True,
    inputs=ONE_PRIM,
    outputs={
        f"{name}Vector": Attribute("double[3]", f"the direction {name} in the world, of length 1")
        for name in ("backward", "down", "forward", "left", "right", "up")
    },
)
def get_prim_direction_vector(db: Database) -> bool:
    """Give a prim's directions in the world: right is its x, up its y, backward its z axis, as for a camera.

    For a missing prim the outputs keep their values.
    """
    import numpy as np

    from .stage_prims import path_of

    prim = find_prim(db, path_of(db))
    if prim is None:
        return False
    columns = db.app.fabric.world_matrix(str(prim.GetPath()))[:3, :3]
    for name, column in _DIRECTIONS.items():
        axis = columns[:, column] / np.linalg.norm(columns[:, column])
        setattr(db.outputs, f"{name}Vector", axis)
        setattr(db.outputs, f"{_OPPOSITES[name]}Vector", -axis)
    return True


def _resets(prim: Any) -> bool:
    from graph.sim.usd import UsdGeom

    return bool(prim.IsA(UsdGeom.Xformable) and UsdGeom.Xformable(prim).GetResetXformStack())
