"""Runs whole graphs for some updates, with a world or without one, and returns what they did."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from contextlib import ExitStack
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from graph.base.errors import Problem, RunError, UserError
from graph.evaluate import Graph
from graph.node.context import Context, WarningLog
from graph.node.registry import DEFAULT, Registry
from graph.session.missed_ticks import missed_in_run
from graph.session.partial_compile import compile_file
from graph.session.runner import INTERRUPTS_OFF
from graph.spec.file_spec import FileSpec, GraphSpec, PipelineStage

from .driving import Driver
from .source import changed, length_in_updates, load_source
from .trace import GraphTrace
from .updates import check_length
from .world import Observed, observe

if TYPE_CHECKING:
    from graph.recording.sources import Source

_STAGES: tuple[PipelineStage, ...] = ("simulation", "pre_render", "on_demand", "post_render")


def run_graph(
    source: str | Path | FileSpec | GraphSpec,
    *,
    updates: int | None = None,
    inputs: Mapping[str, Any] | None = None,
    pulses: Mapping[str, Iterable[int]] | None = None,
    app: bool | None = None,
    loop_hz: float | str | Fraction | None = None,
    playing: bool | Callable[[int], bool] = True,
    stops: Collection[int] = (),
    settings: Mapping[str, Any] | None = None,
    fidelity: Mapping[str, Any] | None = None,
    seed: int = 0,
    record: Collection[str] | None = None,
    on_update: Callable[[int, GraphTrace], None] | None = None,
    catch: bool = False,
    closes: bool = False,
    play: Iterable[str | Path | Source] = (),
    allow: Iterable[str | Path] = (),
    allow_scripts: bool = False,
    registry: Registry = DEFAULT,
) -> GraphTrace:
    """Runs the graphs of a file, of a text (YAML or JSON of more than one line), or of a specification.

    updates: how many (default: the file's duration, else 1). inputs: values by `node.attr`, which replace the file's; a
    callable gets the index of each update and returns the value. pulses: for each execution input (`node.execIn`) the
    updates in which it is triggered, after the graph's own events; several in one update come in this order. app: True
    runs in an App without a window, False without a world; else an App is made if the file has a scene. In an App
    graphs are evaluated as in `graph run`. Without one every graph is evaluated once per update (simulation,
    pre_render, on_demand, post_render; in file order) and time is a clock of `loop_hz` (default: the file's, else 60).
    playing: whether the timeline plays, or a function of the update index. stops: the updates before which it is
    stopped (clocks at 0, node state as at the start), to play again if it plays there. seed: of an App's random
    streams. record: the data attributes to keep the values of (default: all). on_update: called with the index and the
    trace so far before each update. catch: a failure that ends the run is put into `trace.error` instead of being
    raised. closes: whether the App closes at the end, for OnClosing; its effects are recorded under update `updates`.
    play: messages for subscribers, which needs an App: files as for `graph run --play`, or sources.
    allow: further folders in which the file may name files. allow_scripts: whether nodes may run code from the file
    (ScriptNode).

    Raises UserError with every problem of the file, of `inputs` and of `pulses`, and RunError when the run fails.
    """
    if updates is not None:
        check_length(updates)
    folders = [Path(folder) for folder in allow]
    spec = changed(load_source(source, folders), inputs or {}, loop_hz, settings or {}, fidelity or {})
    play = list(play)
    in_world = bool(spec.scene.usd or spec.scene.mjcf or spec.scene.prims or play) if app is None else app
    if play and not in_world:
        raise UserError("play: messages come through an App; run the graphs in one")
    with ExitStack() as cleanup:
        world: Observed | None = None
        warnings: Any = WarningLog()
        if in_world:
            world = observe(spec, folders, seed, registry, cleanup, allow_scripts=allow_scripts)
            warnings, graphs = world.app.warnings, list(world.app.graphs.values())
            world.receive(play)
        else:
            graphs, spec = compile_file(spec, registry)
            for graph in graphs:
                graph.interrupts = not spec.settings.get(INTERRUPTS_OFF, True)
            for note in spec.notes:
                warnings(*note)
            cleanup.callback(_close, graphs)
        trace = _trace(graphs, record)
        rate = spec.clock.loop_hz or Fraction(60)
        total = updates if updates is not None else length_in_updates(spec, world.app.loop_rate if world else rate)
        driver = Driver(trace, inputs or {}, pulses or {}, total)
        context = standalone_context(rate, warnings)
        context.scripts = "run" if allow_scripts else "refuse"
        step = _world_step(world, trace, playing) if world else _standalone_step(graphs, context, playing)
        close_down = _world_end(world) if world else _standalone_end(graphs, context)
        stop = world.app.stop if world else partial(stop_standalone, graphs, context)
        try:
            for update in range(total):
                if on_update is not None:
                    on_update(update, trace)
                if update in stops:
                    stop()
                driver.begin(update)
                step(update)
                driver.end()
                trace.note(update)
                trace.updates += 1
            if closes:
                close_down(total)
                trace.note(total)
        except RunError as error:
            trace.error = error
            if not catch:
                raise
        finally:
            if world:
                for note in missed_in_run(world.app):
                    world.app.warn(*note)
            trace.warnings = list(warnings)
    return trace


def _trace(graphs: list[Graph], record: Collection[str] | None) -> GraphTrace:
    try:
        return GraphTrace(graphs, record)
    except KeyError as error:
        raise UserError(Problem(f"record: {error.args[0]}")) from None


def standalone_context(rate: Fraction, warnings: WarningLog) -> Context:
    """Time without a world, at `rate` updates a second."""
    context = Context.standalone(rate)
    context.warn = warnings
    return context


def stop_standalone(graphs: Iterable[Graph], context: Context) -> None:
    """What a stop does without a world: timeline at 0, node state as at the start."""
    context.exact_time = Fraction(0)
    for graph in graphs:
        graph.reset()


def _standalone_step(
    graphs: list[Graph], context: Context, playing: bool | Callable[[int], bool]
) -> Callable[[int], None]:
    ordered = sorted(graphs, key=lambda graph: _STAGES.index(graph.pipeline_stage))

    def step(update: int) -> None:
        context.is_playing = playing(update) if callable(playing) else playing
        context.advance()
        for graph in ordered:
            graph.evaluate(context)

    return step


def _world_step(world: Observed, trace: GraphTrace, playing: bool | Callable[[int], bool]) -> Callable[[int], None]:
    app = world.app
    trace.in_world, trace.messages, trace.frames = True, world.messages, world.frames

    def step(update: int) -> None:
        world.play(playing(update) if callable(playing) else playing)
        world.update = update
        app.update()

    return step


def _standalone_end(graphs: list[Graph], context: Context) -> Callable[[int], None]:
    def end(update: int) -> None:
        context.closing = True
        for graph in graphs:
            if graph.evaluator == "execution":
                graph.evaluate(context)

    return end


def _world_end(world: Observed) -> Callable[[int], None]:
    def end(update: int) -> None:
        world.update = update
        world.app.tell_closing()

    return end


def _close(graphs: Iterable[Graph]) -> None:
    for graph in graphs:
        graph.close()
