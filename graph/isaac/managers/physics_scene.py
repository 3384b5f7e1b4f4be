"""Physics scenes: the prims with the settings of a simulation, and wrappers around them with Isaac Sim's calls.

A wrapper whose prim is the *active* scene of an App, its stage's first one, controls that App: `set_dt` takes effect
from the next step on, `set_gravity` at once. Values set while playing are authored again after stop has restored the
stage, so they last. Other scenes are only prims: values set there are stored on them.
"""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction
from typing import Any, Protocol

from graph.base import exact
from graph.base.errors import RunError
from graph.base.suggesting import Suggesting
from graph.sim import entered
from graph.sim.attributes import value_of
from graph.sim.scene.prim_paths import is_path
from graph.sim.scene.scene_attributes import (
    EARTH_GRAVITY,
    RATE_ATTRIBUTES,
    author,
    authored_rate,
    newton_only,
    scene_prims,
)
from graph.sim.scene.stage_metadata import meters_per_unit, up_axis

DEFAULT_PATH = "/PhysicsScene"
DEFAULT_RATE = 60


def steps_per_second(dt: float | Fraction, *, truncate: bool = False) -> Fraction:
    """The rate [Hz] that a step of `dt` [s] means: exactly 1 / dt, or the whole number int(1 / dt); 0 for dt 0.

    Isaac Sim stores whole rates, computed in floating point: 1/99 gives 98. Raises ValueError unless dt is 0,
    or from 1e-9 to 1 s.
    """
    step = exact.duration(dt)
    if not 0 <= step <= 1:
        raise ValueError(f"dt {dt}: a physics step lasts from 0 to 1 s")
    if not step:
        return Fraction(0)
    if step * 10**9 < 1:
        raise ValueError(f"dt {dt}: a physics step of less than 1e-9 s cannot be run")
    return Fraction(int(1.0 / float(dt))) if truncate else 1 / step


class Setup(Protocol):
    """The simulation of a stage by its active scene (`simulation_setup.SimulationSetup`)."""

    scene_path: str

    @property
    def stage(self) -> Any:
        """The stage that is simulated."""

    @property
    def built(self) -> bool:
        """Whether the world is built."""

    @property
    def truncates(self) -> bool:
        """Whether a dt is stored as a whole number of steps per second."""

    @property
    def next_rate(self) -> Fraction:
        """The rate of the next step [Hz]."""

    def set_rate(self, steps_per_second: Fraction) -> None:
        """Sets a new physics rate [Hz] from the next step on."""

    def refuse_rate_zero(self, path: str | None = None) -> None:
        """Warns that a rate of 0 is stored but not run."""

    def scene_changed(self, scene: PhysicsScene, name: str, kind: str, value: Any) -> None:
        """Called when an attribute of a scene was set while playing."""

    def warn(self, code: str, where: str, message: str) -> None:
        """Gives a warning."""


class Simulated(Protocol):
    """The part of an App that is used here."""

    @property
    def simulation(self) -> Setup:
        """Its simulation."""


