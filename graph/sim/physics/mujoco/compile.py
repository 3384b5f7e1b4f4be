"""Compiles a `WorldModel` to a MuJoCo model."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import fields, replace
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import numpy as np

from graph.base.errors import UserError
from graph.base.records import dataclass, field
from graph.sim import transforms
from graph.sim.physics.authored_settings import StoredSettings
from graph.sim.physics.contact_materials import Material
from graph.sim.physics.filters import bits
from graph.sim.physics.joint_tree import Forest, grow_forest
from graph.sim.physics.mass_properties import Inertia, body_inertia
from graph.sim.physics.solver import CHOICES, SWITCHES, SolverOptions, chosen
from graph.sim.physics.world_model import Body, Collider, Gripper, Joint, Soft, Volume, WorldModel
from graph.sim.scene.stage import Warn
from graph.sim.transforms import Floats

from .constraints import add_drive, add_grips, add_joints, add_ties, kept_apart, still_name
from .contacts import add_pairs, plan_contacts
from .deformables import add_soft
from .geoms import Grip, Meshes, Shape, add_geom, compiled, measured, new_spec, still
from .library import give_memory, mujoco
from .queries import GROUP
from .restitution import NO_RESTITUTION, Restitution

if TYPE_CHECKING:
    from graph.sim.fidelity import Fidelity
    from graph.sim.physics.protocol import ModelScene


RIGID, FREE = 0.9999, 0.0001
"""MuJoCo keeps impedances between these."""


def soften_contacts(model: Any, softness: float) -> None:
    """Multiplies the compliance 1 - d of every contact by `softness`, where d is MuJoCo's impedance (`solimp`).

    A body at rest sinks in by (1 - d) / d2 of g times the square of its contact's time constant, and creeps on a slope
    by (1 - d) / d of half that constant times its downhill acceleration per second; both are proportional to 1 - d
    while that is small (MuJoCo, Computation, "Impedance").
    """
    rows = [model.geom_solimp, model.pair_solimp, model.flex_solimp, model.opt.o_solimp[None]]
    for impedance in (each[:, :2] for each in rows):
        impedance[:] = np.clip(1 - softness * (1 - impedance), FREE, RIGID)


OWN = SolverOptions(integrator="implicitfast", cone="elliptic", impratio=10.0)
"""The options of worlds without a model of their own, where neither a knob nor the scene chooses."""

Start = Callable[[Any, Any], None]
"""Puts a model's data into the initial state of its scene."""


@dataclass(frozen=True)
class Compiled:
    """The model, its bodies in its own order (body 0 of the model is the world) and its joints in stage order."""

    model: Any
    bodies: tuple[Body, ...]
    joints: tuple[Joint, ...]
    kinematic: tuple[str, ...]
    grippers: tuple[Gripper, ...] = ()
    start: Start | None = None
    touches: Mapping[str, Material] = field(default_factory=dict)
    """The explicit pairs of the model by name."""
    softs: tuple[Soft, ...] = ()
    restitution: Restitution = NO_RESTITUTION
    flexes: Mapping[str, tuple[str, Floats]] = field(default_factory=dict)
    """Soft parts of a model: by prim, the name in the model and the initial points (n, 3) [m, world]."""
    geom_paths: Mapping[int, str] = field(default_factory=dict)
    """By number, the prims of geoms whose names are not their paths: those of an MJCF model."""
    own: bool = False
    """Whether no model of a file is in it."""
    divides: bool = False
    """Whether steps are divided where chains or loops need it: nobody chose how it is integrated."""


@dataclass(frozen=True)
class Base:
    """A model to which a world is added: its specification (which is changed), its bodies in its order, its joints."""

    spec: Any
    bodies: tuple[Body, ...]
    joints: tuple[Joint, ...]
    start: Start | None = None


def compiler_of(fidelity: Fidelity | None, mjcf: ModelScene | None) -> Callable[[WorldModel, Fraction, Warn], Compiled]:
    """The compiler of a world and of its later versions; shapes are measured once for all of them."""
    volumes: dict[Shape, Volume] = {}

    def compiled_world(world: WorldModel, dt: Fraction, warn: Warn) -> Compiled:
        options = chosen(fidelity).over(world.options)
        if mjcf is None:
            compiled = compile_world(world, dt, options, warn, volumes=volumes)
        else:
            compiled = mjcf.compiled(world, dt, options, warn, volumes)
        if fidelity is not None and fidelity.physics_contact_softness is not None:
            soften_contacts(compiled.model, fidelity.physics_contact_softness)
        return compiled

    return compiled_world


