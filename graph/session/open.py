"""Opens a graph file as an App; the one module that joins engine, world, sensors and nodes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from graph.base.asset_roots import mapped
from graph.base.errors import Mark, Problem, UserError
from graph.base.exact import shortest
from graph.base.gc_pause import collector_paused
from graph.base.records import dataclass, field
from graph.spec.file_spec import FileSpec, Note

from .graph_checks import graph_notes
from .overrides import apply_overrides
from .randomized import randomized
from .scene_checks import fast_cameras, idle_actuators, prim_notes, scaled_sensors
from .stage import (
    build_stage,
    missing_targets,
    prims_for_products,
    sensors_in_solids,
    stage_problems,
    type_problems,
    unmade_products,
    unrenderable_cameras,
)

if TYPE_CHECKING:
    from pxr import Usd

    from graph.evaluate import Graph
    from graph.node.context import Scripts
    from graph.node.registry import Registry
    from graph.sim.app import App

    from .runner import GraphRunner, OnError

    A = TypeVar("A", bound=App)


@dataclass(frozen=True, slots=True)
class Parts:
    """The parts that a graph file gives.

    spec and compiled graphs; stage (None if it could not be made); problems; warnings that do not stop loading (code,
    place, message); the MJCF model that the stage mirrors, if any; what `randomize` drew.
    """

    spec: FileSpec | None
    graphs: list[Graph]
    stage: Usd.Stage | None
    problems: list[Problem]
    warnings: list[tuple[str, str, str]]
    mjcf: Any = None
    drawn: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Session:
    """An opened graph file: its spec, the App that runs it, the graphs bound to that App.

    drawn: what `randomize` of the file drew.
    """

    spec: FileSpec
    app: App
    runner: GraphRunner
    drawn: Mapping[str, Any] = field(default_factory=dict)


@collector_paused()
def build_parts(
    path: str | Path | FileSpec,
    *,
    allow: Sequence[str | Path] = (),
    skip_outside: bool = False,
    overrides: Mapping[str, Any] | None = None,
    settings: Mapping[str, Any] | None = None,
    fidelity: Mapping[str, Any] | None = None,
    registry: Registry | None = None,
    skip_unknown: bool = False,
    seed: int = 0,
) -> Parts:
    """Loads, compiles and stages a graph file; each step works on the valid part of the step before.

    A `FileSpec` is taken unchanged. `allow` names further folders that the file may read, besides its own. References
    of a scene to other folders are refused, or with `skip_outside` left out with a warning. `overrides` maps NODE.ATTR
    or /PRIM/PATH.ATTR to a value (`apply_overrides`); `settings` and `fidelity` replace the file's; `registry` has the
    node types (default: all); `skip_unknown` leaves out nodes of other types; `seed` draws the values of `randomize`.
    """
    from graph.files import examine
    from graph.node.registry import DEFAULT

    from .partial_compile import compile_file, compile_rest

    folders = [Path(folder) for folder in allow]
    spec: FileSpec | None
    problems: list[Problem] = []
    if isinstance(path, FileSpec):
        spec = path
    else:
        examined = examine(path, allow=folders, skip_outside=skip_outside)
        spec, problems = examined.spec, list(examined.problems)
    graphs: list[Graph] = []
    stage = mjcf = None
    drawn: dict[str, Any] = {}
    flaws: list[Problem] = []
    warnings: list[tuple[str, str, str]] = []

    def warn(code: str, where: str, message: str) -> None:
        warnings.append((code, where, message))

    if spec is not None:
        from graph.sim.scene.diagnostics import reading

        scene = str(spec.scene.usd or spec.path)
        if spec.randomize:
            with _collecting(problems):
                spec, drawn = randomized(spec, seed, overrides or ())
        with _collecting(problems):
            spec = apply_overrides(spec, overrides or {})
            spec = replace(
                spec,
                settings={**spec.settings, **(settings or {})},
                fidelity={**spec.fidelity, **(fidelity or {})},
            )
        try:
            graphs, spec = compile_file(spec, registry or DEFAULT, skip_unknown=skip_unknown)
        except UserError as error:
            problems += error.problems
            graphs = compile_rest(spec, registry or DEFAULT)
        with _collecting(problems), reading(scene):
            stage, mjcf, flaws = build_stage(spec, folders, warn, skip_outside=skip_outside)
            problems += flaws
        problems += option_problems(spec)
    if spec is not None and stage is not None:
        with _collecting(problems), reading(scene):
            problems += () if flaws else stage_problems(stage, spec)
            scene_lost = any(one.message.startswith(("scene.usd:", "scene.mjcf:", "scene.urdf:")) for one in problems)
            missing = [] if scene_lost else missing_targets(stage, spec, graphs, flawed=bool(flaws))
            refused = [*unrenderable_cameras(stage, spec, graphs), *prims_for_products(stage, spec, graphs)]
            refused += () if flaws else type_problems(stage, spec, graphs)
            if spec.lenient:
                warnings += [("prim-missing", str(one.mark), one.message) for one in missing]
                warnings += [("node-cannot-work", str(one.mark), one.message) for one in refused]
            else:
                problems += [*missing, *refused]
    warnings[:0] = spec.notes if spec else ()
    if not problems and spec is not None and stage is not None:
        warnings += [*_clock_notes(spec), *graph_notes(graphs), *sensors_in_solids(stage, graphs)]
        warnings += [*prim_notes(spec), *scaled_sensors(stage, spec, graphs), *fast_cameras(spec, graphs)]
        warnings += idle_actuators(stage, graphs)
        warnings += unmade_products(stage, spec, graphs)
    return Parts(
        spec, graphs, stage, sorted(dict.fromkeys(problems), key=_place), [*dict.fromkeys(warnings)], mjcf, drawn
    )


def open_session(
    path: str | Path | FileSpec,
    *,
    app_type: type[App] | None = None,
    allow: Sequence[str | Path] = (),
    skip_outside: bool = False,
    settings: Mapping[str, Any] | None = None,
    fidelity: Mapping[str, Any] | None = None,
    overrides: Mapping[str, Any] | None = None,
    seed: int = 0,
    realtime: bool = False,
    on_error: OnError | None = None,
    registry: Registry | None = None,
    skip_unknown: bool = False,
    allow_scripts: bool = False,
    asset_roots: Mapping[str, str | Path] | None = None,
) -> Session:
    """Loads, checks and builds everything that `path` names (or a loaded file contains); nothing plays yet.

    `app_type` is the class of the App; None: the one without Isaac Sim's names. `settings` and `fidelity` replace the
    file's. `on_error` is "stop" or "continue"; None means "continue" for a saved scene with missing assets or nodes
    that cannot work, else the setting nodeErrorsStop. Nodes that run code from the file are refused unless
    `allow_scripts`; those of a saved scene do nothing, with a warning. `asset_roots` is as for `App`. Raises UserError
    with every problem found.
    """
    from graph.evaluate.script_permission import script_problems

    folders = [Path(folder) for folder in allow]
    with mapped(asset_roots or {}):
        parts = build_parts(
            path,
            allow=folders,
            skip_outside=skip_outside,
            overrides=overrides,
            settings=settings,
            fidelity=fidelity,
            registry=registry,
            skip_unknown=skip_unknown,
            seed=seed,
        )
    refused = [] if allow_scripts else script_problems(parts.graphs)
    if parts.spec is None or parts.problems or (refused and not parts.spec.lenient):
        found = [*parts.problems, *([] if parts.spec and parts.spec.lenient else refused)]
        raise UserError(sorted(found, key=_place))
    return start(
        parts,
        folders,
        app_type=app_type,
        seed=seed,
        realtime=realtime,
        on_error=on_error,
        allow_scripts=allow_scripts,
    )


def start(
    parts: Parts,
    folders: Sequence[Path] = (),
    *,
    app_type: type[App] | None = None,
    seed: int = 0,
    realtime: bool = False,
    on_error: OnError | None = None,
    allow_scripts: bool = False,
) -> Session:
    """The App over parts without problems, with their graphs bound to it; options as in `open_session`."""
    from graph.evaluate.script_permission import script_problems
    from graph.sim.app import App
    from graph.sim.scene.diagnostics import reading
    from graph.sim.timing.run_loop import RealClock

    from .runner import GraphRunner

    refused = [] if allow_scripts else script_problems(parts.graphs)
    spec = parts.spec
    assert spec is not None
    with reading(str(spec.scene.usd or spec.path)):
        app = (app_type or App)(
            parts.stage,
            mjcf=parts.mjcf,
            physics_hz=spec.clock.physics_hz,
            loop_hz=spec.clock.loop_hz,
            experience=spec.clock.experience,
            parity=spec.clock.parity,
            settings=spec.settings,
            fidelity=spec.fidelity,
            seed=seed,
            wall_clock=RealClock() if realtime else None,
        )
    if app.fidelity.lidar_motion != "frozen":
        from sensors.motion.history import begin_history

        begin_history(app.world)
    for warning in parts.warnings:
        app.warn(*warning)
    for problem in refused:
        app.warn("scripts-not-allowed", str(problem.mark or spec.path), f"{problem.message}; it does nothing")
    app.folders = tuple(folder for folder in (spec.folder, *folders) if folder is not None)
    if on_error is None:
        broken = any(code in ("usd-missing-asset", "prim-missing", "node-cannot-work") for code, _, _ in parts.warnings)
        on_error = "continue" if spec.lenient and broken else None
    scripts: Scripts = "run" if allow_scripts else "skip" if refused else "refuse"
    runner = GraphRunner(app, parts.graphs, on_error=on_error, scripts=scripts)
    app.graphs.update(runner.graphs)
    return Session(spec, app, runner, parts.drawn)


def open_app(app_type: type[A], path: str | Path | FileSpec, **options: Any) -> A:
    """`App.from_file`: the App of an opened graph file, with its graphs bound to it. Options as in `open_session`.

    device: the knob of that name, as for `App`.
    """
    device = options.pop("device", None)
    if device is not None:
        options["fidelity"] = {**(options.get("fidelity") or {}), "device": device}
    app = open_session(path, app_type=app_type, **options).app
    assert isinstance(app, app_type)
    return app


def option_problems(spec: FileSpec) -> list[Problem]:
    """What is wrong with the file's clock, settings and fidelity knobs."""
    from graph.sim import settings
    from graph.sim.fidelity import Fidelity
    from graph.sim.options import clock_rates, refuse_unavailable

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


def _clock_notes(spec: FileSpec) -> Iterator[Note]:
    """Rates so low that they must be time steps."""
    clock = spec.clock
    for name, rate in (("physics_hz", clock.physics_hz), ("loop_hz", clock.loop_hz)):
        if rate is not None and 0 < rate < 1:
            message = f"{name} {shortest(rate)} is one in {shortest(1 / rate)} s; it is a rate: for a time step of"
            yield "rate-below-1", str(clock.mark), f"{message} {shortest(rate)} s write {shortest(1 / rate)}"


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
