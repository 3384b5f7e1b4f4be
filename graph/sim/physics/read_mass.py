"""UsdPhysics.MassAPI of bodies and colliders."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from graph.base.records import dataclass
from graph.sim.scene.stage import Warn
from graph.sim.transforms import Floats
from graph.sim.usd import EARLIEST, UsdPhysics

from .attributes import quaternion_of


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
        value = _authored(attribute)
        if value is None or 0 < value < math.inf:
            return None if value is None else float(value)
        if value != 0:
            complain(attribute, f"is {value:g}, not a number from 0")
        return None

    def vector(attribute: Any) -> Floats | None:
        value = _authored(attribute)
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
    axes = _authored(api.GetPrincipalAxesAttr())
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


def _authored(attribute: Any) -> Any:
    return attribute.Get(EARLIEST) if attribute and attribute.HasAuthoredValue() else None


def _shown(value: Floats) -> str:
    return f"({', '.join(f'{part:g}' for part in value)})"