def compile_world(
    world: WorldModel,
    dt: Fraction,
    options: SolverOptions,
    warn: Warn,
    base: Base | None = None,
    volumes: dict[Shape, Volume] | None = None,
) -> Compiled:
    """Builds the MuJoCo model; with a `base`, adds to it, with its gravity and options where `options` has None.

    volumes: see `measured`. Raises UserError, with names where possible, if MuJoCo refuses the world.
    """
    forest = grow_forest(world, warn)
    spec = new_spec() if base is None else base.spec
    if base is None:
        spec.option.gravity = world.gravity
        # Bodies connected by a joint are kept apart by explicit excludes.
        spec.option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_FILTERPARENT)
    # After a divergence the state must be kept for the message.
    spec.option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_AUTORESET)
    meshes = Meshes(spec)
    every = measured(world.colliders, warn, volumes)
    usable = [each for each in every if not each[0].trigger]
    colliders = [collider for collider, _ in usable]
    given = {body.path: body.model_name for body in world.given}
    handles = _add_bodies(spec, forest, usable, given, warn)
    _put_to_sleep(spec, forest, handles)
    roots = _weld_roots(forest)
    names = [f"{collider.path}#{number}" for number, collider in enumerate(colliders)]
    plan = plan_contacts(colliders, names, still(colliders, roots), world.meets, warn)
    write_options(spec.option, _suited(options, world, base is not None))
    spec.option.timestep = float(dt)
    for number, (collider, name) in enumerate(zip(colliders, names, strict=True)):
        parent = _still_body(spec, collider.still) if collider.body is None else handles[collider.body]
        grip = Grip(
            float(plan.friction[number]),
            int(plan.priority[number]),
            (1, 1) if world.meets is None else bits(world.meets, collider.mask),
        )
        geom = add_geom(parent, collider, meshes, name, grip)
        if collider.body in given:  # its mass is the model's, except for what the collider states
            geom.density = collider.density or collider.material_density or 0.0
            if collider.mass is not None:
                geom.mass = collider.mass
    for number, (collider, _) in enumerate(every):
        if collider.trigger:
            parent = spec.worldbody if collider.body is None else handles[collider.body]
            geom = add_geom(parent, collider, meshes, f"{collider.path}#t{number}", Grip(1.0, bits=(0, 0)))
            geom.group = GROUP
    add_ties(spec, world, forest, handles, warn)
    touches = add_pairs(spec, names, plan, _meeting(colliders, roots, world))
    grippers = add_grips(spec, world)
    for soft in world.softs:
        add_soft(spec, soft, handles)
    joints = _hung(world, forest)
    for joint in joints:
        if joint.drive is not None:
            add_drive(spec, joint)
    give_memory(spec, len(forest.branches))
    model = compiled(spec)
    if base is None and options.tolerance is None and options.solver in (None, "newton"):
        model.opt.tolerance *= min(1.0, 100 * lightest_share(model))  # a robot's wheels are right without that
    bodies = tuple(branch.body for branch in forest.branches)
    _damp(model, bodies)
    _say_held(model, bodies, warn)
    if base is not None:
        known = {body.model_name: body for body in (*base.bodies, *bodies)}
        order = (model.body(number).name for number in range(1, model.nbody))
        bodies, joints = tuple(known[name] for name in order if name in known), (*base.joints, *joints)
    kinematic = tuple(body.path for body in bodies if body.kinematic)
    return Compiled(
        model,
        bodies,
        joints,
        kinematic,
        grippers,
        base.start if base else None,
        touches,
        world.softs,
        plan.restitution,
        own=base is None,
        divides=base is None and options.integrator is None,
    )


def write_options(option: Any, options: SolverOptions) -> None:
    """Sets chosen values in the `option` of a spec or the `opt` of a model."""
    for each in fields(options):
        value = getattr(options, each.name)
        if value is None:
            continue
        if each.name in CHOICES:
            name = CHOICES[each.name][value]
            kind = {"integrator": "Integrator", "solver": "Solver", "cone": "Cone", "jacobian": "Jacobian"}[each.name]
            setattr(option, each.name, int(getattr(getattr(mujoco, f"mjt{kind}"), name)))
        elif each.name in SWITCHES:
            bit = int(getattr(mujoco.mjtDisableBit, SWITCHES[each.name]))
            option.disableflags = option.disableflags & ~bit if value else option.disableflags | bit
        else:
            setattr(option, each.name, value)


def _suited(options: SolverOptions, world: WorldModel, based: bool) -> SolverOptions:
    """The options, with those that the world needs where nothing is chosen; a model (`based`) keeps its own.

    Only with `discrete` are stiff drives and contacts, and elastic bodies, stable together. Elliptic cones: with
    pyramids friction holds less along diagonals and bodies at rest creep (measured in `tests/stability`).
    """
    driven = any(single.drive for joint in world.joints for single in joint.singles)
    elastic = next((soft.path for soft in world.softs if soft.elements is not None), None)
    if elastic and options.integrator not in (None, "discrete", "euler"):
        raise UserError(
            f"physics.integrator {options.integrator} cannot integrate what is elastic ({elastic}); use discrete, or "
            "euler with a small time step"
        )
    if driven or elastic:
        options = options.over(SolverOptions(integrator="discrete"))
    if based:
        return options
    own = OWN if options.cone in (None, OWN.cone) else replace(OWN, impratio=None)
    return options.over(own)


