"""Nodes while they are being compiled: what the file says, checked against what the node type declares."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from graph.base.errors import Mark
from graph.base.records import dataclass, field
from graph.base.suggest import one_of
from graph.evaluate.graph import Graph
from graph.evaluate.instances import with_target
from graph.evaluate.node import PREFIXES, Layout, Node
from graph.node.declaration import Attribute, NodeType
from graph.spec.file_spec import NodeSpec
from graph.values.coercion import coerce, shown, zero
from graph.values.conversion import way_between
from graph.values.types import Extended, Type
from graph.values.untyped import natural_type, typed_value

BACKWARDS = 2**63
"""In place of an index: the type follows from a reader."""
Report = Callable[[str, "Mark | None"], None]
"""Takes a message and a mark."""


@dataclass(eq=False, slots=True)
class Draft:
    """A node that is being compiled. Attributes are named in full, `inputs:x`."""

    node: Node
    type: NodeType
    """The node's type."""
    spec: NodeSpec
    types: dict[str, Type | None]
    """Resolved type of every attribute."""
    open: tuple[str, ...]
    """Attributes whose declared type is open."""
    dynamic: dict[str, Attribute] = field(default_factory=dict)
    authored: dict[str, Any] = field(default_factory=dict)
    """Values as written."""
    fed: dict[str, Any] = field(default_factory=dict)
    """The link that ends at each connected data attribute."""
    refused: set[str] = field(default_factory=set)
    """Attributes at which a connection that was reported should have ended."""
    consumed: set[str] = field(default_factory=set)
    late: dict[str, int] = field(default_factory=dict)
    """Open attributes whose type follows from a written value: the index of the node that has it; or BACKWARDS."""
    kept: Node | None = None
    """The node of an earlier compilation whose types and initial values it takes over."""
    unset: str = ""
    """Why the node of an unfinished graph cannot compute."""

    @property
    def label(self) -> str:
        """How messages name the node."""
        return f'node "{self.node.name}"'

    def attribute(self, full: str) -> Attribute:
        """The declaration of an attribute that exists."""
        if full in self.dynamic:
            return self.dynamic[full]
        prefix, _, name = full.partition(":")
        declared: Attribute = getattr(self.type, prefix)[name]
        return declared

    def find(self, prefix: str, name: str, *, add: bool = True) -> str | None:
        """The full name of an attribute; with `add`, a dynamic one is created.

        None if the type has no such attribute.
        """
        full = f"{prefix}:{name}"
        if name in getattr(self.type, prefix) or full in self.dynamic:
            return full
        attribute = self.type.find(prefix, name) if add else None
        if attribute is not None:
            self.add(full, attribute)
            return full
        return None

    def add(self, full: str, attribute: Attribute) -> None:
        """Adds an attribute that the type does not declare."""
        self.dynamic[full] = attribute
        parsed = attribute.parsed
        self.types = {**self.types, full: parsed if isinstance(parsed, Type) else None}
        if isinstance(parsed, Extended):
            self.open += (full,)

    def mark_of(self, key: str) -> Mark | None:
        """The place of an authored value, else that of the node."""
        return self.spec.input_marks.get(key, self.spec.mark)


@dataclass(slots=True)
class Shape:
    """What all nodes of one type share: attribute names, types, initial values and storage."""

    names: Mapping[str, tuple[str, ...]]
    types: dict[str, Type | None]
    open: tuple[str, ...]
    initial: Mapping[str, Any]
    layout: Layout
    deprecates: bool
    """Whether any attribute is deprecated."""

    @classmethod
    def of(cls, node_type: NodeType) -> Shape:
        """The shape that follows from the declarations."""
        attributes = {
            f"{prefix}:{name}": attribute
            for prefix in PREFIXES
            for name, attribute in getattr(node_type, prefix).items()
        }
        types = {full: one.parsed if isinstance(one.parsed, Type) else None for full, one in attributes.items()}
        names = {prefix: tuple(getattr(node_type, prefix)) for prefix in PREFIXES}
        initial = {full: one.initial for full, one in attributes.items() if not one.is_execution}
        return cls(
            names,
            types,
            tuple(full for full, one in attributes.items() if isinstance(one.parsed, Extended)),
            initial,
            Layout.of(node_type.short_name, names, initial),
            any(one.deprecated for one in attributes.values()),
        )


