"""An oracle: a small scene whose answer is known on paper, and the error of physics against it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

from graph.sim.fidelity import Fidelity
from graph.sim.physics import build_physics
from graph.sim.scene.prims import author_prims
from graph.sim.scene.stage import open_stage

INTEGRATORS = ("euler", "implicit", "implicitfast", "discrete", "rk4")
G = 9.81
NO_GRAVITY = {"/Scene": {"type": "PhysicsScene", "attributes": {"physics:gravityMagnitude": 0.0}}}
GROUND = {"/Ground": {"type": "Plane"}}

Knobs = Mapping[str, Any]

WIDE = tuple(30 * 2**power for power in range(10))
NARROW = (60, 90, 120, 180, 240, 360, 480, 720, 960, 1440)
CROWDED = (30, 40, 60, 80, 100, 120, 150, 180, 200, 240)
"""Ten physics rates [Hz]: from 30 to 15,360, for scenes that take longer, and for hundreds of bodies."""


@dataclass(frozen=True)
class Case:
    """A scene with a known answer.

    error: by physics steps per second and knobs, how far the scene's physics is from it [unit]. bound: of the error at
    `hz` with the defaults. orders: by integrator, the power of the step that the error follows in theory; the others
    are not smooth, or exact. rates: those of the study [Hz]. floor: errors below it are not those of the step.
    """

    name: str
    answer: str
    unit: str
    error: Callable[[int, Knobs], float]
    bound: float
    hz: int = 240
    orders: Mapping[str, int] = field(default_factory=dict)
    rates: tuple[int, ...] = WIDE
    floor: float = 1e-11


def first_order(rk4: int | None = 4) -> dict[str, int]:
    """The orders in theory of smooth motion."""
    return {name: 1 for name in INTEGRATORS if name != "rk4"} | ({} if rk4 is None else {"rk4": rk4})


def world(prims: Mapping[str, Any], hz: int, knobs: Knobs) -> Any:
    """The physics of inline prims; knobs: without `physics.`."""
    stage = open_stage()
    author_prims(stage, prims)
    fidelity = Fidelity.from_mapping({f"physics.{name}": value for name, value in knobs.items()})
    physics = build_physics(stage, Fraction(1, hz), fidelity)
    assert physics is not None
    return physics


def material(path: str, friction: float, restitution: float = 0.0) -> dict[str, Any]:
    """A physics material as a prim."""
    values = {"staticFriction": friction, "dynamicFriction": friction, "restitution": restitution}
    attributes = {f"physics:{name}": value for name, value in values.items()}
    return {path: {"type": "Material", "schemas": "PhysicsMaterialAPI", "attributes": attributes}}
