"""Poses of prims in a parent, as arrays that a transform publisher takes."""

from __future__ import annotations

from graph.base.records import dataclass
from graph.node import Attribute, Database, node_type
from graph.sim.scene.prim_paths import prim_at

from .transform_trees import TransformTree, edges_of


@dataclass(slots=True)
class _Tree:
    key: tuple[str, tuple[str, ...]] = ("", ())
    tree: TransformTree | None = None


@node_type(
    "isaacsim.core.nodes.IsaacComputeTransformTree",
    version=1,
    needs=(("targetPrims",),),
    inputs={
        "execIn": Attribute("execution", "reads the poses"),
        "parentPrim": Attribute("target", "the prim the others are placed in; none means the world", optional=True),
        "targetPrims": Attribute("target", "prims to place; the root of an articulation stands for all its links"),
    },
    outputs={
        "execOut": Attribute("execution", "follows every reading"),
        "parentFrames": Attribute("token[]", "name of each transform's parent frame"),
        "childFrames": Attribute("token[]", "name of each transform's child frame"),
        "translations": Attribute("double[3][]", "positions in the parent frames", unit="m"),
        "orientations": Attribute("double[4][]", "rotations in the parent frames, quaternions x, y, z, w"),
    },
    memory=_Tree,
)
def compute_transform_tree(db: Database) -> None:
    """Give the poses of the targets in the parent; links of an articulation are given in their parent links.

    Frame names: isaac:nameOverride, else the prim's name, else (if two prims share it) its path with _ for /.
    """
    inputs, memory, app = db.inputs, db.memory, db.app
    parents, targets = inputs.parentPrim or (), inputs.targetPrims or ()
    key = (str(parents[0]) if parents else "", tuple(map(str, targets)))
    if memory.tree is None or key != memory.key:
        if not key[1]:
            db.lack("nothing to place; set targetPrims")
        for path in (*key[1], *filter(None, key[:1])):
            if not prim_at(app.stage, path):
                db.fail(f"there is no prim {path} on the stage; correct the path")
        memory.key, memory.tree = key, TransformTree(edges_of(app.stage, *key, keep_parent=True))
    poses = memory.tree.read(app.fabric, app.meters_per_unit)
    outputs = db.outputs
    outputs.parentFrames, outputs.childFrames = [pose.parent for pose in poses], [pose.child for pose in poses]
    outputs.translations = [pose.translation for pose in poses]
    outputs.orientations = [pose.rotation for pose in poses]
    db.fire("execOut")
