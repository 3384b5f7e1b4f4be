"""A `World` as a MuJoCo model."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from graph.errors import UserError
from graph.sim import transforms
from graph.sim.stage import Warn
from graph.sim.transforms import Floats

from .grippers import weld_name
from .library import mujoco
from .masses import Inertia, Volume, body_inertia
from .model import Body, Collider, Gripper, Joint, World
from .tree import Branch, Forest, grow_forest

TORSION, ROLLING = 0.005, 0.0001
"""MuJoCo's own defaults of friction against spinning and rolling [m]."""

_GEOMS = {
    "box": mujoco.mjtGeom.mjGEOM_BOX,
    "sphere": mujoco.mjtGeom.mjGEOM_SPHERE,
    "ellipsoid": mujoco.mjtGeom.mjGEOM_ELLIPSOID,
    "capsule": mujoco.mjtGeom.mjGEOM_CAPSULE,
    "cylinder": mujoco.mjtGeom.mjGEOM_CYLINDER,
    "plane": mujoco.mjtGeom.mjGEOM_PLANE,
    "mesh": mujoco.mjtGeom.mjGEOM_MESH,
}
INTEGRATORS = {
    "euler": mujoco.mjtIntegrator.mjINT_EULER,
    "rk4": mujoco.mjtIntegrator.mjINT_RK4,
    "implicit": mujoco.mjtIntegrator.mjINT_IMPLICIT,
    "implicitfast": mujoco.mjtIntegrator.mjINT_IMPLICITFAST,
    "discrete": mujoco.mjtIntegrator.mjINT_DISCRETE,
}
"""Names of the fidelity knob `physics.integrator`."""


Start = Callable[[Any, Any], None]
"""Puts a model's data into the state that its scene starts in."""


@dataclass(frozen=True)
class Compiled:
    """The model, its bodies in its own order (the model's body 0 is the world) and its joints in stage order."""

    model: Any
    bodies: tuple[Body, ...]
    joints: tuple[Joint, ...]
    kinematic: tuple[str, ...]
    grippers: tuple[Gripper, ...] = ()
    start: Start | None = None


@dataclass(frozen=True)
class Base:
    """A model that a world is added to: its specification (changed by that), its bodies in its order, its joints."""

    spec: Any
    bodies: tuple[Body, ...]
    joints: tuple[Joint, ...]
    start: Start | None = None


def compile_world(
    world: World,
    dt: Fraction,
    integrator: str | None,
    iterations: int | None,
    warn: Warn,
    base: Base | None = None,
) -> Compiled:
    """Build the MuJoCo model; with a `base` add to that one, whose gravity and options count.

    integrator: None leaves the engine's default (or the base's). Raises UserError, naming what it can, where MuJoCo
    refuses the world.
    """
    forest = grow_forest(world, warn)
    spec = _new_spec() if base is None else base.spec
    spec.option.timestep = float(dt)
    if base is None:
        spec.option.gravity = world.gravity
        # Bodies tied by a joint are kept apart by explicit excludes.
        spec.option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_FILTERPARENT)
    if integrator is not None:
        spec.option.integrator = INTEGRATORS[integrator]
    if iterations is not None:
        spec.option.iterations = iterations
    # A divergence must leave its state to be looked at.
    spec.option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_AUTORESET)
    meshes = _Meshes(spec)
    usable = _measured(world.colliders, warn)
    given = {body.path: body.model_name for body in world.given}
    handles = _add_bodies(spec, forest, usable, given, warn)
    for number, (collider, _) in enumerate(usable):
        parent = spec.worldbody if collider.body is None else handles[collider.body]
        geom = _add_geom(parent, collider, meshes, f"{collider.path}#{number}")
        if collider.body in given:  # its mass is the model's, but for what is said of the collider
            geom.density = collider.density or 0.0
            if collider.mass is not None:
                geom.mass = collider.mass
    _add_constraints(spec, world, forest, given, warn)
    grippers = _add_grips(spec, world, given)
    hung = {branch.joint.path for branch in forest.branches if branch.joint}
    joints = tuple(joint for joint in world.joints if joint.path in hung and joint.kind != "fixed")
    for joint in joints:
        if joint.drive is not None:
            _add_drive(spec, joint)
    model = _compiled(spec)
    bodies = tuple(branch.body for branch in forest.branches)
    if base is not None:
        known = {body.model_name: body for body in (*base.bodies, *bodies)}
        names = (model.body(number).name for number in range(1, model.nbody))
        bodies, joints = tuple(known[name] for name in names if name in known), (*base.joints, *joints)
    kinematic = tuple(body.path for body in bodies if body.kinematic)
    return Compiled(model, bodies, joints, kinematic, grippers, base.start if base else None)


