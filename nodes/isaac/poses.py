"""World poses of prims, and their translation, rotation and scale."""

from __future__ import annotations

from typing import TYPE_CHECKING

from graph.node import Attribute, Database, node_type
from graph.sim.scene.prim_paths import prim_at

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

IDENTITY = [0.0, 0.0, 0.0, 1.0]
ZERO = [0.0, 0.0, 0.0]


@node_type(
    "isaacsim.core.nodes.IsaacReadWorldPose",
    version=2,
    needs=(("prim",),),
    volatile=True,
    inputs={"prim": Attribute("target", "the prim to look at")},
    outputs={
        "translation": Attribute("vectord[3]", "position in the world", default=ZERO, unit="stage units"),
        "orientation": Attribute("quatd[4]", "orientation in the world, quaternion x, y, z, w", default=IDENTITY),
        "scale": Attribute("vectord[3]", "scale along the prim's axes", default=ZERO),
    },
)
def read_world_pose(db: Database) -> None:
    """Read a prim's pose from Fabric: of this moment, in stage units."""
    targets = db.inputs.prim
    if len(targets) != 1:
        db.lack(f"input prim names {len(targets)} prims; give it one prim path")
    outputs = db.outputs
    outputs.translation, outputs.orientation, outputs.scale = decompose(world_matrix(db, targets[0]))


def world_matrix(db: Database, path: str) -> NDArray[np.float64]:
    """Prim to world, (4, 4), column vectors, stage units. Fails the node if the prim does not exist."""
    app = db.app
    if not prim_at(app.stage, path):
        db.fail(f"there is no prim {path} on the stage; correct the path")
    matrix: NDArray[np.float64] = app.fabric.world_matrix(path)
    return matrix


def decompose(
    matrix: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Translation (3,), quaternion x, y, z, w (4,) with w >= 0, scale (3,) of a column-vector pose.

    A mirrored pose gets a negative x scale; an axis of scale 0 gives the rotation as if the scale were 1.
    """
    from graph.sim.transforms import quaternion, rotations_and_scales, to_xyzw

    rotation, scale = rotations_and_scales(matrix[None])
    return matrix[:3, 3].copy(), to_xyzw(quaternion(rotation[0])), scale[0]
