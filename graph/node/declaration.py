"""A node type as data: attributes, the compute function and other hooks, facts that the engine uses."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal, get_args

from graph.base.records import dataclass, field
from graph.values.coercion import coerce, shown, zero
from graph.values.types import AnyType, Extended, parse_type

if TYPE_CHECKING:
    from .at_load import NodeAtLoad
    from .database import Database
    from .known_types import KnownTypes


class _Unset:
    def __repr__(self) -> str:
        return "UNSET"


UNSET: Any = _Unset()
"""No default is declared: the type's zero is used, and an open type must be connected or given a value."""

Role = Literal[
    "", "topic", "stamp", "frame", "data", "prim", "sensor", "product", "command", "timeline time", "loop time"
]
"""What an attribute means to the scheduler, the checks and the reports, none of which knows a node type by name.

Inputs: "topic": the topic that the node publishes on; "stamp": the time [s] in its messages' headers, of several inputs
in the first that has one; "frame": a coordinate frame that its messages name; "data": what its messages say;
"prim": paths as text of prims that must exist (those of targets must anyhow), unless an input `usePath` is false;
"sensor": the prims that it renders;
"product": the path of a render product: in a post-render graph, each new frame of it triggers the node's first
unconnected execution input; "command": what a controller is to do, which a stop clears in the profile isaacsim-6.0.1.

Outputs: "product": the path of the render product that the node creates; "timeline time", "loop time": a clock other
than the one that sensor stamps use.
"""

CLOSING = "closing"
"""The phase of events that come once, just before the App closes."""
PHYSICS_STEP = "physics_post_step"
"""The phase of events that come with each physics step."""
NEVER_FIRES = "it never fires in a {stage} graph; give the graph pipeline_stage: on_demand"
"""The warning about such an event in a graph of another stage."""

Compute = Callable[["Database"], "bool | None"]
Resolve = Callable[["KnownTypes"], Mapping[str, Any]]
Specialize = Callable[["Database"], "Compute | None"]
Hook = Callable[["Database"], None]
Check = Callable[["NodeAtLoad"], Iterable[tuple[str, str]]]
MessageType = Callable[["Database"], str]
FurtherTopics = Callable[["Database"], Mapping[str, str]]
Frames = Callable[["Database"], Iterable[str] | None]
Asks = Callable[["Database"], Iterable[str]]
Notes = Callable[["Database"], Iterable[tuple[str, str, str]]]


@dataclass(frozen=True)
class Attribute:
    """Declares one attribute of a node type.

    type: an OGN type name, or a tuple of names and groups (a union); unit: shown to people, never used to compute;
    optional: an open type may stay unset; literal_only: cannot be connected; output_only: an input that can only be a
    source (constants); allowed_tokens: the values that a file may write; minimum, maximum: bounds of the values that a
    file may write; deprecated: what to use instead, "" if not deprecated; warns_itself: the node itself warns of the
    deprecation; role: its meaning for the scheduler and the reports (see `Role`).
    """

    type: str | tuple[str, ...]
    doc: str
    default: Any = field(default=UNSET, kw_only=True)
    unit: str = field(default="", kw_only=True)
    optional: bool = field(default=False, kw_only=True)
    literal_only: bool = field(default=False, kw_only=True)
    output_only: bool = field(default=False, kw_only=True)
    allowed_tokens: tuple[str, ...] = field(default=(), kw_only=True)
    minimum: float | None = field(default=None, kw_only=True)
    maximum: float | None = field(default=None, kw_only=True)
    deprecated: str = field(default="", kw_only=True)
    warns_itself: bool = field(default=False, kw_only=True)
    role: Role = field(default="", kw_only=True)

    @cached_property
    def parsed(self) -> AnyType:
        """The declared type. Raises ValueError for an unknown name."""
        return parse_type(self.type)

    @property
    def is_execution(self) -> bool:
        """Whether it carries execution instead of data."""
        return self.type == "execution"

    @cached_property
    def initial(self) -> Any:
        """The value before anyone sets one: the default, else the type's zero (None for open types)."""
        if self.default is UNSET or isinstance(self.parsed, Extended):
            return zero(self.parsed)
        return coerce(self.parsed, self.default)

    def check(self, value: Any) -> str:
        """What is wrong with a value (already coerced) that a user wrote, by choices and bounds; "" if it is valid."""
        if (
            self.allowed_tokens
            and value not in self.allowed_tokens
            and (self.default is UNSET or value != self.default)
        ):
            from graph.base.suggest import did_you_mean

            choices = ", ".join(f'"{token}"' for token in self.allowed_tokens)
            return f"{shown(value)} is not one of {choices}{did_you_mean(str(value), self.allowed_tokens)}"
        if isinstance(value, int | float):
            if self.minimum is not None and not value >= self.minimum:
                return f"{shown(value)} is below the minimum {self.minimum}"
            if self.maximum is not None and not value <= self.maximum:
                return f"{shown(value)} is above the maximum {self.maximum}"
        return ""


