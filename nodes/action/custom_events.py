"""Custom events and message-bus events: execution that goes from graph to graph.

An event that is sent in one update is received in the next one: all waiting events, one after another, in the order of
sending, each with its own compute and walk.
"""

from __future__ import annotations

from typing import Any

from graph.node import Attribute, Database, node_type
from graph.node.attribute_names import python_name
from graph.values.coercion import coerce
from graph.values.types import concrete_type

from .events import ONLY_PLAYBACK
from .inboxes import Listening, close_inbox, deliver, next_event

CUSTOM, MESSAGE = "custom:", "message:"
LITERAL_NAME = Attribute("token", "name of the event", default="", literal_only=True)


@node_type(
    "omni.graph.action.SendCustomEvent",
    version=2,
    inputs={
        "bundle": Attribute("bundle", "data that goes with the event"),
        "eventName": Attribute("token", "name of the event", default=""),
        "execIn": Attribute("execution", "sends the event"),
        "path": Attribute("token", "a path that goes with the event", default=""),
    },
    outputs={"execOut": Attribute("execution", "follows once the event is on its way")},
)
def send_custom_event(db: Database) -> None:
    """Send an event to every OnCustomEvent of that name, in any graph; it arrives in the next update."""
    inputs = db.inputs
    payload = {"path": inputs.path, "bundle": dict(inputs.bundle or {})}
    db.context.events.send(CUSTOM + inputs.eventName, payload, update=db.context.update, by_node=True)
    db.fire("execOut")


@node_type(
    "omni.graph.action.OnCustomEvent",
    version=3,
    event=True,
    inputs={"eventName": LITERAL_NAME, "onlyPlayback": ONLY_PLAYBACK},
    outputs={
        "bundle": Attribute("bundle", "data that came with the event"),
        "execOut": Attribute("execution", "fires once for each event, one after another"),
        "path": Attribute("token", "the path that came with the event"),
    },
    memory=Listening,
    release=close_inbox,
)
def on_custom_event(db: Database) -> bool:
    """Fire for every custom event of that name, one after another, in the order of sending."""
    event = next_event(db, CUSTOM + db.inputs.eventName)
    if event is None:
        return False
    db.outputs.path = str(event.payload.get("path", ""))
    db.outputs.bundle = dict(event.payload.get("bundle", {}))
    deliver(db)
    return True


@node_type(
    "omni.graph.action.SendMessageBusEvent",
    version=1,
    inputs={"eventName": LITERAL_NAME, "execIn": Attribute("execution", "sends the event")},
    dynamic_inputs={"{x}": Attribute("any", "an entry of the payload, under the attribute's name")},
    outputs={"execOut": Attribute("execution", "follows once the event is on its way")},
)
def send_message_bus_event(db: Database) -> None:
    """Send an event with a payload: the inputs that the file adds, by name. It arrives in the next update."""
    names = db.dynamic_input_names()
    payload = dict(zip(names, db.dynamic_inputs(), strict=True))
    db.context.events.send(MESSAGE + db.inputs.eventName, payload, update=db.context.update, by_node=True)
    db.fire("execOut")


@node_type(
    "omni.graph.action.OnMessageBusEvent",
    version=2,
    event=True,
    inputs={"eventName": LITERAL_NAME, "onlyPlayback": ONLY_PLAYBACK},
    outputs={"execOut": Attribute("execution", "fires once for each event, one after another")},
    dynamic_outputs={"{x}": Attribute("any", "the entry of that name of the event's payload")},
    memory=Listening,
    release=close_inbox,
)
def on_message_bus_event(db: Database) -> bool:
    """Fire for every event of that name, one by one; added outputs take the payload's entries of their name."""
    event = next_event(db, MESSAGE + db.inputs.eventName)
    if event is None:
        return False
    for name in db.dynamic_outputs():
        if name in event.payload:
            setattr(db.outputs, python_name(name), _typed(db, name, event.payload[name]))
    deliver(db)
    return True


def _typed(db: Database, name: str, value: Any) -> Any:
    """The entry as a value of the output's type; the node fails if it does not fit."""
    type_name = db.output_type(name)
    if type_name is None:
        return value
    try:
        return coerce(concrete_type(type_name), value)
    except ValueError as error:
        db.fail(f'event "{db.inputs.eventName}", entry {name}: {error}')
