"""The attributes of physics scene prims, by the names of UsdPhysics, PhysX, Newton and MuJoCo."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from graph.base import exact
from graph.sim.attributes import applied_schemas, value_of

EARTH_GRAVITY = 9.81

RATE_ATTRIBUTES = ("physxScene:timeStepsPerSecond", "mjc:option:timestep", "newton:timeStepsPerSecond")
"""The attributes with the step rate of a scene; an earlier name is preferred."""

_SCHEMAS = {"physxScene": "PhysxSceneAPI", "mjc": "MjcSceneAPI", "newton": "NewtonSceneAPI"}
"""The API schema of an attribute, by the first part of its name."""


def scene_prims(stage: Any) -> Any:
    """The physics scene prims of a stage, in stage order."""
    from graph.sim.usd import UsdPhysics

    return (prim for prim in stage.Traverse() if prim.IsA(UsdPhysics.Scene))


def author(prim: Any, name: str, kind: str, value: Any) -> None:
    """Sets an attribute; a missing one is created with type `kind` (a name of `Sdf.ValueTypeNames`); None blocks it."""
    from graph.sim.usd import Sdf

    attribute = prim.GetAttribute(name)
    if value is None:
        if attribute:
            attribute.Block()
        return
    _apply_schema(prim, name)
    if not attribute:
        attribute = prim.CreateAttribute(name, getattr(Sdf.ValueTypeNames, kind), custom=False)
    attribute.Set(value)


def _apply_schema(prim: Any, name: str) -> None:
    """Applies the API schema of an attribute, by name, since this USD may not know it."""
    schema = _SCHEMAS.get(name.partition(":")[0])
    applied = applied_schemas(prim)
    if schema is None or schema in applied:
        return
    prim.AddAppliedSchema(schema)
    if not set(applied) & set(_SCHEMAS.values()) and schema != "PhysxSceneAPI":
        prim.AddAppliedSchema("PhysxSceneAPI")  # so that the scene's default stays 60 steps per second


def authored_rate(prim: Any) -> Fraction | None:
    """Steps per second [Hz] that a scene prim authors; 0 for 0 (or less), None if not authored.

    An API schema that is applied without a value has its own default: 1000 Hz of NewtonSceneAPI, 500 Hz of MjcSceneAPI,
    unless PhysxSceneAPI, with the general default of 60 Hz, is applied too.
    """
    for name in RATE_ATTRIBUTES:
        value = value_of(prim, name)
        if value is None:
            continue
        try:
            number = exact.duration(value) if name.endswith("timestep") else exact.rate(value)
        except ValueError:
            return Fraction(0)
        if number <= 0:
            return Fraction(0)
        return 1 / number if name.endswith("timestep") else number
    applied = applied_schemas(prim)
    if "PhysxSceneAPI" in applied:
        return None
    if "MjcSceneAPI" in applied:
        return Fraction(500)
    return Fraction(1000) if newton_only(prim) else None


def newton_only(prim: Any) -> bool:
    """Whether a scene prim has Newton's attributes and not PhysX's."""
    applied = applied_schemas(prim)
    return "NewtonSceneAPI" in applied and "PhysxSceneAPI" not in applied
