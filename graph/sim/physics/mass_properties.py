"""Mass, centre and inertia of bodies: authored (UsdPhysics.MassAPI), else from the volumes of their colliders."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from graph.base.errors import UserError
from graph.base.records import dataclass
from graph.sim import transforms
from graph.sim.attributes import authored_value, quaternion_of
from graph.sim.scene.stage import Warn
from graph.sim.transforms import Floats
from graph.sim.usd import UsdPhysics

from .world_model import DEFAULT_DENSITY, Body, Collider, Volume


@dataclass(frozen=True)
class AuthoredMass:
    """The authored mass properties of a prim, in stage units; None if unset, or if the value means "not set"."""

    mass: float | None = None
    density: float | None = None
    center: Floats | None = None
    inertia: Floats | None = None
    """(3,) about the centre, along the principal axes."""
    axes: Floats | None = None
    """w, x, y, z of the principal axes, unit."""


def read_mass(prim: Any, warn: Warn) -> AuthoredMass:
    """Reads the authored mass properties of a prim; impossible values count as not authored (`bad-mass`)."""
    api = UsdPhysics.MassAPI(prim)

    def number(attribute: Any) -> float | None:
        value = authored_value(attribute)
        if value is None or 0 < value < math.inf:
            return None if value is None else float(value)
        if value != 0:
            complain(attribute, f"is {value:g}, not a number from 0")
        return None

    def vector(attribute: Any) -> Floats | None:
        value = authored_value(attribute)
        out = None if value is None else np.array(value, dtype=np.float64)
        if out is None or np.isfinite(out).all():
            return out
        if not np.isneginf(out).all():
            complain(attribute, f"is {_shown(out)}, not finite")
        return None

    def complain(attribute: Any, what: str) -> None:
        name = attribute.GetName()
        warn("bad-mass", f"{prim.GetPath()}.{name}", f"{name} {what}; it counts as not written")

    inertia = vector(api.GetDiagonalInertiaAttr())
    if inertia is not None and not (inertia > 0).all():
        if inertia.any():
            complain(api.GetDiagonalInertiaAttr(), f"is {_shown(inertia)}, not all above 0")
        inertia = None
    axes = authored_value(api.GetPrincipalAxesAttr())
    length = 0.0 if axes is None else axes.GetLength()
    if not math.isfinite(length):
        complain(api.GetPrincipalAxesAttr(), "is not finite")
        length = 0.0
    return AuthoredMass(
        mass=number(api.GetMassAttr()),
        density=number(api.GetDensityAttr()),
        center=vector(api.GetCenterOfMassAttr()),
        inertia=inertia,
        axes=quaternion_of(axes) if length else None,
    )


def _shown(value: Floats) -> str:
    return f"({', '.join(f'{part:g}' for part in value)})"


LEAST, MOST = 1e-15, 1e14
"""MuJoCo's least mass [kg] and moment of inertia [kg m2] of a moving body, and the most, above which bodies sink
into what they rest on.
"""

FLAT, TRIMMED = 1e-6, 1e-12
"""The largest moment of inertia is at most the sum of the others. float32 may miss that for a flat body by less than
the first fraction; it is then set this much below the sum.
"""

SMALL_SPHERE = 0.1
"""A body without volume has the inertia of a ball of this radius [m] (and 1 kg), as in PhysX."""


@dataclass(frozen=True)
class Inertia:
    """Mass [kg], centre of mass [m] and inertia about it (3, 3) [kg m2], along the body's axes."""

    mass: float
    center: Floats
    tensor: Floats


