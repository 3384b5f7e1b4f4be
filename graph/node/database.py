"""The database: a compute function's view of its node's attributes, memory, control flow and world."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, NoReturn, Protocol

from graph.base.suggest import did_you_mean

from .attribute_names import names_in_order, python_name
from .context import Context

if TYPE_CHECKING:
    from graph.sim.app import App
    from graph.values.types import Type

    from .variables import Variables

# Why a node computes, if no execution input triggered it.
STARTED: Any = None
"""The evaluation itself started it: an event node, a sleeping node, a data node."""
RETURNED: Any = False
"""The walk came back after `fire_and_return`."""
RETURN: Any = None
"""Follows an output in the list of fired outputs: come back to this node afterwards."""


class OwnGraph(Protocol):
    """What a compute function can ask of the graph of its node."""

    @property
    def path(self) -> str:
        """The graph's path."""

    @property
    def context(self) -> Context:
        """Time and world of the present evaluation."""

    @property
    def variables(self) -> Variables:
        """The graph's variables."""

    @property
    def target(self) -> str:
        """The prim of this graph instance, else the graph's path."""

    @property
    def pipeline_stage(self) -> str:
        """The pipeline stage in which it is evaluated."""

    @property
    def step_limit(self) -> int:
        """Most nodes that one walk may compute."""

    def sleeps(self, db: Database) -> None:
        """Called when a node falls asleep."""

    def wakes(self, db: Database) -> None:
        """Called when a node wakes up."""


class OwnType(Protocol):
    """What a compute function can ask of the type of its node: its declaration (`graph.node.NodeType`)."""

    @property
    def short_name(self) -> str:
        """The last part of the id."""

    @property
    def inputs(self) -> Mapping[str, object]:
        """The declared inputs by name."""

    @property
    def outputs(self) -> Mapping[str, object]:
        """The declared outputs by name."""

    @property
    def compute(self) -> Any:
        """The compute function; None for constants."""


class OwnNode(Protocol):
    """What a compute function can ask of its node."""

    @property
    def path(self) -> str:
        """The node's path."""

    @property
    def type(self) -> OwnType:
        """The node's type."""

    @property
    def graph(self) -> OwnGraph:
        """The graph that contains it."""

    @property
    def names(self) -> Mapping[str, tuple[str, ...]]:
        """Attribute names by prefix; dynamic ones are last."""

    @property
    def types(self) -> Mapping[str, Type | None]:
        """Resolved types by full name; None for open ones."""

    @property
    def computes(self) -> int:
        """How often it has computed, summed over all instances of its graph."""

    def connected(self, name: str) -> bool:
        """Whether a connection leads to this input, or from this output."""

    def consumed(self, name: str) -> bool:
        """Whether anything reads this output."""

    def is_read(self) -> bool:
        """Whether anything needs what it gives."""

    def wires_into(self, name: str) -> int:
        """The number of connections to this execution input."""


class NodeError(Exception):
    """A node cannot do its work; the message says why and what to do."""


class LackError(NodeError):
    """Something that the file or an edit should provide is missing.

    In a saved scene the run goes on without the node's work.
    """


