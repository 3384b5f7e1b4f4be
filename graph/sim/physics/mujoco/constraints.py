"""Joints as MuJoCo's joints and constraints: in the tree, closing loops, by distance, mimicking; and excluded pairs."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from graph.sim import transforms
from graph.sim.physics.joint_tree import Branch, Forest
from graph.sim.physics.world_model import Gripper, Joint, Suction, WorldModel
from graph.sim.scene.stage import Warn

from .library import mujoco

_KINDS = {
    "revolute": mujoco.mjtJoint.mjJNT_HINGE,
    "prismatic": mujoco.mjtJoint.mjJNT_SLIDE,
    "spherical": mujoco.mjtJoint.mjJNT_BALL,
}
LEVER = 0.1
"""The distance from a joint's origin [m] at which its axis is tied or its swing measured."""

HARDEST, STOP = (1e-9, 1.0), (0.99, 0.999, 0.001, 0.5, 2.0)
"""How MuJoCo stops a joint at a limit: in the shortest time that it can, two steps (it raises shorter values to that),
almost rigidly.

At a speed v, a joint passes its limit by at most v dt, its way in one step.
"""


def weld_name(point: Suction) -> str:
    """The name of the weld in the model for an attachment point."""
    return f"{point.path}#grip"


def add_joints(handle: Any, branch: Branch, degrees: bool) -> None:
    """Adds the joint by which a body is attached; degrees: whether the spec's angles are in degrees."""
    joint = branch.joint
    if joint is None:
        handle.add_freejoint(name=f"{branch.body.path}#free")
        return
    for single in reversed(joint.singles) if branch.reversed else joint.singles:
        _add_single(handle, single, branch.reversed, degrees)


def _add_single(handle: Any, joint: Joint, backwards: bool, degrees: bool) -> None:
    frame = joint.frames[0 if backwards else 1]
    made = handle.add_joint(name=joint.path, type=_KINDS[joint.kind], pos=frame[:3, 3])
    made.armature = joint.armature
    made.frictionloss = joint.friction
    made.damping[0] = joint.damping
    if joint.kind == "spherical":
        return
    made.axis = frame[:3, joint.axis] * (-1.0 if backwards else 1.0)
    unit = math.degrees(1) if degrees and joint.kind == "revolute" else 1.0
    made.ref = joint.start * unit
    if joint.limited:
        made.limited = mujoco.mjtLimited.mjLIMITED_TRUE
        made.solref_limit, made.solimp_limit = HARDEST, STOP
        made.range = np.clip([joint.lower, max(joint.upper, joint.lower + 1e-9)], -1e9, 1e9) * unit


def add_drive(spec: Any, joint: Joint) -> None:
    """An actuator whose control is a force; `drives` sets its gains, which depend on the time step."""
    actuator = spec.add_actuator(name=joint.path, target=joint.path, trntype=mujoco.mjtTrn.mjTRN_JOINT)
    actuator.gaintype, actuator.biastype = mujoco.mjtGain.mjGAIN_FIXED, mujoco.mjtBias.mjBIAS_AFFINE


def add_ties(spec: Any, world: WorldModel, forest: Forest, handles: Mapping[str, Any], warn: Warn) -> None:
    """Adds all constraints that are not joints of the tree; handles: the spec's bodies by path."""
    given = {body.path: body.model_name for body in world.given}
    for joint in forest.loops:
        if any(single.drive or single.limited for single in joint.singles):
            warn("loop-joint", joint.path, "it closes a loop of joints; its drive and its limits have no effect")
        _add_loop(spec, joint, given, warn)
    for joint in world.joints:
        if joint.kind == "distance" and joint.limited:
            _add_distance(spec, joint, handles, (joint.lower, joint.upper))
        elif joint.kind == "spherical" and math.isfinite(joint.cone):
            _add_cone(spec, joint, handles)
    singles = {single.path: single for branch in forest.branches if branch.joint for single in branch.joint.singles}
    for mimic in world.mimics:
        if mimic.path not in singles or mimic.leader not in singles:
            warn("bad-mimic", mimic.path, f"it cannot follow {mimic.leader}: one of them closes a loop of joints")
            continue
        tie = spec.add_equality(type=mujoco.mjtEq.mjEQ_JOINT, objtype=mujoco.mjtObj.mjOBJ_JOINT)
        tie.name, tie.name1, tie.name2 = f"{mimic.path}#mimic", mimic.path, mimic.leader
        # MuJoCo counts from the initial positions: q - q0 = a0 + a1 (p - p0)
        ahead = mimic.offset + mimic.ratio * singles[mimic.leader].start - singles[mimic.path].start
        tie.data[:5] = [ahead, mimic.ratio, 0, 0, 0]
    names = {path: still_name(path) for path in {collider.still for collider in world.colliders} if path}
    names |= {body.path: body.model_name for body in (*world.bodies, *world.given)}
    for first, second in kept_apart(world):
        if first in names and second in names and spec.body(names[first]) and spec.body(names[second]):
            spec.add_exclude(bodyname1=names[first], bodyname2=names[second])


