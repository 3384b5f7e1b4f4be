"""Fidelity knobs: every approximation by name, typed and checked; defaults are the cheapest documented behaviour."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any, Literal

from graph.base import exact
from graph.base.errors import Mark, Problem, UserError
from graph.base.suggest import did_you_mean

Kind = Literal["rate", "count", "length", "number", "switch", "choice"]


@dataclass(frozen=True, slots=True)
class Knob:
    """What a knob takes: a rate [Hz], a count from 1, a length [m], a number above 0, on/off, or one of `choices`.

    `available`: the values that can be run so far, where that is not all of them, and what is `missing` for the others.
    """

    kind: Kind
    doc: str
    choices: tuple[str, ...] = ()
    available: tuple[Any, ...] | None = None
    missing: str = ""


_NO_GPU_ENGINE = "the engine here is MuJoCo, which computes on the CPU; an engine for the GPU (MuJoCo Warp) is missing"

KNOBS: dict[str, Knob] = {
    "physics.hz": Knob("rate", "physics steps per second; beats the clock's physics_hz"),
    "physics.integrator": Knob(
        "choice", "how states are integrated", ("euler", "rk4", "implicit", "implicitfast", "discrete")
    ),
    "physics.solver": Knob("choice", "how constraints are solved", ("pgs", "cg", "newton")),
    "physics.cone": Knob("choice", "shape of friction cones", ("pyramidal", "elliptic")),
    "physics.jacobian": Knob("choice", "how constraints are stored", ("auto", "dense", "sparse")),
    "physics.iterations": Knob("count", "most solver iterations per step"),
    "physics.ls_iterations": Knob("count", "most line search iterations per solver iteration"),
    "physics.noslip_iterations": Knob("count", "iterations that take the slip out of friction after solving"),
    "physics.ccd_iterations": Knob("count", "most iterations of the convex collision detection"),
    "physics.tolerance": Knob("number", "improvement below which the solver stops"),
    "physics.ls_tolerance": Knob("number", "improvement below which the line search stops"),
    "physics.ccd_tolerance": Knob("number", "precision of the convex collision detection"),
    "physics.impratio": Knob("number", "how much harder friction is than contact (elliptic cones)"),
    "physics.multiccd": Knob("switch", "several contacts between two convex meshes"),
    "physics.nativeccd": Knob("switch", "MuJoCo's own convex collision detection, else that of libccd"),
    "physics.dynamics": Knob("choice", "where dynamics are computed", ("cpu", "cuda"), ("cpu",), _NO_GPU_ENGINE),
    "physics.pipeline": Knob("choice", "where the physics' state lives", ("cpu", "cuda"), ("cpu",), _NO_GPU_ENGINE),
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
    "mesh.tolerance": Knob("length", "largest distance between a curved surface and the triangles that stand for it"),
    "mesh.subdivision": Knob(
        "choice", "subdivision surfaces as their cages, or refined to mesh.tolerance", ("cage", "refined")
    ),
    "fabric": Knob("switch", "world transforms flattened (on), or written to the stage after every physics step (off)"),
    "tlas": Knob("choice", "sensors see the state of their own tick, or the update's last state", ("sensor", "frame")),
}
"""Every knob by the name that graph files and the command line use."""


@dataclass(frozen=True, slots=True)
class Fidelity:
    """The knobs' values; `lidar.motion` is the field `lidar_motion`. None leaves the choice to the scene or model."""

    physics_hz: Fraction | None = None
    physics_integrator: Literal["euler", "rk4", "implicit", "implicitfast", "discrete"] | None = None
    physics_solver: Literal["pgs", "cg", "newton"] | None = None
    physics_cone: Literal["pyramidal", "elliptic"] | None = None
    physics_jacobian: Literal["auto", "dense", "sparse"] | None = None
    physics_iterations: int | None = None
    physics_ls_iterations: int | None = None
    physics_noslip_iterations: int | None = None
    physics_ccd_iterations: int | None = None
    physics_tolerance: float | None = None
    physics_ls_tolerance: float | None = None
    physics_ccd_tolerance: float | None = None
    physics_impratio: float | None = None
    physics_multiccd: bool | None = None
    physics_nativeccd: bool | None = None
    physics_dynamics: Literal["cpu"] = "cpu"
    physics_pipeline: Literal["cpu"] = "cpu"
    lidar_motion: Literal["frozen", "update", "continuous"] = "frozen"
    lidar_bins: int = 8
    lidar_noise: bool = False
    lidar_subrays: int = 1
    radar_rays: int | None = None
    radar_bounces: int | None = None
    camera_samples: int = 1
    mesh_tolerance: float = 0.001
    mesh_subdivision: Literal["cage", "refined"] = "cage"
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
        hint = did_you_mean(name, KNOBS, f"the knobs are {', '.join(KNOBS)}")
        raise ValueError(f"there is no such knob{hint}")
    checked: Any
    if knob.kind == "choice":
        checked = _choice(value, knob.choices)
    elif knob.kind == "switch":
        checked = value if isinstance(value, bool) else _choice(value, ("on", "off")) == "on"
    else:
        checked = _positive(value, knob.kind)
    if knob.available is not None and checked not in knob.available:
        missing = f": {knob.missing}" if knob.missing else " yet"
        raise ValueError(f"{value!r} is not available{missing}; {_instead(knob)}")
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
