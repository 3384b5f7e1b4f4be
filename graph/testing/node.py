"""Tests one node in two lines, without a world or a file.

trace = run_node("Countdown", inputs={"duration": 10, "period": 3}, pulses={"execIn": [0]}, updates=12)
assert trace.fired("tick") == [3, 6, 9]
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from contextlib import ExitStack
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

from graph.base.errors import RunError, UserError
from graph.base.suggest import one_of
from graph.evaluate import Graph, Node
from graph.node import Database
from graph.node.context import Context, Warned, WarningLog
from graph.node.declaration import Attribute, NodeType
from graph.node.decorator import declare, node_type
from graph.node.registry import DEFAULT, Registry
from graph.plan import compile_graphs
from graph.spec.file_spec import ConnectionSpec, GraphSpec, NodeSpec, VariableSpec
from graph.values.coercion import coerce
from graph.values.types import Type

from .trace import held
from .updates import check_length, count_updates

_PROBE = "tickgraph.testing.Probe"
_SOURCE = "tickgraph.testing.Source"


@dataclass
class Trace:
    """What a node did, by update index. Attribute names are short (`tick`; outputs first) or full (`inputs:x`).

    updates: how many updates were completed.
    """

    node: Node
    graph: Graph
    updates: int
    log: WarningLog
    fires: list[tuple[int, str]] = field(default_factory=list)
    """Every execution output that was followed, as (update, name), in order."""
    recorded: dict[str, list[Any]] = field(default_factory=dict)
    error: RunError | None = None
    """The error that ended the run early (with `run_node(..., catch=True)`)."""

    def fired(self, output: str) -> list[int]:
        """The updates in which this execution output was followed, once for each time."""
        if f"outputs:{output}" not in self.node.types or not self.node.attribute(f"outputs:{output}").is_execution:
            self.node.full_name(f"outputs:{output}")
            raise KeyError(f'"{output}" of {self.node.type.id} is not an execution output; ask for its values')
        return [update for update, name in self.fires if name == output]

    def values(self, name: str) -> list[Any]:
        """The value of an attribute after each update, as a reader of it gets it."""
        return self.recorded[self.full_name(name)]

    def value(self, name: str) -> Any:
        """The value of an attribute after the last update."""
        return self.values(name)[-1]

    @property
    def warnings(self) -> list[Warned]:
        """The node's warnings: objects with code, where, message and count."""
        return list(self.log)

    @property
    def computes(self) -> int:
        """How often the node computed."""
        return self.node.computes

    def full_name(self, name: str) -> str:
        """`outputs:x` for `x`. Raises KeyError for an unknown attribute and for an execution attribute."""
        full = f"outputs:{name}" if f"outputs:{name}" in self.recorded else self.node.full_name(name)
        if full not in self.recorded:
            raise KeyError(f'"{name}" of {self.node.type.id} is an execution attribute; ask when it fired')
        return full