class Database:
    """The `db` argument of a compute function: its view of the node.

    `inputs`, `outputs` and `state` hold plain values as attributes (`db.inputs.duration`). Never change an array or a
    list in place; assign a new one. `memory` is private to the node; the type's `memory` factory makes it at creation
    and again after every timeline stop. `path` is the node's path. `asleep`: whether the node sleeps.
    """

    __slots__ = {
        "_active": "what made it compute: an execution input's name, STARTED or RETURNED",
        "_blocked": "whether triggers are ignored",
        "_compute": "the type's compute",
        "_deaf": "how often a trigger was ignored",
        "_enabled": "names of the outputs fired in this compute; RETURN after one to come back from",
        "_frames": "budgets of the walks that wait for this node's return",
        "_held": "whether a walk must look closer first: it is blocked, or data nodes compute before it",
        "_node": "the node",
        "_pulls": "data nodes to compute first: a tuple, True while not known yet, () for none",
        "_push": "copies the outputs to their readers",
        "_wires": "execution outputs by name",
        "asleep": "whether the node sleeps",
        "computes": "how often the node has computed",
        "fire": "fire(output): follow this execution output after the compute; several in the order of the calls",
        "inputs": "input values",
        "memory": "the node's own memory",
        "outputs": "output values",
        "path": "the node's path",
        "state": "state values",
    }

    def __init__(self, node: OwnNode) -> None:
        # The evaluators create these objects and use more of their members.
        self._node: Any = node
        self._active: Any = STARTED
        self._blocked = False
        # Constants have no database members to run: they are never computed.
        self._compute: Any = node.type.compute
        self._enabled: list[Any] = []
        self._deaf = 0
        self._frames: list[Any] = []
        self._held = False
        self._pulls: Any = ()
        self._push: Any = None
        self._wires: dict[str, Any] = {}
        self.asleep = False
        self.computes = 0
        # A bound append costs half as much as a method call; the walk looks the names up.
        self.fire: Callable[[str], None] = self._enabled.append
        self.inputs: Any = None
        self.memory: Any = None
        self.outputs: Any = None
        self.path = node.path
        self.state: Any = None

    # -- control -----------------------------------------------------------------------------------------------------

    def fire_and_return(self, output: str) -> None:
        """Follow this execution output to its end, then compute this node again, with `returned` true."""
        self._enabled += (output, RETURN)

    def triggered(self, name: str) -> bool:
        """Whether this execution input triggered the compute.

        False if the node woke up, was returned to, or is an event.
        """
        is_this: bool = name == self._active
        return is_this

    @property
    def active(self) -> str | None:
        """The execution input that triggered the compute. None if the node woke up, was returned to, or is an event."""
        return self._active or None

    @property
    def returned(self) -> bool:
        """Whether this compute is the one that follows `fire_and_return`."""
        return self._active is RETURNED

    def sleep(self) -> None:
        """Compute this node again in every later evaluation, ahead of the events, until `wake`; ignore triggers."""
        if not self.asleep:
            self.asleep = True
            self._node.graph.sleeps(self)

    def wake(self) -> None:
        """End the sleep. Triggers that come later in this evaluation are still ignored."""
        if self.asleep:
            self.asleep = False
            self._node.graph.wakes(self)

    def _set_blocked(self, blocked: bool) -> None:
        self._blocked = blocked
        self._held = blocked or bool(self._pulls)

    def _set_pulls(self, pulls: Any) -> None:
        self._pulls = pulls
        self._held = self._blocked or bool(pulls)

    # -- attributes --------------------------------------------------------------------------------------------------

    def connected(self, name: str) -> bool:
        """Whether a connection leads to this input, or from this output."""
        return self.node.connected(name)

    def consumed(self, name: str) -> bool:
        """Whether anything reads this output."""
        return self.node.consumed(name)

    def wanted(self, name: str) -> bool:
        """Whether anything reads this output, or a program may do so at any time."""
        return self.node.graph.context.asked or self.node.consumed(name)

    def is_read(self) -> bool:
        """Whether anything needs the outputs now: not if all that they lead to are publishers without a listener."""
        return self.node.is_read()

    def wires_into(self, name: str) -> int:
        """The number of connections to this execution input."""
        return self.node.wires_into(name)

    def dynamic_inputs(self, prefix: str = "") -> list[Any]:
        """Values of the inputs `prefix0`, `prefix1`, ... in numeric order, declared ones included.

        Without prefix: of all inputs that the file added, in the order of the file (numeric if all share one stem).
        """
        return [getattr(self.inputs, python_name(name)) for name in self.dynamic_input_names(prefix)]

    def dynamic_input_names(self, prefix: str = "") -> list[str]:
        """Names of the inputs whose values `dynamic_inputs` gives."""
        return self._dynamic("inputs", prefix)

    def dynamic_outputs(self, prefix: str = "") -> list[str]:
        """Names of the outputs `prefix0`, `prefix1`, ...: declared or connected by the file, in numeric order."""
        return self._dynamic("outputs", prefix)

    def input_type(self, name: str) -> str | None:
        """The OGN type name of an input; None if it is open and unresolved."""
        type_ = self._node.types.get(f"inputs:{name}")
        return None if type_ is None else type_.name

    def output_type(self, name: str) -> str | None:
        """The OGN type name of an output; None if it is open and unresolved."""
        type_ = self._node.types.get(f"outputs:{name}")
        return None if type_ is None else type_.name

    # -- world -------------------------------------------------------------------------------------------------------

    @property
    def context(self) -> Context:
        """Time and world of this evaluation."""
        context: Context = self._node.graph.context
        return context

    @property
    def app(self) -> App:
        """The App. Raises NodeError if the graph runs without a world."""
        app: App | None = self._node.graph.context.app
        if app is None:
            raise NodeError("this node needs a world; run its graph in an App")
        return app

    @property
    def variables(self) -> Variables:
        """The graph's variables by name."""
        return self.node.graph.variables

    @property
    def node(self) -> OwnNode:
        """The node itself, for the few computes that need more than `db` offers."""
        node: OwnNode = self._node
        return node

    def warn(self, code: str, message: str) -> None:
        """Report a warning to the user: a stable code and one line. Repeats are counted, not shown."""
        self._node.graph.context.warn(code, self.path, message)

    def log_error(self, message: str) -> None:
        """Report an error without ending the run, under the code `node-error`."""
        self.warn("node-error", message)

    def log_warning(self, message: str) -> None:
        """Report a warning to the user, under the code `node-warning`."""
        self.warn("node-warning", message)

    def log_info(self, message: str) -> None:
        """Write to the log (`logging`, level INFO), which is hidden by default."""
        import logging

        logging.getLogger("tickgraph").info("%s: %s", self.path, message)

    def claim(self, size: int) -> None:
        """Reserve memory for a result of `size` bytes before it is made. Raises NodeError if it is too much."""
        problem = self._node.graph.context.room.claim(self.path, size)
        if problem:
            raise NodeError(problem)

    def fail(self, message: str) -> NoReturn:
        """Give up: the run stops with this message, the node's path and its place in the file."""
        raise NodeError(message)

    def lack(self, message: str) -> NoReturn:
        """Give up because something in the graph is missing.

        In a graph of a saved scene this is a warning, and the run goes on.
        """
        raise LackError(message)

    def source_of(self, name: str) -> str:
        """The attribute that feeds an input, as the file writes it (`make.array`); "" if the input is unconnected."""
        node = self._node
        ends = {f"{owner}.{side}{name}" for owner in (node.name, node.path) for side in ("", "inputs:")}
        return next((one.source for one in node.graph.spec.connections if one.target in ends), "")

    def _dynamic(self, prefix: str, stem: str) -> list[str]:
        names = self._node.names[prefix]
        if stem:
            return names_in_order([n for n in names if n.startswith(stem) and n[len(stem) :].isdecimal()])
        declared = getattr(self._node.type, prefix)
        if len(names) == len(declared):
            return []
        return names_in_order([name for name in names if name not in declared])

    def _no_wire(self, output: str) -> NoReturn:
        raise NodeError(
            f'the node type has no execution output "{output}"{did_you_mean(output, self._wires)}'
        ) from None
