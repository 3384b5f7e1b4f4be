"""Reads a stage's UsdPhysics as a `WorldModel`: gravity, bodies and their masses."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from graph.base.errors import UserError
from graph.base.records import dataclass, field
from graph.sim import transforms
from graph.sim.attributes import kilograms_per_unit, value_of, vector
from graph.sim.scene.scan import BodyPrim, Scan, scan_stage
from graph.sim.scene.scene_attributes import EARTH_GRAVITY
from graph.sim.scene.stage import Warn, ignore_warning
from graph.sim.scene.stage_metadata import up_axis
from graph.sim.transforms import Floats
from graph.sim.usd import EARLIEST, UsdGeom, UsdPhysics

from .authored_settings import StoredSettings, check_settings
from .filters import Filters, read_filters
from .mass_properties import read_mass
from .read_forces import read_forces, read_surfaces
from .read_joints import read_joints, read_locks, read_mimics
from .solver import authored_options
from .world_model import Body, Collider, Gripper, Joint, Soft, WorldModel


@dataclass(frozen=True)
class Known:
    """Parts of a world, by path, that have not changed since they were read: they are reused, not read again.

    Of colliders only the shapes are reused; materials and filters are read.
    """

    bodies: Mapping[str, Body] = field(default_factory=dict)
    joints: Mapping[str, Joint] = field(default_factory=dict)
    colliders: Mapping[str, Sequence[Collider]] = field(default_factory=dict)


NOTHING = Known()


def read_world(scan: Scan, warn: Warn, known: Known = NOTHING) -> WorldModel:
    """Everything in the scan that moves, or that something moving can hit."""
    _say_several_scenes(scan, warn)
    filters = read_filters(scan, warn)
    joints = read_joints(scan, warn, known.joints)
    bodies = tuple(
        known.bodies.get(path) or _body(scan, body, warn)
        for path, body in scan.bodies.items()
        if path in scan.moving and not body.given
    )
    stored = StoredSettings()
    locks = read_locks(scan, bodies, joints, stored)
    stored.tell(warn)
    return WorldModel(
        gravity=read_gravity(scan, warn),
        bodies=bodies,
        colliders=_colliders(scan, filters, warn, known) if scan.colliders else (),
        joints=(*joints, *(known.joints.get(lock.path, lock) for lock in locks)),
        filtered=filters.apart,
        grippers=_grippers(scan, warn) if scan.grippers else (),
        mimics=read_mimics(scan, joints, warn),
        meets=None if filters.meets.all() else filters.meets,
        options=authored_options(scan, warn),
        softs=_softs(scan, warn) if scan.soft else (),
        forces=read_forces(scan, warn),
        surfaces=read_surfaces(scan, bodies, warn),
        given=tuple(_body(scan, body, warn) for body in scan.bodies.values() if body.given),
        mechanisms=scan.mechanisms,
    )


# Imported if a scene has what they read: a check reads no shapes, and most scenes are rigid.


def _colliders(scan: Scan, filters: Filters, warn: Warn, known: Known) -> tuple[Collider, ...]:
    from .read_colliders import read_colliders

    return read_colliders(scan, filters, warn, known.colliders)


def _grippers(scan: Scan, warn: Warn) -> tuple[Gripper, ...]:
    from .read_grippers import read_grippers

    return read_grippers(scan, warn)


def _softs(scan: Scan, warn: Warn) -> tuple[Soft, ...]:
    from .read_soft import read_softs

    return read_softs(scan, warn)


def survey(stage: Any, *, mirrors: bool = False) -> list[tuple[str, str, str]]:
    """The warnings of building the physics of a stage, (code, place, message), except for its colliders' shapes.

    Cheap enough for a check: no shape is read and no engine loaded. mirrors: see `check_settings`. Raises UserError if
    the stage cannot be played.
    """
    found: list[tuple[str, str, str]] = []

    def warn(code: str, where: str, message: str) -> None:
        found.append((code, where, message))

    check_settings(stage, warn, mirrors=mirrors)
    scan = scan_stage(stage)
    if scan.dynamic:
        read_world(replace(scan, colliders={}), warn)
    return [*dict.fromkeys(found)]


def _say_several_scenes(scan: Scan, warn: Warn) -> None:
    if len(scan.scenes) > 1:
        others = ", ".join(str(prim.GetPath()) for prim in scan.scenes[1:])
        warn(
            "several-physics-scenes",
            str(scan.scenes[0].GetPath()),
            f"one physics scene is simulated, this one; {others} has no effect, and what names it as its "
            "physics:simulationOwner moves here with everything else",
        )


def read_gravity(scan: Scan, warn: Warn = ignore_warning) -> Floats:
    """(3,) m/s2 of the first physics scene; without a scene, or unset, 9.81 down the up axis.

    A negative magnitude and a direction of length 0 mean "not set" in UsdPhysics; other values that are not finite give
    a warning (`bad-gravity`).
    """
    if not scan.scenes:
        return EARTH_GRAVITY * _down(scan.stage)
    return gravity_of(scan.scenes[0], scan.meters_per_unit, warn)


def _down(stage: Any) -> Floats:
    out: Floats = -np.eye(3)["XYZ".index(up_axis(stage))]
    return out


def gravity_of(prim: Any, meters: float, warn: Warn = ignore_warning) -> Floats:
    """(3,) m/s2 of a physics scene, as `read_gravity`; meters: in a stage unit."""
    scene, down = UsdPhysics.Scene(prim), _down(prim.GetStage())
    if value_of(prim, "newton:gravityEnabled") is False:
        return np.zeros(3)
    direction = np.array(scene.GetGravityDirectionAttr().Get(EARLIEST), dtype=np.float64)
    magnitude = float(scene.GetGravityMagnitudeAttr().Get(EARLIEST))
    length = float(np.linalg.norm(direction))
    path = str(prim.GetPath())
    if not math.isfinite(length):
        text = f"physics:gravityDirection is not finite; gravity is down the {up_axis(prim.GetStage())} axis"
        warn("bad-gravity", f"{path}.physics:gravityDirection", text)
    if math.isnan(magnitude) or magnitude == math.inf:
        text = f"physics:gravityMagnitude is {magnitude:g}, not finite; it is {EARTH_GRAVITY} m/s2"
        warn("bad-gravity", f"{path}.physics:gravityMagnitude", text)
    if not math.isfinite(length) or length == 0:
        direction, length = down, 1.0
    strength = magnitude * meters if 0 <= magnitude < math.inf else EARTH_GRAVITY
    return direction / length * strength


def _body(scan: Scan, prim: BodyPrim, warn: Warn) -> Body:
    unit, mass_unit = scan.meters_per_unit, kilograms_per_unit(scan.stage)
    world = scan.world_matrix(prim.prim)
    if not np.isfinite(world).all():
        raise UserError(f"{prim.path}: the body's transform is not finite; correct its xformOps")
    pose = scan.body_pose(prim.path)
    rigid = UsdPhysics.RigidBodyAPI(prim.prim)
    if not transforms.usable(world):
        warn("bad-transform", prim.path, "the body's transform is flat; its rotation is not to be trusted")
    local_scale = (transforms.inverse_rigid(transforms.rigid_part(world)) @ world)[:3, :3]
    said = read_mass(prim.prim, warn)
    turned = _parent_rotation(scan, prim.prim)
    return Body(
        path=prim.path,
        pose=pose,
        kinematic=prim.kinematic,
        mass=None if said.mass is None else said.mass * mass_unit,
        density=None if said.density is None else said.density * mass_unit / unit**3,
        center_of_mass=None if said.center is None else local_scale @ said.center * unit,
        diagonal_inertia=None if said.inertia is None else said.inertia * mass_unit * unit**2,
        principal_axes=said.axes,
        velocity=turned @ _speed(rigid.GetVelocityAttr(), prim.path, warn) * unit,
        angular_velocity=turned @ np.radians(_speed(rigid.GetAngularVelocityAttr(), prim.path, warn)),
        weightless=bool(value_of(prim.prim, "physxRigidBody:disableGravity")),
        damping=(_share(prim, "linear", warn), _share(prim, "angular", warn)),
        max_speed=_max_speed(prim, unit, warn),
        asleep=bool(rigid.GetStartsAsleepAttr().Get(EARLIEST)),
        name=prim.given,
    )


def _speed(attribute: Any, path: str, warn: Warn) -> Floats:
    value = vector(attribute)
    if value is not None:
        return value
    if attribute.HasAuthoredValue():
        warn("bad-velocity", path, f"{attribute.GetName()} is not finite; the body starts without it")
    return np.zeros(3)


def _share(prim: BodyPrim, kind: str, warn: Warn) -> float:
    name = f"physxRigidBody:{kind}Damping"
    value = value_of(prim.prim, name)
    if value is None or (math.isfinite(value) and value >= 0):
        return float(value or 0.0)
    warn("bad-damping", prim.path, f"{name} is {value:g}; it must be 0 or more; damping is ignored")
    return 0.0


def _max_speed(prim: BodyPrim, unit: float, warn: Warn) -> tuple[float, float]:
    """The speed limits of a body [m/s], [rad/s]."""
    out = []
    for kind, factor in (("Linear", unit), ("Angular", math.pi / 180)):
        name = f"physxRigidBody:max{kind}Velocity"
        value = value_of(prim.prim, name)
        if value is not None and not value >= 0:
            warn(
                "bad-velocity",
                f"{prim.path}.{name}",
                f"{name} is {value:g}; it must be 0 or more; the limit is ignored",
            )
        out.append(math.inf if value is None or not value >= 0 else float(value) * factor)
    return out[0], out[1]


def _parent_rotation(scan: Scan, prim: Any) -> Floats:
    """Velocities are authored in the same space as the prim's own transform: its parent's."""
    parent = prim.GetParent()
    if not parent or UsdGeom.Xformable(prim).GetResetXformStack():
        return np.eye(3)
    return transforms.rigid_part(scan.world_matrix(parent))[:3, :3]
