"""`Graph` and `Node`."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace
from typing import Any

from graph.editing.graph_set import GraphSet
from graph.evaluate import Graph as OurGraph
from graph.isaac.events import EventStream
from graph.isaac.og import Compound, Controller, OmniGraphError, find
from graph.isaac.outcomes import inert
from graph.isaac.session import mirror
from graph.spec.file_spec import GraphSpec

from .attributes import Attribute, attribute_or_none
from .editing import disconnect_all, follow, kind_name, respecify
from .enums import (
    AttributePortType,
    ExtendedAttributeType,
    GraphBackingType,
    GraphEvaluationMode,
    GraphPipelineStage,
)
from .graph_parts import GraphContext, IVariable
from .handle import Handle
from .node_type import COMPOUND, NodeType

STAGES = {
    GraphPipelineStage.GRAPH_PIPELINE_STAGE_SIMULATION: "simulation",
    GraphPipelineStage.GRAPH_PIPELINE_STAGE_PRERENDER: "pre_render",
    GraphPipelineStage.GRAPH_PIPELINE_STAGE_POSTRENDER: "post_render",
    GraphPipelineStage.GRAPH_PIPELINE_STAGE_ONDEMAND: "on_demand",
}
MODES = {
    GraphEvaluationMode.GRAPH_EVALUATION_MODE_AUTOMATIC: "automatic",
    GraphEvaluationMode.GRAPH_EVALUATION_MODE_STANDALONE: "standalone",
    GraphEvaluationMode.GRAPH_EVALUATION_MODE_INSTANCED: "instanced",
}


class Graph(Handle):
    """A graph."""

    @property
    def ours(self) -> OurGraph:
        """The graph itself. Raises OmniGraphError if it is gone."""
        return self._graphs.get(self.path)

    def is_valid(self) -> bool:
        return self._graphs.latest(self.path) is not None

    def get_path_to_graph(self) -> str:
        return self.path

    def get_nodes(self) -> list[Node]:
        return [Node(self._graphs, node.path) for node in (self._graphs.latest(self.path) or self.ours).nodes.values()]

    def get_node(self, path: str) -> Node | None:
        return node_or_none(self._graphs, path if str(path).startswith("/") else f"{self.path}/{path}")

    def get_pipeline_stage(self) -> GraphPipelineStage:
        return next(stage for stage, name in STAGES.items() if name == self.ours.pipeline_stage)

    def change_pipeline_stage(self, newPipelineStage: Any) -> None:
        self.ours.change_pipeline_stage(STAGES.get(newPipelineStage, newPipelineStage))
        follow(self.path)

    def get_evaluator_name(self) -> str:
        return str(self.ours.evaluator)

    @property
    def evaluation_mode(self) -> GraphEvaluationMode:
        return next(mode for mode, name in MODES.items() if name == self.ours.spec.evaluation_mode)

    @evaluation_mode.setter
    def evaluation_mode(self, mode: Any) -> None:
        from dataclasses import replace

        spec = self._graphs.current_spec(self.path)
        self._graphs.apply([replace(spec, evaluation_mode=MODES[GraphEvaluationMode(mode)])], {})  # type: ignore[arg-type]
        follow(self.path)

    def get_graph_backing_type(self) -> GraphBackingType:
        return GraphBackingType(GraphBackingType.GRAPH_BACKING_TYPE_FABRIC_WITHOUT_HISTORY)

    def evaluate(self) -> None:
        self._edit.evaluate_sync(self.ours)

    def set_disabled(self, disable: bool) -> None:
        self.ours.disabled = bool(disable)

    def is_disabled(self) -> bool:
        return self.ours.disabled

    def create_node(self, path: str, node_type: Any, use_usd: bool = True) -> Node:
        full = path if str(path).startswith("/") else f"{self.path}/{path}"
        return Node(self._graphs, self._edit.create_node(full, getattr(node_type, "id", node_type)).path)

    def destroy_node(self, node_path: str, update_usd: bool = True) -> bool:
        full = node_path if str(node_path).startswith("/") else f"{self.path}/{node_path}"
        return self._edit.delete_node(full, ignore_if_missing=True)

    def rename_node(self, path: str, new_path: str) -> bool:
        from .editing import rename_node

        return rename_node(self._graphs, self.path, path, new_path)

    def create_variable(self, name: str, type: Any) -> IVariable | None:
        if self.find_variable(name) is not None:
            return None
        self._edit.create_variable(self.ours, name, type)
        return IVariable(self, name)

    def remove_variable(self, variable: IVariable) -> bool:
        from .editing import remove_variable

        return remove_variable(self._graphs, self.path, variable.name)

    def find_variable(self, name: str) -> IVariable | None:
        return IVariable(self, name) if name in self.ours.variables else None

    def get_variables(self) -> list[IVariable]:
        return [IVariable(self, name) for name in self.ours.variables]

    def get_context(self) -> GraphContext:
        return GraphContext(self)

    get_default_graph_context = get_context

    def get_instance_count(self) -> int:
        return len(self.ours.instances)

    def get_parent_graph(self) -> Graph | None:
        parent = self.path.rpartition("/")[0]
        while parent and self._graphs.latest(parent) is None:
            parent = parent.rpartition("/")[0]
        return Graph(self._graphs, parent) if parent else None

    def get_subgraphs(self) -> list[Graph]:
        below = [path for path in self._graphs.graphs if path.startswith(f"{self.path}/")]
        return [one for path in below if (one := Graph(self._graphs, path)).get_parent_graph() == self]

    def get_subgraph(self, path: str) -> Graph | None:
        full = path if str(path).startswith("/") else f"{self.path}/{path}"
        return next((one for one in self.get_subgraphs() if one.path == full), None)

    def create_subgraph(self, subgraphPath: str, evaluator: str = "", createUsd: bool = True) -> Graph:
        path = subgraphPath if str(subgraphPath).startswith("/") else f"{self.path}/{subgraphPath}"
        return graph_of(
            self._graphs, self._edit.create_graph({"graph_path": path, "evaluator_name": evaluator or "push"})
        )

    def get_owning_compound_node(self) -> Node:
        return Node(self._graphs, "")

    def is_compound_graph(self) -> bool:
        owner = Node(self._graphs, self.path.removesuffix("/Subgraph"))
        return owner.path != self.path and owner.is_valid() and owner.is_compound_node()

    @inert("omni.graph.core")
    def get_event_stream(self) -> EventStream:
        return EventStream()

    @inert("omni.graph.core")
    def register_error_status_change_callback(self, callback: Any) -> int:
        return 0

    @inert("omni.graph.core")
    def deregister_error_status_change_callback(self, status_change_handle: int) -> None: ...

    def reload_from_stage(self) -> None:
        """Applies at once what was changed on the graph's prims."""
        if (prims := mirror()) is not None:
            prims.sync()

    @inert("omni.graph.core")
    def reload_settings(self) -> None: ...


