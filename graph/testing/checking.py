"""Checks the parts of a case that need no run: the node type, and every name in it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path

from graph.base.errors import Problem, UserError
from graph.base.suggest import did_you_mean
from graph.files import examine
from graph.node.declaration import Attribute, NodeType
from graph.node.registry import DEFAULT, Registry
from graph.spec.file_spec import GraphSpec

from .cases import Case
from .messages import named
from .updates import read_range

PREFIXES = ("inputs", "outputs", "state")


class UnsettledError(Exception):
    """The node exists but its type is unknown, so its attributes cannot be checked."""


class GraphNames:
    """The nodes and attributes of the graphs of a file."""

    def __init__(self, graphs: Sequence[GraphSpec], registry: Registry = DEFAULT) -> None:
        self._registry = registry
        self._named: dict[str, list[str]] = {}
        self._types: dict[str, str] = {}
        for graph in graphs:
            for node in graph.nodes:
                path = f"{graph.path}/{node.name}"
                self._named.setdefault(node.name, []).append(path)
                self._types[path] = node.type

    def node(self, reference: str) -> str:
        """The path of the node with that name or path. Raises KeyError with the nearest name."""
        if reference in self._types:
            return reference
        found = self._named.get(reference, [])
        if len(found) == 1:
            return found[0]
        if found:
            raise KeyError(f'"{reference}" stands in several graphs; write {" or ".join(found)}')
        known = self._types if "/" in reference else self._named
        raise KeyError(f'there is no node "{reference}"{did_you_mean(reference, known)}')

    def attribute(self, reference: str, prefix: str) -> tuple[str, Attribute]:
        """Full name (`inputs:x`) and declaration of `node.attr`; `prefix` is searched first.

        Raises KeyError with the nearest name, UnsettledError if the node's type is unknown.
        """
        name, dot, short = reference.rpartition(".")
        if not dot:
            raise KeyError(f'"{reference}" names no attribute; write node.attribute')
        type_id = self._types[self.node(name)]
        if type_id not in self._registry:
            raise UnsettledError(type_id)
        return declared(self._registry.get(type_id), short, prefix)


class NodeNames:
    """The attributes of one node type."""

    def __init__(self, node_type: NodeType) -> None:
        self._type = node_type

    def node(self, reference: str) -> str:
        """The node is always named `node`. Raises KeyError for any other name."""
        if reference != "node":
            raise KeyError(f'there is no node "{reference}"; the node under test is called "node"')
        return reference

    def attribute(self, reference: str, prefix: str) -> tuple[str, Attribute]:
        """Full name and declaration of an attribute; `prefix` is searched first.

        Raises KeyError with the nearest name.
        """
        return declared(self._type, reference, prefix)


def declared(node_type: NodeType, name: str, prefix: str) -> tuple[str, Attribute]:
    """Full name and declaration of a type's attribute `x` or `inputs:x`. Raises KeyError with the nearest name."""
    written, _, short = name.partition(":")
    places = [written] if written in PREFIXES and short else sorted(PREFIXES, key=lambda one: one != prefix)
    bare = short if written in PREFIXES and short else name
    # Declared attributes are preferred over those that a template allows.
    for known in (True, False):
        for place in places:
            if (bare in getattr(node_type, place)) == known and (found := node_type.find(place, bare)) is not None:
                return f"{place}:{bare}", found
    names = [one for place in places for one in getattr(node_type, place)]
    raise KeyError(f'{node_type.id} has no attribute "{name}"{did_you_mean(bare, names)}')


Wrong = Callable[[str, Attribute], str | None]
"""Returns why an attribute (full name) may not be named in some place, or None."""


def check_cases(cases: Iterable[Case], allow: Iterable[str | Path] = (), registry: Registry = DEFAULT) -> list[Problem]:
    """The mistakes in names and updates of cases.

    Mistakes of graph files are left to the run, and so is every case that expects wrong input.
    """
    known: dict[Path, tuple[GraphSpec, ...]] = {}
    folders = [Path(one) for one in allow]
    problems: list[Problem] = []
    for case in cases:
        error = case.setup.expect.error
        if error is not None and error.exit != 1:
            continue
        if case.file is not None and case.file not in known:
            spec = examine(case.file, allow=folders).spec
            known[case.file] = () if spec is None else spec.graphs
        graphs = known[case.file] if case.file is not None else case.spec.graphs
        found = [*_check(case, graphs, registry), *_late(case), *_unplayable(case)]
        problems += [Problem(named(case.name, one.message), one.mark) for one in found]
    return problems


