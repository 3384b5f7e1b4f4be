"""Events of colliders that meet: contacts of bodies, and what enters a trigger."""

from __future__ import annotations

from collections import deque
from typing import Any

from graph.base.records import dataclass, field
from graph.node import Attribute, Database, node_type

FOUND, PERSISTS, LOST = "foundExecOut", "persistsExecOut", "lostExecOut"


@dataclass(slots=True)
class _Touching:
    """The pairs (input body, other body) of the last evaluation, and the events that are still to be fired."""

    pairs: dict[tuple[str, str], None] = field(default_factory=dict)
    waiting: deque[tuple[str, str, str]] = field(default_factory=deque)


@node_type(
    "omni.physx.graph.OnContactEventBasic",
    version=1,
    event=True,
    inputs={
        "bodyPaths": Attribute("token[]", "the bodies to watch", default=[], literal_only=True),
        "targetBodies": Attribute("target", "further bodies to watch", optional=True, literal_only=True),
    },
    outputs={
        FOUND: Attribute("execution", "fires when a contact begins"),
        PERSISTS: Attribute("execution", "fires in each evaluation in which it goes on"),
        LOST: Attribute("execution", "fires when it ends"),
        "inputBody": Attribute("token", "the watched body"),
        "contactingBody": Attribute("token", "what it touches: a body, or a static collider"),
    },
    memory=_Touching,
)
def on_contact_event(db: Database) -> bool:
    """Fire for each pair of a watched body and another in contact, once an evaluation; every body reports here.

    Contacts are those with a force in the newest physics step. Several events of an evaluation follow each other.
    """
    memory: _Touching = db.memory
    if not db.returned:
        now = _pairs(db)
        memory.waiting.clear()
        memory.waiting.extend((FOUND if pair not in memory.pairs else PERSISTS, *pair) for pair in now)
        memory.waiting.extend((LOST, *pair) for pair in memory.pairs if pair not in now)
        memory.pairs = now
    if not memory.waiting:
        return False
    output, db.outputs.inputBody, db.outputs.contactingBody = memory.waiting.popleft()
    (db.fire_and_return if memory.waiting else db.fire)(output)
    return True


def _pairs(db: Database) -> dict[tuple[str, str], None]:
    """The pairs in contact now: watched body and the other, in the order of the contacts."""
    physics = None if db.app.timeline.is_stopped() else db.app.physics
    if physics is None:
        return {}
    watched = {str(path) for path in (*db.inputs.bodyPaths, *(db.inputs.targetBodies or ()))}
    found: dict[tuple[str, str], None] = {}
    contacts: Any = physics.contacts()
    for bodies, colliders in zip(contacts.bodies, contacts.pairs, strict=True):
        one, other = (body or collider for body, collider in zip(bodies, colliders, strict=True))
        if one in watched:
            found[one, other] = None
        if other in watched:
            found[other, one] = None
    return found


@dataclass(slots=True)
class _Inside:
    """The pairs (trigger, collider inside) of the last evaluation, and the events that are still to be fired."""

    pairs: dict[tuple[str, str], None] = field(default_factory=dict)
    waiting: deque[tuple[str, str, str]] = field(default_factory=deque)


@node_type(
    "omni.physx.graph.OnTriggerCollider",
    version=1,
    event=True,
    inputs={
        "listenToAllTriggers": Attribute("bool", "watch every trigger of the stage", default=False, literal_only=True),
        "triggersPaths": Attribute("token[]", "the triggers to watch", default=[], literal_only=True),
        "triggersRelationships": Attribute("target", "further triggers to watch", optional=True, literal_only=True),
    },
    outputs={
        "enterExecOut": Attribute("execution", "fires when a collider enters"),
        "leaveExecOut": Attribute("execution", "fires when it has left"),
        "otherBody": Attribute("token", "the body that entered or left; empty for a static collider"),
        "otherCollider": Attribute("token", "its collider"),
        "triggerBody": Attribute("token", "the trigger's body; empty for a static one"),
        "triggerCollider": Attribute("token", "the trigger"),
    },
    memory=_Inside,
)
def on_trigger_collider(db: Database) -> bool:
    """Fire for each collider that enters or leaves a trigger, a collider with PhysxTriggerAPI.

    What is inside at play enters in the first evaluation. Several events of an evaluation follow each other.
    """
    memory: _Inside = db.memory
    if not db.returned:
        now = _inside(db)
        memory.waiting.clear()
        memory.waiting.extend(("enterExecOut", *pair) for pair in now if pair not in memory.pairs)
        memory.waiting.extend(("leaveExecOut", *pair) for pair in memory.pairs if pair not in now)
        memory.pairs = now
    if not memory.waiting:
        return False
    outputs = db.outputs
    output, outputs.triggerCollider, outputs.otherCollider = memory.waiting.popleft()
    outputs.triggerBody = _body(db, outputs.triggerCollider)
    outputs.otherBody = _body(db, outputs.otherCollider)
    (db.fire_and_return if memory.waiting else db.fire)(output)
    return True


def _body(db: Database, path: str) -> str:
    """The rigid body of a collider; "" for a static one."""
    prim = db.app.stage.GetPrimAtPath(path)
    while prim and "PhysicsRigidBodyAPI" not in prim.GetAppliedSchemas():
        prim = prim.GetParent()
    return str(prim.GetPath()) if prim else ""


def _inside(db: Database) -> dict[tuple[str, str], None]:
    """The pairs of a watched trigger and a collider in it now."""
    inputs = db.inputs
    physics = None if db.app.timeline.is_stopped() else db.app.physics
    if physics is None:
        return {}
    watched = {str(path) for path in (*inputs.triggersPaths, *(inputs.triggersRelationships or ()))}
    return {
        (trigger, collider): None
        for trigger, colliders in physics.triggered().items()
        if inputs.listenToAllTriggers or trigger in watched
        for collider in colliders
    }
