"""From a graph file to a running App: the one place that joins engine, world, sensors and nodes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .context import Warn
from .errors import Mark, Problem, UserError
from .spec import FileSpec, GraphSpec

if TYPE_CHECKING:
    from pxr import Usd

    from .evaluate import Graph
    from .registry import Registry
    from .runner import GraphRunner, OnError
    from .scripts import Scripts
    from .sim import App


GRAPH_PRIMS = ("", "Scope", "Xform", "OmniGraph", "ComputeGraph")
"""Types of prims that a graph's path may name."""


@dataclass(frozen=True, slots=True)
class Parts:
    """What a graph file gave: what it says, its compiled graphs, its stage (None where it could not be made),
    everything that is wrong with it, and what is odd but no hindrance (code, where, message)."""

    spec: FileSpec | None
    graphs: list[Graph]
    stage: Usd.Stage | None
    problems: list[Problem]
    warnings: list[tuple[str, str, str]]


@dataclass(frozen=True, slots=True)
class Session:
    """An opened graph file: what it says, the App that runs it, the graphs bound to that App."""

    spec: FileSpec
    app: App
    runner: GraphRunner


def build_parts(
    path: str | Path | FileSpec,
    *,
    allow: Sequence[Path] = (),
    overrides: Mapping[str, str] | None = None,
    settings: Mapping[str, Any] | None = None,
    fidelity: Mapping[str, Any] | None = None,
    registry: Registry | None = None,
    skip_unknown: bool = False,
) -> Parts:
    """Loads, compiles and stages a graph file; each step works on what the one before found right.

    A `FileSpec` is taken as it is. `allow` names folders besides the file's own that it may read; `overrides` maps
    NODE.ATTR to a value as in YAML; `settings` and `fidelity` beat the file's; `registry` has the node types (default:
    all there are); `skip_unknown` leaves nodes of other types out.
    """
    from .files import examine
    from .leniency import compile_file
    from .registry import DEFAULT

    spec: FileSpec | None
    problems: list[Problem] = []
    if isinstance(path, FileSpec):
        spec = path
    else:
        examined = examine(path, allow=allow)
        spec, problems = examined.spec, list(examined.problems)
    graphs: list[Graph] = []
    stage = None
    warnings: list[tuple[str, str, str]] = []

    def warn(code: str, where: str, message: str) -> None:
        warnings.append((code, where, message))

    if spec is not None:
        with _collecting(problems):
            spec = override_inputs(spec, overrides or {})
            spec = replace(
                spec,
                settings={**spec.settings, **(settings or {})},
                fidelity={**spec.fidelity, **(fidelity or {})},
            )
            graphs, spec = compile_file(spec, registry or DEFAULT, skip_unknown=skip_unknown)
        with _collecting(problems):
            stage = build_stage(spec, allow, warn)
        problems += option_problems(spec)
    if spec is not None and stage is not None:
        problems += bad_lidars(stage, spec)
        problems += taken_paths(stage, spec)
        missing = missing_targets(stage, spec, graphs)
        if spec.lenient:
            warnings += [("prim-missing", str(one.mark), one.message) for one in missing]
        else:
            problems += missing
    warnings[:0] = spec.notes if spec else ()
    return Parts(spec, graphs, stage, sorted(dict.fromkeys(problems), key=_place), [*dict.fromkeys(warnings)])


def open_session(
    path: str | Path | FileSpec,
    *,
    allow: Sequence[Path] = (),
    settings: Mapping[str, Any] | None = None,
    fidelity: Mapping[str, Any] | None = None,
    overrides: Mapping[str, str] | None = None,
    seed: int = 0,
    realtime: bool = False,
    on_error: OnError | None = None,
    registry: Registry | None = None,
    skip_unknown: bool = False,
    allow_scripts: bool = False,
) -> Session:
    """Loads, checks and builds everything that `path` names (or a loaded file says); nothing plays yet.

    `settings` and `fidelity` beat the file's; `on_error` is "stop" or "continue" (None: "continue" for a saved scene
    with missing assets, whose nodes cannot all work, else "stop"). Nodes that run code of the file are refused unless
    `allow_scripts`; those of a saved scene do nothing, with a warning. Raises UserError with every problem found.
    """
    from .runner import GraphRunner
    from .scripts import script_problems
    from .sim import App
    from .sim.wall_clock import RealClock

    parts = build_parts(
        path,
        allow=allow,
        overrides=overrides,
        settings=settings,
        fidelity=fidelity,
        registry=registry,
        skip_unknown=skip_unknown,
    )
    refused = [] if allow_scripts else script_problems(parts.graphs)
    if parts.spec is None or parts.problems or (refused and not parts.spec.lenient):
        found = [*parts.problems, *([] if parts.spec and parts.spec.lenient else refused)]
        raise UserError(sorted(found, key=_place))
    spec = parts.spec
    app = App(
        parts.stage,
        physics_hz=spec.clock.physics_hz,
        loop_hz=spec.clock.loop_hz,
        experience=spec.clock.experience,
        parity=spec.clock.parity,
        settings=spec.settings,
        fidelity=spec.fidelity,
        seed=seed,
        wall_clock=RealClock() if realtime else None,
    )
    for warning in parts.warnings:
        app.warn(*warning)
    for problem in refused:
        app.warn("scripts-not-allowed", str(problem.mark or spec.path), f"{problem.message}; it does nothing")
    app.folders = tuple(folder for folder in (spec.folder, *allow) if folder is not None)
    if on_error is None:
        missing = any(code in ("usd-missing-asset", "prim-missing") for code, _, _ in parts.warnings)
        on_error = "continue" if spec.lenient and missing else "stop"
    scripts: Scripts = "run" if allow_scripts else "skip" if refused else "refuse"
    runner = GraphRunner(app, parts.graphs, on_error=on_error, scripts=scripts)
    app.graphs.update(runner.graphs)
    return Session(spec, app, runner)