def _check(case: Case, graphs: tuple[GraphSpec, ...], registry: Registry) -> Iterator[Problem]:
    names: GraphNames | NodeNames
    if case.node is not None:
        try:
            names = NodeNames(registry.get(case.node))
        except UserError as error:
            yield Problem(error.problems[0].message, case.at("node"))
            return
    elif not graphs:
        return
    else:
        names = GraphNames(graphs, registry)
    expect = case.setup.expect
    tolerances = case.setup.tolerance if isinstance(case.setup.tolerance, dict) else ()
    written: list[tuple[tuple[str | int, ...], str, str, Wrong]] = [
        *((("inputs", one), one, "inputs", _settable) for one in case.setup.inputs),
        *((("changes", at, one), one, "inputs", _settable) for at, many in case.setup.changes.items() for one in many),
        *((("pulses", one), one, "inputs", _triggerable) for one in case.setup.pulses),
        *((("connect", one), one, "inputs", _data_input) for one in case.setup.connect if case.node is not None),
        *((("expect", "fired", one), one, "outputs", _follows) for one in expect.fired),
        *((("expect", "outputs", one), one, "outputs", _has_value) for one in expect.outputs),
        *((("expect", "values", one), one, "outputs", _has_value) for one in expect.values),
        *((("tolerance", one), one, "outputs", _has_value) for one in tolerances),
    ]
    for location, reference, prefix, wrong in written:
        try:
            message = wrong(*names.attribute(reference, prefix))
            message = message and f'"{reference}" {message}'
        except KeyError as error:
            message = str(error.args[0])
        except UnsettledError:
            continue
        if message:
            yield Problem(f"{'.'.join(map(str, location[:-1]))}: {message}", case.at(*location))
    for reference in expect.computes:
        try:
            names.node(reference)
        except KeyError as error:
            yield Problem(f"expect.computes: {error.args[0]}", case.at("expect", "computes", reference))


def _late(case: Case) -> Iterator[Problem]:
    """Reports pulses and changes after the last update."""
    total = case.setup.updates
    if total is None:
        return
    runs = f"the case runs {total} updates, 0 to {total - 1}; give it more" if total else "the case runs no update"
    for reference, updates in case.setup.pulses.items():
        late = [update for update in updates if update >= total]
        if late:
            yield Problem(
                f"pulses: {reference} is to be triggered in update {late[0]}, but {runs}", case.at("pulses", reference)
            )
    for key in case.setup.changes:
        span = read_range(key, 10**9)
        if span is not None and span[0] >= total:
            yield Problem(f"changes: update {key} never comes: {runs}", case.at("changes", key))


def _unplayable(case: Case) -> list[Problem]:
    """Messages of unknown types and with wrong fields."""
    if case.messages:
        from graph.session.message_sources import written_source

        try:
            written_source(case.messages, case.source.name)
        except UserError as error:
            return [Problem(f"play: {one.message}", one.mark) for one in error.problems]
    if (case.messages or case.play) and case.setup.world is False:
        return [Problem("play: messages come through an App; leave out world: false", case.at("world"))]
    return []


def _settable(full: str, attribute: Attribute) -> str | None:
    if attribute.is_execution:
        return "is an execution attribute; trigger it by pulses"
    return "is an output; only inputs and state can be set" if full.startswith("outputs:") else None


def _triggerable(full: str, attribute: Attribute) -> str | None:
    if full.startswith("inputs:") and attribute.is_execution:
        return None
    return "is not an execution input; set it by inputs"


def _data_input(full: str, attribute: Attribute) -> str | None:
    return None if full.startswith("inputs:") and not attribute.is_execution else "is not a data input"


def _follows(full: str, attribute: Attribute) -> str | None:
    if full.startswith("outputs:") and attribute.is_execution:
        return None
    return "is not an execution output; look at its values"


def _has_value(full: str, attribute: Attribute) -> str | None:
    return "is an execution attribute; look at when it fired" if attribute.is_execution else None