def lightest_share(model: Any) -> float:
    """The mass of the lightest body that moves, as a share of the heaviest one's.

    MuJoCo measures its solver's progress by the mean inertia of a model, so that beside a heavy body a light one is
    left without its contact forces. Its tolerance times this share is that of the lightest body alone.
    """
    masses = model.body_mass[(model.body_treeid >= 0) & (model.body_mass > 0)]
    return float(masses.min() / masses.max()) if len(masses) else 1.0


def _weld_roots(forest: Forest) -> dict[str, str | None]:
    """For each body, the body to which fixed joints hold it, if any; None for bodies fixed to the world or held by
    the user.
    """
    roots: dict[str, str | None] = {}
    for branch in forest.branches:
        welded = branch.joint is not None and branch.joint.kind == "fixed"
        path = branch.body.path
        roots[path] = None if branch.body.kinematic else path
        if welded:
            roots[path] = None if branch.parent is None else roots[branch.parent]
    return roots


def _meeting(colliders: list[Collider], roots: dict[str, str | None], world: WorldModel) -> Callable[[int, int], bool]:
    """Whether two colliders can collide: not on the same body, nor on bodies that are welded or kept apart."""
    apart = kept_apart(world)
    root = [None if each.body is None else roots.get(each.body, each.body) for each in colliders]
    owner = [each.body or each.still for each in colliders]

    def meet(first: int, second: int) -> bool:
        a, b = owner[first], owner[second]
        return root[first] != root[second] and ((a, b) if a < b else (b, a)) not in apart

    return meet


def _hung(world: WorldModel, forest: Forest) -> tuple[Joint, ...]:
    """The joints with one axis, and the spherical ones, of the joint tree, in stage order."""
    hung = {branch.joint.path for branch in forest.branches if branch.joint}
    return tuple(single for joint in world.joints if joint.path in hung for single in joint.singles)


def _add_bodies(
    spec: Any, forest: Forest, colliders: Iterable[tuple[Collider, Volume]], given: Mapping[str, str], warn: Warn
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
        handle = parent.add_body(name=body.path, mocap=body.kinematic, gravcomp=float(body.weightless))
        handle.pos, handle.quat = local[:3, 3], transforms.quaternion(local[:3, :3])
        handles[body.path], poses[body.path] = handle, body.pose
        if not body.kinematic:
            _set_inertia(handle, body_inertia(body, own.get(body.path, ()), warn))
            add_joints(handle, branch, bool(spec.compiler.degree))
    return handles


def _still_body(spec: Any, path: str) -> Any:
    """The world; or a static body with its own name, from which bodies can be kept apart."""
    if not path:
        return spec.worldbody
    return spec.body(still_name(path)) or spec.worldbody.add_body(name=still_name(path))


def _put_to_sleep(spec: Any, forest: Forest, handles: Mapping[str, Any]) -> None:
    """Bodies that start asleep stay in place until something touches them; the others never sleep."""
    free = [branch for branch in forest.branches if branch.parent is None and not branch.body.kinematic]
    if not any(branch.body.asleep for branch in free):
        return
    spec.option.enableflags |= int(mujoco.mjtEnableBit.mjENBL_SLEEP)
    kinds = mujoco.mjtSleepPolicy
    for branch in free:
        handles[branch.body.path].sleep = kinds.mjSLEEP_INIT if branch.body.asleep else kinds.mjSLEEP_NEVER


def _set_inertia(handle: Any, inertia: Inertia) -> None:
    handle.explicitinertial = True
    handle.mass, handle.ipos = inertia.mass, inertia.center
    t = inertia.tensor
    handle.fullinertia = [t[0, 0], t[1, 1], t[2, 2], t[0, 1], t[0, 2], t[1, 2]]


def _damp(model: Any, bodies: Iterable[Body]) -> None:
    """Damps free bodies: a force takes this fraction of their momentum per second."""
    for body in bodies:
        if not any(body.damping):
            continue
        number = model.body(body.model_name).id
        if not _is_free(model, number):
            continue
        first = model.jnt_dofadr[model.body_jntadr[number]]
        model.dof_damping[first : first + 3] = body.damping[0] * model.body_mass[number]
        model.dof_damping[first + 3 : first + 6] = body.damping[1] * model.dof_M0[first + 3 : first + 6]


def _say_held(model: Any, bodies: Iterable[Body], warn: Warn) -> None:
    """Warns that damping and speed limits apply only to free bodies; a jointed body has those of its joint."""
    held = StoredSettings()
    for body in bodies:
        if body.kinematic or _is_free(model, model.body(body.model_name).id):
            continue
        for kind, damping, most in zip(("linear", "angular"), body.damping, body.max_speed, strict=True):
            if damping:
                name = f"physxRigidBody:{kind}Damping"
                held.add(body.path, name, "a joint holds this body; set newton:damping on the joint")
            if most < math.inf:
                name = f"physxRigidBody:max{kind.capitalize()}Velocity"
                held.add(body.path, name, "a joint holds this body; set physxJoint:maxJointVelocity on the joint")
    held.tell(warn)


def _is_free(model: Any, body: int) -> bool:
    """Whether a body moves in all six directions."""
    joint = model.body_jntadr[body]
    return bool(joint >= 0 and model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_FREE)
