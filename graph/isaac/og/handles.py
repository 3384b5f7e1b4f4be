"""Compounds as an edit returns them, beside nodes."""

from __future__ import annotations

from typing import Any

from graph.base.suggest import did_you_mean
from graph.editing.errors import OmniGraphError
from graph.editing.model import PREFIXES
from graph.evaluate import Graph, Node
from graph.evaluate.omnigraph_names import AttributeOf


class Compound:
    """A compound of a graph: its ports stand for attributes of the inner nodes."""

    def __init__(self, graph: Graph, name: str) -> None:
        self.graph = graph
        self.name = name
        self.path = f"{graph.path}/{name}"

    def __repr__(self) -> str:
        return f"<compound {self.path}>"

    @property
    def ports(self) -> dict[str, tuple[str, ...]]:
        """Its ports, `inputs:x`, with the inner attributes that each stands for."""
        return dict(self.graph.spec.compounds.get(self.name, {}))

    @property
    def nodes(self) -> list[Node]:
        """The inner nodes."""
        return [node for name, node in self.graph.nodes.items() if name.startswith(f"{self.name}/")]

    def get_attribute(self, name: str) -> AttributeOf:
        """The inner attribute that a port stands for, the first of several.

        Raises OmniGraphError for an unknown port.
        """
        ports = self.ports
        for full in (name, *(f"{prefix}:{name}" for prefix in PREFIXES)):
            if full in ports:
                owner, _, attribute = ports[full][0].rpartition(".")
                return AttributeOf(self.graph.nodes[owner], attribute)
        raise OmniGraphError(f'the compound {self.path} has no port "{name}"{did_you_mean(name, ports)}')

    def get(self, name: str) -> Any:
        """The present value at a port."""
        return self.get_attribute(name).get()

    def get_prim_path(self) -> str:
        """The compound's path."""
        return self.path
