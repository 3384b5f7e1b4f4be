"""A node of a compiled graph: what tools and tests see of it, and how it is reset."""

from __future__ import annotations

from collections.abc import Callable, Container, Iterable, Iterator, Mapping, Sequence
from functools import cache
from typing import TYPE_CHECKING, Any, NoReturn

from graph.base.errors import Mark, RunError
from graph.base.records import dataclass
from graph.base.suggest import did_you_mean
from graph.node.attribute_names import python_name
from graph.node.context import Context
from graph.node.database import Database, LackError
from graph.node.declaration import Attribute, Compute, NodeType
from graph.values.coercion import coerce, zero
from graph.values.precision import ROUNDERS
from graph.values.types import Type

from .omnigraph_names import FamiliarNode
from .wire import Copy, Wire, all_of, storage

if TYPE_CHECKING:
    from .graph import Graph

PREFIXES = ("inputs", "outputs", "state")


class ComputeError(RunError):
    """A node's compute raised.

    The message names the node, its place in the file and the update; the cause is chained.
    """

    def __init__(self, node: Node, update: int, message: str) -> None:
        self.node = node
        self.update = update
        place = f"{node.mark}: " if node.mark else ""
        super().__init__(f"{place}node {node.path} ({node.type.short_name}) failed in update {update}: {message}")


class RunawayError(RunError):
    """Execution wires form a loop without a latent node in it."""


