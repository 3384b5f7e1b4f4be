"""The solver options: chosen by fidelity knobs, by the scene's own attributes or by the needs of the scene.

A knob is preferred over an attribute of the physics scene, then the needs of the scene, then MuJoCo's defaults.
"""

from __future__ import annotations

import math
from dataclasses import fields, replace
from typing import TYPE_CHECKING, Any

from graph.base.limits import check
from graph.base.records import dataclass
from graph.sim.attributes import value_of
from graph.sim.scene.stage import Warn

if TYPE_CHECKING:
    from graph.sim.fidelity import Fidelity
    from graph.sim.scene.scan import Scan

CHOICES: dict[str, dict[str, str]] = {
    "integrator": {name: f"mjINT_{name.upper()}" for name in ("euler", "rk4", "implicit", "implicitfast", "discrete")},
    "solver": {name: f"mjSOL_{name.upper()}" for name in ("pgs", "cg", "newton")},
    "cone": {name: f"mjCONE_{name.upper()}" for name in ("pyramidal", "elliptic")},
    "jacobian": {name: f"mjJAC_{name.upper()}" for name in ("auto", "dense", "sparse")},
}
"""By option, its values and MuJoCo's constants for them."""

SWITCHES = {"multiccd": "mjDSBL_MULTICCD", "nativeccd": "mjDSBL_NATIVECCD"}
"""By option, MuJoCo's bit that disables it."""

_COUNTS = ("iterations", "ls_iterations", "noslip_iterations", "ccd_iterations")


@dataclass(frozen=True, slots=True)
class SolverOptions:
    """Options by MuJoCo's own names; None leaves the engine's default (or that of the model's file)."""

    integrator: str | None = None
    solver: str | None = None
    cone: str | None = None
    jacobian: str | None = None
    iterations: int | None = None
    ls_iterations: int | None = None
    noslip_iterations: int | None = None
    ccd_iterations: int | None = None
    tolerance: float | None = None
    ls_tolerance: float | None = None
    ccd_tolerance: float | None = None
    impratio: float | None = None
    multiccd: bool | None = None
    nativeccd: bool | None = None
    density: float | None = None
    """Of the medium that bodies move through [kg/m3]."""
    viscosity: float | None = None
    """Of the medium [Pa s]."""
    wind: tuple[float, float, float] | None = None
    """Velocity of the medium [m/s]."""

    def over(self, other: SolverOptions) -> SolverOptions:
        """These options, with `other` for those that are None."""
        mine = {f.name: value for f in fields(self) if (value := getattr(self, f.name)) is not None}
        return replace(other, **mine)


UNCHOSEN = SolverOptions()
"""The engine's defaults."""


def chosen(fidelity: Fidelity | None) -> SolverOptions:
    """The options of fidelity knobs (`physics.solver` ...)."""
    if fidelity is None:
        return SolverOptions()
    names = [f.name for f in fields(SolverOptions) if hasattr(fidelity, f"physics_{f.name}")]
    return SolverOptions(**{name: getattr(fidelity, f"physics_{name}") for name in names})


def authored_options(scan: Scan, warn: Warn) -> SolverOptions:
    """The options of the first physics scene: mjc:option:*, newton:maxSolverIterations, physxScene:*."""
    if not scan.scenes:
        return SolverOptions()
    scene = scan.scenes[0]
    path = str(scene.GetPath())
    found: dict[str, Any] = {}

    def complain(name: str, value: Any, wanted: str) -> None:
        warn("bad-scene-option", path, f"{name} is {value!r}, not {wanted}; it has no effect")

    iterations = value_of(scene, "newton:maxSolverIterations")
    if iterations is not None and not math.isfinite(iterations):
        complain("newton:maxSolverIterations", iterations, "a number from 1")
    elif iterations is not None and iterations > 0:
        check("physics.iterations", iterations, f"{path}: newton:maxSolverIterations is {iterations:,}")
        found["iterations"] = int(iterations)
    for f in fields(SolverOptions):
        name = f"mjc:option:{f.name}"
        value = value_of(scene, name)
        if value is None:
            continue
        if f.name in CHOICES:
            if str(value) in CHOICES[f.name]:
                found[f.name] = str(value)
            else:
                complain(name, value, f"one of {', '.join(CHOICES[f.name])}")
        elif f.name == "wind":
            if all(map(math.isfinite, value)):
                found[f.name] = tuple(map(float, value))
            else:
                complain(name, tuple(value), "three finite numbers")
        elif f.name in _COUNTS:
            check("physics.iterations", value, f"{path}: {name} is {value:,}")
            if value >= (0 if f.name == "noslip_iterations" else 1):
                found[f.name] = int(value)
            else:
                complain(name, value, "a number from 1")
        elif math.isfinite(value) and value >= 0 and (value > 0 or f.name != "impratio"):
            found[f.name] = float(value)
        else:
            complain(name, value, "a number from 0")
    for name, switch in (("mjc:flag:multiccd", "multiccd"), ("mjc:flag:nativeccd", "nativeccd")):
        value = value_of(scene, name)
        if value is not None:
            found[switch] = bool(value)
    if value_of(scene, "physxScene:enableCCD"):
        warn(
            "no-continuous-collision",
            path,
            "physxScene:enableCCD has no effect: collisions are looked for at every physics step and not between. "
            "Raise physics_hz where fast bodies pass through thin ones",
        )
    return SolverOptions(**found)