@dataclass(frozen=True, eq=False)
class NodeType:
    """A registered node type. Names are unique within inputs, outputs and state; an input may share an output's name.

    event: computed at the start of every evaluation of an execution graph, lower numbers first; None for other types.
    memory: makes the private memory of a node, and makes it again after every timeline stop. release: called with db
    before that memory is dropped. prepare: called with db before the world's next frames, to request what compute will
    need; must be cheap and repeatable. resolve: resolves open types from the known ones (see `KnownTypes`).

    specialize: called with db once, when the graph is compiled: returns a compute function for the node's resolved
    types, or None for the common one; it may keep db.inputs and db.outputs, which live as long as the node. runs_code:
    its work is to run code from the graph file, which needs the user's permission (`Context.scripts`). check: called
    with `NodeAtLoad` when a graph file is opened; gives (input name or "", message) for each mistake in the node's
    values and connections. latent: it may sleep, and ignores triggers meanwhile. volatile: it reads more than its
    inputs (time, the world, variables), so a dirty_push graph always computes it. needs: groups of inputs; of each
    group, at least one must be connected or have a value that is neither zero nor empty. message_type: called with db:
    the type of the messages on its topics with the present inputs, "" if they name none; without it, the `type_name`
    of its memory counts. notes: called with db: (input, code, message) for values that the node warns of when it
    computes; `graph check` calls it before the run. further_topics: called with db: the inputs that name the topics on
    which it sends besides, with the present inputs, and the type of the messages on each. frames: called with db: the
    frames that its transforms connect, None where only a run knows. asks: called with db: the annotators that it
    attaches to its render product, with the present inputs.

    phase: an event that comes with a phase of the App: on-demand graphs that contain it are evaluated in that phase; an
    event of the phase `CLOSING` computes only then, in graphs of every stage. dynamic_inputs, dynamic_outputs:
    attributes that a file may add, by name template: `{n}` stands for digits, `{operand}` for `c`, `d` ... or a word
    with a number, `{x}` for any word, `{field}` for words joined by `:`, as in `input{n}`. origin: module:line of the
    declaration.
    """

    id: str
    version: int = 1
    inputs: Mapping[str, Attribute] = field(default_factory=dict)
    outputs: Mapping[str, Attribute] = field(default_factory=dict)
    state: Mapping[str, Attribute] = field(default_factory=dict)
    compute: Compute | None = None
    memory: Callable[[], Any] | None = None
    event: int | None = None
    release: Hook | None = None
    prepare: Hook | None = None
    resolve: Resolve | None = None
    volatile: bool = False
    dynamic_inputs: Mapping[str, Attribute] = field(default_factory=dict)
    dynamic_outputs: Mapping[str, Attribute] = field(default_factory=dict)
    doc: str = ""
    origin: str = ""
    specialize: Specialize | None = None
    phase: str = ""
    runs_code: bool = False
    check: Check | None = None
    latent: bool = False
    needs: tuple[tuple[str, ...], ...] = ()
    message_type: MessageType | None = None
    notes: Notes | None = None
    further_topics: FurtherTopics | None = None
    frames: Frames | None = None
    asks: Asks | None = None

    def __post_init__(self) -> None:
        for kind in ("inputs", "outputs", "state", "dynamic_inputs", "dynamic_outputs"):
            for name, attribute in getattr(self, kind).items():
                if attribute.role not in get_args(Role):
                    roles = ", ".join(filter(None, get_args(Role)))
                    raise ValueError(f"{self.id}: {kind} {name}: role {attribute.role!r} is not one of {roles}")
                try:
                    _ = attribute.parsed, attribute.default is UNSET or attribute.initial
                except ValueError as error:
                    raise ValueError(f"{self.id} ({self.origin}): {kind} {name}: {error}") from None
        for name in (name for group in self.needs for name in group if name not in self.inputs):
            raise ValueError(f'{self.id} ({self.origin}): needs: there is no input "{name}"')

    def __repr__(self) -> str:
        return f"<node type {self.id}>"

    @property
    def short_name(self) -> str:
        """The last part of the id."""
        return self.id.rpartition(".")[2]

    @property
    def shipped(self) -> bool:
        """Whether it comes from the package `nodes`, or from a wing."""
        return self.origin.startswith(("nodes.", "nodes:", "wings."))

    @cached_property
    def has_execution(self) -> bool:
        """Whether it has execution attributes, in which case it is never computed on demand."""
        declared = (self.inputs, self.outputs, self.dynamic_inputs, self.dynamic_outputs)
        return any(attribute.is_execution for attributes in declared for attribute in attributes.values())

    @cached_property
    def always_dirty(self) -> bool:
        """Whether a dirty_push graph computes it in every evaluation."""
        return self.volatile or self.has_execution or self.memory is not None or bool(self.state)

    def find(self, prefix: str, name: str) -> Attribute | None:
        """The declared or dynamic attribute `prefix:name` (prefix inputs, outputs or state), or None."""
        declared: Mapping[str, Attribute] = getattr(self, prefix)
        if name in declared:
            return declared[name]
        for pattern, attribute in self._patterns.get(prefix, ()):
            if pattern.fullmatch(name):
                return attribute
        return None

    def dynamic_patterns(self, prefix: str) -> list[str]:
        """Regular expressions of the names that a file may add to the inputs or outputs."""
        return [pattern.pattern for pattern, _ in self._patterns.get(prefix, ())]

    @cached_property
    def _roles(self) -> Mapping[tuple[str, str], tuple[str, ...]]:
        found: dict[tuple[str, str], tuple[str, ...]] = {}
        for side, group in (("inputs", self.inputs), ("outputs", self.outputs)):
            for name, attribute in group.items():
                found[side, attribute.role] = (*found.get((side, attribute.role), ()), name)
        return found

    def inputs_as(self, role: Role) -> tuple[str, ...]:
        """The names of the inputs with this role, in the order of the declaration."""
        return self._roles.get(("inputs", role), ())

    def outputs_as(self, role: Role) -> tuple[str, ...]:
        """The names of the outputs with this role, in the order of the declaration."""
        return self._roles.get(("outputs", role), ())

    @cached_property
    def names(self) -> frozenset[str]:
        """The full names of all declared attributes: `inputs:a`, `outputs:b`, `state:c`."""
        groups = (("inputs", self.inputs), ("outputs", self.outputs), ("state", self.state))
        return frozenset(f"{prefix}:{name}" for prefix, group in groups for name in group)

    @cached_property
    def _patterns(self) -> dict[str, list[tuple[re.Pattern[str], Attribute]]]:
        templates = {"inputs": self.dynamic_inputs, "outputs": self.dynamic_outputs}
        return {
            prefix: [(_template_pattern(template), attribute) for template, attribute in attributes.items()]
            for prefix, attributes in templates.items()
        }


def _template_pattern(template: str) -> re.Pattern[str]:
    parts = re.split(r"(\{n\}|\{x\}|\{operand\}|\{field\})", template)
    meaning = {
        "{n}": r"(?:0|[1-9]\d*)",
        "{x}": r"\w+",
        "{operand}": r"(?:[a-z]{1,2}|[A-Za-z_]+\d+)",
        "{field}": r"\w+(?::\w+)*",
    }
    return re.compile("".join(meaning.get(part) or re.escape(part) for part in parts), re.ASCII)