def still_name(path: str) -> str:
    """The model's name of static geometry from which bodies are kept apart."""
    return f"{path}#still"


def kept_apart(world: WorldModel) -> dict[tuple[str, str], None]:
    """Pairs of bodies (or of a body and static geometry) that never collide, the smaller path first."""
    apart = [joint.bodies for joint in world.joints if not joint.collide] + list(world.filtered)
    return dict.fromkeys((min(a, b), max(a, b)) for a, b in apart if a and b)


def add_grips(spec: Any, world: WorldModel) -> tuple[Gripper, ...]:
    """Adds a weld for each point of a gripper, inactive and between any two bodies until it holds one.

    A single body has nothing to hold, and MuJoCo has no weld of a body to itself: its grippers get a weld to the world.
    """
    bodies = (*world.bodies, *world.given)
    names = {body.path: body.model_name for body in bodies}
    for gripper in world.grippers:
        for point in gripper.points:
            other = next((body.model_name for body in bodies if body.path != point.body), "world")
            weld = spec.add_equality(type=mujoco.mjtEq.mjEQ_WELD, objtype=mujoco.mjtObj.mjOBJ_BODY)
            weld.name, weld.name1, weld.name2, weld.active = weld_name(point), names[point.body], other, False
    return world.grippers


def _add_loop(spec: Any, joint: Joint, given: Mapping[str, str], warn: Warn) -> None:
    """Connects two bodies of one tree: at one point, at two points of an axis, or fully."""
    names = [given.get(body or "world", body or "world") for body in joint.bodies]
    if any(single.kind == "prismatic" for single in joint.singles) or len(joint.singles) == 2:
        warn(
            "joint-not-supported",
            joint.path,
            "it closes a loop of joints that all slide, or have several axes; it is not simulated",
        )
        return
    if joint.kind == "fixed":
        relative = joint.frames[0] @ transforms.inverse_rigid(joint.frames[1])
        weld = spec.add_equality(type=mujoco.mjtEq.mjEQ_WELD, objtype=mujoco.mjtObj.mjOBJ_BODY)
        weld.name, weld.name1, weld.name2 = joint.path, *names
        weld.solref, weld.solimp = HARDEST, STOP
        weld.data[:11] = [0, 0, 0, *relative[:3, 3], *transforms.quaternion(relative[:3, :3]), 1.0]
        return
    hinge = joint.singles[0] if len(joint.singles) == 1 and joint.kind != "spherical" else None
    frame = joint.frames[0] if hinge is None else hinge.frames[0]
    for number, end in enumerate((0.0,) if hinge is None else (-LEVER, LEVER)):
        anchor = frame[:3, 3] + (0.0 if hinge is None else end * frame[:3, hinge.axis])
        tie = spec.add_equality(type=mujoco.mjtEq.mjEQ_CONNECT, objtype=mujoco.mjtObj.mjOBJ_BODY)
        tie.name, tie.name1, tie.name2 = f"{joint.path}#{number}", *names
        tie.solref, tie.solimp = HARDEST, STOP
        tie.data[:3] = anchor


def _add_distance(
    spec: Any, joint: Joint, handles: Mapping[str, Any], limits: tuple[float, float], shift: float = 0.0
) -> None:
    """Adds a tendon between a point of each body, with length limits."""
    tendon = spec.add_tendon(name=joint.path)
    for side, (body, frame) in enumerate(zip(joint.bodies, joint.frames, strict=True)):
        holder = spec.worldbody if body is None else handles[body]
        name = f"{joint.path}#{side}"
        holder.add_site(name=name, pos=frame[:3, 3] + shift * frame[:3, joint.axis])
        tendon.wrap_site(name)
    tendon.solref_limit, tendon.solimp_limit = HARDEST, STOP
    tendon.limited = mujoco.mjtLimited.mjLIMITED_TRUE
    low, high = limits
    tendon.range = [low, min(max(high, low + 1e-6), 1e9)]


def _add_cone(spec: Any, joint: Joint, handles: Mapping[str, Any]) -> None:
    """Two points on the axis, one of each body, are 2 r sin(swing / 2) apart at a distance r from the joint."""
    _add_distance(spec, joint, handles, (0.0, 2 * LEVER * math.sin(joint.cone / 2)), LEVER)
