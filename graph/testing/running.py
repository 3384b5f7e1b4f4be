"""Runs a case and finds every expectation that was not met."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from graph.base.errors import Problem, UserError
from graph.evaluate import Node
from graph.files import load
from graph.files.tree import Map
from graph.node.registry import DEFAULT, Registry
from graph.session.message_sources import written_source
from graph.spec.file_spec import ClockSpec, FileSpec

from .cases import Case
from .expectations import failures_of
from .graphs import run_graph, stop_standalone
from .node import Trace, run_node, set_input
from .seen import Seen, of_graphs, of_node
from .trace import GraphTrace
from .updates import read_range
from .world import observe

if TYPE_CHECKING:
    from graph.recording.sources import Source


@dataclass(frozen=True)
class Outcome:
    """The result of a case: the failures (empty: it passed), and its duration [s]."""

    case: Case
    failures: tuple[Problem, ...]
    seconds: float

    @property
    def passed(self) -> bool:
        """Whether all expectations were met."""
        return not self.failures


@dataclass(frozen=True)
class Options:
    """Options of all cases in a run.

    Further folders that may be read, settings that replace all others, whether nodes may run code from a file.
    """

    allow: tuple[Path, ...] = ()
    settings: dict[str, Any] = field(default_factory=dict)
    allow_scripts: bool = False
    registry: Registry = DEFAULT


def run_case(case: Case, options: Options | None = None) -> Outcome:
    """Runs one case. Failures are in the result, not raised."""
    options = options or Options()
    started = time.perf_counter()
    try:
        seen = (_run_graph if case.node is None else _run_node)(case, options)
    except UserError as error:
        seen = Seen(error=error, exit=2)
    except AssertionError as error:  # a node wrote a value of another type than its output's
        return Outcome(case, (Problem(str(error), case.mark),), time.perf_counter() - started)
    except (KeyError, ValueError) as error:
        seen = Seen(error=UserError(str(error.args[0] if error.args else error)), exit=2)
    except Exception as error:  # a defect of the tool or of a library: the other cases still run
        message = " ".join(f"internal error: {type(error).__name__}: {error}".split())
        return Outcome(case, (Problem(message, case.mark),), time.perf_counter() - started)
    return Outcome(case, tuple(failures_of(case, seen)), time.perf_counter() - started)


def _run_graph(case: Case, options: Options) -> Seen:
    setup = case.setup
    spec = case.spec if case.file is None else _with_own(case, load(case.file, allow=options.allow))
    changes = _changes(case)

    def change(update: int, trace: GraphTrace) -> None:
        for reference, value in changes.get(update, ()):
            node, full = trace.attribute(reference, "inputs")
            _set(node, full, value, update)

    trace = run_graph(
        spec,
        updates=setup.updates,
        inputs=setup.inputs,
        pulses=setup.pulses,
        app=setup.world,
        playing=_playing(case),
        stops=frozenset(setup.stops),
        closes=setup.closes,
        play=_played(case),
        settings=options.settings,
        seed=setup.seed or 0,
        record=[*setup.expect.outputs, *setup.expect.values],
        on_update=change if changes else None,
        catch=True,
        allow=options.allow,
        allow_scripts=options.allow_scripts,
        registry=options.registry,
    )
    return of_graphs(trace)


def _run_node(case: Case, options: Options) -> Seen:
    setup = case.setup
    assert case.node is not None
    changes = _changes(case)
    playing = _playing(case)
    spec = replace(case.spec, settings={**case.spec.settings, **options.settings})
    # A connection would write its value in every update, so a change of it must last.
    brought = {name: value for name, value in setup.inputs.items() if name in setup.connect}
    with ExitStack() as cleanup:
        world = None
        played = _played(case)
        if setup.world or (setup.world is None and (spec.scene.prims or played)) or spec.scene.usd:
            world = observe(spec, options.allow, setup.seed or 0, options.registry, cleanup)
            world.receive(played)

        stops = frozenset(setup.stops)

        def before(update: int, node: Node) -> None:
            if update in stops:
                if world is not None:
                    world.app.stop()
                else:
                    stop_standalone([node.graph], node.graph.context)
            for reference, value in changes.get(update, ()):
                if reference in brought:
                    brought[reference] = value
                else:
                    _set(node, reference, value, update)
            if world is not None:
                world.update = update
                world.play(playing(update))

        trace: Trace = run_node(
            case.node,
            inputs={**setup.inputs, **{name: _latest(brought, name) for name in brought}},
            pulses=setup.pulses,
            updates=1 if setup.updates is None else setup.updates,
            connect=setup.connect,
            variables={name: (one.type, one.value) for name, one in setup.variables.items()},
            playing=playing,
            loop_hz=spec.clock.loop_hz or 60,
            app=world.app if world else None,
            on_update=before,
            catch=True,
            closes=setup.closes,
            allow_scripts=options.allow_scripts,
            registry=options.registry,
        )
        return of_node(trace, world)


def _played(case: Case) -> list[Path | Source]:
    """The messages that the case's subscribers receive. Raises UserError for messages that their types do not allow."""
    return [*case.play, *([written_source(case.messages, case.source.name)] if case.messages else [])]


def _latest(values: dict[str, Any], name: str) -> Callable[[int], Any]:
    return lambda update: values[name]


def _with_own(case: Case, spec: FileSpec) -> FileSpec:
    """A graph file with the case's clock, settings and fidelity instead of its own."""
    own = case.spec
    return replace(
        spec,
        clock=_clock(spec.clock, own.clock, case.tree.get("clock")),
        settings={**spec.settings, **own.settings},
        fidelity={**spec.fidelity, **own.fidelity},
        marks={**spec.marks, **own.marks},
    )


def _clock(clock: ClockSpec, own: ClockSpec, written: Any) -> ClockSpec:
    given = {key: getattr(own, key) for key in written} if isinstance(written, Map) else {}
    return replace(clock, **given)


def _changes(case: Case) -> dict[int, list[tuple[str, Any]]]:
    """The values to set before each update."""
    changes: dict[int, list[tuple[str, Any]]] = {}
    for key, values in case.setup.changes.items():
        for update in read_range(key, 10**9) or ():
            changes.setdefault(update, []).extend(values.items())
    return changes


def _set(node: Node, name: str, value: Any, update: int) -> None:
    try:
        set_input(node, name, value)
    except ValueError as error:
        raise UserError(f"changes: update {update}: {error}") from None


def _playing(case: Case) -> Any:
    playing = case.setup.playing
    if isinstance(playing, bool):
        return lambda update: playing
    return frozenset(playing).__contains__