def open_app(app_type: type[App], path: str | Path, **options: Any) -> App:
    """`App.from_file`: the App of an opened graph file, with its graphs bound to it. Options as in `open_session`."""
    return open_session(path, **options).app


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


def option_problems(spec: FileSpec) -> list[Problem]:
    """What is wrong with the file's clock, settings and fidelity knobs."""
    from .sim import settings
    from .sim.fidelity import Fidelity
    from .sim.options import clock_rates, refuse_unavailable

    def mark(section: str) -> Callable[[str], Mark | None]:
        return lambda key: spec.marks.get((section, key))

    problems: list[Problem] = []
    with _collecting(problems):
        settings.from_mapping(spec.settings, mark("settings"))
    with _collecting(problems, mark("fidelity")("lidar.motion")):
        refuse_unavailable("base", "documented", Fidelity.from_mapping(spec.fidelity, mark("fidelity")))
    clock = spec.clock
    with _collecting(problems, clock.mark):
        refuse_unavailable(clock.experience, clock.parity, Fidelity())
        clock_rates(clock.physics_hz, clock.loop_hz, clock.experience, None, None)
    return problems


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


def override_inputs(spec: FileSpec, overrides: Mapping[str, str]) -> FileSpec:
    """The file with `NODE.ATTR` inputs replaced; NODE is a node's name, or its path where the name stands twice."""
    from .files import parse_value

    graphs = list(spec.graphs)
    for target, text in overrides.items():
        name, _, attribute = target.rpartition(".")
        found = [
            (g, n)
            for g, graph in enumerate(graphs)
            for n, node in enumerate(graph.nodes)
            if name in (node.name, f"{graph.path}/{node.name}")
        ]
        if len(found) != 1:
            which = "no node has that name" if not found else "several graphs have such a node; give its whole path"
            raise UserError(f"--set {target}: {which}")
        [(g, n)] = found
        attribute = attribute.removeprefix("inputs:")
        if _is_connected(graphs[g], graphs[g].nodes[n].name, attribute):
            raise UserError(f"--set {target}: a connection feeds this input; set the attribute at its source")
        graphs[g] = _with_input(graphs[g], n, attribute, parse_value(text))
    return replace(spec, graphs=tuple(graphs))


def _is_connected(graph: GraphSpec, node: str, attribute: str) -> bool:
    ends = (connection.target.rpartition(".") for connection in graph.connections)
    return any(
        end in (node, f"{graph.path}/{node}") and name.removeprefix("inputs:") == attribute for end, _, name in ends
    )


def _with_input(graph: GraphSpec, index: int, attribute: str, value: Any) -> GraphSpec:
    nodes = list(graph.nodes)
    nodes[index] = replace(nodes[index], inputs={**nodes[index].inputs, attribute: value})
    return replace(graph, nodes=tuple(nodes))


@contextmanager
def _collecting(problems: list[Problem], mark: Mark | None = None) -> Iterator[None]:
    """Adds the problems of a UserError raised inside; those without a place of their own get `mark`."""
    try:
        yield
    except UserError as error:
        problems += [problem if problem.mark else Problem(problem.message, mark) for problem in error.problems]


def _place(problem: Problem) -> tuple[bool, tuple[str, int, int]]:
    mark = problem.mark
    return mark is not None, (mark.file, mark.line, mark.column) if mark else ("", 0, 0)
