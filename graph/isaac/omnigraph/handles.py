"""OmniGraph's handles: Graph, Node, Attribute, IVariable and others, which look up what they name at each call."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from typing import Any
from weakref import WeakKeyDictionary

from graph.editing.graph_set import GraphSet
from graph.evaluate import Graph as OurGraph
from graph.evaluate.omnigraph_names import AttributeOf
from graph.evaluate.omnigraph_names import Variable as OurVariable
from graph.isaac.events import EventStream
from graph.isaac.og import Compound, Controller, OmniGraphError
from graph.isaac.outcomes import inert, tell_inert
from graph.isaac.session import mirror
from graph.values.types import TYPES, Extended

from .enums import (
    ACCORDING_TO_CONTEXT_GRAPH_INDEX,
    AUTHORING_GRAPH_INDEX,
    AttributePortType,
    ExtendedAttributeType,
    GraphBackingType,
    GraphEvaluationMode,
    GraphPipelineStage,
    eVariableScope,
)
from .types import Type, type_of

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
COMPOUND = "omni.graph.nodes.CompoundSubgraph"
_PORTS = {"inputs": AttributePortType.INPUT, "outputs": AttributePortType.OUTPUT, "state": AttributePortType.STATE}
_CALLBACKS: dict[tuple[int, str], Callable[[Any], None]] = {}
_METADATA: WeakKeyDictionary[GraphSet, dict[str, dict[str, str]]] = WeakKeyDictionary()
"""What scripts have set on attributes, by the attribute's path."""


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
        return self._edit.node(self.path)

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
        return Attribute(self, found.full_name) if (found := _attribute(self.ours, name)) else None

    def get_attribute_exists(self, name: str) -> bool:
        return _attribute(self.ours, name) is not None

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
        from .editing import create_attribute

        return create_attribute(self, attributeName, attributeType, portType, value, extendedType) is not None

    def remove_attribute(self, attributeName: str) -> bool:
        from .editing import remove_attribute

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