def draft_node(graph: Graph, spec: NodeSpec, node_type: NodeType, shape: Shape, index: int, report: Report) -> Draft:
    """Starts a node with the values that the file gives; reports names that the type does not have."""
    # Only open types are ever written to: nodes without open types share the dict.
    types = dict(shape.types) if shape.open else shape.types
    draft = Draft(Node(graph, spec.name, node_type, index, spec.mark), node_type, spec, types, shape.open)
    for added, type_name in spec.attributes.items():
        _add_attribute(draft, added, type_name, report)
    for key, value in spec.inputs.items():
        prefix, _, name = key.partition(":")
        if prefix == "outputs":
            report(f"{draft.label}: {key} is an output; only inputs and state can be set", draft.mark_of(key))
            continue
        prefixes = (prefix,) if prefix in ("inputs", "state") else ("inputs", "state")
        name = name if prefix in ("inputs", "state") else key
        # A declared state attribute is preferred over a dynamic input of any name.
        full = next((f for p in prefixes if (f := draft.find(p, name, add=False))), None)
        full = full or next((f for p in prefixes if (f := draft.find(p, name))), None)
        if full is None:
            report(f"{draft.label} {no_attribute(draft, 'input', name)}", draft.mark_of(key))
        elif full in draft.authored:
            report(f"{draft.label}: {full} is set twice; keep one", draft.mark_of(key))
        else:
            draft.authored[full] = with_target(value, graph.target)
    return draft


def _add_attribute(draft: Draft, full: str, type_name: str, report: Report) -> None:
    """Creates an attribute that the file adds. An attribute that the type declares keeps its declaration."""
    prefix, _, name = full.partition(":")
    if prefix not in PREFIXES or not name:
        report(
            f'{draft.label}: "{full}" is not an attribute; write inputs:, outputs: or state: before the name',
            draft.spec.mark,
        )
        return
    if draft.find(prefix, name, add=False) is not None:
        return
    attribute = draft.type.find(prefix, name)
    doc = attribute.doc if attribute else "added by the file"
    try:
        added = Attribute(type_name, doc)
        _ = added.parsed
    except ValueError as error:
        report(f"{draft.label}: {full}: {error}", draft.spec.mark)
        return
    draft.add(full, added)


def no_attribute(draft: Draft, kind: str, name: str) -> str:
    """The end of a message about an attribute that the type does not have; kind: input or output."""
    prefixes = ("outputs", "inputs", "state") if kind == "output" else ("inputs", "state")
    known = [one for prefix in prefixes for one in getattr(draft.type, prefix)]
    other = "inputs" if kind == "output" else "outputs"
    hint = one_of(name, known)
    if name in getattr(draft.type, other):
        hint = f"; it is an {other[:-1]}"
    return f'({draft.type.short_name}) has no {kind} "{name}"{hint}'


def initial_values(draft: Draft, shape: Shape, report: Report) -> Mapping[str, Any]:
    """The initial value of each data attribute; reports written values that do not fit the resolved type."""
    if not draft.authored and not draft.dynamic and not draft.open:
        return shape.initial
    initial = dict(shape.initial)
    for full, attribute in draft.dynamic.items():
        if not attribute.is_execution:
            initial[full] = attribute.initial
    for full in draft.open:
        settled = draft.types[full]
        initial[full] = None if settled is None else zero(settled)
    for full, raw in draft.authored.items():
        attribute, type_ = draft.attribute(full), draft.types[full]
        key = full if full in draft.spec.inputs else full.partition(":")[2]
        mark = draft.mark_of(key)
        name = full.removeprefix("inputs:")
        if full in draft.fed and not attribute.is_execution:
            continue
        try:
            explicit = typed_value(raw)
            if type_ is None:
                report(f"{draft.label}: {name}: {_untypable(attribute, raw, explicit)}", mark)
                continue
            value = coerce(type_, raw if explicit is None else explicit[1])
        except ValueError as error:
            report(f"{draft.label}: {name}: {error}", mark)
            continue
        wrong = attribute.check(value)
        if wrong:
            report(f"{draft.label}: {name}: {wrong}", mark)
        initial[full] = value
    return initial


def _untypable(attribute: Attribute, raw: Any, explicit: tuple[Type, Any] | None) -> str:
    """Why a value does not determine the type of an open attribute."""
    value, declared = explicit[1] if explicit else raw, attribute.parsed
    given = explicit[0] if explicit else next(iter(natural_type(raw)), None)
    if given is None or not isinstance(declared, Extended) or declared.accepts(given):
        return f"cannot tell the type of {shown(raw)}; write {{type: ..., value: ...}}"
    return f"{shown(value)} ({given}) is not one of its types ({declared}){way_between(given, declared)}"


def all_names(draft: Draft, shape: Shape) -> Mapping[str, tuple[str, ...]]:
    """Attribute names by prefix; dynamic ones last, in the order they were added."""
    if not draft.dynamic:
        return shape.names
    names = {prefix: list(shape.names[prefix]) for prefix in PREFIXES}
    for full in draft.dynamic:
        prefix, _, name = full.partition(":")
        names[prefix].append(name)
    return {prefix: tuple(listed) for prefix, listed in names.items()}
