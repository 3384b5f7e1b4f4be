"""Publisher and subscriber of any message type: the message's fields are attributes of the node.

    publish: {type: ROS2Publisher, inputs: {messagePackage: geometry_msgs, messageName: Point, x: 1.5}}

A field inside a field is named `linear:x`; strings are tokens; a list of messages is a token[] of JSON texts.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from graph.base.records import dataclass
from graph.node import Attribute, Database, KnownTypes, node_type

from .any_fields import FIELD, Fields, check_type, field_types, planned_type, required_type, type_inputs, type_name
from .publishing import Publisher, publisher_inputs, subscribed_topic
from .subscribing import EXEC_OUT, Subscriber, next_message, subscriber_inputs, unsubscribe


@dataclass(slots=True)
class _AnyPublisher(Publisher):
    fields: Fields | None = None
    names: Any = None
    """The node's attributes that the fields were looked up for; an edit gives it others."""


def _input_types(known: KnownTypes) -> Mapping[str, str]:
    name = type_name(known.value)
    return field_types(known, {"inputs:": name}) if name else {}


@node_type(
    "isaacsim.ros2.bridge.ROS2Publisher",
    version=1,
    needs=(("messagePackage",), ("messageName",)),
    check=check_type,
    message_type=planned_type,
    inputs={
        "execIn": Attribute("execution", "publishes"),
        **publisher_inputs("topic"),
        **type_inputs("msg"),
    },
    outputs={"execOut": Attribute("execution", "the message was published")},
    dynamic_inputs={"{field}": FIELD},
    resolve=_input_types,
    memory=_AnyPublisher,
)
def publish_any(db: Database) -> bool:
    """Publish a message of any type: its fields are the inputs that the file adds; missing fields are zero or empty."""
    memory = db.memory
    if memory.names is not db.node.names:
        memory.names = db.node.names
        memory.type_name = required_type(db)
        memory.fields = Fields(memory.type_name, db.dynamic_input_names())
    fields = memory.fields
    topic = subscribed_topic(db)
    if topic is None:
        return False
    db.app.bus.publish(topic, fields.message, fields.read(db), _now(db))
    db.fire("execOut")
    return True


def _now(db: Database) -> int:
    from graph.base.exact import nanoseconds

    return nanoseconds(db.app.simulation.time)


@dataclass(slots=True)
class _AnySubscriber(Subscriber):
    fields: Fields | None = None
    names: Any = None
    """The node's attributes that the fields were looked up for; an edit gives it others."""


def _output_types(known: KnownTypes) -> Mapping[str, str]:
    name = type_name(known.value)
    return field_types(known, {"outputs:": name}) if name else {}


@node_type(
    "isaacsim.ros2.bridge.ROS2Subscriber",
    version=1,
    needs=(("messagePackage",), ("messageName",)),
    check=check_type,
    inputs={**subscriber_inputs("topic"), **type_inputs("msg")},
    outputs={"execOut": EXEC_OUT},
    dynamic_outputs={"{field}": FIELD},
    resolve=_output_types,
    memory=_AnySubscriber,
    release=unsubscribe,
)
def subscribe_any(db: Database) -> bool:
    """Receive a message of any type: its fields are the outputs that the file connects."""
    memory = db.memory
    if memory.names is not db.node.names:
        memory.names = db.node.names
        memory.fields = Fields(required_type(db), db.dynamic_outputs(""))
    message = next_message(db, memory.fields.message)
    if message is None:
        return False
    memory.fields.write(db, message)
    db.fire("execOut")
    return True
