"""What all UCX nodes share: an endpoint, which is a topic of the bus, named by port and tag."""

from __future__ import annotations

from graph.node import Attribute, Database
from nodes.ros2.publishing import subscribed_topic


def endpoint_inputs(port: int, tag: int, *, wide_port: bool = False, timeout: bool = True) -> dict[str, Attribute]:
    """execIn, port, tag and, for most, timeoutMs, with this node type's defaults."""
    waiting = {
        "timeoutMs": Attribute(
            "uint", "how long to wait for the other side; within one run nothing waits", default=0, unit="ms"
        )
    }
    return {
        "execIn": Attribute("execution", "sends, or takes what has come"),
        "port": Attribute("uint64" if wide_port else "uint", "port; part of the topic's name", default=port),
        "tag": Attribute("uint64", "tag of the messages; part of the topic's name", default=tag),
        **(waiting if timeout else {}),
    }


SENT = Attribute("execution", "the message was sent")
TIME_STAMP = Attribute("double", "stamp of the message", default=0.0, unit="s", role="stamp")


def topic_of(db: Database) -> str:
    """The topic of the node's port and tag."""
    return f"/ucx/port_{int(db.inputs.port)}/tag_{int(db.inputs.tag)}"


def listened_topic(db: Database) -> str | None:
    """The node's topic if it has a listener, else None; announces it at the first compute."""
    return subscribed_topic(db, topic_of(db))