class Node(FamiliarNode):
    """One node. `types` holds its attributes' resolved types by full name (`inputs:x`), None for open ones."""

    __slots__ = (
        "_used",
        "added",
        "asked",
        "consumed_names",
        "db",
        "fed_names",
        "graph",
        "index",
        "initial_values",
        "late",
        "mark",
        "name",
        "names",
        "passes",
        "path",
        "rank",
        "readers",
        "sources",
        "type",
        "types",
        "wires_in",
    )

    def __init__(self, graph: Graph, name: str, node_type: NodeType, index: int, mark: Mark | None) -> None:
        self.graph = graph
        self.name = name
        self.path = f"{graph.path}/{name}"
        self.type = node_type
        self.index = index
        self.mark = mark
        self.rank = 0
        """Position in the dependency order over all graphs compiled together."""
        self.sources: tuple[Node, ...] = ()
        """The nodes from which its inputs get outputs or state, in any graph."""
        self.readers: tuple[Node, ...] = ()
        """The nodes that read its outputs, state or set inputs, in any graph."""
        self.types: Mapping[str, Type | None] = {}
        self.names: Mapping[str, tuple[str, ...]] = {}
        """Attribute names by prefix, in file order; dynamic ones last."""
        self.late: Mapping[str, int] = {}
        """Open attributes whose type follows from a written value or a reader; see `graph.plan.draft.Draft.late`."""
        self.initial_values: Mapping[str, Any] = {}
        """The initial values of its attributes, by full name."""
        self.fed_names: frozenset[str] = frozenset()
        """Full names of the attributes that a connection leads to."""
        self.consumed_names: frozenset[str] = frozenset()
        """Full names of the attributes that a connection leads from."""
        self.passes: dict[str, list[Copy]] = {}
        """The functions that copy a set input to its readers, by full name."""
        self.wires_in: Mapping[str, list[Wire]] = {}
        """The wires that lead to each execution input, by full name."""
        self.asked = False
        """Whether a program has asked for an output of it: from then on it is read."""
        self._used = 0
        self.added: Mapping[str, Attribute] = {}
        """Attributes that the file added, by full name."""
        self.db = Database(self)

    def __repr__(self) -> str:
        return f"<node {self.path} ({self.type.short_name})>"

    @property
    def computes(self) -> int:
        """How often it has computed, summed over all instances of its graph."""
        return self.db.computes + sum(one.nodes[self.name].computes for one in self.graph.instances.values())

    @property
    def fired(self) -> dict[str, int]:
        """How often each execution output was followed, summed over all instances of its graph."""
        instances = [one.nodes[self.name].db._wires for one in self.graph.instances.values()]
        return {
            name: wire.count + sum(wires[name].count for wires in instances) for name, wire in self.db._wires.items()
        }

    @property
    def triggered(self) -> int:
        """How often execution reached it over its wires, used or ignored, summed over all instances of its graph."""
        own = sum(wire.count for wires in self.wires_in.values() for wire in wires)
        return own + sum(one.nodes[self.name].triggered for one in self.graph.instances.values())

    @property
    def ignored(self) -> int:
        """How many of these triggers it ignored because it slept, summed over all instances of its graph."""
        return self.db._deaf + sum(one.nodes[self.name].ignored for one in self.graph.instances.values())

    def attribute(self, name: str) -> Attribute:
        """The declaration of an attribute (`x` or `inputs:x`). Raises KeyError with the nearest name."""
        full = self.full_name(name)
        attribute = self.added.get(full) or self.type.find(*full.split(":", 1))
        assert attribute is not None
        return attribute

    def full_name(self, name: str) -> str:
        """`inputs:x` for `x`: inputs first, then outputs, then state. Raises KeyError with the nearest name."""
        prefix, _, short = name.partition(":")
        if prefix in PREFIXES and short in self.names[prefix]:
            return name
        for prefix in PREFIXES:
            if name in self.names[prefix]:
                return f"{prefix}:{name}"
        known = [f"{prefix}:{short}" for prefix in PREFIXES for short in self.names[prefix]]
        near = did_you_mean(name, known if ":" in name else [one.partition(":")[2] for one in known])
        raise KeyError(f'node {self.path} ({self.type.short_name}) has no attribute "{name}"{near}')

    def get(self, name: str) -> Any:
        """The present value of an attribute, `x` or `outputs:x`. Raises KeyError for an unknown one."""
        full = self.full_name(name)
        prefix, short = full.split(":", 1)
        if prefix == "outputs":
            self.asked = True
        value = getattr(getattr(self.db, prefix), python_name(short), None)
        # What a compute wrote into a float or half is rounded when it is read: here and on connections.
        if isinstance(value, float) and (type_ := self.types[full]) is not None and type_.storage in ROUNDERS:
            return ROUNDERS[type_.storage](value)
        return value

    def set(self, name: str, value: Any) -> None:
        """Sets an input or state attribute, now and for every start after a stop; an equal value changes nothing.

        Raises KeyError for an unknown name and ValueError for a value that does not fit the type or that a connection
        would overwrite.
        """
        full = self.full_name(name)
        prefix, short = full.split(":", 1)
        type_ = self.types[full]
        if prefix == "outputs" or full in self.fed_names:
            raise ValueError(
                f"{self.path}.{full} is {'an output' if prefix == 'outputs' else 'connected'}; set its source"
            )
        if type_ is None:
            raise ValueError(f"{self.path}.{full} has an open type; connect it or give it a value in the file")
        try:
            value = coerce(type_, value)
        except ValueError as error:
            raise ValueError(f"{self.path}.{full}: {error}") from None
        wrong = self.attribute(full).check(value)
        if wrong:
            raise ValueError(f"{self.path}.{full}: {wrong}")
        self.initial_values = {**self.initial_values, full: value}
        self.graph.written[self.name, full] = value
        values, attribute = getattr(self.db, prefix), python_name(short)
        changed = not _equal(getattr(values, attribute), value)
        setattr(values, attribute, value)
        for copy in self.passes.get(full, ()):
            copy()
        if changed:
            self.graph.touched(self)
        for instance in self.graph.instances.values():
            instance.nodes[self.name].set(full, instance.resolved(value))

    def initial(self, full: str) -> Any:
        """The initial value of an attribute, named in full."""
        return self.initial_values[full]

    def connected(self, name: str) -> bool:
        """Whether a connection leads to this input (or state), or from this output."""
        full = self.full_name(name)
        return full in self.consumed_names if full.startswith("outputs:") else full in self.fed_names

    def empty_needs(self) -> Iterator[tuple[str, ...]]:
        """The groups of inputs that the node needs (`NodeType.needs`) of which none has a value now."""
        for group in self.type.needs:
            values = [self.get(name) for name in group]
            if not any(len(value) if hasattr(value, "__len__") else value for value in values):
                yield group

    def wires_into(self, name: str) -> int:
        """The number of connections to an execution input."""
        return len(self.wires_in.get(f"inputs:{name}", ()))

    def consumed(self, name: str) -> bool:
        """Whether anything reads this output."""
        full = name if name.startswith("outputs:") else f"outputs:{name}"
        return full in self.consumed_names or (self.name, full) in self.graph.asked

    def is_read(self) -> bool:
        """Whether anything needs what it gives: a node, but for publishers without a listener; a tool; a program.

        A node without any connection from its outputs counts as read: a program may ask for them.
        """
        if self.asked or self.graph.observed or not self.consumed_names:
            return True
        reached = {step[0]._node: None for wire in self.db._wires.values() for step in wire.targets}
        return not all(node.is_idle() for node in (*self.readers, *reached))

    def is_idle(self) -> bool:
        """Whether it has no use for its inputs now: a publisher without a listener, and what only feeds such nodes."""
        told = getattr(self.db.memory, "is_idle", None)
        if told is not None:
            return not self.consumed_names and bool(told(self.db))
        return not (self.type.has_execution or self.type.always_dirty) and not self.is_read()

    def attributes(self) -> Iterator[tuple[str, Attribute]]:
        """Full names and declarations of all attributes, inputs first."""
        for prefix in PREFIXES:
            for name in self.names[prefix]:
                yield f"{prefix}:{name}", self.attribute(f"{prefix}:{name}")

    def prepare(self, context: Context | None = None) -> None:
        """Computes the data nodes that it reads and calls the type's `prepare`; it does not compute or fire itself."""
        if self.type.prepare is None:
            return
        if context is not None:
            self.graph.context = context
        # The memory holds what is prepared, so it is released like the results of a compute.
        self._used = -1
        db = self.db
        try:
            for db in upstream_data(self):
                db.computes += 1
                if db._compute(db) is not False and db._push is not None:
                    db._push()
            db = self.db
            self.type.prepare(db)
        except Exception as error:
            self.graph.failed(db, error)

    # -- for the compiler and the evaluators -------------------------------------------------------------------------

    def build(
        self,
        names: Mapping[str, tuple[str, ...]],
        types: Mapping[str, Type | None],
        initial: Mapping[str, Any],
        added: Mapping[str, Attribute],
        layout: Layout,
        late: Mapping[str, int],
    ) -> None:
        """Makes the storage: names by prefix, types and initial values by full name, attributes that the file added."""
        self.names, self.types, self.initial_values, self.added, self.late = names, types, initial, added, late
        db = self.db
        db.inputs, db.outputs, db.state = layout.inputs(), layout.outputs(), layout.state()
        for name in layout.wires:
            db._wires[name] = Wire(name)
        self._fill()

    def connect(
        self,
        fed: frozenset[str],
        consumed: frozenset[str],
        sources: tuple[Node, ...],
        readers: tuple[Node, ...],
        pushes: list[Copy],
        passes: dict[str, list[Copy]],
        wires_in: Mapping[str, list[Wire]],
        unset: str,
    ) -> None:
        """Gives the node its connections: its sources and readers, and the functions that copy outputs and set inputs.

        wires_in: the wires that lead to each execution input; unset: why it cannot compute, "" if it can.
        """
        self.fed_names, self.consumed_names, self.passes, self.wires_in = fed, consumed, passes, wires_in
        self.sources, self.readers = sources, readers
        self.db._push = all_of(pushes)
        # Found at the first compute: most nodes of a large graph may never need it.
        self.db._set_pulls(True if sources else ())
        # Before any wire stores the compute function.
        if unset:
            self.db._compute = refusing(unset)
            return
        own = self.type.specialize and self.type.specialize(self.db)
        if own:
            self.db._compute = own

    def release(self) -> None:
        """Lets the type release what the node's memory holds, if the node has computed since its start."""
        if self.type.release is not None and self.db.computes != self._used:
            self._used = self.db.computes
            self.type.release(self.db)

    def reset(self) -> None:
        """Back to the start: authored values, new memory, awake. Counts continue."""
        self.release()
        self._used = self.db.computes
        self._fill()

    def clear(self, inputs: Iterable[str]) -> None:
        """Sets inputs to the zero of their type; arrays become empty."""
        for name in inputs:
            settled = self.types[f"inputs:{name}"]
            if settled is not None:
                setattr(self.db.inputs, python_name(name), zero(settled))

    def source_values(self) -> tuple[Any, ...]:
        """The present values of its outputs and state, to see whether a compute changed any."""
        db = self.db
        return tuple(
            getattr(part, python_name(name), None)
            for prefix, part in (("outputs", db.outputs), ("state", db.state))
            for name in self.names[prefix]
        )

    def _fill(self) -> None:
        db = self.db
        parts = {"inputs": db.inputs, "outputs": db.outputs, "state": db.state}
        for full, value in self.initial_values.items():
            prefix, name = storage_place(full)
            setattr(parts[prefix], name, value)
        db._enabled.clear()
        db._frames.clear()
        db.asleep = False
        db._set_blocked(False)
        db.memory = None if self.type.memory is None else self.type.memory()


