"""Contact reports of `omni.physx`: after each physics step, what touches the bodies that ask for it, in stage units."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from typing import Any

import numpy as np

from graph.isaac.session import app
from graph.sim.physics.protocol import Contacts

from .carb import Float3
from .own_schemas import applied
from .physics_scripts import sdfPathToInt

__all__ = ["ContactData", "ContactDataVector", "ContactEventHeader", "ContactEventHeaderVector", "ContactEventType"]
Pair = tuple[str, str]
API = "PhysxContactReportAPI"
THRESHOLD, OTHERS = "physxContactReport:threshold", "physxContactReport:reportPairs"
DEFAULT_THRESHOLD = 1.0
"""The least force [kg * stage units / s2] that is reported, unless the prim says otherwise."""


class ContactEventType(Enum):
    CONTACT_FOUND = 0
    CONTACT_LOST = 1
    CONTACT_PERSIST = 2


@dataclass(frozen=True)
class ContactData:
    """A contact: position, normal towards the first collider, impulse on it, gap between the two (negative: depth)."""

    position: Any
    normal: Any
    impulse: Any
    separation: float
    face_index0: int = 0
    face_index1: int = 0
    material0: int = 0
    material1: int = 0


@dataclass(frozen=True)
class ContactEventHeader:
    """Two colliders and their bodies, as numbers of paths, and which of the contacts are theirs."""

    type: ContactEventType
    actor0: int
    actor1: int
    collider0: int
    collider1: int
    contact_data_offset: int
    num_contact_data: int
    stage_id: int = 0
    proto_index0: int = 0xFFFFFFFF
    proto_index1: int = 0xFFFFFFFF
    friction_anchors_offset: int = 0
    num_friction_anchors_data: int = 0


ContactEventHeaderVector = list[ContactEventHeader]
ContactDataVector = list[ContactData]


class Reports:
    """The reports of one subscription: it remembers which pairs touched in the step before."""

    def __init__(self, tell: Callable[..., Any], *, full: bool = False) -> None:
        self._tell, self._full = tell, full
        self._before: dict[Pair, Pair] = {}

    def __call__(self) -> None:
        """Calls the subscriber with what the last step has to report, if anything."""
        physics = app().physics
        headers, data = self.of(physics.contacts() if physics is not None else Contacts())
        if headers:
            self._tell(headers, data, *([[]] if self._full else []))

    def of(self, held: Contacts) -> tuple[list[ContactEventHeader], list[ContactData]]:
        """Headers and contacts. A pair that has parted gets a last header without contacts."""
        unit = app().meters_per_unit
        rows: dict[Pair, list[int]] = {}
        for row, pair in enumerate(held.pairs):
            rows.setdefault(pair, []).append(row)
        headers: list[ContactEventHeader] = []
        data: list[ContactData] = []
        now: dict[Pair, Pair] = {}
        for pair, mine in rows.items():
            first, second = held.bodies[mine[0]]
            actors = first or pair[0], second or pair[1]
            force = float(np.linalg.norm(held.forces[mine].sum(axis=0))) / unit
            if not _asked_for(pair, actors, force):
                continue
            now[pair] = actors
            found = ContactEventType.CONTACT_PERSIST if pair in self._before else ContactEventType.CONTACT_FOUND
            headers.append(_header(found, pair, actors, len(data), len(mine)))
            for row in mine:
                place, impulse = held.positions[row] / unit, -held.impulses[row] / unit
                gap = float(held.distances[row]) / unit
                data.append(ContactData(Float3(*place), Float3(*-held.normals[row]), Float3(*impulse), gap))
        parted = [pair for pair in self._before if pair not in now]
        lost = ContactEventType.CONTACT_LOST
        headers.extend(_header(lost, pair, self._before[pair], len(data), 0) for pair in parted)
        self._before = now
        return headers, data


def _header(kind: ContactEventType, pair: Pair, actors: Pair, offset: int, number: int) -> ContactEventHeader:
    first, second, collider0, collider1 = map(sdfPathToInt, (*actors, *pair))
    return ContactEventHeader(kind, first, second, collider0, collider1, offset, number)


def _asked_for(pair: Pair, actors: Pair, force: float) -> bool:
    """Whether one of the two has a contact report that takes such a force from the other."""
    stage = app().stage
    for mine, others in ((0, (actors[1], pair[1])), (1, (actors[0], pair[0]))):
        prim = stage.GetPrimAtPath(actors[mine])
        if not prim or API not in applied(prim):
            continue
        least, targets = prim.GetAttribute(THRESHOLD), prim.GetRelationship(OTHERS)
        chosen = targets.GetTargets() if targets else []
        if chosen and not any(str(one) in others for one in chosen):
            continue
        if force >= (least.Get() if least and least.Get() is not None else DEFAULT_THRESHOLD):
            return True
    return False
