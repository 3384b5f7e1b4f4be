"""What all handles of OmniGraph are: a path in a set of graphs, looked up at each call."""

from __future__ import annotations

from graph.editing.graph_set import GraphSet
from graph.isaac.og import Controller


class Handle:
    """What a path names in a set of graphs."""

    def __init__(self, graphs: GraphSet, path: str) -> None:
        self._graphs, self.path = graphs, path

    def __eq__(self, other: object) -> bool:
        return type(other) is type(self) and (self._graphs, self.path) == (other._graphs, other.path)

    def __hash__(self) -> int:
        return hash((type(self).__name__, self.path))

    def __bool__(self) -> bool:
        return self.is_valid()

    def __repr__(self) -> str:
        return f"<omni.graph.core.{type(self).__name__} {self.path}>"

    def is_valid(self) -> bool:
        """Whether what it names exists."""
        raise NotImplementedError

    def get_handle(self) -> int:
        """A number of its own."""
        return abs(hash(self))

    @property
    def _edit(self) -> Controller:
        return Controller(graphs=self._graphs)
