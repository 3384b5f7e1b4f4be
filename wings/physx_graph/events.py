"""Events of colliders that meet: contacts of bodies, and what enters a trigger."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
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
        "bodyPaths": Attribute("token[]", "the bodies to watch", default=[], literal_only=True, role="prim"),
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
    return {(bodies[0], bodies[1]): None for bodies, _, _, _ in _watched(db, _contacts(db))}


def _contacts(db: Database) -> Any:
    """The contacts of the newest physics step; None while nothing moves."""
    physics = None if db.app.timeline.is_stopped() else db.app.physics
    return None if physics is None else physics.contacts()


Ends = tuple[str, str]


def _watched(db: Database, contacts: Any) -> Iterator[tuple[Ends, Ends, int, float]]:
    """For each contact of a watched body: bodies and colliders, its own first, its row, the sign of the force on it."""
    watched = {str(path) for path in (*db.inputs.bodyPaths, *(db.inputs.targetBodies or ()))}
    pairs = () if contacts is None else zip(contacts.bodies, contacts.pairs, strict=True)
    for row, (bodies, colliders) in enumerate(pairs):
        one, other = (body or collider for body, collider in zip(bodies, colliders, strict=True))
        if one in watched:
            yield (one, other), colliders, row, -1.0
        if other in watched:
            yield (other, one), (colliders[1], colliders[0]), row, 1.0


@dataclass(slots=True)
class _Points:
    """As `_Touching`, of pairs of colliders: for each its bodies, and the rows and signs of its contacts now."""

    pairs: dict[Ends, Ends] = field(default_factory=dict)
    rows: dict[Ends, list[tuple[int, float]]] = field(default_factory=dict)
    contacts: Any = None
    waiting: deque[tuple[str, Ends, Ends]] = field(default_factory=deque)


@node_type(
    "omni.physx.graph.OnContactEventAdvanced",
    version=1,
    event=True,
    inputs={
        "bodyPaths": Attribute("token[]", "the bodies to watch", default=[], literal_only=True, role="prim"),
        "targetBodies": Attribute("target", "further bodies to watch", optional=True, literal_only=True),
    },
    outputs={
        FOUND: Attribute("execution", "fires when two colliders begin to touch"),
        PERSISTS: Attribute("execution", "fires in each evaluation in which they go on"),
        LOST: Attribute("execution", "fires when they end"),
        "inputBody": Attribute("token", "the watched body"),
        "inputBodyCollider": Attribute("token", "its collider"),
        "contactingBody": Attribute("token", "what it touches: a body, or a static collider"),
        "contactingCollider": Attribute("token", "the collider of that"),
        "contactPoints": Attribute("pointf[3][]", "where they touch", default=[], unit="stage units"),
        "contactNormals": Attribute("normalf[3][]", "normals towards the watched body", default=[]),
        "contactDepths": Attribute(
            "float[]", "distances of the surfaces, negative where they overlap", default=[], unit="stage units"
        ),
        "contactImpulses": Attribute("vectorf[3][]", "impulses on the watched body", default=[], unit="N s"),
        "inputBodyFaces": Attribute("int[]", "faces of its collider: -1, unknown", default=[]),
        "contactingFaces": Attribute("int[]", "faces of the other collider: -1, unknown", default=[]),
        "inputBodyMaterials": Attribute("int[]", "materials of its collider: -1, unknown", default=[]),
        "contactingMaterials": Attribute("int[]", "materials of the other collider: -1, unknown", default=[]),
    },
    memory=_Points,
)
def on_contact_event_advanced(db: Database) -> bool:
    """Fire for each pair of colliders, one of a watched body, once an evaluation, with their points of contact.

    Contacts are those with a force in the newest physics step. Several events of an evaluation follow each other; a
    pair that has ended has no points.
    """
    import numpy as np

    memory, outputs = db.memory, db.outputs
    if not db.returned:
        memory.contacts, memory.rows = _contacts(db), {}
        before, memory.pairs = memory.pairs, {}
        for bodies, colliders, row, sign in _watched(db, memory.contacts):
            memory.pairs[colliders] = bodies
            memory.rows.setdefault(colliders, []).append((row, sign))
        now = memory.pairs
        memory.waiting.clear()
        memory.waiting.extend((PERSISTS if one in before else FOUND, one, bodies) for one, bodies in now.items())
        memory.waiting.extend((LOST, one, bodies) for one, bodies in before.items() if one not in now)
    if not memory.waiting:
        return False
    output, colliders, bodies = memory.waiting.popleft()
    outputs.inputBody, outputs.contactingBody = bodies
    outputs.inputBodyCollider, outputs.contactingCollider = colliders
    touched = memory.rows.get(colliders, []) if output != LOST else []
    rows, signs = [row for row, _ in touched], np.array([sign for _, sign in touched]).reshape(-1, 1)
    held, unit = memory.contacts, db.app.meters_per_unit
    empty = np.zeros((0, 3), np.float32)
    outputs.contactPoints = (held.positions[rows] / unit).astype(np.float32) if rows else empty
    outputs.contactNormals = (signs * held.normals[rows]).astype(np.float32) if rows else empty
    outputs.contactImpulses = (signs * held.impulses[rows]).astype(np.float32) if rows else empty
    outputs.contactDepths = (held.distances[rows] / unit).astype(np.float32) if rows else empty[:, 0]
    unknown = np.full(len(rows), -1, np.int32)
    outputs.inputBodyFaces = outputs.contactingFaces = unknown
    outputs.inputBodyMaterials = outputs.contactingMaterials = unknown
    (db.fire_and_return if memory.waiting else db.fire)(output)
    return True


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
        "triggersPaths": Attribute("token[]", "the triggers to watch", default=[], literal_only=True, role="prim"),
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
