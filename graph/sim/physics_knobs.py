"""The fidelity knobs of physics (`physics.*`); `graph.sim.fidelity` has the whole table."""

# Without `from __future__ import annotations`: KNOBS is made from the fields' types, which are objects here.

from fractions import Fraction
from typing import Annotated, Literal

from graph.base.records import dataclass

from .knob import Knob

_OWN = "MuJoCo's own default"


def _on_cpu(doc: str) -> Knob:
    missing = "the engine here is MuJoCo, which computes on the CPU; an engine for the GPU (MuJoCo Warp) is missing"
    why = "the engine computes there only"
    return Knob(doc, cost="none", error="none", why=why, available=("cpu",), missing=missing)


@dataclass(frozen=True, slots=True)
class PhysicsKnobs:
    """The values of the knobs of physics; None means that the scene or the model decides."""

    physics_hz: Annotated[
        Fraction | None,
        Knob(
            "physics steps per second; beats the clock's physics_hz",
            cost="proportional",
            error="about proportional to the step, at contacts too; rk4: to its fourth power while nothing touches",
            why="the clock's, else the stage's or the model's, else 60 as in Isaac Sim",
            finer="higher",
            unit="Hz",
        ),
    ] = None
    physics_integrator: Annotated[
        Literal["euler", "rk4", "implicit", "implicitfast", "discrete"] | None,
        Knob(
            "how states are integrated",
            cost="rk4: 2 to 4 times, for four evaluations of the forces per step; discrete: 0.9 to 1.6 times",
            error="of first order in the step (a fall or swing is ahead by half a step), rk4 of fourth where nothing "
            "touches. A body that tumbles by w a step loses about 0.02 w2 of its momentum in it, rk4 w6 / 1000. "
            "Chains on joints without drives keep their energy only where nothing is chosen. A spring drive of rate w "
            "[1/s] errs by 0.9, 0.4, 0.15 w dt at damping ratios of 0.2, 0.5, 1, and without damping loses w2 dt / 2 "
            "of its swing a second (euler: none), with rk4 as free bodies; rk4 and euler need w dt < 2",
            why="discrete with driven joints or elastic bodies, for only there stiff drives and contacts are stable "
            "together; else implicitfast; a model keeps its own",
        ),
    ] = None
    physics_solver: Annotated[
        Literal["pgs", "cg", "newton"] | None,
        Knob(
            "how constraints are solved",
            cost="by the scene: a resting tower of ten boxes takes newton 1 iteration a step, cg 8, pgs 300; one of "
            "newton is the dearest, as it factorises a matrix",
            error="what remains when physics.iterations are used up; pgs leaves most",
            why=f"newton: {_OWN}",
            finer="newton",
        ),
    ] = None
    physics_cone: Annotated[
        Literal["pyramidal", "elliptic"] | None,
        Knob(
            "shape of friction cones",
            cost="elliptic: more and dearer iterations on fewer rows; 0.8 (a tower) to 1.5 times (a pile that falls)",
            error="pyramidal: less friction along diagonals, by up to a factor of sqrt(2), and bodies at rest creep",
            why="elliptic: at the same cost a sliding body stops where it should (pyramidal: 40 % off), and bodies at "
            "rest creep a hundredth; a model keeps its own",
            finer="elliptic",
        ),
    ] = None
    physics_jacobian: Annotated[
        Literal["auto", "dense", "sparse"] | None,
        Knob(
            "how constraints are stored",
            cost="sparse pays with many joints and contacts",
            error="none",
            why="auto: sparse from 60 degrees of freedom on",
        ),
    ] = None
    physics_iterations: Annotated[
        int | None,
        Knob(
            "most solver iterations per step",
            cost="proportional, at the most; a solver that has converged stops",
            error="below 10 a stack of ten boxes can fall; what is left at the last is a warning where it is large "
            "(solver-not-converged)",
            why=f"100, {_OWN}: newton needs 2 to 30",
            finer="higher",
            limit="physics.iterations",
        ),
    ] = None
    physics_ls_iterations: Annotated[
        int | None,
        Knob(
            "most line search iterations per solver iteration",
            cost="proportional, at the most",
            error="fewer make an iteration of the solver less effective",
            why=f"50, {_OWN}",
            finer="higher",
            limit="physics.iterations",
        ),
    ] = None
    physics_noslip_iterations: Annotated[
        int | None,
        Knob(
            "iterations that take the slip out of friction after solving",
            cost="proportional",
            error="without: bodies at rest on a slope creep",
            why=f"0, {_OWN}",
            finer="higher",
            limit="physics.iterations",
        ),
    ] = None
    physics_ccd_iterations: Annotated[
        int | None,
        Knob(
            "most iterations of the convex collision detection",
            cost="proportional, at the most",
            error="too few: contacts of curved shapes are misplaced",
            why=f"35, {_OWN}",
            finer="higher",
            limit="physics.iterations",
        ),
    ] = None
    physics_tolerance: Annotated[
        float | None,
        Knob(
            "improvement below which the solver stops",
            cost="larger: fewer iterations, which saves nothing that could be measured up to 1e-4",
            error="rises with it",
            why="1e-8 by the mean inertia, MuJoCo's own default, times 100 lightest masses over the heaviest (newton); "
            "a model keeps its own",
            finer="lower",
        ),
    ] = None
    physics_ls_tolerance: Annotated[
        float | None,
        Knob(
            "improvement below which the line search stops",
            cost="larger: fewer iterations",
            error="larger makes an iteration of the solver less effective",
            why=f"0.01, {_OWN}",
            finer="lower",
        ),
    ] = None
    physics_ccd_tolerance: Annotated[
        float | None,
        Knob(
            "precision of the convex collision detection",
            cost="larger: fewer iterations",
            error="that of the distance of curved shapes",
            why=f"1e-6, {_OWN}",
            finer="lower",
        ),
    ] = None
    physics_impratio: Annotated[
        float | None,
        Knob(
            "how much harder friction is than contact (elliptic cones)",
            cost="larger: more iterations; 100: 1 to 1.8 times",
            error="the creep of bodies at rest is proportional to 1 / impratio on slopes of up to 0.6 times what "
            "friction holds; near that limit more than 10 can make it larger",
            why="10 with elliptic cones: at no cost that could be measured bodies at rest creep a tenth; a model keeps "
            "its own",
            finer="higher",
        ),
    ] = None
    physics_contact_softness: Annotated[
        float | None,
        Knob(
            "how far contacts give way, as a multiple of what their materials (or their model) say",
            cost="smaller: more iterations; 0.1: 0.9 to 1.2 times",
            error="bodies at rest sink in in proportion, and creep so on slopes of up to 0.6 times what friction "
            "holds; near that limit 0.1 makes them slide",
            why="1: as a model says; else ten times as firm as MuJoCo's default, so that ten boxes sink in 1 mm",
            finer="lower",
        ),
    ] = None
    physics_multiccd: Annotated[
        bool | None,
        Knob(
            "several contacts between two convex meshes",
            cost="on: up to four more tests a pair",
            error="off: meshes that touch along a face rock on one contact",
            why=f"on, {_OWN}",
            finer="on",
        ),
    ] = None
    physics_nativeccd: Annotated[
        bool | None,
        Knob(
            "MuJoCo's own convex collision detection, else that of libccd",
            cost="off: more",
            error="off: that of libccd",
            why=f"on, {_OWN}",
            finer="on",
        ),
    ] = None
    physics_dynamics: Annotated[
        Literal["cpu", "cuda"],
        _on_cpu("where dynamics are computed"),
    ] = "cpu"
    physics_pipeline: Annotated[
        Literal["cpu", "cuda"],
        _on_cpu("where the physics' state lives"),
    ] = "cpu"