class Node(Handle):
    """A node, or a compound."""

    @property
    def ours(self) -> Any:
        """The node itself. Raises OmniGraphError if it is gone."""
        return find.node(self._graphs, self.path)

    def is_valid(self) -> bool:
        if not self.path:
            return False
        with suppress(OmniGraphError):
            return self.ours is not None
        return False

    def get_prim_path(self) -> str:
        return self.path

    def get_type_name(self) -> str:
        return COMPOUND if self.is_compound_node() else str(self.ours.type.id)

    def get_node_type(self) -> NodeType:
        return NodeType(self.get_type_name())

    def get_graph(self) -> Graph:
        return Graph(self._graphs, self.ours.graph.path)

    get_wrapped_graph = get_graph

    def get_attribute(self, name: str) -> Attribute | None:
        return Attribute(self, found.full_name) if (found := attribute_or_none(self.ours, name)) else None

    def get_attribute_exists(self, name: str) -> bool:
        return attribute_or_none(self.ours, name) is not None

    def get_attributes(self) -> list[Attribute]:
        ours = self.ours
        names = list(ours.ports) if isinstance(ours, Compound) else [one.full_name for one in ours.get_attributes()]
        return [Attribute(self, name) for name in names]

    def create_attribute(
        self,
        attributeName: str,
        attributeType: Any,
        portType: Any = AttributePortType.INPUT,
        value: Any = None,
        extendedType: Any = ExtendedAttributeType.REGULAR,
        unionTypes: str = "",
    ) -> bool:
        return create_attribute(self, attributeName, attributeType, portType, value, extendedType) is not None

    def remove_attribute(self, attributeName: str) -> bool:
        return remove_attribute(self, attributeName)

    def get_compute_count(self) -> int:
        return int(self.ours.get_compute_count())

    def request_compute(self) -> bool:
        self.ours.request_compute()
        return True

    def is_compound_node(self) -> bool:
        return isinstance(self.ours, Compound)

    def get_compound_graph_instance(self) -> Graph:
        return Graph(self._graphs, f"{self.path}/Subgraph")

    def is_disabled(self) -> bool:
        return self.ours.name in self.ours.graph.disabled_nodes

    def set_disabled(self, disabled: bool) -> None:
        self.ours.graph.disable_node(self.ours.name, bool(disabled))

    def is_backed_by_usd(self) -> bool:
        return True

    def node_id(self) -> int:
        return self.get_handle()

    @inert("omni.graph.core")
    def get_event_stream(self) -> EventStream:
        return EventStream()

    def get_compute_messages(self, severity: Any) -> list[str]:
        app = self._graphs.app
        log: Any = self._graphs.context.warn if app is None else app.warnings
        return [
            one.message
            for one in log
            if one.where == self.path and (one.code == "compute-failed") == (int(severity) == 2)
        ]

    @inert("omni.graph.core")
    def clear_old_compute_messages(self) -> int:
        return 0

    def log_compute_message(self, severity: Any, message: str) -> bool:
        self._graphs.context.warn("compute-message", self.path, message)
        return True

    @inert("omni.graph.core")
    def set_compute_incomplete(self) -> None: ...

    @inert("omni.graph.core")
    def resolve_coupled_attributes(self, attributesArray: Any) -> bool:
        return True

    @inert("omni.graph.core")
    def resolve_partially_coupled_attributes(self, *_: Any) -> bool:
        return True

    @inert("omni.graph.core")
    def register_on_connected_callback(self, callback: Any) -> int:
        return 0

    @inert("omni.graph.core")
    def register_on_disconnected_callback(self, callback: Any) -> int:
        return 0

    @inert("omni.graph.core")
    def deregister_on_connected_callback(self, callback: int) -> None: ...

    @inert("omni.graph.core")
    def deregister_on_disconnected_callback(self, callback: int) -> None: ...


