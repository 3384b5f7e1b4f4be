"""Fidelity knobs: every approximation by name, with its values, default, cost, error and reason.

The one table of all fidelity knobs (those of physics stand in `physics_knobs`). A knob is a field of `Fidelity`:
`lidar.motion` in files and on the command line is the field `lidar_motion`. Its values follow from the field's type.
`App`, `graph check`, `--fidelity`, `graph schema` and the manual read this table.
"""

# Without `from __future__ import annotations`: KNOBS is made from the fields' types, which are objects here.

from collections.abc import Callable, Mapping
from dataclasses import fields, replace
from fractions import Fraction
from typing import Annotated, Any, Literal, Self

from graph.base.errors import Mark, Problem, UserError
from graph.base.records import dataclass
from graph.base.suggest import did_you_mean

from .knob import Knob
from .physics_knobs import PhysicsKnobs


@dataclass(frozen=True, slots=True)
class Fidelity(PhysicsKnobs):
    """The knobs' values.

    The defaults are the cheapest documented behaviour; None means that the scene or the model decides.
    """

    lidar_motion: Annotated[
        Literal["frozen", "update", "continuous"],
        Knob(
            "frozen: the whole scan at its tick; update: each update casts what fired since; continuous: each firing "
            "alone",
            cost="continuous: 1.5 to 2 times frozen",
            error="what is hit is displaced by (v + w r) t, for a speed v and turn rates w at a distance r (ranges by "
            "up to 1 / cos of the incidence more); frozen: t from the firing to its tick; update: to its update; "
            "continuous: see lidar.bins",
            why="the cheapest; a scan shows the instant that its header names",
            finer="continuous",
        ),
    ] = "frozen"
    lidar_bins: Annotated[
        int,
        Knob(
            "lidar.motion continuous: into how many spans of time a scan is cut; bodies keep still in each",
            cost="one update of the moving bodies in the ray caster each",
            error="(v + w r) T / (2 bins) for a body of speed v, angular speed w and radius r, and a turn of length T",
            why="0.06 m for a body of 10 m/s and a turn of 0.1 s",
            finer="higher",
            limit="lidar.bins",
        ),
    ] = 8
    lidar_noise: Annotated[
        bool,
        Knob(
            "seeded range, angle and origin errors, and the range offsets of the profile",
            cost="on: some random numbers a beam",
            error="off: exact ranges",
            why="as documented: exact ranges and angles",
        ),
    ] = False
    lidar_subrays: Annotated[
        int,
        Knob(
            "rays per beam, over its divergence; they may bring several returns",
            cost="somewhat more than proportional",
            error="1: a beam sees one surface only",
            why="the cheapest; several returns need more",
            finer="higher",
            limit="lidar.rays",
        ),
    ] = 1
    radar_rays: Annotated[
        int | None,
        Knob(
            "rays of a radar's fan, a total for each of its scans: fewer per degree where it is wide. Finer ones over "
            "what is small come on top, an eighth at most. Default: by raysPerDeg, a density",
            cost="proportional",
            error="edges of what is lit are cut to whole rays, fields over their footprints are less exact: in the "
            "yard 0.60 of the detections of 16 times as many rays, 0.45 with half the rays, 0.38 with a quarter "
            "(`graph help radar`); below about one a degree next to nothing is found",
            why="as dense as the radar's own attribute says",
            finer="higher",
            limit="radar.rays",
        ),
    ] = None
    radar_bounces: Annotated[
        int | None,
        Knob(
            "faces that a radar's wave meets at most. Default: traceTreeDepth",
            cost="one cast of the rays that go on for each, and one to see what sends back",
            error="1: no corner reflectors, no ghosts",
            why="the depth of the radar's own attribute",
            finer="higher",
        ),
    ] = None
    camera_backend: Annotated[
        Literal["rays", "gl"],
        Knob(
            "cameras cast rays, or OpenGL draws what it can (MuJoCo's renderer, the extra gl): colours, "
            "depth, points, segmentations and motion of cameras without distortion",
            cost="gl: three drawings an image, whatever the number of triangles; fast with a graphics card only",
            error="gl: depth 1e-5; linear light in steps of 1 / 255; shadows to a few centimetres; area lights are "
            "points; one colour a mesh, or its texture",
            why="the same bytes on every machine",
            finer="rays",
        ),
    ] = "rays"
    camera_samples: Annotated[
        int,
        Knob(
            "rays per pixel of colour pictures",
            cost="pictures: proportional",
            error="1: jagged edges; that of a mean of so many",
            why="the cheapest; depth, labels and boxes take one ray a pixel anyhow",
            finer="higher",
            limit="camera.rays",
        ),
    ] = 1
    camera_noise: Annotated[
        bool,
        Knob(
            "seeded shot and read noise of colour pictures, by the tickgraph:noise: attributes of the camera",
            cost="on: three random numbers a pixel",
            error="off: exact colours",
            why="as lidar.noise: exact unless asked for",
        ),
    ] = False
    mesh_tolerance: Annotated[
        float,
        Knob(
            "largest distance between a curved surface and the triangles that stand for it",
            cost="triangles of curved surfaces: about 1 / tolerance",
            error="the tolerance",
            why="below the range accuracy of every lidar profile",
            finer="lower",
            unit="m",
        ),
    ] = 0.001
    mesh_solids: Annotated[
        Literal["exact", "mesh"],
        Knob(
            "spheres, boxes, capsules, cylinders and cones, of any scale: rays meet their formulas, or their triangles",
            cost="mesh: 2 to 4 times the cast at moving solids; triangles as for mesh.tolerance",
            error="exact: 1e-6 of the range; mesh: mesh.tolerance",
            why="the least error, and the fastest where solids move",
            finer="exact",
        ),
    ] = "exact"
    mesh_subdivision: Annotated[
        Literal["cage", "refined"],
        Knob(
            "subdivision surfaces as their cages, or refined to mesh.tolerance",
            cost="refined: four times the triangles for each level",
            error="cage: its distance from the surface; refined: mesh.tolerance",
            why="the cheapest, and what files show without a subdivider",
            finer="refined",
        ),
    ] = "cage"
    device: Annotated[
        Literal[
            "cpu", "cuda", "cuda:0", "cuda:1", "cuda:2", "cuda:3", "cuda:4", "cuda:5", "cuda:6", "cuda:7", "warp-cpu"
        ],
        Knob(
            "where rays are cast: the processor; a CUDA GPU, with RT cores or without (the extra gpu); or the GPU's "
            "kernels on the processor, to check them",
            cost="cuda: a launch and a copy to the host for each frame; pays from some 10,000 rays on",
            error="ranges 1e-5 m from the processor's, ids the same but at edges",
            why="no GPU is needed",
        ),
    ] = "cpu"
    fabric: Annotated[
        bool,
        Knob(
            "world transforms flattened (on), or written to the stage after every physics step (off)",
            cost="off: 7 to 17 times an update of moving prims",
            error="none: the same bytes",
            why="the same bytes for less",
        ),
    ] = True
    tlas: Annotated[
        Literal["sensor", "frame"],
        Knob(
            "sensors see the state of their own tick, or the update's last state",
            cost="the same",
            error="frame: v times the time from the tick to the end of its update",
            why="as in Isaac Sim 6, and it costs no more",
            finer="sensor",
        ),
    ] = "sensor"

    loop_hz: Annotated[
        Fraction | None,
        Knob(
            "updates per second; beats the clock's loop_hz",
            cost="proportional for graphs and publishers; physics and sensors keep their own rates",
            error="what happens once an update (commands, lidar.motion=update, tlas=frame) is up to one update late",
            why="the clock's, else 60 as in Isaac Sim",
            finer="higher",
            unit="Hz",
        ),
    ] = None

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


def _of_field(hint: Any, default: Any) -> Knob:
    knob: Knob = hint.__metadata__[0]
    return knob.of(hint.__origin__, default)


KNOBS: dict[str, Knob] = {
    one.name if one.name == "loop_hz" else one.name.replace("_", ".", 1): _of_field(one.type, one.default)
    for one in fields(Fidelity)
}
"""Every knob by the name that graph files and the command line use."""