class Attribute(Handle):
    """An attribute of a node."""

    def __init__(self, node: Node, name: str) -> None:
        super().__init__(node._graphs, f"{node.path}.{name}")
        self._node, self.full_name = node, name
        self.is_optional_for_compute = False
        with suppress(OmniGraphError):
            ours = node.ours
            if name.startswith("outputs:") and not isinstance(ours, Compound):
                ours.graph.asked.add((ours.name, name))

    @property
    def ours(self) -> AttributeOf:
        """The attribute itself. Raises OmniGraphError if it is gone."""
        found = _attribute(self._node.ours, self.full_name)
        if found is None:
            raise OmniGraphError(f"{self.path} is gone")
        return found

    def is_valid(self) -> bool:
        with suppress(OmniGraphError):
            return _attribute(self._node.ours, self.full_name) is not None
        return False

    def get(self, on_gpu: bool = False, instance: int = ACCORDING_TO_CONTEXT_GRAPH_INDEX) -> Any:
        if on_gpu:
            tell_inert("omni.graph.core: on_gpu", "values are in the memory of the CPU; the argument changes nothing")
        found = self._of_instance(instance)
        return self._edit.get(self.path) if found is None else found.get()

    def _of_instance(self, instance: int) -> AttributeOf | None:
        """The attribute in the instance with that number; None for the graph itself."""
        held = list(self._node.ours.graph.instances.values())
        if instance in (ACCORDING_TO_CONTEXT_GRAPH_INDEX, AUTHORING_GRAPH_INDEX) or (instance == 0 and not held):
            return None
        if not 0 <= instance < len(held):
            raise OmniGraphError(f"{self.path}: there is no instance {instance}; the graph has {len(held)}")
        return AttributeOf(held[instance].nodes[self._node.ours.name], self.full_name)

    def get_array(
        self, on_gpu: bool = False, get_for_write: bool = False, reserved_element_count: int = 0, *_: Any
    ) -> Any:
        return self.get(on_gpu, *_[:1])

    def set(self, value: Any, on_gpu: bool = False, instance: int = ACCORDING_TO_CONTEXT_GRAPH_INDEX) -> bool:
        from .editing import plain, set_value

        if on_gpu:
            tell_inert("omni.graph.core: on_gpu", "values are in the memory of the CPU; the argument changes nothing")
        if (found := self._of_instance(instance)) is not None:
            try:
                found.set(plain(value))
            except ValueError as error:
                raise OmniGraphError(str(error)) from None
            return True
        set_value(self, value)
        if not self.full_name.startswith("outputs:") and (prims := mirror()) is not None:
            ours = self.ours
            prims.set_value(ours.node, ours.full_name)
        return True

    def set_default(self, value: Any, on_gpu: bool = False) -> bool:
        return self.set(value, on_gpu)

    def get_name(self) -> str:
        return self.full_name

    def get_path(self) -> str:
        return self.path

    def get_node(self) -> Node:
        return self._node

    def get_port_type(self) -> AttributePortType:
        return _PORTS.get(self.full_name.partition(":")[0], AttributePortType.UNKNOWN)

    def get_resolved_type(self) -> Type:
        return type_of(TYPES.get(self.ours.get_type_name()))

    def set_resolved_type(self, resolved_type: Type) -> None:
        """Connections and values resolve types here; asking for another type does nothing."""
        if resolved_type != self.get_resolved_type():
            tell_inert("omni.graph.core.Attribute.set_resolved_type")

    def get_type_name(self) -> str:
        return self.ours.get_type_name()

    def get_extended_type(self) -> ExtendedAttributeType:
        declared = self._declared()
        if not isinstance(declared, Extended):
            return ExtendedAttributeType.REGULAR
        return ExtendedAttributeType.UNION if declared.members else ExtendedAttributeType.ANY

    def get_union_types(self) -> list[str] | None:
        declared = self._declared()
        return [str(one) for one in declared.members] if isinstance(declared, Extended) and declared.members else None

    def _declared(self) -> Any:
        ours = self.ours
        try:
            return ours.node.attribute(ours.full_name).parsed
        except KeyError:
            return Extended("any")

    def is_array(self) -> bool:
        return self.get_resolved_type().array_depth > 0

    def is_dynamic(self) -> bool:
        ours = self.ours
        return ours.full_name in ours.node.added

    def is_deprecated(self) -> bool:
        return bool(self.deprecation_message())

    def deprecation_message(self) -> str:
        ours = self.ours
        with suppress(KeyError):
            return str(ours.node.attribute(ours.full_name).deprecated)
        return ""

    def get_metadata(self, key: str) -> str | None:
        return self.get_all_metadata().get(key)

    def get_all_metadata(self) -> dict[str, str]:
        ours = self.ours
        stored = _METADATA.get(self._graphs, {}).get(self.path, {})
        with suppress(KeyError):
            return {"__description": ours.node.attribute(ours.full_name).doc, **stored}
        return dict(stored)

    def set_metadata(self, key: str, value: str) -> bool:
        _METADATA.setdefault(self._graphs, {}).setdefault(self.path, {})[str(key)] = str(value)
        return True

    def connect(self, path: Any, modify_usd: bool = True) -> bool:
        self._edit.connect(self.path, getattr(path, "path", path))
        return True

    def disconnect(self, attribute: Any, modify_usd: bool = True) -> bool:
        self._edit.disconnect(self.path, getattr(attribute, "path", attribute))
        return True

    def get_upstream_connections(self) -> list[Attribute]:
        return [self._at(source) for source, target in self._connections() if target == self.path]

    def get_downstream_connections(self) -> list[Attribute]:
        return [self._at(target) for source, target in self._connections() if source == self.path]

    def get_upstream_connection_count(self) -> int:
        return len(self.get_upstream_connections())

    def get_downstream_connection_count(self) -> int:
        return len(self.get_downstream_connections())

    def is_connected(self, attribute: Any = None) -> bool:
        ends = [one.path for one in (*self.get_upstream_connections(), *self.get_downstream_connections())]
        return bool(ends) if attribute is None else getattr(attribute, "path", str(attribute)) in ends

    def _connections(self) -> list[tuple[str, str]]:
        from .editing import connections

        return connections(self._graphs, self._node.ours.graph.path)

    def _at(self, path: str) -> Attribute:
        owner, _, name = path.rpartition(".")
        return Attribute(Node(self._graphs, owner), name)

    def is_compatible(self, attribute: Attribute) -> bool:
        from graph.values.conversion import converter

        mine, other = TYPES.get(self.get_type_name()), TYPES.get(attribute.get_type_name())
        return mine is None or other is None or mine is other or converter(mine, other) is not None

    def register_value_changed_callback(self, func: Callable[[Any], None] | None) -> None:
        key = (id(self._graphs), self.path)
        if func is None:
            _CALLBACKS.pop(key, None)
        else:
            _CALLBACKS[key] = func

    def get_attribute_data(self, instance: int = ACCORDING_TO_CONTEXT_GRAPH_INDEX) -> AttributeData:
        return AttributeData(self, instance)

    @staticmethod
    def get_port_type_from_name(name: str) -> AttributePortType:
        return _PORTS.get(name.partition(":")[0], AttributePortType.UNKNOWN)

    @staticmethod
    def ensure_port_type_in_name(name: str, port_type: Any, is_bundle: bool = False) -> str:
        prefix = next(one for one, port in _PORTS.items() if port == port_type)
        return name if name.startswith(f"{prefix}:") else f"{prefix}:{name}"

    @staticmethod
    def remove_port_type_from_name(name: str, is_bundle: bool = False) -> str:
        return name.partition(":")[2] if name.partition(":")[0] in _PORTS else name


