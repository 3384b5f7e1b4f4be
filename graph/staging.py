"""The stage that a graph file describes, and what is wrong with it for the graphs that will run over it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from .context import Warn
from .errors import Mark, Problem, UserError
from .spec import FileSpec

if TYPE_CHECKING:
    from pxr import Usd

    from .evaluate import Graph

GRAPH_PRIMS = ("", "Scope", "Xform", "OmniGraph", "ComputeGraph")
"""Types of prims that a graph's path may name."""


def build_stage(spec: FileSpec, allow: Sequence[Path], warn: Warn) -> Usd.Stage:
    """The file's scene with its inline prims authored on top. Raises UserError with every problem found."""
    from sensors.configs import author_config

    from .sim.prims import author_prims
    from .sim.stage import meters_per_unit, open_stage, up_axis

    scene = spec.scene
    if scene.mjcf is not None:
        raise UserError(Problem("scene.mjcf: MJCF scenes cannot be loaded yet; convert the model to USD", scene.mark))
    roots = [root for root in (spec.folder, *allow) if root is not None]
    stage = open_stage(scene.usd, roots, warn=warn)
    meters_per_unit(stage), up_axis(stage)

    def where(path: str, key: str | None = None) -> Mark | None:
        return scene.prim_marks.get((path, key) if key else (path,)) or scene.prim_marks.get((path,))

    author_prims(
        stage, scene.prims, where, sensor_config=author_config, allow_roots=roots, folder=spec.folder, warn=warn
    )
    return stage


def stage_problems(stage: Usd.Stage, spec: FileSpec) -> Iterator[Problem]:
    """What on the stage cannot be: lidars that are none, graphs where another prim is."""
    yield from bad_lidars(stage, spec)
    yield from taken_paths(stage, spec)


def bad_lidars(stage: Usd.Stage, spec: FileSpec) -> list[Problem]:
    """A line for each lidar of the stage that cannot be one, at its prim in the file where it stands there."""
    from sensors.lidar.check import lidar_problems

    return [Problem(message, spec.scene.prim_marks.get((path,))) for path, message in lidar_problems(stage)]


def taken_paths(stage: Usd.Stage, spec: FileSpec) -> list[Problem]:
    """A line for each graph whose path is that of a prim which is something else."""
    problems = []
    for graph in spec.graphs:
        kind = str(stage.GetPrimAtPath(graph.path).GetTypeName()) if stage.GetPrimAtPath(graph.path) else ""
        if kind not in GRAPH_PRIMS:
            problems.append(Problem(f"{graph.path} is a {kind} on the stage; give the graph another path", graph.mark))
    return problems


def missing_targets(stage: Usd.Stage, spec: FileSpec, graphs: Sequence[Graph]) -> list[Problem]:
    """A line for each `target` input of a node whose prim is not on the stage.

    Graphs and render products are no prims of the scene: they come to be when the file runs.
    """
    written = {f"{graph.path}/{node.name}": node for graph in spec.graphs for node in graph.nodes}
    graph_paths = {graph.path for graph in graphs}
    problems = []
    for node in (node for graph in graphs for node in graph.nodes.values()):
        for name in (name for name, attribute in node.type.inputs.items() if attribute.type == "target"):
            for target in node.get(name) or ():
                if target in graph_paths or target.startswith("/Render/") or stage.GetPrimAtPath(target):
                    continue
                author = written[node.path]
                message = f"{node.path}.inputs:{name}: there is no prim {target} on the stage; correct the path."
                problems.append(Problem(message, author.input_marks.get(name, author.mark)))
    return problems