def body_inertia(body: Body, parts: Sequence[tuple[Collider, Volume]], warn: Warn) -> Inertia:
    """Authored values are preferred: the body's mass over its colliders', mass over density, collider over body over
    material.

    A collider's own centre and inertia count as parts of the body's. An authored mass scales what the volumes give; an
    authored centre moves it without changing the tensor. Raises UserError, with the body's name, if sizes and densities
    give no finite mass.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        inertia = _body_inertia(body, parts, warn)
    if not (np.isfinite(inertia.mass) and np.isfinite(inertia.center).all() and np.isfinite(inertia.tensor).all()):
        raise UserError(f"{body.path}: its size and density give no finite mass and inertia; make it smaller")
    moments, axes = np.linalg.eigh(inertia.tensor)
    least, sum_of_lesser = float(moments[0]), float(moments[0] + moments[1])
    if moments[2] > sum_of_lesser * (1 + FLAT):
        warn(
            "impossible-inertia",
            body.path,
            f"no body has moments of inertia {', '.join(f'{moment:.6g}' for moment in moments)} kg m2: the greatest is "
            "more than the others together; their mean is taken for all",
        )
    elif moments[2] > sum_of_lesser * (1 - TRIMMED):
        moments[2] = sum_of_lesser * (1 - TRIMMED)
        inertia = replace(inertia, tensor=axes @ np.diag(moments) @ axes.T)
    if inertia.mass > MOST:
        raise UserError(
            f"{body.path}: a mass of {inertia.mass:g} kg is too much for the engine (the most is {MOST:g}); check "
            "physics:mass, physics:density, its size and metersPerUnit"
        )
    if inertia.mass < LEAST or least < LEAST:
        raise UserError(
            f"{body.path}: a mass of {inertia.mass:g} kg with an inertia of {least:g} kg m2 is too little for the "
            f"engine (the least is {LEAST:g}); check physics:mass, physics:diagonalInertia, its size and metersPerUnit"
        )
    return inertia


def _body_inertia(body: Body, parts: Sequence[tuple[Collider, Volume]], warn: Warn) -> Inertia:
    out = _summed([_weighed(body, collider, volume) for collider, volume in parts])
    if out is None:
        mass = body.mass or 1.0
        out = Inertia(mass, np.zeros(3), np.eye(3) * (0.4 * mass * SMALL_SPHERE**2))
        if body.diagonal_inertia is None:
            warn(
                "body-without-volume",
                body.path,
                f"no collider gives it an inertia; it has that of a {SMALL_SPHERE} m ball",
            )
    if body.mass is not None:
        out = Inertia(body.mass, out.center, out.tensor * (body.mass / out.mass))
    center = out.center if body.center_of_mass is None else body.center_of_mass
    tensor = out.tensor
    if body.diagonal_inertia is not None:
        axes = np.eye(3) if body.principal_axes is None else transforms.rotation_matrices(body.principal_axes)
        tensor = axes @ np.diag(body.diagonal_inertia) @ axes.T
    return Inertia(out.mass, center, tensor)


def _weighed(body: Body, collider: Collider, volume: Volume) -> Inertia | None:
    densities = (collider.density, body.density, collider.material_density, DEFAULT_DENSITY)
    mass = collider.mass
    if mass is None:
        mass = volume.volume * next(density for density in densities if density is not None)
    if volume.volume <= 0:
        if collider.mass is None or collider.tensor is None:
            return None
        return Inertia(mass, np.zeros(3) if collider.center is None else collider.center, collider.tensor)
    center = volume.center if collider.center is None else collider.center
    return Inertia(
        mass, center, volume.inertia * (mass / volume.volume) if collider.tensor is None else collider.tensor
    )


def _summed(parts: Sequence[Inertia | None]) -> Inertia | None:
    """Parallel axes: each tensor moved to the common centre."""
    solid = [part for part in parts if part is not None and part.mass > 0]
    if not solid:
        return None
    mass = sum(part.mass for part in solid)
    center = np.sum([part.mass * part.center for part in solid], axis=0) / mass
    tensor = np.zeros((3, 3))
    for part in solid:
        arm = part.center - center
        tensor += part.tensor + part.mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    return Inertia(mass, center, tensor)
