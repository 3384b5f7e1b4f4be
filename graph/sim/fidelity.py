"""Fidelity knobs: every approximation by name, typed and checked; defaults are the cheapest documented behaviour."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any, Literal

from graph import exact
from graph.errors import Mark, Problem, UserError

Kind = Literal["rate", "count", "length", "switch", "choice"]


@dataclass(frozen=True, slots=True)
class Knob:
    """What a knob takes: a rate [Hz], a count from 1, a length [m], on/off, or one of `choices`.

    `available`: the values that can be run so far, where that is not all of them.
    """

    kind: Kind
    doc: str
    choices: tuple[str, ...] = ()
    available: tuple[Any, ...] | None = None


KNOBS: dict[str, Knob] = {
    "physics.hz": Knob("rate", "physics steps per second; beats the clock's physics_hz"),
    "physics.integrator": Knob(
        "choice", "how states are integrated", ("euler", "rk4", "implicit", "implicitfast", "discrete")
    ),
    "physics.iterations": Knob("count", "most solver iterations per step"),
    "lidar.motion": Knob(
        "choice",
        "frozen: the whole scan at its tick; update: each update casts what fired since; continuous: each firing alone",
        ("frozen", "update", "continuous"),
    ),
    "lidar.bins": Knob(
        "count", "lidar.motion continuous: into how many spans of time a scan is cut; bodies keep still in each"
    ),
    "lidar.noise": Knob("switch", "seeded range, angle and origin errors, and the range offsets of the profile"),
    "lidar.subrays": Knob("count", "rays per beam, over its divergence; they may bring several returns"),
    "radar.rays": Knob("count", "rays per radar frame", available=()),
    "radar.bounces": Knob("count", "reflections that a radar ray follows", available=()),
    "camera.samples": Knob("count", "rays per pixel", available=(1,)),
    "mesh.tolerance": Knob("length", "largest distance between a curved primitive and the triangles that stand for it"),
    "fabric": Knob(
        "switch", "world transforms flattened (on) or written to USD every substep (off)", available=(True,)
    ),
    "tlas": Knob("choice", "sensors see the state of their own tick, or the update's last state", ("sensor", "frame")),
}
"""Every knob by the name that graph files and the command line use."""


@dataclass(frozen=True, slots=True)
class Fidelity:
    """The knobs' values; `lidar.motion` is the field `lidar_motion`. None leaves the choice to the scene or model."""

    physics_hz: Fraction | None = None
    physics_integrator: Literal["euler", "rk4", "implicit", "implicitfast", "discrete"] | None = None
    physics_iterations: int | None = None
    lidar_motion: Literal["frozen", "update", "continuous"] = "frozen"
    lidar_bins: int = 8
    lidar_noise: bool = False
    lidar_subrays: int = 1
    radar_rays: int | None = None
    radar_bounces: int | None = None
    camera_samples: int = 1
    mesh_tolerance: float = 0.001
    fabric: bool = True
    tlas: Literal["sensor", "frame"] = "sensor"

    @classmethod
    def from_mapping(
        cls, values: Mapping[str, Any], where: Callable[[str], Mark | None] = lambda key: None
    ) -> Fidelity:
        """Knobs from names to values (typed, or text as on the command line).

        Raises UserError with every problem, each with the mark that `where(name)` gives.
        """
        chosen, problems = {}, []
        for name, value in values.items():
            try:
                chosen[name.replace(".", "_")] = _checked(name, value)
            except ValueError as error:
                problems.append(Problem(f"fidelity {name}: {error}", where(name)))
        if problems:
            raise UserError(problems)
        return replace(cls(), **chosen)

    def __getitem__(self, name: str) -> Any:
        """The value of a knob such as "lidar.motion"."""
        if name not in KNOBS:
            raise KeyError(name)
        return getattr(self, name.replace(".", "_"))

    def as_dict(self) -> dict[str, Any]:
        """Every knob's value by name."""
        return {name: self[name] for name in KNOBS}


def _checked(name: str, value: Any) -> Any:
    knob = KNOBS.get(name)
    if knob is None:
        near = difflib.get_close_matches(name, KNOBS, n=1)
        hint = f'did you mean "{near[0]}"?' if near else f"the knobs are {', '.join(KNOBS)}"
        raise ValueError(f"there is no such knob; {hint}")
    checked: Any
    if knob.kind == "choice":
        checked = _choice(value, knob.choices)
    elif knob.kind == "switch":
        checked = value if isinstance(value, bool) else _choice(value, ("on", "off")) == "on"
    else:
        checked = _positive(value, knob.kind)
    if knob.available is not None and checked not in knob.available:
        raise ValueError(f"{value!r} is not available yet; {_instead(knob)}")
    return checked


def _instead(knob: Knob) -> str:
    words = {True: "on", False: "off"} if knob.kind == "switch" else {}
    allowed = [str(words.get(value, value)) for value in knob.available or ()]
    return f"use {' or '.join(allowed)}" if allowed else "leave it out"


def _choice(value: Any, choices: tuple[str, ...]) -> str:
    if value not in choices:
        raise ValueError(f"{value!r} is not one of {', '.join(choices)}")
    return str(value)


def _positive(value: Any, kind: Kind) -> Fraction | int | float:
    try:
        number = exact.rate(value)
    except (ValueError, TypeError):
        raise ValueError(f"{value!r} is not a number") from None
    if number <= 0:
        raise ValueError(f"{value!r} is not above 0")
    if kind == "count":
        if number.denominator != 1:
            raise ValueError(f"{value!r} is not a whole number")
        return int(number)
    return number if kind == "rate" else float(number)
