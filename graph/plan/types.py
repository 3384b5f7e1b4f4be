"""Resolves open types (any, unions) along connections, and checks that connected types match."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from graph.node.known_types import KnownTypes
from graph.values.coercion import coerce
from graph.values.conversion import convertible, settle, way_between
from graph.values.types import AnyType, Extended, Type, concrete_type
from graph.values.untyped import coerced, natural_type, typed_value

from .connections import Link, by_attribute
from .draft import BACKWARDS, Draft, Report


class _WrongValueError(Exception):
    """`resolve` asks for a written value that the input does not accept."""


class Known(KnownTypes):
    """What is known of a draft's types while the graph is compiled."""

    def __init__(self, draft: Draft) -> None:
        self._draft = draft

    def __getitem__(self, name: str) -> Type | None:
        types = self._draft.types
        for full in (name, f"inputs:{name}", f"outputs:{name}", f"state:{name}"):
            if full in types:
                return types[full]
        raise KeyError(name)

    def __iter__(self) -> Iterator[str]:
        return iter(self._draft.types)

    def __len__(self) -> int:
        return len(self._draft.types)

    def value(self, name: str) -> Any:
        """The initial value of an unconnected input: as written, else its default.

        A value that is not allowed ends the resolving; it is reported with its own mark when the values are read.
        """
        full = f"inputs:{name}"
        attribute, type_ = self._draft.attribute(full), self._draft.types[full]
        if full not in self._draft.authored:
            return attribute.initial
        raw = self._draft.authored[full]
        if type_ is None:
            return raw
        try:
            value = coerced(type_, raw)
        except ValueError as error:
            raise _WrongValueError from error
        if attribute.check(value):
            raise _WrongValueError
        return value

    def end(self, name: str) -> str:
        """An input as messages name it: with its type and, if it is connected, its source."""
        type_ = self[f"inputs:{name}"]
        link = self._draft.fed.get(f"inputs:{name}")
        source = f", from {link.source.node.name}.{link.source_name}" if link else ""
        return f"input {name} ({type_}{source})"

    def variable(self, name: str) -> Type | None:
        """The type of a graph variable; None for an unknown name."""
        return self._draft.node.graph.variables.types.get(name)

    @property
    def variables(self) -> Mapping[str, Type]:
        """The types of the graph's variables by name."""
        return self._draft.node.graph.variables.types

    @property
    def unfinished(self) -> bool:
        """Whether the graph is being edited and may still contain what a run would refuse, as in the original."""
        return self._draft.node.graph.compiled_spec.unfinished


class _Settling:
    """Resolves the open types of some nodes along some links."""

    def __init__(self, drafts: Sequence[Draft], links: Sequence[Link], report: Report) -> None:
        self._open = [draft for draft in drafts if draft.open]
        self._links = links if self._open else ()
        self._at = by_attribute(self._links)
        self._report = report
        self._stage = -1
        """Forwards along connections; later the index of the node whose values are read; then BACKWARDS."""
        self._refused: set[Draft] = set()
        self._answered: set[Draft] = set()
        """Nodes that know no more than when they were asked, and then had no answer or answered everything."""
        self._pending: deque[tuple[Draft, str]] = deque()

    def run(self) -> None:
        """Forwards along connections, then from written values, then backwards from typed readers."""
        for draft in self._open:
            self._take_explicit(draft)
            self._ask(draft)
        for link in self._links:
            self._forward(link)
        self._spread()
        for draft in self._open:
            self._stage = draft.node.index
            for full in draft.open:
                if draft.types[full] is None and full in draft.authored and full not in draft.fed:
                    self._take_natural(draft, full)
                    self._spread()
        self._stage = BACKWARDS
        for link in self._links:
            self._backward(link)
            self._spread()

    def _take_explicit(self, draft: Draft) -> None:
        for full in draft.open:
            if full in draft.authored and full not in draft.fed:
                try:
                    explicit = typed_value(draft.authored[full])
                except ValueError:
                    continue  # reported with the value's own mark when the values are read
                declared = draft.attribute(full).parsed
                if explicit is not None and isinstance(declared, Extended):
                    chosen = explicit[0] if declared.accepts(explicit[0]) else settle(explicit[0], declared)
                    if chosen is not None:
                        self._set(draft, full, chosen)

    def _take_natural(self, draft: Draft, full: str) -> None:
        value, declared = draft.authored[full], draft.attribute(full).parsed
        assert isinstance(declared, Extended)
        siblings = [type_ for name in draft.open if (type_ := draft.types[name]) and name.startswith("inputs:")]
        for candidate in (*siblings, *natural_type(value), *declared.members):
            if declared.accepts(candidate) and _fits(candidate, value):
                self._set(draft, full, candidate)
                return

    def _set(self, draft: Draft, full: str, type_: Type, *causes: int) -> None:
        draft.types[full] = type_
        self._answered.discard(draft)
        stage = max(self._stage, *causes) if causes else self._stage
        if stage >= 0:
            draft.late[full] = stage
        self._pending.append((draft, full))

    def _spread(self) -> None:
        while self._pending:
            draft, full = self._pending.popleft()
            for link in self._at.get((draft, full), ()):
                self._forward(link)
            self._ask(draft)

    def _ask(self, draft: Draft) -> None:
        if draft.type.resolve is None or draft in self._answered or draft in self._refused:
            return
        try:
            answer = draft.type.resolve(Known(draft))
        except _WrongValueError:
            self._refused.add(draft)
            return
        except ValueError as error:
            self._refused.add(draft)
            self._report(f"{draft.label} ({draft.type.short_name}): {error}", draft.spec.mark)
            return
        news = False
        for name, type_ in (answer or {}).items():
            if type_ is None:
                continue
            full = next((f for f in (name, f"outputs:{name}", f"inputs:{name}") if f in draft.open), None)
            if full is not None and draft.types[full] is None:
                self._set(draft, full, concrete_type(type_) if isinstance(type_, str) else type_, *draft.late.values())
                news = True
        if not news or None not in [draft.types[full] for full in draft.open]:
            self._answered.add(draft)

    def _forward(self, link: Link) -> None:
        known = link.source.types[link.source_name]
        declared = _open_type(link.target, link.target_name)
        if known is not None and declared is not None:
            chosen = settle(known, declared)
            if chosen is not None:
                self._set(link.target, link.target_name, chosen, link.source.late.get(link.source_name, -1))

    def _backward(self, link: Link) -> None:
        known = link.target.types[link.target_name]
        declared = _open_type(link.source, link.source_name)
        if known is not None and declared is not None:
            chosen = settle(known, declared)
            if chosen is not None and convertible(chosen, known):
                self._set(link.source, link.source_name, chosen)