def run_node(
    type_id: str | NodeType,
    *,
    inputs: Mapping[str, Any] | None = None,
    pulses: Mapping[str, Iterable[int]] | None = None,
    updates: int = 1,
    connect: Mapping[str, str] | None = None,
    outputs: Iterable[str] = (),
    consumed: Iterable[str] | None = None,
    variables: Mapping[str, tuple[str, Any]] | None = None,
    evaluator: str | None = None,
    playing: bool | Callable[[int], bool] = True,
    loop_hz: float | str | Fraction = 60,
    app: Any = None,
    phase: str = "simulation_graphs",
    on_update: Callable[[int, Node], None] | None = None,
    interrupts: bool = False,
    catch: bool = False,
    closes: bool = False,
    allow_scripts: bool = False,
    registry: Registry = DEFAULT,
) -> Trace:
    """Runs one node for some updates and returns what it did.

    inputs: values by name (`x`, or `state:x`); a callable gets the index of each update and returns the value; open
    types also take `{"type": "double[3]", "value": [1, 0, 0]}`. pulses: for each execution input the updates in which
    it is triggered; several in one update come in this order. connect: inputs that count as connected, with the OGN
    type of their source; their values still come from `inputs`. outputs: dynamic outputs to make (`output1`, or in full
    `outputs:output1`). consumed: the data outputs that have a reader (default: all). variables: graph variables as
    name: (type, value). evaluator: execution for a node with execution attributes, push for a data node, by default.
    playing: whether the timeline plays, or a function of the update index. app: an App to run in, one app update for
    each update; it is played first if it is stopped. phase: the App's phase in which the node is evaluated. on_update:
    called with index and node before each update. interrupts: see `Graph.interrupts`. catch: a failure that ends the
    run is put into `trace.error` instead of being raised. closes: whether the App closes at the end, for OnClosing; its
    effects are recorded under update `updates`. allow_scripts: whether a ScriptNode may run its script.

    Outputs are checked against their declared types after every compute: a value of another type raises AssertionError.
    Raises UserError for a wrong type id, name or value, and ComputeError when the node fails.

    >>> trace = run_node(
    ...     "omni.graph.action.Countdown",
    ...     inputs={"duration": 10, "period": 3},
    ...     pulses={"execIn": [0]},
    ...     updates=12,
    ... )
    >>> trace.fired("tick"), trace.fired("finished")
    ([3, 6, 9], [10])
    """
    check_length(updates)
    last = updates if closes else updates - 1
    schedule = {name: _counted(name, times, last) for name, times in (pulses or {}).items()}
    kind = registry.get(type_id) if isinstance(type_id, str) else type_id
    graph, trace = _build(
        kind, inputs or {}, pulses or {}, connect or {}, outputs, consumed, variables or {}, evaluator
    )
    graph.interrupts = interrupts
    node = trace.node
    context = Context.standalone(loop_hz)
    context.warn = trace.log
    context.scripts = "run" if allow_scripts else "refuse"
    if app is not None:
        context.app = app

    def evaluate(update: int) -> None:
        if context.closing:
            pass
        elif app is None:
            context.is_playing = playing(update) if callable(playing) else playing
            context.advance()
        else:
            context.follow(app)
        _set_inputs(node, inputs or {}, update)
        activations = [(node, name) for name, times in schedule.items() for _ in range(times.get(update, 0))]
        graph.nodes["probe"].db.memory.update = update
        graph.evaluate(context, activations)
        _record(trace, update)
        trace.updates = update + (not context.closing)

    try:
        if app is None:
            for update in range(updates):
                if on_update is not None:
                    on_update(update, node)
                evaluate(update)
        else:
            _run_in_app(app, phase, updates, evaluate, node, on_update)
        if closes:
            context.closing = True
            evaluate(updates)
    except RunError as error:
        trace.error = error
        if not catch:
            raise
    return trace


def _counted(name: str, times: Iterable[int], last: int) -> dict[int, int]:
    try:
        return count_updates(times, last)
    except (TypeError, ValueError) as error:
        raise UserError(f"pulses: {name}: {error}") from None


def _run_in_app(
    app: Any,
    phase: str,
    updates: int,
    evaluate: Callable[[int], None],
    node: Node,
    on_update: Callable[[int, Node], None] | None,
) -> None:
    current = 0
    with ExitStack() as stack:
        stack.callback(app.on(phase, lambda: evaluate(current)))
        stack.callback(app.on("stop", node.graph.reset))
        if app.timeline.is_stopped():
            app.play()
        for current in range(updates):
            if on_update is not None:
                on_update(current, node)
            app.update()


@dataclass(slots=True)
class _Probed:
    """The probe's memory; it survives stops because it is made once for each run."""

    fires: list[tuple[int, str]] = field(default_factory=list)
    update: int = 0


