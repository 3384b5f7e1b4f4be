"""The topics of a graph file and their publishers, announced or expected."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from graph.evaluate import Node
    from graph.session.open import Session
    from graph.sim.messages.bus import MessageBus


OF_ONE_CAMERA = frozenset(f"sensor_msgs/msg/{name}" for name in ("Image", "CompressedImage", "CameraInfo"))
"""Message types whose subscribers take a topic for one camera's."""


def shared_topics(bus: MessageBus) -> Iterator[tuple[str, str, str]]:
    """Code, where and message of a warning for each topic on which several nodes publish pictures or lenses."""
    for topic in bus.topics.values():
        if topic.type_name in OF_ONE_CAMERA and len(topic.owners) > 1:
            who = ", ".join(topic.owners)
            yield (
                "topic-shared",
                topic.name,
                f"{who} publish on it, and a subscriber cannot tell their messages apart; give each a topicName",
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
        for name in node.type.inputs_as("topic"):
            # A name that makes no topic is a problem of the file, or the run tells of it.
            if topic := planned_topic(node.db, node.path, str(node.get(name))):
                found.setdefault(topic, {})[node.path] = _message_type(node)
    return found


def _message_type(node: Node) -> str:
    told = node.type.message_type
    return told(node.db) if told is not None else str(getattr(node.db.memory, "type_name", ""))