def _new_spec() -> Any:
    spec = mujoco.MjSpec()
    spec.compiler.degree = False
    spec.compiler.balanceinertia = True
    spec.compiler.autolimits = False
    return spec


def _compiled(spec: Any) -> Any:
    try:
        return spec.compile()
    except ValueError as error:
        raise UserError(f"the scene's physics cannot be built: {' '.join(str(error).split())}") from error


class _Meshes:
    """Mesh assets of a spec; colliders with equal points share one."""

    def __init__(self, spec: Any) -> None:
        self.spec = spec
        self.names: dict[bytes, str] = {}

    def name(self, vertices: Floats) -> str:
        points = np.ascontiguousarray(vertices, dtype=np.float64)
        key = points.tobytes()
        if key not in self.names:
            self.names[key] = f"#mesh{len(self.names)}"
            asset = self.spec.add_mesh(name=self.names[key])
            asset.uservert = points.ravel()
            asset.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX
        return self.names[key]


def _add_geom(parent: Any, collider: Collider, meshes: _Meshes, name: str, density: float = 0.0) -> Any:
    size = np.zeros(3)
    size[: len(collider.size)] = collider.size
    if collider.kind == "plane":
        size[:] = (0, 0, 1)
    geom = parent.add_geom(name=name, type=_GEOMS[collider.kind], size=size, density=density)
    geom.pos = collider.pose[:3, 3]
    geom.quat = transforms.quaternion(collider.pose[:3, :3])
    geom.friction = [collider.friction, TORSION, ROLLING]
    if collider.kind == "mesh":
        assert collider.vertices is not None
        geom.meshname = meshes.name(collider.vertices)
    return geom


def _measured(colliders: Iterable[Collider], warn: Warn) -> list[tuple[Collider, Volume]]:
    """Colliders that MuJoCo can build, each with its volume: a model of each alone, at density 1, tells."""
    out = []
    known: dict[tuple[Any, ...], Volume] = {}
    for collider in colliders:
        if collider.kind == "plane":
            out.append((collider, Volume(0.0, np.zeros(3), np.zeros((3, 3)))))
            continue
        points = b"" if collider.vertices is None else collider.vertices.tobytes()
        key = (collider.kind, collider.size, collider.pose.tobytes(), points)
        if key not in known:
            spec = _new_spec()
            try:
                _add_geom(spec.worldbody.add_body(), collider, _Meshes(spec), "only", density=1.0)
                model = spec.compile()
            except ValueError as error:
                warn("bad-collider", collider.path, f"nothing hits it: {' '.join(str(error).split())}")
                continue
            axes = transforms.rotation_matrices(model.body_iquat[1])
            with np.errstate(over="ignore", invalid="ignore"):  # body_inertia tells what came of it
                tensor = axes @ np.diag(model.body_inertia[1]) @ axes.T
            known[key] = Volume(float(model.body_mass[1]), model.body_ipos[1].copy(), tensor)
        out.append((collider, known[key]))
    return out


def _add_bodies(
    spec: Any, forest: Forest, colliders: list[tuple[Collider, Volume]], given: Mapping[str, str], warn: Warn
) -> dict[str, Any]:
    own: dict[str | None, list[tuple[Collider, Volume]]] = {}
    for collider, volume in colliders:
        own.setdefault(collider.body, []).append((collider, volume))
    handles: dict[str, Any] = {}
    poses: dict[str | None, Floats] = {None: np.eye(4)}
    for branch in forest.branches:
        body = branch.body
        if body.path in given:
            handles[body.path], poses[body.path] = spec.body(given[body.path]), body.pose
            continue
        parent = spec.worldbody if branch.parent is None else handles[branch.parent]
        local = transforms.inverse_rigid(poses[branch.parent]) @ body.pose
        handle = parent.add_body(name=body.path, mocap=body.kinematic)
        handle.pos, handle.quat = local[:3, 3], transforms.quaternion(local[:3, :3])
        handles[body.path], poses[body.path] = handle, body.pose
        if not body.kinematic:
            _set_inertia(handle, body_inertia(body, own.get(body.path, ()), warn))
            _add_joint(handle, branch, bool(spec.compiler.degree))
    return handles


def _set_inertia(handle: Any, inertia: Inertia) -> None:
    handle.explicitinertial = True
    handle.mass, handle.ipos = inertia.mass, inertia.center
    t = inertia.tensor
    handle.fullinertia = [t[0, 0], t[1, 1], t[2, 2], t[0, 1], t[0, 2], t[1, 2]]


