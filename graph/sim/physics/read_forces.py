"""Forces and moving surfaces that PhysX's schemas author on rigid bodies."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from graph.base.errors import RunError
from graph.sim.attributes import applied_schemas, kilograms_per_unit, value_of
from graph.sim.scene.scan import Scan
from graph.sim.scene.stage import Warn
from graph.sim.scene.stage_metadata import meters_per_unit
from graph.sim.transforms import Floats
from graph.sim.usd import EARLIEST

from .world_model import Body, BodyForce, MovingSurface

if TYPE_CHECKING:
    from .protocol import PhysicsEngine

FORCE, SURFACE = "PhysxForceAPI", "PhysxSurfaceVelocityAPI"
DEGREES = math.pi / 180


def read_forces(scan: Scan, warn: Warn) -> tuple[BodyForce, ...]:
    """The forces of PhysxForceAPI on bodies that forces can move."""
    prims = (body.prim for path, body in scan.bodies.items() if path in scan.moving and not body.kinematic)
    return tuple(force for prim in prims if (force := force_of(prim, warn)))


def force_of(prim: Any, warn: Warn) -> BodyForce | None:
    """The force of a body's PhysxForceAPI; None if the schema is not applied, or off."""
    if FORCE not in applied_schemas(prim) or value_of(prim, "physxForce:forceEnabled") is False:
        return None
    stage = prim.GetStage()
    length, mass = meters_per_unit(stage), kilograms_per_unit(stage)
    accelerates = str(value_of(prim, "physxForce:mode") or "acceleration") == "acceleration"
    force, torque = (_vector(prim, f"physxForce:{name}", warn) for name in ("force", "torque"))
    return BodyForce(
        str(prim.GetPath()),
        force * (length if accelerates else mass * length),
        torque * (DEGREES if accelerates else mass * length**2),
        local=not value_of(prim, "physxForce:worldFrameEnabled"),
        acceleration=accelerates,
    )


def read_surfaces(scan: Scan, bodies: Iterable[Body], warn: Warn) -> tuple[MovingSurface, ...]:
    """The surfaces of PhysxSurfaceVelocityAPI; and, as in PhysX, kinematic bodies with a velocity, the older form of
    belts.
    """
    out = []
    for body in bodies:
        surface = surface_of(scan.bodies[body.path].prim, body.pose, warn)
        if surface is None and body.kinematic and (body.velocity.any() or body.angular_velocity.any()):
            turn = body.pose[:3, :3].T
            surface = MovingSurface(body.path, body.pose, turn @ body.velocity, turn @ body.angular_velocity)
        if surface is not None:
            out.append(surface)
    return tuple(out)


def surface_of(prim: Any, pose: Floats, warn: Warn) -> MovingSurface | None:
    """The PhysxSurfaceVelocityAPI of a body at a rigid pose (4, 4) [m]; None if it is not applied."""
    if SURFACE not in applied_schemas(prim):
        return None
    path, length = str(prim.GetPath()), meters_per_unit(prim.GetStage())
    velocity = _vector(prim, "physxSurfaceVelocity:surfaceVelocity", warn) * length
    turn = _vector(prim, "physxSurfaceVelocity:surfaceAngularVelocity", warn) * DEGREES
    if value_of(prim, "physxSurfaceVelocity:surfaceVelocityEnabled") is False:
        velocity, turn = np.zeros(3), np.zeros(3)
    if value_of(prim, "physxSurfaceVelocity:surfaceVelocityLocalSpace") is False:
        velocity, turn = pose[:3, :3].T @ velocity, pose[:3, :3].T @ turn
    return MovingSurface(path, pose, velocity, turn)


def start_surfaces(physics: PhysicsEngine, warn: Warn) -> None:
    """Makes the engine move the surfaces of its world."""
    for surface in physics.world.surfaces:
        where = f"{surface.path}.physxSurfaceVelocity:surfaceVelocity"
        try:
            changed = physics.set_surface_velocity(surface.path, surface.pose, surface.velocity, surface.turn)
        except (RunError, ValueError) as error:
            warn("bad-surface-velocity", where, f"nothing is carried: {error}")
            continue
        if changed:
            warn("belt-integrator", where, "physics.integrator is implicitfast: discrete cannot move surfaces")


def _vector(prim: Any, name: str, warn: Warn) -> Floats:
    attribute = prim.GetAttribute(name)
    value = attribute.Get(EARLIEST) if attribute else None
    out = np.zeros(3) if value is None else np.array(value, dtype=np.float64)
    if np.isfinite(out).all():
        return out
    warn("bad-force", f"{prim.GetPath()}.{name}", f"{name} is not finite; 0 is taken")
    return np.zeros(3)
