"""Poses of prims as a ROS 2 transform tree."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial

from graph.base.records import dataclass, field
from graph.node import Attribute, Database, node_type
from graph.sim.scene.prim_paths import prim_at
from nodes.isaac.clocks import stamp_ns
from nodes.isaac.transform_trees import FrameTransform, TransformTree, edges_of

from .messages import TRANSFORMS, publish_transforms
from .publishing import TIME_STAMP, Publisher, check_names, publisher_inputs, subscribed_topic

GIVEN = "one per transform; with childFrames set, the node publishes these instead of prims"


@dataclass(slots=True)
class _Tree(Publisher):
    key: tuple[str, tuple[str, ...]] = ("", ())
    tree: TransformTree | None = None
    latched: list[FrameTransform] = field(default_factory=list)


def _frames(db: Database) -> Iterable[str] | None:
    if any(db.connected(f"inputs:{name}") for name in ("parentPrim", "targetPrims", "parentFrames", "childFrames")):
        return None
    inputs, stage = db.inputs, db.app.stage
    if len(inputs.childFrames):
        return (*inputs.parentFrames, *inputs.childFrames)
    parents, targets = map(str, inputs.parentPrim or ()), [str(path) for path in inputs.targetPrims or ()]
    edges = edges_of(stage, next(parents, ""), [path for path in targets if prim_at(stage, path)])
    return [name for edge in edges for name in (edge.parent_frame, edge.child_frame)]


@node_type(
    "isaacsim.ros2.bridge.ROS2PublishTransformTree",
    version=1,
    needs=(("targetPrims", "childFrames"),),
    check=check_names,
    inputs={
        "execIn": Attribute("execution", "publishes the poses"),
        "parentPrim": Attribute("target", "the prim the others are placed in; none means the world", optional=True),
        "targetPrims": Attribute("target", "prims to publish; the root of an articulation stands for all its links"),
        **publisher_inputs("tf"),
        "timeStamp": TIME_STAMP,
        "staticPublisher": Attribute(
            "bool", "publish once, and again when something moved, on tf_static where topicName is tf", default=False
        ),
        "parentFrames": Attribute("token[]", f"parent frame names, {GIVEN}", optional=True),
        "childFrames": Attribute("token[]", f"child frame names, {GIVEN}", optional=True),
        "translations": Attribute("double[3][]", f"positions in the parent frame, {GIVEN}", optional=True, unit="m"),
        "orientations": Attribute("double[4][]", f"rotations, quaternions x, y, z, w, {GIVEN}", optional=True),
    },
    memory=partial(_Tree, TRANSFORMS),
    frames=_frames,
)
def publish_transform_tree(db: Database) -> bool:
    """Publish `tf2_msgs/TFMessage`: the targets' poses in the parent, in metres and x, y, z, w quaternions.

    Frame names: isaac:nameOverride, else the prim's name, else (if two prims share it) its path with _ for /.
    """
    inputs = db.inputs
    static = inputs.staticPublisher
    topic = subscribed_topic(db, "tf_static" if static and inputs.topicName == "tf" else None, latched=static)
    if topic is None:
        return False
    poses = _given(db) if len(inputs.childFrames) else _of_prims(db)
    memory = db.memory
    if static:
        if poses == memory.latched:
            return False
        memory.latched = poses
    nanoseconds = stamp_ns(db.app, inputs.timeStamp)
    publish_transforms(db, topic, poses, nanoseconds)
    return True


def _of_prims(db: Database) -> list[FrameTransform]:
    inputs, memory, app = db.inputs, db.memory, db.app
    parents, targets = inputs.parentPrim or (), inputs.targetPrims or ()
    key = (str(parents[0]) if parents else "", tuple(map(str, targets)))
    if memory.tree is None or key != memory.key:
        if not key[1]:
            db.lack("nothing to publish; set targetPrims")
        for path in (*key[1], *filter(None, key[:1])):
            if not prim_at(app.stage, path):
                db.fail(f"there is no prim {path} on the stage; correct the path")
        memory.key, memory.tree = key, TransformTree(edges_of(app.stage, *key))
    poses: list[FrameTransform] = memory.tree.read(app.fabric, app.meters_per_unit)
    return poses


def _given(db: Database) -> list[FrameTransform]:
    inputs = db.inputs
    columns = (inputs.parentFrames, inputs.childFrames, inputs.translations.tolist(), inputs.orientations.tolist())
    if len({len(column) for column in columns}) != 1:
        sizes = ", ".join(map(str, map(len, columns)))
        db.fail(f"parentFrames, childFrames, translations, orientations have {sizes} entries; they must agree")
    return [
        FrameTransform(parent, child, (x, y, z), (qx, qy, qz, qw))
        for parent, child, (x, y, z), (qx, qy, qz, qw) in zip(*columns, strict=True)
    ]
