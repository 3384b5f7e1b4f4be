"""A tiny node library of the engine's own, so that its tests prove the evaluator and not the shipped nodes."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import pytest

from graph import Attribute, Context, Graph, Mark, compile_graphs, declare, node_type
from graph.node.registry import Registry
from graph.spec.file_spec import ConnectionSpec, GraphSpec, NodeSpec, VariableSpec

EXECUTION_IN = {"execIn": Attribute("execution", "activates")}
EXECUTION_OUT = {"execOut": Attribute("execution", "follows")}


class Journal(list[str]):
    """Names of nodes in the order in which they computed."""

    def take(self) -> list[str]:
        """What came since the last time."""
        taken = list(self)
        self.clear()
        return taken


class Countdown:
    """Memory of the latent test node."""

    def __init__(self) -> None:
        self.left = 0


@pytest.fixture
def journal() -> Journal:
    return Journal()


@pytest.fixture
def library(journal: Journal) -> Registry:
    registry = Registry()

    def note(db: Any) -> None:
        journal.append(db.node.name)

    @node_type("test.Tick", outputs={"tick": Attribute("execution", "every evaluation")}, event=True, registry=registry)
    def tick(db: Any) -> None:
        """Fires in every evaluation."""
        note(db)
        db.fire("tick")

    @node_type("test.Step", inputs=EXECUTION_IN, outputs=EXECUTION_OUT, registry=registry)
    def step(db: Any) -> None:
        """Passes control on."""
        note(db)
        db.fire("execOut")

    @node_type(
        "test.Sequence",
        inputs=EXECUTION_IN,
        dynamic_outputs={"output{n}": Attribute("execution", "in turn")},
        registry=registry,
    )
    def sequence(db: Any) -> None:
        """Fires all its outputs in numeric order."""
        note(db)
        for name in db.dynamic_outputs("output"):
            db.fire(name)

    @node_type(
        "test.Loop",
        inputs=EXECUTION_IN | {"times": Attribute("int", "passes", default=3)},
        outputs={
            "body": Attribute("execution", "each pass"),
            "finished": Attribute("execution", "in the end"),
            "index": Attribute("int", "pass"),
        },
        state={"pass": Attribute("int", "next pass")},
        registry=registry,
    )
    def loop(db: Any) -> None:
        """A for loop."""
        if not db.returned:
            setattr(db.state, "pass", 0)
        index = getattr(db.state, "pass")
        if index < db.inputs.times:
            db.outputs.index = index
            setattr(db.state, "pass", index + 1)
            db.fire_and_return("body")
        else:
            db.fire("finished")

    @node_type(
        "test.Wait",
        inputs=EXECUTION_IN | {"updates": Attribute("int", "how long", default=2)},
        outputs={"tick": Attribute("execution", "while it waits"), "finished": Attribute("execution", "in the end")},
        memory=Countdown,
        registry=registry,
    )
    def wait(db: Any) -> None:
        """Sleeps for some evaluations."""
        note(db)
        if db.triggered("execIn"):
            db.memory.left = db.inputs.updates
            db.sleep()
            return
        db.memory.left -= 1
        db.fire("tick")
        if db.memory.left == 0:
            db.fire("finished")
            db.wake()

    @node_type(
        "test.Inc",
        inputs={"a": Attribute("double", "in")},
        outputs={"y": Attribute("double", "a + 1")},
        registry=registry,
    )
    def inc(db: Any) -> None:
        """Adds one."""
        note(db)
        db.outputs.y = db.inputs.a + 1

    @node_type(
        "test.Count",
        inputs=EXECUTION_IN,
        outputs=EXECUTION_OUT | {"count": Attribute("int", "so far")},
        state={"count": Attribute("int", "so far")},
        registry=registry,
    )
    def count(db: Any) -> None:
        """Counts its activations."""
        note(db)
        db.state.count += 1
        db.outputs.count = db.state.count
        db.fire("execOut")

    @node_type(
        "test.Record",
        inputs=EXECUTION_IN | {"value": Attribute("double", "what to note")},
        outputs=EXECUTION_OUT,
        memory=list,
        registry=registry,
    )
    def record(db: Any) -> None:
        """Notes its input."""
        note(db)
        db.memory.append(db.inputs.value)
        db.fire("execOut")

    @node_type(
        "test.Fail",
        inputs=EXECUTION_IN | {"message": Attribute("string", "why")},
        outputs=EXECUTION_OUT,
        registry=registry,
    )
    def fail(db: Any) -> None:
        """Raises the exception of the test."""
        note(db)
        if db.inputs.message:
            db.fail(db.inputs.message)
        raise ZeroDivisionError("division by zero")

    @node_type("test.Never", inputs=EXECUTION_IN, outputs=EXECUTION_OUT, registry=registry)
    def never(db: Any) -> bool:
        """Has nothing to do."""
        note(db)
        db.fire("execOut")
        return False

    @node_type(
        "test.Sum",
        inputs={"a": Attribute(("numerics",), "one"), "b": Attribute(("numerics",), "two")},
        outputs={"sum": Attribute(("numerics",), "a + b")},
        dynamic_inputs={"{x}": Attribute(("numerics",), "more")},
        resolve=lambda known: {"sum": known["a"]} if known["a"] and known["b"] else {},
        registry=registry,
    )
    def total(db: Any) -> None:
        """Adds up."""
        note(db)
        db.outputs.sum = sum(db.dynamic_inputs(), db.inputs.a + db.inputs.b)

    @node_type("test.Show", inputs={"value": Attribute("any", "anything")}, memory=list, registry=registry)
    def show(db: Any) -> None:
        """Takes anything."""
        note(db)
        db.memory.append(db.inputs.value)

    source = {"value": Attribute("double", "a number", default=0.0, output_only=True)}
    declare("test.Constant", "A number.", inputs=source, registry=registry)
    vector = {"value": Attribute("double[3]", "a vector", output_only=True)}
    declare("test.Vector", "A vector.", inputs=vector, registry=registry)
    token = {"value": Attribute("token", "a word", output_only=True)}
    declare("test.Word", "A word.", inputs=token, registry=registry)
    return registry


Build = Callable[..., Graph]


def spec_of(
    nodes: Mapping[str, Any],
    connections: Sequence[str] = (),
    evaluator: Any = "execution",
    path: str = "/World/G",
    variables: Mapping[str, tuple[str, Any]] | None = None,
    file: str = "g.yaml",
) -> GraphSpec:
    """A graph from `{"name": "Type"}` or `{"name": ("Type", {"input": value})}` and `"a.x -> b.y"`.

    Marks: line n is the n-th node, line 100 + n the n-th connection.
    """
    made = []
    for line, (name, entry) in enumerate(nodes.items(), 1):
        type_id, inputs = (entry, {}) if isinstance(entry, str) else entry
        made.append(NodeSpec(name, type_id, inputs, Mark(file, line, 1)))
    links = [
        ConnectionSpec(source, target, Mark(file, 100 + line, 1))
        for line, (source, _, target) in enumerate((text.partition(" -> ") for text in connections), 1)
    ]
    specs = {name: VariableSpec(type_, value) for name, (type_, value) in (variables or {}).items()}
    return GraphSpec(path, tuple(made), tuple(links), evaluator, variables=specs)


@pytest.fixture
def build(library: Registry) -> Build:
    """Compiles one graph over the test library; see `spec_of`."""

    def make(
        nodes: Mapping[str, Any], connections: Sequence[str] = (), evaluator: Any = "execution", **more: Any
    ) -> Graph:
        return compile_graphs([spec_of(nodes, connections, evaluator, **more)], library)[0]

    return make


@pytest.fixture
def playing() -> Context:
    return Context.standalone()


@pytest.fixture
def make_spec() -> Callable[..., GraphSpec]:
    return spec_of
