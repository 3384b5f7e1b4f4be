"""`omni.graph.core`."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from graph.isaac.og import OmniGraphError, OmniGraphValueError, get_registered_nodes
from graph.isaac.og.keys import PrimExposureType, TypedValue
from graph.isaac.omnigraph.attributes import Attribute, AttributeData
from graph.isaac.omnigraph.controller import Controller, DataView, GraphController, Keys, NodeController
from graph.isaac.omnigraph.enums import (
    ACCORDING_TO_CONTEXT_GRAPH_INDEX,
    AUTHORING_GRAPH_INDEX,
    INSTANCING_GRAPH_TARGET_PATH,
    AttributePortType,
    AttributeRole,
    BaseDataType,
    ConnectionType,
    ExecutionAttributeState,
    ExtendedAttributeType,
    GraphBackingType,
    GraphEvaluationMode,
    GraphEvent,
    GraphPipelineStage,
    MemoryType,
    NodeEvent,
    Severity,
    eVariableScope,
)
from graph.isaac.omnigraph.graph_parts import GraphContext, IVariable
from graph.isaac.omnigraph.handles import STAGES, Graph, Node
from graph.isaac.omnigraph.lookup import (
    ObjectLookup,
    get_all_graphs,
    get_graph_by_path,
    get_graphs_in_pipeline_stage,
    get_node_by_path,
    is_global_graph_prim,
    present,
)
from graph.isaac.omnigraph.node_type import NodeType
from graph.isaac.omnigraph.types import AttributeType, Type
from graph.isaac.outcomes import tell_inert
from graph.ogn.database import OgnDatabase as Database

__all__ = [
    "ACCORDING_TO_CONTEXT_GRAPH_INDEX",
    "AUTHORING_GRAPH_INDEX",
    "INSTANCING_GRAPH_TARGET_PATH",
    "Attribute",
    "AttributeData",
    "AttributePortType",
    "AttributeRole",
    "AttributeType",
    "BaseDataType",
    "ConnectionType",
    "Controller",
    "DataView",
    "Database",
    "ExecutionAttributeState",
    "ExtendedAttributeType",
    "Graph",
    "GraphBackingType",
    "GraphContext",
    "GraphController",
    "GraphEvaluationMode",
    "GraphEvent",
    "GraphPipelineStage",
    "IVariable",
    "Keys",
    "MemoryType",
    "Node",
    "NodeController",
    "NodeEvent",
    "NodeType",
    "ObjectLookup",
    "OmniGraphAttributeError",
    "OmniGraphBindingError",
    "OmniGraphError",
    "OmniGraphTypeError",
    "OmniGraphValueError",
    "PrimExposureType",
    "Settings",
    "Severity",
    "Type",
    "TypedValue",
    "eVariableScope",
    "get_all_graphs",
    "get_all_graphs_and_subgraphs",
    "get_compute_graph_contexts",
    "get_global_orchestration_graphs",
    "get_global_orchestration_graphs_in_pipeline_stage",
    "get_graph_by_path",
    "get_graphs_in_pipeline_stage",
    "get_node_by_path",
    "get_node_type",
    "get_registered_nodes",
    "is_global_graph_prim",
]
get_all_graphs_and_subgraphs = get_all_graphs


class OmniGraphAttributeError(OmniGraphError): ...


class OmniGraphTypeError(OmniGraphError): ...


class OmniGraphBindingError(Exception): ...


class _Orchestration(Graph):
    """The graph above all graphs of a pipeline stage: new graphs are made as its nodes."""

    def __init__(self, stage: GraphPipelineStage) -> None:
        super().__init__(present(), f"/__{stage.name.rpartition('_')[2].lower()}_orchestration_graph")
        self._stage = stage

    def is_valid(self) -> bool:
        return True

    def get_pipeline_stage(self) -> GraphPipelineStage:
        return self._stage

    def get_subgraphs(self) -> list[Graph]:
        return get_graphs_in_pipeline_stage(self._stage)

    def get_nodes(self) -> list[Node]:
        return [_GraphAsNode(self._graphs, one.path) for one in self.get_subgraphs()]

    def create_graph_as_node(
        self,
        name: str,
        path: str,
        evaluator: str,
        is_global_graph: bool = True,
        is_backed_by_usd: bool = True,
        backing_type: Any = None,
        pipeline_stage: Any = None,
        evaluation_mode: Any = GraphEvaluationMode.GRAPH_EVALUATION_MODE_AUTOMATIC,
    ) -> Node:
        stage = self._stage if pipeline_stage is None else pipeline_stage
        Controller.create_graph(
            {
                "graph_path": path,
                "evaluator_name": evaluator,
                "pipeline_stage": stage,
                "evaluation_mode": evaluation_mode,
            }
        )
        return _GraphAsNode(self._graphs, path)


class _GraphAsNode(Node):
    """A graph as a node of the graph above it."""

    def is_valid(self) -> bool:
        return self._graphs.latest(self.path) is not None

    def get_wrapped_graph(self) -> Graph:
        return Graph(self._graphs, self.path)


def get_global_orchestration_graphs() -> list[Graph]:
    return [_Orchestration(stage) for stage in STAGES]


def get_global_orchestration_graphs_in_pipeline_stage(pipeline_stage: Any) -> list[Graph]:
    return [_Orchestration(GraphPipelineStage(pipeline_stage))]


def get_compute_graph_contexts() -> list[GraphContext]:
    return [GraphContext(one) for one in get_all_graphs()]


def get_node_type(node_type_name: str) -> NodeType:
    return NodeType(node_type_name)


class Settings:
    """Settings of OmniGraph within a `with` block."""

    def __init__(self, **named: Any) -> None:
        for name in named:
            tell_inert(f"omni.graph.core.Settings: {name}")

    @staticmethod
    def temporary(path: str, value: Any = None) -> Any:
        from contextlib import contextmanager

        from graph.isaac.session import app

        @contextmanager
        def changed() -> Iterator[None]:
            settings = app().settings
            before = settings.get(path)
            settings.set(path, value)
            try:
                yield
            finally:
                settings.set(path, before)

        return changed()

    def __enter__(self) -> Settings:
        return self

    def __exit__(self, *_: object) -> None:
        return None
