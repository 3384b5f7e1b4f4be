"""`NodeType`: a node type of the library."""

from __future__ import annotations

from graph.isaac.outcomes import inert

COMPOUND = "omni.graph.nodes.CompoundSubgraph"


class NodeType:
    """A node type of the library."""

    def __init__(self, name: str) -> None:
        self.id = name

    def get_node_type(self) -> str:
        return self.id

    def is_valid(self) -> bool:
        from graph.node.registry import DEFAULT

        return self.id in DEFAULT

    def __bool__(self) -> bool:
        return self.is_valid()

    def __eq__(self, other: object) -> bool:
        return isinstance(other, NodeType) and other.id == self.id

    def __hash__(self) -> int:
        return hash(self.id)

    def get_all_metadata(self) -> dict[str, str]:
        from graph.node.registry import DEFAULT

        return {"__description": DEFAULT.get(self.id).doc} if self.is_valid() else {}

    def get_metadata(self, key: str) -> str | None:
        return self.get_all_metadata().get(key)

    @inert("omni.graph.core")
    def get_all_categories(self) -> list[str]:
        return []

    def has_state(self) -> bool:
        from graph.node.registry import DEFAULT

        return self.is_valid() and bool(DEFAULT.get(self.id).state)

    def is_compound_node_type(self) -> bool:
        return self.id == COMPOUND
