"""What all subscribers share: inputs, queue, and the rule of one message for each compute.

A subscriber listens from its first compute on, and also gets messages from earlier in that update. Each compute takes
the oldest waiting message, as the original does; a message beyond the queue's length drops the oldest. Outputs keep the
last message; execOut fires only in a compute that took a message.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import TYPE_CHECKING, Any

from graph.base.records import dataclass
from graph.node import Attribute, Database

from .profiles import offered_quality, queue_depth
from .publishing import topic_name

if TYPE_CHECKING:
    from graph.node.declaration import Compute

EXEC_IN = Attribute("execution", "takes the next message, if one has come")
EXEC_OUT = Attribute("execution", "a message was taken")


@dataclass(slots=True)
class Subscriber:
    """Memory of a subscribing node: its queue, and whether it has warned of lost messages."""

    subscription: Any = None
    told: int = 0


def subscriber_inputs(topic: str) -> dict[str, Attribute]:
    """The inputs that all subscribers have, with this node type's default topic."""
    return {
        "execIn": EXEC_IN,
        "context": Attribute("uint64", "a ROS2Context; 0 is the default context", default=0),
        "nodeNamespace": Attribute(
            "string", "put before the topic; empty takes the isaac:namespace of the prims above", default=""
        ),
        "topicName": Attribute("string", "topic; one that begins with / ignores the namespace", default=topic),
        "qosProfile": Attribute(
            "string", "a ROS2QoSProfile's text: its history and depth go before queueSize", default=""
        ),
        "queueSize": Attribute(
            "uint64", "messages that wait; one more pushes the oldest out", default=10, unit="messages"
        ),
    }


def receives(type_name: str) -> Callable[[Callable[[Any, Any], None]], Compute]:
    """The compute function of a subscriber from `write(outputs, message)`, which is called for each message taken."""

    def made(write: Callable[[Any, Any], None]) -> Compute:
        @wraps(write)
        def compute(db: Database) -> bool:
            message = next_message(db, type_name)
            if message is None:
                return False
            write(db.outputs, message)
            db.fire("execOut")
            return True

        return compute

    return made


def next_message(db: Database, type_name: str) -> Any:
    """The oldest waiting message, as its class in the type store, or None. Subscribes at the first call."""
    return take(db, type_name, lambda: topic_name(db, db.path))


def take(db: Database, type_name: str, topic: Any, depth: Any = None) -> Any:
    """As `next_message`, for a node whose topic and queue length come from functions."""
    memory = db.memory
    if memory.subscription is None:
        length = queue_depth(db) if depth is None else depth()
        memory.subscription = db.app.bus.listen(
            topic(), type_name, depth=length, owner=db.path, quality=offered_quality(db)
        )
    subscription = memory.subscription
    if subscription.dropped > memory.told:
        memory.told = subscription.dropped
        db.warn(
            "subscriber-queue-full",
            f"messages on {subscription.topic} came faster than they were taken, the oldest are lost; raise queueSize",
        )
    message = subscription.take()
    return None if message is None else message.message


def unsubscribe(db: Database) -> None:
    """Stops listening; for a node type's `release`."""
    subscription = db.memory.subscription
    if subscription is not None:
        db.app.bus.unlisten(subscription)
        db.memory.subscription = None


def seconds(stamp: Any) -> float:
    """A `builtin_interfaces/Time` in seconds."""
    return float(stamp.sec + stamp.nanosec * 1e-9)
