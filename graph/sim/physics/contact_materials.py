"""Physics materials, and the contact between two of them."""

from __future__ import annotations

import math
from typing import Any, Literal

from graph.base.records import dataclass
from graph.sim.scene.stage import Warn
from graph.sim.usd import EARLIEST, UsdPhysics, UsdShade

Mode = Literal["average", "min", "multiply", "max"]
MODES: tuple[Mode, ...] = ("average", "min", "multiply", "max")
"""Ways to combine the values of two materials; of two different ways the later one in this list is used (as in
PhysX).
"""

DEFAULT_FRICTION = 0.5
"""Friction of colliders without a physics material."""

TORSION, ROLLING = 0.005, 0.0001
"""MuJoCo's own defaults of friction against spinning and rolling [m]."""


@dataclass(frozen=True, slots=True)
class Material:
    """A surface: static and dynamic friction, coefficient of restitution, and how both are combined."""

    static: float = DEFAULT_FRICTION
    sliding: float = DEFAULT_FRICTION
    restitution: float = 0.0
    friction_mode: Mode = "average"
    restitution_mode: Mode = "average"
    torsion: float = TORSION
    rolling: float = ROLLING


PLAIN = Material()
"""The material of colliders without a physics material."""


def touch(first: Material, second: Material) -> Material:
    """The material that stands for the contact of two. Static friction is never below dynamic friction."""
    friction = _stronger(first.friction_mode, second.friction_mode)
    sliding = combined(friction, first.sliding, second.sliding)
    return Material(
        static=max(sliding, combined(friction, first.static, second.static)),
        sliding=sliding,
        restitution=combined(
            _stronger(first.restitution_mode, second.restitution_mode), first.restitution, second.restitution
        ),
        torsion=max(first.torsion, second.torsion),
        rolling=max(first.rolling, second.rolling),
    )


def combined(mode: Mode, first: float, second: float) -> float:
    """Combines two values."""
    if mode == "average":
        return (first + second) / 2
    if mode == "multiply":
        return first * second
    return min(first, second) if mode == "min" else max(first, second)


def _stronger(first: Mode, second: Mode) -> Mode:
    return MODES[max(MODES.index(first), MODES.index(second))]


def bound_material(prim: Any) -> Any:
    """The UsdPhysics.MaterialAPI that is bound to a prim for physics, or None."""
    material, _ = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial("physics")
    if not material or not material.GetPrim().HasAPI(UsdPhysics.MaterialAPI):
        return None
    return UsdPhysics.MaterialAPI(material.GetPrim())


def read_material(api: Any, warn: Warn) -> Material:
    """The material of a UsdPhysics.MaterialAPI (None: unbound).

    If only one friction is authored, the other one is equal.
    """
    if api is None:
        return PLAIN
    material = api.GetPrim()
    path = str(material.GetPath())
    static, sliding = api.GetStaticFrictionAttr(), api.GetDynamicFrictionAttr()
    if not static.HasAuthoredValue():
        static = sliding
    if not sliding.HasAuthoredValue():
        sliding = static

    def number(attribute: Any, default: float, most: float = math.inf) -> float:
        value = attribute.Get(EARLIEST) if attribute else None
        if value is None:
            return default
        if not math.isfinite(value) or not 0 <= value <= most:
            said = "a number from 0" + (f" to {most:g}" if most < math.inf else "")
            warn("bad-material", path, f"{attribute.GetName()} is {value:g}, not {said}; {default:g} is taken")
            return default
        return float(value)

    def optional(names: tuple[str, ...], default: float) -> float:
        found = next((a for name in names if (a := material.GetAttribute(name)) and a.HasAuthoredValue()), None)
        return number(found, default)

    def mode(name: str) -> Mode:
        attribute = material.GetAttribute(f"physxMaterial:{name}CombineMode")
        value = attribute.Get(EARLIEST) if attribute else None
        if value is not None and value not in MODES:
            warn("bad-material", path, f"{attribute.GetName()} is {value!r}, not one of {', '.join(MODES)}; average is")
        return next((each for each in MODES if each == value), "average")

    return Material(
        static=number(static, DEFAULT_FRICTION),
        sliding=number(sliding, DEFAULT_FRICTION),
        restitution=number(api.GetRestitutionAttr(), 0.0, 1.0),
        friction_mode=mode("friction"),
        restitution_mode=mode("restitution"),
        torsion=optional(("newton:torsionalFriction", "mjc:torsionalfriction"), TORSION),
        rolling=optional(("newton:rollingFriction", "mjc:rollingfriction"), ROLLING),
    )