def settle_types(drafts: Sequence[Draft], links: Sequence[Link], report: Report) -> None:
    """Resolves every open type that can be resolved; reports connections whose types do not match.

    An open output that nothing resolves stays open: its values pass unchanged. A required open input that is neither
    connected nor set is reported.
    """
    _Settling(drafts, links, report).run()
    unknowable: set[Draft] | None = None
    for link in links:
        source, target = link.source.types[link.source_name], link.target.types[link.target_name]
        if source is not None and target is not None:
            meet = convertible(source, target)
        else:
            meet = source is None and (target is None or not _closed_to(link, target))
        if not meet and not link.execution:
            if source is None:
                unknowable = _behind_cycles(links) if unknowable is None else unknowable
                if link.source in unknowable:
                    continue  # the cycle is reported instead
            ends = link.ends_with_types()
            report(f"{ends[0]} cannot feed {ends[1]}{way_between(source, _asked_of(link))}", link.mark)
    for draft in drafts:
        for full in draft.open:
            attribute = draft.attribute(full)
            given = full in draft.fed or full in draft.authored or full in draft.refused
            if draft.types[full] is None and not given and full.startswith("inputs:") and not attribute.optional:
                name = full.removeprefix("inputs:")
                unit = f" [{attribute.unit}]" if attribute.unit else ""
                message = f"input {name}{unit} is not set. Give it a value or connect it."
                if draft.node.graph.compiled_spec.unfinished:
                    draft.unset = message
                else:
                    report(f"{draft.label}: {message}", draft.spec.mark)


def _behind_cycles(links: Sequence[Link]) -> set[Draft]:
    """The nodes that lie on a data cycle, or get their types from one."""
    waits: dict[Draft, int] = {}
    readers: dict[Draft, list[Draft]] = {}
    for link in links:
        if not link.execution and not link.source_name.startswith("inputs:"):
            waits[link.target] = waits.get(link.target, 0) + 1
            readers.setdefault(link.source, []).append(link.target)
    ready = [draft for draft in readers if draft not in waits]
    while ready:
        for reader in readers.get(ready.pop(), ()):
            waits[reader] -= 1
            if not waits[reader]:
                del waits[reader]
                ready.append(reader)
    return set(waits)


def _asked_of(link: Link) -> AnyType:
    """The type that the target has, or those that it accepts."""
    return link.target.types[link.target_name] or link.target.attribute(link.target_name).parsed


def _closed_to(link: Link, target: Type) -> bool:
    """Whether no type of the open source could feed the target."""
    declared = link.source.attribute(link.source_name).parsed
    return isinstance(declared, Extended) and settle(target, declared) is None


def _open_type(draft: Draft, full: str) -> Extended | None:
    """The declared type of an attribute that is open and not resolved yet."""
    declared: AnyType | None = draft.attribute(full).parsed if draft.types[full] is None else None
    return declared if isinstance(declared, Extended) else None


def _fits(candidate: Type, value: Any) -> bool:
    try:
        coerce(candidate, value)
    except ValueError:
        return False
    return True
