"""Physics scenes in MuJoCo's terms."""

from __future__ import annotations

import math
from collections.abc import Iterable
from fractions import Fraction
from typing import Any

from graph.base import exact
from graph.sim.attributes import value_of

from .physics_scene import PhysicsScene

_CHOICES = {
    "integrator": ("euler", "rk4", "implicit", "implicitfast", "discrete"),
    "solver": ("pgs", "cg", "newton"),
    "cone": ("pyramidal", "elliptic"),
    "jacobian": ("auto", "dense", "sparse"),
}


class NewtonMjcScene(PhysicsScene):
    """A physics scene with MuJoCo's options, `mjc:option:*` of MjcSceneAPI; they take effect at the next play.

    An unauthored option reads as MuJoCo's default, even if this engine chooses another one (its integrator: see
    `graph.sim.physics.build_physics`). Setters raise ValueError for values that the option does not accept.
    """

    def get_dt(self) -> float:
        """The authored time step [s], else MuJoCo's 0.002; an App uses another one until `set_dt` authors it."""
        return float(self._authored("mjc:option:timestep", 0.002))

    def set_dt(self, dt: float | Fraction) -> None:
        """Sets the time step [s], without rounding. Raises ValueError unless dt > 0."""
        step = exact.duration(dt)
        if step <= 0:
            raise ValueError(f"dt {dt}: give a time step above 0 s")
        self._set_rate(1 / step, as_step=True)

    def get_integrator(self) -> str:
        """The integrator: "euler" (default), "rk4", "implicit", "implicitfast" or "discrete"."""
        return self._token("integrator", "euler")

    def set_integrator(self, integrator: str) -> None:
        """Sets the integrator."""
        self._choose("integrator", integrator)

    def get_solver(self) -> str:
        """The constraint solver: "pgs", "cg" or "newton" (default)."""
        return self._token("solver", "newton")

    def set_solver(self, solver: str) -> None:
        """Sets the constraint solver."""
        self._choose("solver", solver)

    def get_iterations(self) -> int:
        """Most solver iterations per step, 100 unless authored."""
        return int(self._number("iterations", 100))

    def set_iterations(self, iterations: int) -> None:
        """Sets the most solver iterations per step, 0 or more."""
        if iterations < 0:
            raise ValueError(f"iterations {iterations}: give 0 or more")
        self._author("mjc:option:iterations", "Int", int(iterations))

    def get_tolerance(self) -> float:
        """The improvement at which the solver ends early, 1e-8 unless authored."""
        return float(self._number("tolerance", 1e-8))

    def set_tolerance(self, tolerance: float) -> None:
        """Sets the improvement at which the solver ends early, 0 or more."""
        self._author_number("tolerance", tolerance)

    def get_cone(self) -> str:
        """The shape of friction cones: "pyramidal" (default) or "elliptic"."""
        return self._token("cone", "pyramidal")

    def set_cone(self, cone: str) -> None:
        """Sets the shape of friction cones."""
        self._choose("cone", cone)

    def get_jacobian(self) -> str:
        """How the constraints' Jacobian is stored: "auto" (default), "dense" or "sparse"."""
        return self._token("jacobian", "auto")

    def set_jacobian(self, jacobian: str) -> None:
        """Sets how the constraints' Jacobian is stored."""
        self._choose("jacobian", jacobian)

    def get_impratio(self) -> float:
        """The ratio of frictional to normal impedance for elliptic cones, 1 unless authored."""
        return float(self._number("impratio", 1.0))

    def set_impratio(self, impratio: float) -> None:
        """Sets the ratio of impedances, above 0."""
        if not impratio > 0:
            raise ValueError(f"impratio {impratio}: give a number above 0")
        self._author_number("impratio", impratio)

    def get_wind(self) -> Any:
        """The medium's velocity, `Gf.Vec3d` [m/s] in the world; 0 unless authored."""
        from graph.sim.usd import Gf

        return Gf.Vec3d(self._number("wind", (0.0, 0.0, 0.0)))

    def set_wind(self, wind: Iterable[float]) -> None:
        """Sets the medium's velocity, (3,) [m/s] in the world."""
        from graph.sim.usd import Gf

        vector = Gf.Vec3d(*[float(each) for each in wind])
        if not math.isfinite(vector.GetLength()):
            raise ValueError(f"wind {tuple(vector)}: give three finite numbers")
        self._author("mjc:option:wind", "Double3", vector)

    def get_density(self) -> float:
        """The medium's density [kg/m3], 0 unless authored."""
        return float(self._number("density", 0.0))

    def set_density(self, density: float) -> None:
        """Sets the medium's density [kg/m3], 0 or more."""
        self._author_number("density", density)

    def get_viscosity(self) -> float:
        """The medium's viscosity [Pa s], 0 unless authored."""
        return float(self._number("viscosity", 0.0))

    def set_viscosity(self, viscosity: float) -> None:
        """Sets the medium's viscosity [Pa s], 0 or more."""
        self._author_number("viscosity", viscosity)

    def _number(self, option: str, default: Any) -> Any:
        value = value_of(self._prim, f"mjc:option:{option}")
        return default if value is None else value

    def _token(self, option: str, default: str) -> str:
        return str(self._number(option, default))

    def _choose(self, option: str, value: str) -> None:
        if value not in _CHOICES[option]:
            raise ValueError(f"{option} {value!r} is not one of {', '.join(_CHOICES[option])}")
        self._author(f"mjc:option:{option}", "Token", value)

    def _author_number(self, option: str, value: float) -> None:
        if not (math.isfinite(value) and value >= 0):
            raise ValueError(f"{option} {value}: give a finite number, 0 or more")
        self._author(f"mjc:option:{option}", "Double", float(value))