def graph_of(graphs: GraphSet, ours: Any) -> Graph:
    """The handle of a graph."""
    return Graph(graphs, ours.path)


def node_or_none(graphs: GraphSet, path: str) -> Node | None:
    """The node with that path, or None."""
    found = Node(graphs, str(path))
    return found if found.is_valid() else None


_PREFIXES = {AttributePortType.INPUT: "inputs", AttributePortType.OUTPUT: "outputs", AttributePortType.STATE: "state"}


def create_attribute(
    node: Node, name: str, kind: Any, port: Any = AttributePortType.INPUT, value: Any = None, extended: Any = 0
) -> Attribute | None:
    """Adds an attribute to a node; None if it is there already."""
    prefix = _PREFIXES[AttributePortType(port)]
    full = name if name.partition(":")[0] in _PREFIXES.values() else f"{prefix}:{name}"
    if node.get_attribute(full) is not None:
        return None
    text = kind_name(kind) if int(extended) == ExtendedAttributeType.REGULAR else "any"
    node._edit.edit(node.ours.graph, {Controller.Keys.CREATE_ATTRIBUTES: [(f"{node.path}.{full}", text)]})
    made = Attribute(node, full)
    if value is not None:
        made.set(value)
    return made


def remove_attribute(node: Node, name: str) -> bool:
    """Removes an attribute that was added to a node; False if the type declares it, or it is missing."""
    found = node.get_attribute(name)
    if found is None or not found.is_dynamic():
        return False
    disconnect_all(node._graphs, found.path)

    def without(spec: GraphSpec) -> GraphSpec:
        return replace(
            spec,
            nodes=tuple(
                replace(
                    one,
                    attributes={key: kind for key, kind in one.attributes.items() if key != found.full_name},
                    inputs={key: value for key, value in one.inputs.items() if key != found.full_name},
                )
                if one.name == node.ours.name
                else one
                for one in spec.nodes
            ),
        )

    respecify(node._graphs, node.ours.graph.path, without)
    return True
