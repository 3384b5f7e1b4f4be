"""Ports of compounds: a connection to a port is a connection to the inner attribute."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from .properties import RawAttribute
from .raw_graph import RawNode


class Ports:
    """The promoted attributes of every compound, by path."""

    def __init__(self, compounds: Sequence[RawNode], nodes: Iterable[RawNode]) -> None:
        self._ports = {f"{node.path}.{one.name}": one for node in compounds for one in node.attributes}
        self._readers: dict[str, list[str]] = {}
        for node in (*compounds, *nodes) if compounds else ():
            for attribute in node.attributes:
                for source in sources_of(attribute):
                    if source in self._ports:
                        self._readers.setdefault(source, []).append(f"{node.path}.{attribute.name}")
        self._origins: dict[str, tuple[str, ...]] = {}

    def __bool__(self) -> bool:
        return bool(self._ports)

    def __contains__(self, path: str) -> bool:
        return path in self._ports

    def behind(self, path: str) -> tuple[str, ...]:
        """The attributes of real nodes that feed `path`: itself if it is not a port, empty if nothing feeds it."""
        if path not in self._ports:
            return (path,)
        if path not in self._origins:
            self._origins[path] = ()  # ports that feed each other in a cycle have no source
            found = (origin for source in sources_of(self._ports[path]) for origin in self.behind(source))
            self._origins[path] = tuple(dict.fromkeys(found))
        return self._origins[path]

    def inside(self, path: str) -> list[str]:
        """The attributes of real nodes that a port feeds, through the ports of inner compounds."""
        found: dict[str, None] = {}
        pending, seen = [path], {path}
        while pending:
            for reader in self._readers.get(pending.pop(0), ()):
                if reader not in self._ports:
                    found[reader] = None
                elif reader not in seen:
                    seen.add(reader)
                    pending.append(reader)
        return list(found)

    def value(self, path: str) -> RawAttribute | None:
        """The port whose value `path` passes on, or None."""
        seen: set[str] = set()
        while path in self._ports and path not in seen:
            seen.add(path)
            port = self._ports[path]
            inner = sources_of(port)
            if not inner:
                return None if port.value is None else port
            path = inner[0]
        return None


def sources_of(attribute: RawAttribute) -> tuple[str, ...]:
    """The sources of an attribute, including targets of a relationship that are attributes of nodes."""
    if not attribute.is_relationship:
        return attribute.sources
    return tuple(source for target in attribute.value if (source := as_source(target)))


def targets_of(attribute: RawAttribute) -> list[Any]:
    """The targets of a relationship that are prims."""
    return [target for target in attribute.value if not as_source(target)]


def as_source(target: str) -> str | None:
    """The output that a relationship's target means: `/G/n.outputs:x`, or the bundle prim `/G/n/outputs_x`."""
    if "." in target:
        return target
    node, _, name = target.rpartition("/")
    return f"{node}.outputs:{name.removeprefix('outputs_')}" if name.startswith("outputs_") and node else None
