"""What all publishers share: inputs, topic, and the rule that no message is made without a listener."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from functools import wraps
from typing import TYPE_CHECKING, Any

from graph.base.records import dataclass
from graph.node import Attribute, Database, NodeAtLoad
from graph.sim.messages.message import DEFAULT, Quality
from nodes.isaac.clocks import stamp_ns

from .profiles import offered_quality

if TYPE_CHECKING:
    from graph.node.declaration import Compute

NAMESPACE_ATTRIBUTE = "isaac:namespace"


def publisher_inputs(topic: str, *, frame_id: str | None = None) -> dict[str, Attribute]:
    """The inputs that all publishers have, with this node type's default topic (and frame)."""
    frame = (
        {}
        if frame_id is None
        else {"frameId": Attribute("string", "frame of the message's header", default=frame_id, role="frame")}
    )
    return {
        "context": Attribute("uint64", "a ROS2Context; 0 is the default context", default=0),
        "nodeNamespace": Attribute(
            "string", "put before the topic; empty takes the isaac:namespace of the prims above", default=""
        ),
        **frame,
        "topicName": Attribute(
            "string", "topic; one that begins with / ignores the namespace", default=topic, role="topic"
        ),
        "qosProfile": Attribute(
            "string", "quality of service that recordings note beside the topic; they keep everything", default=""
        ),
        "queueSize": Attribute(
            "uint64", "queue length that recordings note; they keep everything", default=10, unit="messages"
        ),
    }


TIME_STAMP = Attribute("double", "stamp of the message", default=0.0, unit="s", role="stamp")


def stamped_inputs(topic: str, *, frame_id: str | None = None) -> dict[str, Attribute]:
    """The inputs of a publisher of stamped messages, as in `publisher_inputs`: execIn first, timeStamp last."""
    execution = Attribute("execution", "publishes")
    return {"execIn": execution, **publisher_inputs(topic, frame_id=frame_id), "timeStamp": TIME_STAMP}


@dataclass(slots=True)
class Publisher:
    """Memory of a publishing node: the type of its messages, the topic it announced, the quality it offers."""

    type_name: str = ""
    topic: str = ""
    quality: Quality = DEFAULT

    def is_idle(self, db: Database) -> bool:
        """Whether nobody would get a message of the node."""
        bus = db.app.bus
        if bus.has_subscribers():
            return False
        if not self.topic and "topicName" not in db.node.type.inputs:
            return False
        topic = self.topic or planned_topic(db, db.path)
        return topic is not None and not bus.has_subscribers(topic)


def subscribed_topic(db: Database, name: str | None = None, *, latched: bool = False) -> str | None:
    """The node's absolute topic if it has a listener, else None; announces the topic at the first compute.

    name: the topic to use instead of the input topicName. latched: late subscribers get the last message.
    """
    memory = db.memory
    bus = db.app.bus
    if not memory.topic:
        memory.topic = topic_name(db, db.path, name)
        memory.quality = offered_quality(db, latched=latched)
        bus.advertise(memory.topic, memory.type_name, db.path, memory.quality)
    topic: str = memory.topic
    return topic if bus.has_subscribers(topic) else None


def publishes(make: Callable[[Database, int], Any]) -> Compute:
    """The compute function of a publisher from `make(db, stamp)`, which returns its message.

    It is called only while the topic has a listener. stamp: that of timeStamp [ns]. None: nothing is sent.
    """

    @wraps(make)
    def compute(db: Database) -> bool:
        topic = subscribed_topic(db)
        if topic is None:
            return False
        nanoseconds = stamp_ns(db.app, db.inputs.timeStamp)
        message = make(db, nanoseconds)
        if message is None:
            return False
        db.app.bus.publish(topic, db.memory.type_name, message, nanoseconds)
        return True

    return compute


_TOPIC = re.compile(r"(/[A-Za-z_][A-Za-z0-9_]*)+")
"""The form of a topic (https://design.ros2.org/articles/topic_and_service_names.html)."""


def topic_name(db: Database, below: str, name: str | None = None) -> str:
    """The absolute topic of a publishing node; `below`: the path whose ancestors may carry isaac:namespace.

    name: the topic to use instead of the input topicName. Fails the node if the result is not a valid topic.
    """
    name, namespace = _name_and_namespace(db, below, name)
    if problem := topic_problem(name, namespace):
        db.fail(problem)
    return absolute_topic(name, namespace)


def planned_topic(db: Database, below: str, name: str | None = None) -> str | None:
    """The topic that a node will publish on, by its present inputs; None if they do not give a valid topic."""
    name, namespace = _name_and_namespace(db, below, name)
    return None if topic_problem(name, namespace) else absolute_topic(name, namespace)


def _name_and_namespace(db: Database, below: str, name: str | None) -> tuple[str, str]:
    name = (getattr(db.inputs, "topicName", "") if name is None else name).strip()
    if name.startswith("/"):
        return name, ""
    return name, getattr(db.inputs, "nodeNamespace", "") or collect_namespace(db.app.stage, below)


def absolute_topic(name: str, namespace: str = "") -> str:
    """An absolute topic; a topic that begins with / ignores the namespace."""
    if name.startswith("/"):
        return "/" + name.strip("/")
    return "/" + "/".join(part.strip("/") for part in (namespace, name) if part.strip("/"))


def topic_problem(name: str, namespace: str = "") -> str | None:
    """Why a name is not a valid topic, as one line, or None."""
    if not name.strip().strip("/"):
        return "input topicName is empty; give it a topic"
    topic = absolute_topic(name.strip(), namespace)
    if _TOPIC.fullmatch(topic):
        return None
    return f"{topic!r} is not a ROS 2 topic name; its parts are letters, digits and _, and start with no digit"


def namespace_problem(namespace: str) -> str | None:
    """Why a namespace is not valid, as one line, or None."""
    below = absolute_topic("topic", namespace)
    if _TOPIC.fullmatch(below):
        return None
    return f"{namespace!r} is not a ROS 2 namespace; its parts are letters, digits and _, and start with no digit"


def check_names(node: NodeAtLoad) -> Iterator[tuple[str, str]]:
    """The topics and namespaces of a node in a file that ROS 2 does not allow: input, what is wrong."""
    inputs = node.db.inputs
    for name in node.given:
        problem = None
        if name.lower().endswith("topicname"):
            problem = topic_problem(str(getattr(inputs, name)))
        elif name == "nodeNamespace" and _uses_namespace(node.db):
            problem = namespace_problem(str(inputs.nodeNamespace))
        if problem:
            yield name, problem


def _uses_namespace(db: Database) -> bool:
    """Whether any topic or service of the node has a name that does not begin with /."""
    names = [name for name in db.node.type.inputs if name.lower().endswith(("topicname", "servicename"))]
    return any(db.connected(f"inputs:{name}") or not str(getattr(db.inputs, name)).startswith("/") for name in names)


def collect_namespace(stage: Any, path: str) -> str:
    """The isaac:namespace values of the prim at `path` and of those above it, outermost first, joined with /."""
    parts: list[str] = []
    while path.strip("/"):
        prim = stage.GetPrimAtPath(path)
        value = prim.GetAttribute(NAMESPACE_ATTRIBUTE).Get() if prim else None
        if value:
            parts.insert(0, str(value).strip("/"))
        path = path.rpartition("/")[0]
    return "/".join(parts)
