"""Fidelity knobs: every approximation by name, typed and checked; defaults are the cheapest documented behaviour."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, replace
from fractions import Fraction
from typing import Any, Literal

from graph import exact
from graph.errors import Mark, Problem, UserError

Integrator = Literal["euler", "rk4", "implicit", "implicitfast", "discrete"]


@dataclass(frozen=True, slots=True)
class Fidelity:
    """The knobs; a key such as `lidar.motion` is the field `lidar_motion`. None leaves the choice to the scene."""

    physics_hz: Fraction | None = None
    """Steps per second [Hz]; beats the clock's `physics_hz`."""
    physics_integrator: Integrator | None = None
    physics_iterations: int | None = None
    lidar_motion: Literal["frozen", "update", "continuous"] = "frozen"
    lidar_noise: bool = False
    lidar_subrays: int = 1
    """Rays per beam."""
    radar_rays: int | None = None
    radar_bounces: int | None = None
    camera_samples: int = 1
    mesh_tolerance: float = 0.001
    """Largest distance [m] between a curved primitive and the triangles that stand for it."""
    fabric: bool = True
    tlas: Literal["sensor", "frame"] = "sensor"

    @classmethod
    def from_mapping(
        cls, values: Mapping[str, Any], where: Callable[[str], Mark | None] = lambda key: None
    ) -> Fidelity:
        """Knobs from keys such as `lidar.motion` to values (typed, or text as on the command line).

        Raises UserError with every problem, each with the mark that `where(key)` gives.
        """
        chosen, problems = {}, []
        for key, value in values.items():
            try:
                chosen[key.replace(".", "_")] = _checked(key, value)
            except ValueError as error:
                problems.append(Problem(f"fidelity {key}: {error}", where(key)))
        if problems:
            raise UserError(problems)
        return replace(cls(), **chosen)

    def __getitem__(self, key: str) -> Any:
        """The value of a key such as "lidar.motion"."""
        if key not in KEYS:
            raise KeyError(key)
        return getattr(self, key.replace(".", "_"))

    def as_dict(self) -> dict[str, Any]:
        """Every key with its value."""
        return {key: self[key] for key in KEYS}


KEYS = tuple(
    field.name if field.name in ("fabric", "tlas") else field.name.replace("_", ".", 1) for field in fields(Fidelity)
)
"""The knobs' names as graph files and the command line write them."""


def _checked(key: str, value: Any) -> Any:
    if key not in KEYS:
        near = difflib.get_close_matches(key, KEYS, n=1)
        hint = f'did you mean "{near[0]}"?' if near else f"the knobs are {', '.join(KEYS)}"
        raise ValueError(f"there is no such knob; {hint}")
    return _CHECKS[key](value)


def _choice(*allowed: str) -> Callable[[Any], str]:
    def check(value: Any) -> str:
        if value not in allowed:
            raise ValueError(f"{value!r} is not one of {', '.join(allowed)}")
        return str(value)

    return check


def _switch(value: Any) -> bool:
    truth = {True: True, False: False, "on": True, "off": False, "true": True, "false": False}.get(
        value if isinstance(value, (bool, str)) else None
    )
    if truth is None:
        raise ValueError(f"{value!r} is not one of on, off")
    return truth


def _count(value: Any) -> int:
    number = _number(value)
    if number.denominator != 1 or number < 1:
        raise ValueError(f"{value!r} is not a whole number above 0")
    return int(number)


def _rate(value: Any) -> Fraction:
    number = _number(value)
    if number <= 0:
        raise ValueError(f"{value!r} is not a rate above 0 Hz")
    return number


def _length(value: Any) -> float:
    number = _number(value)
    if number <= 0:
        raise ValueError(f"{value!r} is not a length above 0 m")
    return float(number)


def _number(value: Any) -> Fraction:
    try:
        return exact.rate(value)
    except (ValueError, TypeError):
        raise ValueError(f"{value!r} is not a number") from None


_CHECKS: dict[str, Callable[[Any], Any]] = {
    "physics.hz": _rate,
    "physics.integrator": _choice("euler", "rk4", "implicit", "implicitfast", "discrete"),
    "physics.iterations": _count,
    "lidar.motion": _choice("frozen", "update", "continuous"),
    "lidar.noise": _switch,
    "lidar.subrays": _count,
    "radar.rays": _count,
    "radar.bounces": _count,
    "camera.samples": _count,
    "mesh.tolerance": _length,
    "fabric": _switch,
    "tlas": _choice("sensor", "frame"),
}