class AttributeData:
    """The value of an attribute."""

    def __init__(self, attribute: Attribute, instance: int) -> None:
        self._attribute, self._instance = attribute, instance

    def get(self, on_gpu: bool = False, *_: Any, **__: Any) -> Any:
        return self._attribute.get(on_gpu, self._instance)

    def set(self, value: Any, on_gpu: bool = False, *_: Any, **__: Any) -> bool:
        return self._attribute.set(value, on_gpu, self._instance)

    def get_type(self) -> Type:
        return self._attribute.get_resolved_type()

    get_resolved_type = get_type

    def size(self) -> int:
        value = self.get()
        return len(value) if hasattr(value, "__len__") else 1

    def is_valid(self) -> bool:
        return self._attribute.is_valid()

    def is_read_only(self) -> bool:
        return self._attribute.full_name.startswith("outputs:")

    def cpu_valid(self) -> bool:
        return True

    def gpu_valid(self) -> bool:
        return False


class IVariable:
    """A variable of a graph."""

    def __init__(self, graph: Graph, name: str) -> None:
        self._graph, self.name = graph, name
        self.category = self.display_name = self.tooltip = ""
        self.scope = eVariableScope.E_PRIVATE

    def __eq__(self, other: object) -> bool:
        return isinstance(other, IVariable) and (self._graph, self.name) == (other._graph, other.name)

    def __hash__(self) -> int:
        return hash(self.source_path)

    def __repr__(self) -> str:
        return f"<omni.graph.core.IVariable {self.source_path}>"

    @property
    def source_path(self) -> str:
        return f"{self._graph.path}.graph:variable:{self.name}"

    @property
    def valid(self) -> bool:
        return self._graph.is_valid() and self.name in self._graph.ours.variables

    def is_valid(self) -> bool:
        return self.valid

    def __bool__(self) -> bool:
        return self.valid

    @property
    def type(self) -> Type:
        return type_of(self._graph.ours.variables.types[self.name])

    @property
    def ours(self) -> OurVariable:
        return OurVariable(self._graph.ours, self.name)

    def get(self, graph_context: Any = None, instance_path: str | None = None) -> Any:
        return self.ours.get(instance_path)

    def get_array(self, graph_context: Any = None, *_: Any, instance_path: str | None = None) -> Any:
        return self.ours.get(instance_path)

    def set(self, graph_context: Any, value: Any, instance_path: str | None = None) -> bool:
        self.ours.set(value, instance_path)
        return True

    def set_type(self, variable_type: Any) -> bool:
        """Gives it another type and that type's zero; False if a node uses it."""
        from .editing import kind_name, remove_variable

        if kind_name(variable_type) == str(self._graph.ours.variables.types[self.name]):
            return True
        if not remove_variable(self._graph._graphs, self._graph.path, self.name):
            return False
        self._graph._edit.create_variable(self._graph.ours, self.name, kind_name(variable_type))
        return True


class GraphContext:
    """The time of a graph."""

    def __init__(self, graph: Graph) -> None:
        self._graph = graph

    def get_graph(self) -> Graph:
        return self._graph

    def get_graph_target(self, index: int = 0) -> str:
        return self._graph.path

    def get_time(self) -> float:
        return float(self._graph._graphs.context.time)

    def get_time_since_start(self) -> float:
        return float(self._graph._graphs.context.since_start)

    def get_elapsed_time(self) -> float:
        return float(self._graph._graphs.context.delta)

    def get_frame(self) -> float:
        return float(self._graph._graphs.context.update)

    def get_is_playing(self) -> bool:
        return bool(self._graph._graphs.context.is_playing)

    def is_valid(self) -> bool:
        return self._graph.is_valid()


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


def _attribute(ours: Any, name: str) -> AttributeOf | None:
    try:
        found: AttributeOf = ours.get_attribute(name)
    except (KeyError, OmniGraphError):
        return None
    return found


def graph_of(graphs: GraphSet, ours: Any) -> Graph:
    """The handle of a graph."""
    return Graph(graphs, ours.path)


def node_or_none(graphs: GraphSet, path: str) -> Node | None:
    """The node with that path, or None."""
    found = Node(graphs, str(path))
    return found if found.is_valid() else None


def follow(path: str) -> None:
    """A graph was changed, not by an edit: its prims follow."""
    if (prims := mirror()) is not None:
        prims.write(path)


def tell_changed(attribute: Attribute) -> None:
    """Calls the callback that was registered for changes of an attribute."""
    if (callback := _CALLBACKS.get((id(attribute._graphs), attribute.path))) is not None:
        callback(attribute)