class StaleNode(Node):
    """A node that an edit concerns that is not compiled yet: reading what the compiler decides compiles the graph."""

    __slots__ = ()

    if not TYPE_CHECKING:

        def __getattribute__(self, name):
            if name in COMPILED:
                self.graph.settle()
            return object.__getattribute__(self, name)


COMPILED = frozenset(Node.__slots__) - {
    *("_used", "added", "asked", "graph", "index", "mark", "name", "names", "path", "type")
}
"""What the compiler decides about a node."""


@cache
def storage_place(full: str) -> tuple[str, str]:
    """Where the value of an attribute, named in full, is stored: the storage object and the name in it."""
    prefix, _, short = full.partition(":")
    return prefix, python_name(short)


@dataclass(frozen=True, slots=True)
class Layout:
    """The classes that nodes with the same attributes share: storage by prefix, names of execution outputs."""

    inputs: Callable[[], Any]
    outputs: Callable[[], Any]
    state: Callable[[], Any]
    wires: tuple[str, ...]

    @classmethod
    def of(cls, owner: str, names: Mapping[str, Sequence[str]], initial: Container[str]) -> Layout:
        """For attributes of these names by prefix; an attribute without an initial value is execution."""
        data = {prefix: tuple(n for n in names[prefix] if f"{prefix}:{n}" in initial) for prefix in PREFIXES}
        inputs, outputs, state = (storage(f"{prefix} of {owner}", data[prefix]) for prefix in PREFIXES)
        return cls(inputs, outputs, state, tuple(n for n in names["outputs"] if n not in data["outputs"]))


def refusing(message: str) -> Compute:
    """The compute function of a node that cannot compute because an open input is unset."""

    def compute(db: Database) -> NoReturn:
        raise LackError(message)

    return compute


def upstream_data(node: Node) -> tuple[Database, ...]:
    """The data nodes that a node reads and that nothing else computes, sources first.

    Includes indirect sources through other data nodes, but not through nodes with execution attributes. Data nodes of
    push graphs are left out: they compute by themselves.
    """
    found: dict[Node, None] = {}
    pending = list(node.sources)
    while pending:
        source = pending.pop()
        if source not in found and not source.type.has_execution:
            found[source] = None
            pending += source.sources
    computed = (one for one in found if one.type.compute is not None and one.graph.evaluator == "execution")
    return tuple(one.db for one in sorted(computed, key=lambda one: one.rank))


def _equal(before: Any, now: Any) -> bool:
    """Whether a value set from outside equals the present one, in type and shape too."""
    if hasattr(now, "dtype"):
        return hasattr(before, "dtype") and before.shape == now.shape and bool((before == now).all())
    return type(before) is type(now) and bool(before == now)