def _build(
    kind: NodeType,
    inputs: Mapping[str, Any],
    pulses: Mapping[str, Iterable[int]],
    connect: Mapping[str, str],
    outputs: Iterable[str],
    consumed: Iterable[str] | None,
    variables: Mapping[str, tuple[str, Any]],
    evaluator: str | None,
) -> tuple[Graph, Trace]:
    probed = _Probed()
    registry = Registry()
    registry.add(kind)
    _declare_probes(registry, probed, connect)
    added = [name.removeprefix("outputs:") for name in outputs]
    names = list(dict.fromkeys([*kind.outputs, *added]))
    execution = [name for name in names if (found := kind.find("outputs", name)) and found.is_execution]
    data = (
        [name for name in names if name not in execution]
        if consumed is None
        else [name.removeprefix("outputs:") for name in consumed]
    )
    written = {name: value for name, value in inputs.items() if name not in connect}
    node = NodeSpec("node", kind.id, {name: _first(value) for name, value in written.items()})
    links = [
        *(ConnectionSpec(f"node.outputs:{name}", f"probe.inputs:fires_{name}") for name in execution),
        *(ConnectionSpec(f"node.outputs:{name}", f"probe.inputs:reads_{name}") for name in data),
        *(ConnectionSpec(f"source.outputs:{name.removeprefix('inputs:')}", f"node.{_input(name)}") for name in connect),
    ]
    spec = GraphSpec(
        "/test",
        (node, NodeSpec("probe", _PROBE), NodeSpec("source", _SOURCE)),
        tuple(links),
        evaluator or ("execution" if kind.has_execution else "push"),  # type: ignore[arg-type]
        "on_demand",
        {name: VariableSpec(type_, value) for name, (type_, value) in variables.items()},
    )
    graph = compile_graphs([spec], registry)[0]
    trace = Trace(graph.nodes["node"], graph, 0, WarningLog(), probed.fires)
    for name in pulses:
        if name not in trace.node.names["inputs"]:
            execution = [
                one for one in trace.node.names["inputs"] if trace.node.attribute(f"inputs:{one}").is_execution
            ]
            raise UserError(f'pulses: {kind.id} has no input "{name}"{one_of(name, execution)}')
        if not trace.node.attribute(f"inputs:{name}").is_execution:
            raise UserError(f'pulses: "{name}" of {kind.id} is not an execution input; set it by inputs')
    for full, attribute in trace.node.attributes():
        if not attribute.is_execution:
            trace.recorded[full] = []
    return graph, trace


def _declare_probes(registry: Registry, probed: _Probed, connect: Mapping[str, str]) -> None:
    @node_type(
        _PROBE,
        dynamic_inputs={
            "fires_{field}": Attribute("execution", "an output under test"),
            "reads_{field}": Attribute("any", "read"),
        },
        memory=lambda: probed,
        registry=registry,
    )
    def probe(db: Database) -> None:
        """Records which execution output triggered it."""
        if db.active is not None:
            db.memory.fires.append((db.memory.update, db.active.removeprefix("fires_")))

    sources = {name.removeprefix("inputs:"): Attribute(type_, "feeds an input") for name, type_ in connect.items()}
    declare(_SOURCE, "Feeds inputs that the test calls connected", outputs=sources, registry=registry)


def _input(name: str) -> str:
    return name if name.startswith("inputs:") else f"inputs:{name}"


def _first(value: Any) -> Any:
    return value(0) if callable(value) else value


def _set_inputs(node: Node, inputs: Mapping[str, Any], update: int) -> None:
    for name, value in inputs.items():
        if callable(value):
            set_input(node, name, value(update))
        elif node.connected(name):
            set_input(node, name, value)


def set_input(node: Node, name: str, value: Any) -> None:
    """Sets an input or state attribute of a node under test, also one that counts as connected."""
    full = node.full_name(name)
    if node.connected(full):
        type_ = node.types[full]
        setattr(node.db.inputs, full.partition(":")[2], coerce(type_, value) if type_ else value)
    else:
        node.set(name, value)


def _record(trace: Trace, update: int) -> None:
    node = trace.node
    for full, values in trace.recorded.items():
        value = node.get(full)
        type_ = node.types[full]
        if full.startswith("outputs:") and type_ is not None:
            value = _as_read(node, full, type_, value, update)
        values.append(held(value))


def _as_read(node: Node, full: str, type_: Type, value: Any, update: int) -> Any:
    """The value of an output as a reader gets it: a tuple written to a double[] becomes an array."""
    if type_.storage == "bundle":
        return value
    try:
        return coerce(type_, value)
    except ValueError as error:
        raise AssertionError(f"{node.type.id} wrote a wrong value to {full} in update {update}: {error}") from None
