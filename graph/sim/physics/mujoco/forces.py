"""Forces of the engine's last step: along joints, through joints, at contacts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from graph.sim.physics.protocol import Contacts
from graph.sim.transforms import Floats

from .library import mujoco

if TYPE_CHECKING:
    from graph.sim.physics.world_model import Joint

    from .engine import MujocoEngine

_LIMIT = int(mujoco.mjtConstraint.mjCNSTR_LIMIT_JOINT)


def joint_efforts(physics: MujocoEngine) -> Floats:
    """(nv,) effort along each coordinate of velocity [N or N m]: drives, applied efforts and joint limits."""
    data = physics.data
    out: Floats = data.qfrc_actuator + data.qfrc_applied
    for row in np.flatnonzero(data.efc_type[: data.nefc] == _LIMIT):
        coordinate = physics.model.jnt_dofadr[data.efc_id[row]]
        out[coordinate] += data.efc_force[row] * _slope(physics, int(row), int(coordinate))
    return out


def _slope(physics: MujocoEngine, row: int, coordinate: int) -> float:
    """How a constraint row changes with one coordinate of velocity."""
    data = physics.data
    if not mujoco.mj_isSparse(physics.model):
        return float(data.efc_J.reshape(-1, physics.model.nv)[row, coordinate])
    start, count = data.efc_J_rowadr[row], data.efc_J_rownnz[row]
    columns = data.efc_J_colind[start : start + count]
    return float(data.efc_J[start : start + count][columns == coordinate].sum())


def joint_reactions(physics: MujocoEngine, joints: Sequence[Joint]) -> Floats:
    """(n, 6) force [N], then torque [N m], that each joint passes on to its second body.

    Torques are about the origin of the joint's frame on that body; both are along its axes.
    """
    model, data = physics.model, physics.data
    mujoco.mj_rnePostConstraint(model, data)
    out = np.zeros((len(joints), 6))
    for number, joint in enumerate(joints):
        child = int(model.jnt_bodyid[model.joint(joint.model_name).id])
        frame = joint.frames[1]
        place, turn = frame[:3, 3], frame[:3, :3]
        if joint.bodies[1] is not None:
            body = physics.body_paths.index(joint.bodies[1])
            place = physics.positions[body] + physics.rotations[body] @ place
            turn = physics.rotations[body] @ turn
        torque, force = data.cfrc_int[child, :3], data.cfrc_int[child, 3:]
        moved = torque + np.cross(data.subtree_com[model.body_rootid[child]] - place, force)
        sign = 1.0 if physics.body_paths[child - 1] == joint.bodies[1] else -1.0
        out[number, :3], out[number, 3:] = sign * force @ turn, sign * moved @ turn
    return out


def contacts_of(physics: MujocoEngine) -> Contacts:
    """The contacts with forces in the last step."""
    model, data = physics.model, physics.data
    contacts = data.contact
    active = np.flatnonzero(np.asarray(contacts.efc_address)[: data.ncon] >= 0)
    wrenches = np.zeros((len(active), 6))
    for row, index in enumerate(active.tolist()):
        mujoco.mj_contactForce(model, data, index, wrenches[row])
    frames = np.asarray(contacts.frame)[active].reshape(-1, 3, 3)
    geoms, flexes = np.asarray(contacts.geom)[active].tolist(), np.asarray(contacts.flex)[active].tolist()
    known = physics.colliders
    sides = [
        [known[one] if one >= 0 else (model.flex(soft).name, "") for one, soft in zip(geom, flex, strict=True)]
        for geom, flex in zip(geoms, flexes, strict=True)
    ]
    return Contacts(
        tuple((first[0], second[0]) for first, second in sides),
        tuple((first[1], second[1]) for first, second in sides),
        np.asarray(contacts.pos)[active].copy(),
        frames[:, 0].copy(),
        np.asarray(contacts.dist)[active].copy(),
        np.einsum("ni,nij->nj", wrenches[:, :3], frames),
        float(model.opt.timestep),
    )


def colliders_of(model: Any, body_paths: Sequence[str], known: Mapping[int, str]) -> list[tuple[str, str]]:
    """For each geom, the paths of its collider and of its body (empty: static). known: paths of geoms by number."""
    out = []
    for geom, body in enumerate(model.geom_bodyid.tolist()):
        path = known.get(geom) or model.geom(geom).name.rpartition("#")[0]
        out.append((path, body_paths[body - 1] if 0 < body <= len(body_paths) else ""))
    return out
