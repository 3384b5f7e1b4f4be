"""The initial state of a model: joints, velocities of bodies, deformables, targets of drives."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from graph.sim.physics.world_model import Joint
from graph.sim.transforms import Floats

from .memory import forward

if TYPE_CHECKING:
    from .engine import MujocoEngine

Velocities = dict[str, tuple[Floats, Floats]]
"""For each body: velocity of its centre of mass [m/s], and its angular velocity [rad/s]; world axes."""


def set_initial_state(engine: MujocoEngine) -> None:
    """Sets the velocities and targets of the world in the engine's data, and everything that depends on them."""
    model, data, compiled = engine.model, engine.data, engine.compiled
    if compiled.start is not None:
        compiled.start(model, data)
    for joint in engine.joints:
        if joint.initial_position is not None:
            data.qpos[model.joint(joint.model_name).qposadr[0]] = joint.initial_position
    engine.forces.step(data)  # with the kinematics
    velocities: Velocities = {}
    for number, body in enumerate(compiled.bodies, start=1):
        if not (body.velocity.any() or body.angular_velocity.any()) or body.kinematic:
            continue
        velocities[body.path] = body.velocity, body.angular_velocity
        if engine.is_free(body.path):
            turn = data.xmat[number].reshape(3, 3)
            arm = data.xipos[number] - data.xpos[number]
            address = model.jnt_dofadr[model.body_jntadr[number]]
            data.qvel[address : address + 3] = body.velocity - np.cross(body.angular_velocity, arm)
            data.qvel[address + 3 : address + 6] = turn.T @ body.angular_velocity
    for joint in engine.joints:
        _start_joint(engine, joint, velocities)
        if joint.initial_velocity is not None:
            data.qvel[model.joint(joint.model_name).dofadr[0]] = joint.initial_velocity
    engine.deformables.start(data)
    engine.drives.apply(data)
    forward(model, data)


def _start_joint(engine: MujocoEngine, joint: Joint, velocities: Velocities) -> None:
    """By the relative motion of the bodies; motion of a centre of mass beyond that also rotates them."""
    model, data = engine.model, engine.data
    first, second = joint.bodies
    if joint.kind == "fixed" or second not in velocities:
        return
    rest = np.zeros(3), np.zeros(3)
    v1, w1 = velocities[second]
    v0, w0 = velocities.get(first or "", rest)
    joint_number, body = model.joint(joint.model_name).id, engine.number(second)
    address = model.jnt_dofadr[joint_number]
    turn = data.xmat[body].reshape(3, 3)
    axis = turn @ joint.frames[1][:3, joint.axis]
    if joint.kind == "prismatic":
        data.qvel[address] = axis @ (v1 - v0)
        return
    arm = data.xipos[body] - data.xanchor[joint_number]
    spin = w1 - w0
    alone = model.body_jntnum[body] == 1
    if alone and first not in velocities and v1.any():  # of a flying pair, the common motion is not the joint's
        missing = v1 - np.cross(w1, arm)
        across = arm if joint.kind == "spherical" else arm - axis * (axis @ arm)
        if across @ across > 1e-12:
            spin = spin + np.cross(across, missing) / (across @ across)
    if joint.kind == "spherical":
        data.qvel[address : address + 3] = turn.T @ spin
    else:
        data.qvel[address] = axis @ spin
