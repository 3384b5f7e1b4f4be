"""Fidelity knobs: every approximation by name, with its values, default, cost, error and reader.

The one table of all fidelity knobs. A knob is a field of `Fidelity`: `lidar.motion` in files and on the command line is
the field `lidar_motion`. Its values follow from the field's type. `App`, `graph check`, `--fidelity`, `graph schema`
and the README's test read this table.
"""

# Without `from __future__ import annotations`: KNOBS is made from the fields' types, which are objects here.

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, replace
from fractions import Fraction
from typing import Annotated, Any, Literal, Self

from graph.base.errors import Mark, Problem, UserError
from graph.base.suggest import did_you_mean

from .knob import Knob

_SOLVER = "graph.sim.physics.solver"
_LIDAR = "sensors.lidar.runtime"
_RADAR = "sensors.radar.runtime"
_NO_GPU_ENGINE = "the engine here is MuJoCo, which computes on the CPU; an engine for the GPU (MuJoCo Warp) is missing"


@dataclass(frozen=True, slots=True)
class Fidelity:
    """The knobs' values.

    The defaults are the cheapest documented behaviour; None means that the scene or the model decides.
    """

    physics_hz: Annotated[
        Fraction | None,
        Knob(
            "physics steps per second; beats the clock's physics_hz",
            cost="proportional",
            error="about proportional to the step; rk4: to its fourth power while nothing touches",
            read_by="graph.sim.app",
        ),
    ] = None
    physics_integrator: Annotated[
        Literal["euler", "rk4", "implicit", "implicitfast", "discrete"] | None,
        Knob(
            "how states are integrated",
            cost="rk4: four evaluations of the forces per step instead of one",
            error="of first order in the step, rk4 of fourth; the implicit ones damp stiff joints without diverging",
            read_by=_SOLVER,
        ),
    ] = None
    physics_solver: Annotated[
        Literal["pgs", "cg", "newton"] | None,
        Knob(
            "how constraints are solved",
            cost="per iteration newton most, for it factors a matrix; it needs the fewest iterations",
            error="what remains when physics.iterations are used up; pgs leaves most",
            read_by=_SOLVER,
        ),
    ] = None
    physics_cone: Annotated[
        Literal["pyramidal", "elliptic"] | None,
        Knob(
            "shape of friction cones",
            cost="elliptic: more per iteration",
            error="pyramidal: the limit of friction depends on the direction, by up to a factor of sqrt(2)",
            read_by=_SOLVER,
        ),
    ] = None
    physics_jacobian: Annotated[
        Literal["auto", "dense", "sparse"] | None,
        Knob(
            "how constraints are stored",
            cost="sparse pays with many joints and contacts",
            error="none",
            read_by=_SOLVER,
        ),
    ] = None
    physics_iterations: Annotated[
        int | None,
        Knob(
            "most solver iterations per step",
            cost="proportional, at the most",
            error="falls with each",
            read_by=_SOLVER,
            limit="physics.iterations",
        ),
    ] = None
    physics_ls_iterations: Annotated[
        int | None,
        Knob(
            "most line search iterations per solver iteration",
            cost="proportional, at the most",
            error="fewer make an iteration of the solver less effective",
            read_by=_SOLVER,
            limit="physics.iterations",
        ),
    ] = None
    physics_noslip_iterations: Annotated[
        int | None,
        Knob(
            "iterations that take the slip out of friction after solving",
            cost="proportional",
            error="without: bodies at rest on a slope creep",
            read_by=_SOLVER,
            limit="physics.iterations",
        ),
    ] = None
    physics_ccd_iterations: Annotated[
        int | None,
        Knob(
            "most iterations of the convex collision detection",
            cost="proportional, at the most",
            error="too few: contacts of curved shapes are misplaced",
            read_by=_SOLVER,
            limit="physics.iterations",
        ),
    ] = None
    physics_tolerance: Annotated[
        float | None,
        Knob(
            "improvement below which the solver stops",
            cost="larger: fewer iterations",
            error="rises with it",
            read_by=_SOLVER,
        ),
    ] = None
    physics_ls_tolerance: Annotated[
        float | None,
        Knob(
            "improvement below which the line search stops",
            cost="larger: fewer iterations",
            error="larger makes an iteration of the solver less effective",
            read_by=_SOLVER,
        ),
    ] = None
    physics_ccd_tolerance: Annotated[
        float | None,
        Knob(
            "precision of the convex collision detection",
            cost="larger: fewer iterations",
            error="that of the distance of curved shapes",
            read_by=_SOLVER,
        ),
    ] = None
    physics_impratio: Annotated[
        float | None,
        Knob(
            "how much harder friction is than contact (elliptic cones)",
            cost="larger: more iterations",
            error="larger: less slip",
            read_by=_SOLVER,
        ),
    ] = None
    physics_multiccd: Annotated[
        bool | None,
        Knob(
            "several contacts between two convex meshes",
            cost="on: up to four more tests a pair",
            error="off: meshes that touch along a face rock on one contact",
            read_by=_SOLVER,
        ),
    ] = None
    physics_nativeccd: Annotated[
        bool | None,
        Knob(
            "MuJoCo's own convex collision detection, else that of libccd",
            cost="off: more",
            error="off: that of libccd",
            read_by=_SOLVER,
        ),
    ] = None
    physics_dynamics: Annotated[
        Literal["cpu", "cuda"],
        Knob(
            "where dynamics are computed",
            cost="none",
            error="none",
            available=("cpu",),
            missing=_NO_GPU_ENGINE,
        ),
    ] = "cpu"
    physics_pipeline: Annotated[
        Literal["cpu", "cuda"],
        Knob(
            "where the physics' state lives",
            cost="none",
            error="none",
            available=("cpu",),
            missing=_NO_GPU_ENGINE,
        ),
    ] = "cpu"
    lidar_motion: Annotated[
        Literal["frozen", "update", "continuous"],
        Knob(
            "frozen: the whole scan at its tick; update: each update casts what fired since; continuous: each firing "
            "alone",
            cost="continuous: 2.6 to 3 times frozen",
            error="of v t for a speed v: frozen: t from the firing to its tick; update: to its update; "
            "continuous: see lidar.bins",
            read_by=_LIDAR,
        ),
    ] = "frozen"
    lidar_bins: Annotated[
        int,
        Knob(
            "lidar.motion continuous: into how many spans of time a scan is cut; bodies keep still in each",
            cost="one update of the moving bodies in the ray caster each",
            error="(v + w r) T / (2 bins) for a body of speed v, angular speed w and radius r, and a turn of length T",
            read_by="sensors.lidar.bins",
            limit="lidar.bins",
        ),
    ] = 8
    lidar_noise: Annotated[
        bool,
        Knob(
            "seeded range, angle and origin errors, and the range offsets of the profile",
            cost="on: some random numbers a beam",
            error="off: exact ranges",
            read_by=_LIDAR,
        ),
    ] = False
    lidar_subrays: Annotated[
        int,
        Knob(
            "rays per beam, over its divergence; they may bring several returns",
            cost="somewhat more than proportional",
            error="1: a beam sees one surface only",
            read_by=_LIDAR,
            limit="lidar.rays",
        ),
    ] = 1
    radar_rays: Annotated[
        int | None,
        Knob(
            "rays of a radar's fan; finer ones over what is small come on top, a quarter at most. Default: raysPerDeg",
            cost="proportional",
            error="fewer: edges of what is lit are cut to whole rays, fields over their footprints are less exact",
            read_by=_RADAR,
            limit="radar.rays",
        ),
    ] = None
    radar_bounces: Annotated[
        int | None,
        Knob(
            "faces that a radar's wave meets at most. Default: traceTreeDepth",
            cost="one cast of the rays that go on for each, and one to see what sends back",
            error="1: no corner reflectors, no ghosts",
            read_by=_RADAR,
        ),
    ] = None
    camera_samples: Annotated[
        int,
        Knob(
            "rays per pixel of colour pictures",
            cost="pictures: proportional",
            error="1: jagged edges; that of a mean of so many",
            read_by="sensors.camera.runtime",
            limit="camera.rays",
        ),
    ] = 1
    mesh_tolerance: Annotated[
        float,
        Knob(
            "largest distance between a curved surface and the triangles that stand for it",
            cost="triangles of curved surfaces: about 1 / tolerance",
            error="the tolerance",
            read_by="graph.sim.world",
            unit="m",
        ),
    ] = 0.001
    mesh_subdivision: Annotated[
        Literal["cage", "refined"],
        Knob(
            "subdivision surfaces as their cages, or refined to mesh.tolerance",
            cost="refined: four times the triangles for each level",
            error="cage: its distance from the surface; refined: mesh.tolerance",
            read_by="graph.sim.world",
        ),
    ] = "cage"
    fabric: Annotated[
        bool,
        Knob(
            "world transforms flattened (on), or written to the stage after every physics step (off)",
            cost="off: 7 to 17 times an update of moving prims",
            error="none: the same bytes",
            read_by="graph.sim.world",
        ),
    ] = True
    tlas: Annotated[
        Literal["sensor", "frame"],
        Knob(
            "sensors see the state of their own tick, or the update's last state",
            cost="the same",
            error="frame: v times the time from the tick to the end of its update",
            read_by="graph.sim.managers.simulation_manager",
        ),
    ] = "sensor"

    @classmethod
    def from_mapping(cls, values: Mapping[str, Any], where: Callable[[str], Mark | None] = lambda key: None) -> Self:
        """Fidelity from names and values (typed, or text as on the command line).

        Raises UserError with every problem, each with the mark that `where(name)` gives.
        """
        chosen, problems = {}, []
        for name, value in values.items():
            try:
                chosen[name.replace(".", "_")] = _known(name).checked(value)
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


def _known(name: str) -> Knob:
    if name not in KNOBS:
        hint = did_you_mean(name, KNOBS, f"the knobs are {', '.join(KNOBS)}")
        raise ValueError(f"there is no such knob{hint}")
    return KNOBS[name]


KNOBS: dict[str, Knob] = {
    one.name.replace("_", ".", 1): one.type.__metadata__[0].of(one.type.__origin__, one.default)  # type: ignore[union-attr]
    for one in fields(Fidelity)
}
"""Every knob by the name that graph files and the command line use."""
