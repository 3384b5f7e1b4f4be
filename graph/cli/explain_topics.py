"""The topics of a graph file and their publishers, announced or expected."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from graph.evaluate import Node
    from graph.session.open import Session
    from graph.sim.messages.bus import MessageBus


TIES = frozenset({"nav_msgs/msg/Odometry"})
"""Message types that say themselves where their frame is."""
SHARED = frozenset({"tf2_msgs/msg/TFMessage"})
"""Message types whose topics are made for several publishers: each message says what it is about."""


def shared_topics(bus: MessageBus) -> Iterator[tuple[str, str, str]]:
    """The warnings of `shared` about the topics of a run."""
    for topic in bus.topics.values():
        yield from shared(topic.name, topic.type_name, topic.owners)


def shared(topic: str, type_name: str, publishers: Sequence[str]) -> Iterator[tuple[str, str, str]]:
    """Code, where and message of a warning if several nodes publish on a topic that subscribers take for one's own."""
    if type_name not in SHARED and len(publishers) > 1:
        yield (
            "topic-shared",
            topic,
            f"{', '.join(publishers)} publish on it, and a subscriber cannot tell their messages apart; give each its "
            "own topic name",
        )


def topic_facts(session: Session) -> list[dict[str, Any]]:
    """The topics announced so far, and those of publishers that have not computed yet (type None if not known)."""
    bus = session.app.bus
    found: dict[str, tuple[str | None, list[str]]] = {
        topic.name: (topic.type_name, list(topic.owners)) for topic in bus.topics.values()
    }
    known = {owner for _, owners in found.values() for owner in owners}
    for topic, publishers in planned_topics(session).items():
        for path in (one for one in publishers if one not in known):
            found.setdefault(topic, (publishers[path] or None, []))[1].append(path)
    return [
        {"topic": name, "type": type_name, "publishers": owners, "heard_in_file": bus.is_listened_to(name)}
        for name, (type_name, owners) in found.items()
    ]


def planned_topics(session: Session) -> dict[str, dict[str, str]]:
    """Topic to its publishers (node paths) to the types of their messages, as inputs stand; "" for an unknown type."""
    from nodes.ros2.publishing import planned_topic

    found: dict[str, dict[str, str]] = {}
    for node in (node for graph in session.runner.graphs.values() for node in graph.nodes.values()):
        if disabled(node):
            continue
        below = next(iter(sensors_behind(node)), node.path)
        for name, kind in _sent(node).items():
            # A name that makes no topic is a problem of the file, or the run tells of it.
            if topic := planned_topic(node.db, below, str(node.get(name))):
                found.setdefault(topic, {})[node.path] = kind
    return found


def disabled(node: Node) -> bool:
    """Whether the file switches a node off."""
    return "enabled" in node.type.inputs and not node.connected("enabled") and node.get("enabled") is False


def sensors_behind(node: Node) -> list[str]:
    """The sensor prims whose render products are connected to a node."""
    if not any(map(node.connected, node.type.inputs_as("product"))):
        return []
    return [
        str(path) for maker in node.sources for name in maker.type.inputs_as("sensor") for path in maker.get(name) or ()
    ]


def _sent(node: Node) -> dict[str, str]:
    """The inputs that name topics of a node, with the type of the messages on each."""
    further = node.type.further_topics
    return dict.fromkeys(node.type.inputs_as("topic"), _message_type(node)) | dict(further(node.db) if further else {})


def named_frames(session: Session, nodes: Iterable[Node]) -> Iterator[tuple[str, str, str]]:
    """Topic, node path and frame of each publisher whose headers name a frame that the file writes.

    Without those that say where their frame is, and without sensors that give points in another frame than their own.
    """
    from nodes.ros2.publishing import planned_topic

    stage = session.app.stage
    for node in nodes:
        if not _sends(node) or _message_type(node) in TIES | SHARED:
            continue
        sensors = sensors_behind(node)
        topic = planned_topic(node.db, next(iter(sensors), node.path))
        for name in node.type.inputs_as("frame"):
            if topic and not node.connected(name) and not any(_elsewhere(stage, path) for path in sensors):
                yield topic, node.path, str(node.get(name))


def _sends(node: Node) -> bool:
    """Whether a node publishes on a topic, is not switched off, and something starts it."""
    starts = [name for name, attribute in node.type.inputs.items() if attribute.is_execution]
    by_frames = node.graph.pipeline_stage == "post_render"
    started = not starts or by_frames or any(map(node.connected, starts))
    return bool(node.type.inputs_as("topic")) and not disabled(node) and started


def _elsewhere(stage: Any, path: str) -> bool:
    """Whether a sensor gives its points in the world or in a frame of the user's."""
    prim = stage.GetPrimAtPath(path)
    return bool(prim) and any(
        attribute.GetName().endswith(":outputFrameOfReference") and attribute.Get() not in (None, "SENSOR")
        for attribute in prim.GetAuthoredAttributes()
    )


def placed_frames(nodes: Iterable[Node]) -> set[str] | None:
    """The frames that the transforms of these nodes will connect; None if they are known only in a run."""
    found: set[str] = set()
    for node in nodes:
        if _sends(node) and _message_type(node) in SHARED:
            frames = node.type.frames(node.db) if node.type.frames is not None else None
            if frames is None:
                return None
            found.update(frames)
    return found


def _message_type(node: Node) -> str:
    told = node.type.message_type
    return told(node.db) if told is not None else str(getattr(node.db.memory, "type_name", ""))