class PhysicsScene(Suggesting):
    """A UsdPhysics scene prim: at a path (a missing one is created) or given as a prim.

    `app` defaults to the current App, if the prim is on its stage. Raises ValueError for a prim of another type,
    RunError for a scene to be created while the simulation plays.
    """

    def __init__(self, prim: Any = DEFAULT_PATH, app: Simulated | None = None, *, setup: Setup | None = None) -> None:
        """setup: the simulation of the stage, instead of an App."""
        from graph.sim.usd import Sdf, UsdPhysics

        named = isinstance(prim, (str, Sdf.Path))
        if setup is None:
            if app is None:
                app = entered.current() if named else entered.of_stage(prim.GetStage()) if prim else None
            setup = None if app is None else app.simulation
        if named:
            assert setup is not None  # entered.current() raises without an App
            prim = _scene_at(setup, str(prim))
        if not prim or not prim.IsA(UsdPhysics.Scene):
            name = f"{prim.GetPath()}: a prim of type {prim.GetTypeName() or 'none'}" if prim else "an expired prim"
            raise ValueError(f"{name} is not a PhysicsScene")
        self._prim = prim
        self._setup = setup

    @property
    def path(self) -> str:
        """The prim's path."""
        return str(self._prim.GetPath())

    @property
    def prim(self) -> Any:
        """The `Usd.Prim`."""
        return self._prim

    @property
    def physics_scene(self) -> Any:
        """The prim as `UsdPhysics.Scene`."""
        from graph.sim.usd import UsdPhysics

        return UsdPhysics.Scene(self._prim)

    @staticmethod
    def get_physics_scene_paths(stage: Any = None) -> list[str]:
        """The paths of all physics scenes of a stage (default: the current App's), in the order of the stage."""
        return [str(prim.GetPath()) for prim in scene_prims(stage or entered.current().stage)]

    @property
    def is_active(self) -> bool:
        """Whether an App simulates with this scene: the first one of its stage."""
        setup = self._setup
        if setup is None:
            return False
        if setup.built:
            return setup.scene_path == self.path
        return bool(next(scene_prims(setup.stage), None) == self._prim)

    def get_dt(self) -> float:
        """The length of a physics step [s]: the App's for its active scene, else the authored one; 0.0 at rate 0."""
        rate = self._rate()
        return float(1 / rate) if rate else 0.0

    def set_dt(self, dt: float | Fraction) -> None:
        """Sets the length of a physics step [s], from 0 to 1.

        The profile `isaacsim-6.0.1` stores the whole number int(1 / dt) of steps per second. 0 is stored, but a running
        simulation keeps its rate, with a warning. Raises ValueError outside 0 to 1 s.
        """
        self._set_rate(steps_per_second(dt, truncate=self._setup is not None and self._setup.truncates))

    def get_gravity(self) -> Any:
        """Gravity in the world, `Gf.Vec3f` [stage units/s2]; by default 9.81 m/s2 down the up axis."""
        from graph.sim.usd import EARLIEST, Gf

        scene = self.physics_scene
        direction = Gf.Vec3f(scene.GetGravityDirectionAttr().Get(EARLIEST))
        magnitude = float(scene.GetGravityMagnitudeAttr().Get(EARLIEST))
        stage = self._prim.GetStage()
        if not 0 < direction.GetLength() < float("inf"):
            direction = -Gf.Vec3f.Axis("XYZ".index(up_axis(stage)))
        if not 0 <= magnitude < float("inf"):
            magnitude = EARTH_GRAVITY / meters_per_unit(stage)
        return direction.GetNormalized() * magnitude

    def set_gravity(self, gravity: Iterable[float]) -> None:
        """Sets gravity, (3,) in the world [stage units/s2]. Raises ValueError unless finite."""
        from graph.sim.usd import Gf

        try:
            vector = Gf.Vec3f(*map(float, gravity))
        except (TypeError, ValueError):
            vector = Gf.Vec3f(float("nan"))
        magnitude = vector.GetLength()
        if not magnitude < float("inf"):
            raise ValueError(f"gravity {gravity!r}: give three finite numbers")
        if magnitude:
            self._author("physics:gravityDirection", "Vector3f", vector / magnitude)
        self._author("physics:gravityMagnitude", "Float", magnitude)

    def get_enabled_gravity(self) -> bool:
        """Whether gravity is on; True unless authored."""
        return bool(self._authored("newton:gravityEnabled", True))

    def set_enabled_gravity(self, enabled: bool) -> None:
        """Switches gravity on or off."""
        self._author("newton:gravityEnabled", "Bool", bool(enabled))

    def get_max_solver_iterations(self) -> int:
        """Most solver iterations per step; -1 lets the engine choose."""
        return int(self._authored("newton:maxSolverIterations", -1))

    def set_max_solver_iterations(self, iterations: int) -> None:
        """Sets the most solver iterations per step; -1 lets the engine choose. Raises ValueError below -1."""
        if iterations < -1:
            raise ValueError(f"max solver iterations {iterations}: give -1 (the engine's choice) or more")
        self._author("newton:maxSolverIterations", "Int", int(iterations))

    def _rate(self) -> Fraction:
        """Steps per second [Hz]; 0 if 0 is stored."""
        stored = authored_rate(self._prim)
        if stored == 0:
            return stored
        if self.is_active:
            assert self._setup is not None
            return self._setup.next_rate
        return Fraction(DEFAULT_RATE) if stored is None else stored

    def store_rate(self, rate: Fraction, *, as_step: bool = False) -> None:
        """Authors a rate [Hz]: whole numbers as steps per second, others (with `as_step` all) as MuJoCo's time step."""
        if as_step or rate.denominator != 1:
            name = "mjc:option:timestep"
            self._author(name, "Double", float(1 / rate))
        elif newton_only(self._prim):
            name = "newton:timeStepsPerSecond"
            self._author(name, "Int", int(rate))
        else:
            name = "physxScene:timeStepsPerSecond"
            self._author(name, "UInt", int(rate))
        for other in RATE_ATTRIBUTES:
            if other != name and value_of(self._prim, other) is not None:
                self._author(other, "", None)

    def _set_rate(self, rate: Fraction, *, as_step: bool = False) -> None:
        """Authors a rate [Hz]; the App follows if this is its active scene. Raises UserError above 1e9 Hz."""
        setup, active = self._setup, self.is_active
        if setup is not None and active and rate:
            setup.set_rate(rate)
        self.store_rate(rate, as_step=as_step)
        if setup is None:
            return
        if not active:
            first = next(scene_prims(setup.stage)).GetPath()
            message = f"only the first physics scene is simulated, {first}; what is set here is kept on the prim"
            setup.warn("physics-scene-inactive", self.path, message)
        elif not rate:
            setup.refuse_rate_zero(self.path)

    def _authored(self, name: str, default: Any) -> Any:
        value = value_of(self._prim, name)
        return default if value is None else value

    def _author(self, name: str, kind: str, value: Any) -> None:
        """Sets an attribute of the prim, None blocks it.

        The running simulation follows, and the value outlasts the stop.
        """
        author(self._prim, name, kind, value)
        if self._setup is not None and self._setup.built:
            self._setup.scene_changed(self, name, kind, value)

    def _stored_only(self, name: str, why: str) -> None:
        if self._setup is not None:
            message = f"it is kept on the prim and changes nothing: {why}"
            self._setup.warn("physics-setting-stored", f"{self.path}.{name}", message)


def _scene_at(setup: Setup, path: str) -> Any:
    from graph.sim.usd import Sdf, UsdPhysics

    if not (is_path(path) and Sdf.Path(path).IsAbsolutePath() and Sdf.Path(path).IsPrimPath()):
        raise ValueError(f"{path!r} is not a prim path; give one such as {DEFAULT_PATH}")
    prim = setup.stage.GetPrimAtPath(path)
    if prim:
        return prim
    if setup.built:
        raise RunError(f"{path}: a physics scene cannot be made while the simulation plays; call app.stop() first")
    return UsdPhysics.Scene.Define(setup.stage, path).GetPrim()
