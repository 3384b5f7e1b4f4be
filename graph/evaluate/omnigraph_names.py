"""OmniGraph's names for what scripts call on nodes and graphs, as aliases of ours."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .graph import Graph
    from .node import Node


class AttributeOf:
    """An attribute of one node. It stays valid when edits change the node."""

    __slots__ = ("full_name", "node")

    def __init__(self, node: Node, full_name: str) -> None:
        self.node = node
        self.full_name = full_name

    def __repr__(self) -> str:
        return f"<attribute {self.path}>"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, AttributeOf) and (self.node, self.full_name) == (other.node, other.full_name)

    def __hash__(self) -> int:
        return hash((self.node, self.full_name))

    @property
    def path(self) -> str:
        """`/Graph/node.inputs:x`."""
        return f"{self.node.path}.{self.full_name}"

    def get(self) -> Any:
        """The present value."""
        return self.node.get(self.full_name)

    def set(self, value: Any) -> None:
        """Sets the value. Raises ValueError if it does not fit the type or if a connection would overwrite it."""
        self.node.set(self.full_name, value)

    def get_name(self) -> str:
        """`inputs:x`."""
        return self.full_name

    def get_path(self) -> str:
        """`/Graph/node.inputs:x`."""
        return self.path

    def get_node(self) -> Node:
        """The node it belongs to."""
        return self.node

    def get_type_name(self) -> str:
        """The OGN type name: the resolved one of an open attribute, else the declared one."""
        settled = self.node.types.get(self.full_name)
        if settled is not None or self.full_name not in self.node.types:
            return str(settled or "any")
        return str(self.node.attribute(self.full_name).parsed)

    def get_port_type(self) -> str:
        """inputs, outputs or state."""
        return self.full_name.partition(":")[0]

    def is_connected(self) -> bool:
        """Whether a connection leads to it or from it."""
        return self.full_name in self.node.fed_names or self.full_name in self.node.consumed_names


class Variable:
    """A variable of a graph."""

    def __init__(self, graph: Graph, name: str) -> None:
        self.graph = graph
        self.name = name

    def __repr__(self) -> str:
        return f"<variable {self.name} of {self.graph.path}>"

    def get_name(self) -> str:
        """Its name."""
        return self.name

    def get(self, instance_path: str | None = None) -> Any:
        """The present value in the graph, or in the instance on a prim."""
        return self._of(instance_path).variables[self.name]

    def set(self, value: Any, instance_path: str | None = None) -> None:
        """Sets the value. Raises ValueError if it does not fit the type."""
        self._of(instance_path).variables[self.name] = value

    def get_type_name(self) -> str:
        """The OGN type name."""
        return self.graph.variables.types[self.name].name

    def _of(self, prim: str | None) -> Graph:
        return self.graph if prim is None else self.graph.instance(prim)


class FamiliarNode:
    """The methods that scripts call on a node."""

    __slots__ = ()

    def get_attribute(self: Any, name: str) -> AttributeOf:
        """The attribute of that name, `x` or `inputs:x`. Raises KeyError with the nearest one.

        A dynamic attribute, such as a field of a message, is created by its first connection or value.
        """
        try:
            return AttributeOf(self, self.full_name(name))
        except KeyError:
            prefix, _, short = name.partition(":")
            if prefix not in ("inputs", "outputs", "state") or self.type.find(prefix, short) is None:
                raise
            return AttributeOf(self, name)

    def get_attributes(self: Any) -> list[AttributeOf]:
        """All attributes, inputs first."""
        return [AttributeOf(self, full) for full, _ in self.attributes()]

    def get_attribute_exists(self: Any, name: str) -> bool:
        """Whether an attribute of that name exists."""
        try:
            self.full_name(name)
        except KeyError:
            return False
        return True

    def get_prim_path(self: Any) -> str:
        """The node's path."""
        return str(self.path)

    def get_type_name(self: Any) -> str:
        """The type id."""
        return str(self.type.id)

    def get_graph(self: Any) -> Graph:
        """The graph it belongs to."""
        graph: Graph = self.graph
        return graph

    def get_compute_count(self: Any) -> int:
        """How often it has computed."""
        return int(self.computes)

    def request_compute(self: Any) -> None:
        """Makes it compute once in the next evaluation of its graph, however often this is called."""
        self.graph.request(self)


class FamiliarGraph:
    """The methods that scripts call on a graph."""

    def get_nodes(self: Any) -> list[Node]:
        """All nodes, in order."""
        return list(self.nodes.values())

    def get_node(self: Any, name: str) -> Node:
        """The node of that name or path. Raises KeyError with the nearest one."""
        node: Node = self.node(name)
        return node

    def get_path_to_graph(self: Any) -> str:
        """The graph's path."""
        return str(self.path)

    def get_pipeline_stage(self: Any) -> str:
        """The pipeline stage in which it is evaluated."""
        return str(self.pipeline_stage)

    def get_evaluator_name(self: Any) -> str:
        """execution, push or dirty_push."""
        return str(self.evaluator)

    def get_variables(self: Any) -> list[Variable]:
        """Its variables, in order."""
        return [Variable(self, name) for name in self.variables]

    def find_variable(self: Any, name: str) -> Variable | None:
        """The variable of that name, or None."""
        return Variable(self, name) if name in self.variables else None
