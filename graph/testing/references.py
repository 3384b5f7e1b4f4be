"""Checks names in tests against the declarations of the graphs, before anything runs."""

from __future__ import annotations

from collections.abc import Sequence

from graph.base.suggest import did_you_mean
from graph.node.declaration import Attribute, NodeType
from graph.node.registry import DEFAULT, Registry
from graph.spec.file_spec import GraphSpec

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
