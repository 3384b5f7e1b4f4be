"""Finds graphs, nodes, attributes, variables and prims by what scripts name them."""

from __future__ import annotations

from typing import Any

from graph.editing.graph_set import GraphSet
from graph.isaac.og import Controller as OurController
from graph.isaac.og import OmniGraphError, find
from graph.isaac.og.controller import OnEither
from graph.isaac.og.names import node_text
from graph.isaac.og.present import present_set
from graph.isaac.session import app_or_none, mirror
from graph.session.runner import graphs_of

from .attributes import Attribute
from .graph_parts import IVariable
from .handles import Graph, Node, node_or_none
from .node_type import NodeType
from .types import UNKNOWN, AttributeType, Type


def present() -> GraphSet:
    """The graphs of the App that scripts act on; without an App, those of this process."""
    if (prims := mirror()) is not None:
        prims.sync()
    app = app_or_none()
    return present_set() if app is None else graphs_of(app)


class ObjectLookup:
    """Finds graphs, nodes, attributes, variables and prims by what scripts name them."""

    @OnEither
    def graph(self: Any, graph_id: Any) -> Any:
        if isinstance(graph_id, (list, tuple)) and not isinstance(graph_id, Graph):
            return [ObjectLookup.graph(one) for one in graph_id]
        path = find.graph_path(graph_id)
        return Graph(present(), path) if present().latest(path) is not None else None

    @OnEither
    def node(self: Any, node_id: Any, graph_id: Any = None) -> Any:
        if isinstance(node_id, list):
            return [ObjectLookup.node(one, graph_id) for one in node_id]
        graphs = present()
        chosen = graph_id if graph_id is not None else getattr(self, "_graph_id", None)
        if isinstance(node_id, str) and not node_id.startswith("/") and chosen is not None:
            node_id = (node_id, find.graph_path(chosen))
        return Node(graphs, find.node(graphs, bare(node_id)).path)

    @OnEither
    def attribute(self: Any, attribute_id: Any, node_id: Any = None, graph_id: Any = None) -> Any:
        if isinstance(attribute_id, list):
            return [ObjectLookup.attribute(one, node_id, graph_id) for one in attribute_id]
        if isinstance(attribute_id, Attribute):
            return attribute_id
        if hasattr(attribute_id, "GetPath"):
            attribute_id = str(attribute_id.GetPath())
        graphs = present()
        found = find.attribute(graphs, bare(attribute_id), bare(node_id), bare(graph_id))
        return Attribute(Node(graphs, found.node.path), found.full_name)

    @OnEither
    def variable(self: Any, variable_id: Any, graph_id: Any = None) -> Any:
        if isinstance(variable_id, IVariable):
            return variable_id
        if isinstance(variable_id, tuple):
            graph_id, variable_id = (
                variable_id if "/" in str(getattr(variable_id[0], "path", variable_id[0])) else variable_id[::-1]
            )
        if ".graph:variable:" in str(variable_id):
            graph_id, variable_id = str(variable_id).split(".graph:variable:")
        found = OurController(graphs=present()).variable(str(variable_id), bare(graph_id))
        return IVariable(Graph(present(), found.graph.path), found.name)

    @OnEither
    def prim(self: Any, prim_id: Any, graph_id: Any = None) -> Any:
        if isinstance(prim_id, list):
            return [ObjectLookup.prim(one, graph_id) for one in prim_id]
        return prim_id if hasattr(prim_id, "GetPath") else OurController(graphs=present()).prim(bare(prim_id))

    @OnEither
    def prim_path(self: Any, prim_ids: Any) -> Any:
        if isinstance(prim_ids, list):
            return [ObjectLookup.prim_path(one) for one in prim_ids]
        return str(prim_ids.GetPath()) if hasattr(prim_ids, "GetPath") else node_text(bare(prim_ids), "prim")

    @OnEither
    def node_path(self: Any, node_spec: Any) -> str:
        return str(ObjectLookup.node(node_spec).path)

    @OnEither
    def attribute_path(self: Any, attribute_spec: Any) -> str:
        return str(ObjectLookup.attribute(attribute_spec).path)

    @OnEither
    def node_type(self: Any, type_id: Any) -> Any:
        name = type_id.get_type_name() if isinstance(type_id, Node) else getattr(type_id, "id", type_id)
        found = NodeType(str(name))
        if not found.is_valid():
            raise OmniGraphError(f'"{name}" is not a node type')
        return found

    @OnEither
    def attribute_type(self: Any, type_id: Any) -> Type:
        if isinstance(type_id, Type):
            return type_id
        if isinstance(type_id, Attribute):
            return type_id.get_resolved_type()
        found = AttributeType.type_from_ogn_type_name(str(type_id))
        found = AttributeType.type_from_sdf_type_name(type_id) if found == UNKNOWN else found
        if found == UNKNOWN:
            raise OmniGraphError(f'"{type_id}" is not an attribute type')
        return found

    @OnEither
    def split_graph_from_node_path(self: Any, node_path: Any) -> tuple[Any, str]:
        graph, name = find.graph_and_name(present(), node_text(bare(node_path)))
        return Graph(present(), graph.path), name


def bare(spec: Any) -> Any:
    """A name for the engine's look-ups: handles and prims as text."""
    if isinstance(spec, tuple):
        return tuple(bare(one) for one in spec)
    if isinstance(spec, (Graph, Node, Attribute)):
        return spec.path
    if hasattr(spec, "GetPath") and not isinstance(spec, str):
        return str(spec.GetPath())
    return str(spec) if type(spec).__name__ == "Path" else spec


def get_graph_by_path(path: Any) -> Graph | None:
    found: Graph | None = ObjectLookup.graph(path)
    return found


def get_node_by_path(path: Any) -> Node | None:
    return node_or_none(present(), str(bare(path)))


def get_all_graphs() -> list[Graph]:
    graphs = present()
    return [Graph(graphs, path) for path in graphs.graphs]


def get_graphs_in_pipeline_stage(pipeline_stage: Any) -> list[Graph]:
    return [one for one in get_all_graphs() if one.get_pipeline_stage() == pipeline_stage]


def is_global_graph_prim(prim_path: str) -> bool:
    return get_graph_by_path(prim_path) is not None