def _add_joint(handle: Any, branch: Branch, degrees: bool) -> None:
    joint = branch.joint
    if joint is None:
        handle.add_freejoint(name=f"{branch.body.path}#free")
        return
    if joint.kind == "fixed":
        return
    frame = joint.frames[0 if branch.reversed else 1]
    kinds = {
        "revolute": mujoco.mjtJoint.mjJNT_HINGE,
        "prismatic": mujoco.mjtJoint.mjJNT_SLIDE,
        "spherical": mujoco.mjtJoint.mjJNT_BALL,
    }
    made = handle.add_joint(name=joint.path, type=kinds[joint.kind], pos=frame[:3, 3])
    if joint.kind == "spherical":
        return
    made.axis = frame[:3, joint.axis] * (-1.0 if branch.reversed else 1.0)
    unit = math.degrees(1) if degrees and joint.kind == "revolute" else 1.0
    made.ref = joint.start * unit
    if math.isfinite(joint.lower) or math.isfinite(joint.upper):
        made.limited = mujoco.mjtLimited.mjLIMITED_TRUE
        made.range = np.clip([joint.lower, max(joint.upper, joint.lower + 1e-9)], -1e9, 1e9) * unit


def _add_drive(spec: Any, joint: Joint) -> None:
    """An actuator whose control is a force; `drives` sets its gains, which depend on the time step."""
    actuator = spec.add_actuator(name=joint.path, target=joint.path, trntype=mujoco.mjtTrn.mjTRN_JOINT)
    actuator.gaintype, actuator.biastype = mujoco.mjtGain.mjGAIN_FIXED, mujoco.mjtBias.mjBIAS_AFFINE


def _add_constraints(spec: Any, world: World, forest: Forest, given: Mapping[str, str], warn: Warn) -> None:
    for joint in forest.loops:
        if joint.drive is not None or math.isfinite(joint.lower) or math.isfinite(joint.upper):
            warn("loop-joint", joint.path, "it closes a loop of joints; its drive and its limits have no effect.")
        _add_loop(spec, joint, given, warn)
    apart = [joint.bodies for joint in world.joints if not joint.collide] + list(world.filtered)
    for first, second in dict.fromkeys((min(pair), max(pair)) for pair in apart if pair[0] and pair[1]):  # type: ignore
        names = [given.get(str(path), str(path)) for path in (first, second)]
        spec.add_exclude(bodyname1=names[0], bodyname2=names[1])


def _add_grips(spec: Any, world: World, given: Mapping[str, str]) -> tuple[Gripper, ...]:
    """A weld for each point of a gripper, off and between any two bodies until it holds one; none for a lone body."""
    bodies = (*world.bodies, *world.given)
    if len(bodies) < 2:
        return ()
    for gripper in world.grippers:
        for point in gripper.points:
            holder = given.get(point.body, point.body)
            other = next(body.model_name for body in bodies if body.path != point.body)
            weld = spec.add_equality(type=mujoco.mjtEq.mjEQ_WELD, objtype=mujoco.mjtObj.mjOBJ_BODY)
            weld.name, weld.name1, weld.name2, weld.active = weld_name(point), holder, other, False
    return world.grippers


def _add_loop(spec: Any, joint: Joint, given: Mapping[str, str], warn: Warn) -> None:
    """Tie two bodies that already hang together: at one point, at two points of an axis, or wholly."""
    names = [given.get(body or "world", body or "world") for body in joint.bodies]
    if joint.kind == "prismatic":
        warn("joint-not-supported", joint.path, "a prismatic joint that closes a loop is not simulated.")
        return
    if joint.kind == "fixed":
        relative = joint.frames[0] @ transforms.inverse_rigid(joint.frames[1])
        weld = spec.add_equality(type=mujoco.mjtEq.mjEQ_WELD, objtype=mujoco.mjtObj.mjOBJ_BODY)
        weld.name1, weld.name2 = names
        weld.data[:11] = [0, 0, 0, *relative[:3, 3], *transforms.quaternion(relative[:3, :3]), 1.0]
        return
    ends = (0.0,) if joint.kind == "spherical" else (-0.1, 0.1)
    for end in ends:
        anchor = joint.frames[0][:3, 3] + end * joint.frames[0][:3, joint.axis]
        tie = spec.add_equality(type=mujoco.mjtEq.mjEQ_CONNECT, objtype=mujoco.mjtObj.mjOBJ_BODY)
        tie.name1, tie.name2 = names
        tie.data[:3] = anchor
