"""World axes along or about which a body must not move, as a joint between the world and the body."""

from __future__ import annotations

import numpy as np

from graph.sim import transforms
from graph.sim.scene.scan import Scan
from graph.sim.transforms import Floats

from .attributes import value_of
from .authored_settings import StoredSettings
from .d6_joints import Axis, single_joints
from .world_model import Body, Joint

SUFFIX = "#locked"
"""Suffix of a body's path that gives the path of the joint for its locks."""

POSITION, ROTATION = "physxRigidBody:lockedPosAxis", "physxRigidBody:lockedRotAxis"


def read_locks(scan: Scan, bodies: tuple[Body, ...], joints: tuple[Joint, ...], stored: StoredSettings) -> list[Joint]:
    """The joints of bodies with locked axes; what cannot be had is noted in `stored`.

    A locked body keeps its origin, not its centre of mass, on the axes that stay: they differ only where it may turn.
    """
    tied = {path for joint in joints for path in joint.bodies if path}
    out = []
    for body in bodies:
        prim = scan.bodies[body.path].prim
        place, turn = (int(value_of(prim, name) or 0) & 7 for name in (POSITION, ROTATION))
        if not place and not turn:
            continue
        why = ""
        if body.kinematic:
            why = "a kinematic body moves as it is told; write other transforms"
        elif body.path in tied:
            why = "a joint holds this body; lock axes by the limits of its joints"
        if why:
            for name, mask in ((POSITION, place), (ROTATION, turn)):
                if mask:
                    stored.add(body.path, name, why)
            continue
        if turn in (1, 2, 4):
            stored.add(body.path, ROTATION, "one axis of rotation cannot be locked alone; lock two, or all three")
            turn = 0
        if place or turn:
            out.append(_locked(scan, body, place, turn))
    return out


def _locked(scan: Scan, body: Body, place: int, turn: int) -> Joint:
    """Slides along the world's axes that are free, then a turn about the free one, or about all.

    The frames depend only on what the locks keep, so that a joint made later measures the same positions.
    """
    free_turns = [axis for axis in range(3) if not turn >> axis & 1]
    frame = np.eye(4)
    rotation = body.pose[:3, :3]
    frame[:3, :3] = _onto(free_turns[0], rotation.T[:, free_turns[0]]) if len(free_turns) == 1 else rotation.T
    base = np.eye(4)
    base[:3, 3] = [body.pose[axis, 3] if place >> axis & 1 else 0.0 for axis in range(3)]
    whole = Joint(f"{body.path}{SUFFIX}", "d6", (None, body.path), (base, frame), collide=True)
    axes = [Axis(axis) for axis in range(3) if not place >> axis & 1]
    axes += [Axis(3 + free_turns[0])] if len(free_turns) == 1 else []
    dofs = single_joints(scan, whole, axes)
    if len(free_turns) == 3:
        ball = np.eye(4)
        ball[:3, 3] = body.pose[:3, 3]
        dofs += (Joint(f"{whole.path}:rot", "spherical", whole.bodies, (ball, frame), collide=True),)
    if not dofs:
        return Joint(whole.path, "fixed", whole.bodies, (body.pose @ frame, frame), collide=True)
    return Joint(whole.path, "d6", whole.bodies, whole.frames, collide=True, dofs=dofs)


def _onto(axis: int, direction: Floats) -> Floats:
    """(3, 3): the least rotation that takes an axis to a unit direction."""
    start = np.eye(3)[axis]
    half = start + direction
    length = float(np.linalg.norm(half))
    if length < 1e-9:  # opposite: half a turn about another axis
        out = -np.eye(3)
        out[(axis + 1) % 3, (axis + 1) % 3] = 1.0
        return out
    half /= length
    quaternion = np.concatenate([[float(start @ half)], np.cross(start, half)])
    return transforms.rotation_matrices(quaternion)
