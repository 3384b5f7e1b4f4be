"""Moves prims by a transform tree from a topic."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

from graph.base.errors import RunError
from graph.base.records import dataclass, field
from graph.node import Attribute, Database, NodeAtLoad, node_type
from graph.sim.scene.mechanisms import mechanisms_of
from graph.sim.scene.prim_paths import near_prim, prim_at

from .messages import TRANSFORMS
from .publishing import check_names
from .subscribing import EXEC_OUT, Subscriber, next_message, subscriber_inputs, unsubscribe


@dataclass(slots=True)
class _Follower(Subscriber):
    frames: dict[str, str] = field(default_factory=dict)
    placed: dict[str, Any] = field(default_factory=dict)
    stop_holding: Callable[[], None] | None = None


def _release(db: Database) -> None:
    unsubscribe(db)
    if db.memory.stop_holding is not None:
        db.memory.stop_holding()
        db.memory.stop_holding = None


def _check(node: NodeAtLoad) -> Iterator[tuple[str, str]]:
    yield from check_names(node)
    if "frameNamesMap" in node.given and (wrong := _wrong_map(node.stage, list(node.db.inputs.frameNamesMap))):
        yield "frameNamesMap", wrong


@node_type(
    "isaacsim.ros2.bridge.ROS2SubscribeTransformTree",
    version=1,
    check=_check,
    inputs={
        **subscriber_inputs("tf"),
        "frameNamesMap": Attribute("token[]", "prim path, frame name, prim path, frame name, ...", default=[]),
        "articulationRoots": Attribute(
            "token[]",
            "robots of the map, by any of their prims: their root links follow",
            default=[],
            role="prim",
        ),
    },
    outputs={"execOut": EXEC_OUT},
    memory=_Follower,
    release=_release,
)
def subscribe_transform_tree(db: Database) -> bool:
    """Receive `tf2_msgs/TFMessage`: move the prims of frameNamesMap by the transforms between their frames.

    A transform counts if both its frames are in the map: the child's prim gets the parent's pose times the transform.
    All waiting messages are taken at once. A rigid body stays where it was put, against physics. A link that a joint
    holds cannot be moved and stays with its joint, with a warning.
    """
    memory = db.memory
    if memory.subscription is None:
        memory.frames = _frames(db)
    received = False
    while (message := next_message(db, TRANSFORMS)) is not None:
        received = True
        for one in message.transforms:
            parent, child = memory.frames.get(one.header.frame_id), memory.frames.get(one.child_frame_id)
            if parent is not None and child is not None:
                _place(db, child, db.app.fabric.world_matrix(parent), one.transform)
    if received:
        db.fire("execOut")
    return received


def _frames(db: Database) -> dict[str, str]:
    """Frame name -> prim path. Fails the node unless the map consists of pairs of a prim and a unique frame name."""
    inputs, stage = db.inputs, db.app.stage
    names = list(inputs.frameNamesMap)
    if wrong := _wrong_map(stage, names):
        db.fail(wrong)
    frames: dict[str, str] = dict(zip(names[1::2], names[::2], strict=True))
    for path in inputs.articulationRoots:
        if not prim_at(stage, path):
            db.fail(f"there is no prim {path} on the stage{near_prim(stage, path)}")
    links: dict[str, str] = {path: _root_link(db, path) for path in inputs.articulationRoots}
    return {frame: links.get(path, path) for frame, path in frames.items()}


def _wrong_map(stage: Any, names: Sequence[str]) -> str:
    """What is wrong with a map of pairs of a prim and a unique frame name; "" if nothing is."""
    if len(names) % 2:
        return f"frameNamesMap has {len(names)} entries; it needs pairs of prim path and frame name"
    paths, frames = names[::2], names[1::2]
    if twice := next((one for group in (frames, paths) for one in group if group.count(one) > 1), ""):
        return f"frameNamesMap names {twice} twice; each prim has one frame"
    gone = next((path for path in paths if not prim_at(stage, path)), None)
    return "" if gone is None else f"there is no prim {gone} on the stage{near_prim(stage, gone)}"


def _root_link(db: Database, path: str) -> str:
    """The root link of the articulation of a prim. Fails the node without an articulation."""
    links = mechanisms_of(db.app.stage).carriers(path)
    if not links:
        db.fail(f"articulationRoots: {path} has no articulation; name a prim of a robot, or leave it out")
    return next(iter(links))


def _place(db: Database, path: str, parent: Any, transform: Any) -> None:
    """Puts a prim at `transform` [m] in the parent's world pose, without scale."""
    import numpy as np

    from graph.sim.transforms import rotations_and_scales

    rotation, move = transform.rotation, transform.translation
    quaternion = np.array([rotation.w, rotation.x, rotation.y, rotation.z])
    length = float(np.linalg.norm(quaternion))
    if not np.isfinite(length) or length < 1e-9:
        db.warn("tf-rotation-invalid", f"a transform of {path} has no rotation (its quaternion is 0); it is left out")
        return
    frame = np.eye(4)
    frame[:3, :3] = rotations_and_scales(parent[None])[0][0]
    frame[:3, 3] = parent[:3, 3]
    relative = np.eye(4)
    relative[:3, :3] = _matrix(*(quaternion / length).tolist())
    relative[:3, 3] = np.array([move.x, move.y, move.z]) / db.app.meters_per_unit
    pose = frame @ relative
    try:
        db.app.fabric.set_world_matrix(path, pose)
    except RunError as error:
        db.warn("tf-prim-held", f"it cannot follow the transforms: {error}")
        return
    memory, app = db.memory, db.app
    if app.physics is not None and path in app.physics.body_paths:
        memory.placed[path] = pose
        if memory.stop_holding is None:
            memory.stop_holding = app.on("physics_post_step", lambda: _hold(app.fabric, memory.placed))


def _hold(fabric: Any, placed: dict[str, Any]) -> None:
    for path, pose in placed.items():
        fabric.set_world_matrix(path, pose)


def _matrix(w: float, x: float, y: float, z: float) -> list[list[float]]:
    """The rotation matrix of a unit quaternion."""
    return [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
