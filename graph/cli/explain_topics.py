"""The topics of a graph file and their publishers, announced or expected."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from graph.evaluate import Node
    from graph.session.open import Session
    from graph.sim.messages.bus import MessageBus


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
        for name in node.type.inputs_as("topic"):
            # A name that makes no topic is a problem of the file, or the run tells of it.
            if topic := planned_topic(node.db, node.path, str(node.get(name))):
                found.setdefault(topic, {})[node.path] = _message_type(node)
    return found


def _message_type(node: Node) -> str:
    told = node.type.message_type
    return told(node.db) if told is not None else str(getattr(node.db.memory, "type_name", ""))
