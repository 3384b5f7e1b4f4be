"""`og.Controller` and its parts, with OmniGraph's arguments and results."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from typing import Any

from graph.editing.graph_set import GraphSet
from graph.evaluate.omnigraph_names import AttributeOf
from graph.isaac.og import Controller as OurController
from graph.isaac.og import Keys as OurKeys
from graph.isaac.og import OmniGraphError, TypedValue, find
from graph.isaac.og.controller import OnEither
from graph.isaac.og.keys import PrimExposureType
from graph.isaac.og.names import node_text
from graph.isaac.og.present import present_set
from graph.isaac.session import app_or_none, mirror
from graph.session.runner import graphs_of

from . import editing
from .attributes import Attribute
from .enums import AttributePortType, ExtendedAttributeType, GraphPipelineStage
from .graph_parts import IVariable
from .handles import MODES, STAGES, Graph, Node, follow, node_or_none
from .node_type import NodeType
from .types import UNKNOWN, AttributeType, Type

_UNGIVEN: Any = object()


class Keys(OurKeys):
    DISCONNECT_ALL = "disconnect_all"


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
        return Node(graphs, find.node(graphs, _bare(node_id)).path)

    @OnEither
    def attribute(self: Any, attribute_id: Any, node_id: Any = None, graph_id: Any = None) -> Any:
        if isinstance(attribute_id, list):
            return [ObjectLookup.attribute(one, node_id, graph_id) for one in attribute_id]
        if isinstance(attribute_id, Attribute):
            return attribute_id
        if hasattr(attribute_id, "GetPath"):
            attribute_id = str(attribute_id.GetPath())
        graphs = present()
        found = find.attribute(graphs, _bare(attribute_id), _bare(node_id), _bare(graph_id))
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
        found = OurController(graphs=present()).variable(str(variable_id), _bare(graph_id))
        return IVariable(Graph(present(), found.graph.path), found.name)

    @OnEither
    def prim(self: Any, prim_id: Any, graph_id: Any = None) -> Any:
        if isinstance(prim_id, list):
            return [ObjectLookup.prim(one, graph_id) for one in prim_id]
        return prim_id if hasattr(prim_id, "GetPath") else OurController(graphs=present()).prim(_bare(prim_id))

    @OnEither
    def prim_path(self: Any, prim_ids: Any) -> Any:
        if isinstance(prim_ids, list):
            return [ObjectLookup.prim_path(one) for one in prim_ids]
        return str(prim_ids.GetPath()) if hasattr(prim_ids, "GetPath") else node_text(_bare(prim_ids), "prim")

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
        graph, name = find.graph_and_name(present(), node_text(_bare(node_path)))
        return Graph(present(), graph.path), name


class DataView:
    """Reads and writes values."""

    def __init__(self, attribute: Any = None, *_: Any, **__: Any) -> None:
        self._attribute = attribute

    @OnEither
    def get(self: Any, attribute: Any = None, node: Any = None, *_: Any, **__: Any) -> Any:
        found = _value(self, attribute, node)
        return found.get()

    @OnEither
    def set(self: Any, attribute: Any = _UNGIVEN, value: Any = _UNGIVEN, node: Any = None, *_: Any, **__: Any) -> bool:
        if value is _UNGIVEN:
            attribute, value = None, attribute
        if value is _UNGIVEN:
            raise OmniGraphError("set needs a value")
        if type(attribute) is str and node is None:  # the common form, without a handle for each call
            graphs, ours = present(), None
            with suppress(OmniGraphError):
                ours = find.attribute(graphs, attribute)
            if ours is not None:
                return editing.set_value(graphs, ours, value)
        found = _value(self, None if attribute is _UNGIVEN else attribute, node)
        if isinstance(found, IVariable):
            return found.set(None, value)
        return bool(found.set(value))

    @OnEither
    def get_array_size(self: Any, attribute: Any = None) -> int:
        return len(_value(self, attribute, None).get())

    @staticmethod
    def force_usd_update(force: bool = True) -> Any:
        from contextlib import nullcontext

        return nullcontext()


def _value(owner: Any, attribute: Any, node: Any) -> Any:
    chosen = attribute if attribute is not None else getattr(owner, "_attribute", None)
    if chosen is None:
        raise OmniGraphError("name an attribute")
    if isinstance(chosen, (Attribute, IVariable)):
        return chosen
    with suppress(OmniGraphError):
        return ObjectLookup.attribute(chosen, node)
    if isinstance(chosen, tuple) or ".graph:variable:" in str(chosen):
        return ObjectLookup.variable(chosen)
    found = OurController(graphs=present())
    found.get(_bare(chosen), _bare(node))  # makes a dynamic attribute, or says what is wrong
    return ObjectLookup.attribute(chosen, node)


class Controller(ObjectLookup, DataView):
    """Makes, changes, reads and evaluates graphs; every call works on the class and on an instance."""

    Keys = Keys
    PrimExposureType = PrimExposureType
    TypedValue = TypedValue
    PipelineStage = GraphPipelineStage

    def __init__(
        self, graph_id: Any = None, path_to_object_map: Any = None, *_: Any, attribute: Any = None, **options: Any
    ) -> None:
        if isinstance(graph_id, (Attribute, AttributeOf, IVariable)):  # Controller(attribute).get()
            graph_id, attribute = None, graph_id
        super().__init__(attribute)
        self._graph_id, self._map = graph_id, {} if path_to_object_map is None else path_to_object_map
        self._options = {key: value for key, value in options.items() if key.startswith("allow_exists_")}

    @OnEither
    def edit(
        self: Any,
        graph_id: Any = None,
        edit_commands: Mapping[str, Any] | None = None,
        path_to_object_map: dict[str, Any] | None = None,
        update_usd: bool = True,
        undoable: bool = True,
        allow_exists_attr: bool = False,
        allow_exists_node: bool = False,
        allow_exists_prim: bool = False,
    ) -> tuple[Any, list[Any], list[Any], dict[str, Any]]:
        if (
            isinstance(graph_id, Mapping)
            and graph_id
            and not any(key in graph_id for key in ("graph_path", "evaluator_name"))
            and edit_commands is None
        ):
            graph_id, edit_commands = None, graph_id
        if graph_id is None:
            graph_id = self._graph_id
        elif isinstance(self._map, dict):
            self._graph_id = find.graph_path(_settings(graph_id))
        if graph_id is None:
            raise OmniGraphError("name a graph to edit")
        graphs, editor = present(), OurController(graphs=present())
        allowed = {**self._options}
        for name, given in (("attr", allow_exists_attr), ("node", allow_exists_node), ("prim", allow_exists_prim)):
            if given:
                allowed[f"allow_exists_{name}"] = given
        names = self._map if path_to_object_map is None else path_to_object_map
        target = _settings(graph_id)
        path = find.graph_path(target)
        commands: dict[str, Any] = _commands(edit_commands or {})
        there = editing.split_existing(
            graphs,
            path,
            commands,
            nodes=bool(allowed.get("allow_exists_node")),
            attributes=bool(allowed.get("allow_exists_attr")),
            prims=bool(allowed.get("allow_exists_prim")),
        )
        for one in find_listed(commands.pop(Keys.DISCONNECT_ALL, [])):
            text = str(getattr(one, "path", one))
            editing.disconnect_all(graphs, text if text.startswith("/") else f"{path}/{text}")
        try:
            graph, nodes, prims, short = editor.edit(target, commands)
        except OmniGraphError:
            if graphs.latest(path) is None:
                editing.one_by_one(editor, target, commands)
            raise
        made = {name: Node(graphs, node.path) for name, node in short.items()}
        names.update(there | made)
        order = [*there.values(), *(Node(graphs, node.path) for node in nodes)]
        return Graph(graphs, graph.path), order, prims, {**names, **{str(prim.GetPath()): prim for prim in prims}}

    @OnEither
    def create_graph(self: Any, graph_id: Any, *_: Any, **__: Any) -> Any:
        return Graph(present(), OurController(graphs=present()).create_graph(_settings(graph_id)).path)

    @OnEither
    def delete_graph(self: Any, graph_id: Any, *_: Any, **__: Any) -> None:
        OurController(graphs=present()).delete_graph(_settings(graph_id))
        follow(find.graph_path(_settings(graph_id)))

    @OnEither
    def create_node(self: Any, node_id: Any, node_type_id: Any, allow_exists: bool = False, *_: Any, **__: Any) -> Any:
        kind = str(getattr(node_type_id, "id", node_type_id))
        made = OurController(graphs=present()).create_node(_bare(node_id), kind, allow_exists)
        return Node(present(), made.path)

    @OnEither
    def delete_node(
        self: Any, node_id: Any, graph_id: Any = None, ignore_if_missing: bool = False, *_: Any, **__: Any
    ) -> bool:
        if isinstance(node_id, list):
            each = [Controller.delete_node(one, graph_id, ignore_if_missing) for one in node_id]
            return all(each)
        return OurController(graphs=present()).delete_node(_bare(node_id), _bare(graph_id), ignore_if_missing)

    @OnEither
    def create_variable(
        self: Any, graph_id: Any, name: str, var_type: Any, allow_exists: bool = False, *_: Any, **__: Any
    ) -> Any:
        graph = Graph(present(), find.graph_path(_bare(graph_id)))
        if allow_exists and (found := graph.find_variable(name)) is not None:
            return found
        OurController(graphs=present()).create_variable(graph.path, name, editing.kind_name(var_type))
        return IVariable(graph, name)

    @OnEither
    def get_variable_default_value(self: Any, variable_id: Any) -> Any:
        found = ObjectLookup.variable(variable_id)
        return found._graph.ours.spec.variables[found.name].value

    @OnEither
    def set_variable_default_value(self: Any, variable_id: Any, value: Any) -> None:
        ObjectLookup.variable(variable_id).set(None, value)

    @OnEither
    def create_attribute(
        self: Any,
        node: Any,
        attr_name: str,
        attr_type: Any,
        attr_port: Any = AttributePortType.INPUT,
        attr_default: Any = None,
        attr_extended_type: Any = ExtendedAttributeType.REGULAR,
        undoable: bool = True,
    ) -> Any:
        extended = attr_extended_type[0] if isinstance(attr_extended_type, tuple) else attr_extended_type
        return editing.create_attribute(
            ObjectLookup.node(node), attr_name, attr_type, attr_port, attr_default, extended
        )

    @OnEither
    def remove_attribute(self: Any, attribute: Any, node: Any = None, *_: Any, **__: Any) -> bool:
        found = ObjectLookup.attribute(attribute, node)
        return editing.remove_attribute(found.get_node(), found.get_name())

    @OnEither
    def create_prim(
        self: Any,
        prim_path: Any,
        attribute_values: Mapping[str, Any] | None = None,
        prim_type: str | None = None,
        allow_exists: bool = False,
        *_: Any,
        **__: Any,
    ) -> Any:
        from graph.isaac.session import app

        stage, path = app().stage, str(_bare(prim_path))
        if (there := stage.GetPrimAtPath(path)) and not allow_exists:
            raise OmniGraphError(f"prim {path} already exists")
        from graph.isaac.og.prims import PrimPlan

        if there:
            return there
        plan = PrimPlan(present(), "")
        plan.add((path, dict(attribute_values or {}), prim_type or ""))
        return plan.apply()[0]

    @OnEither
    def expose_prim(self: Any, exposure_type: Any, prim_id: Any, node_path_id: Any, *_: Any, **__: Any) -> Any:
        graph, name = find.graph_and_name(present(), node_text(_bare(node_path_id)))
        entry = (exposure_type, ObjectLookup.prim_path(prim_id), name)
        OurController(graphs=present()).edit(graph, {Keys.EXPOSE_PRIMS: [entry]})
        return Node(present(), f"{graph.path}/{name}")

    @OnEither
    def connect(self: Any, src_spec: Any, dst_spec: Any, *_: Any, **__: Any) -> None:
        OurController(graphs=present()).connect(_end(self, src_spec), _end(self, dst_spec))

    @OnEither
    def disconnect(self: Any, src_spec: Any, dst_spec: Any, *_: Any, **__: Any) -> None:
        OurController(graphs=present()).disconnect(_end(self, src_spec), _end(self, dst_spec))

    @OnEither
    def disconnect_all(self: Any, attribute_spec: Any, *_: Any, **__: Any) -> None:
        found = ObjectLookup.attribute(attribute_spec)
        editing.disconnect_all(present(), found.path)

    @OnEither
    def evaluate_sync(self: Any, graph_id: Any = None) -> None:
        if graph_id is None:
            graph_id = getattr(self, "_graph_id", None)
        several = [_settings(one) for one in graph_id] if isinstance(graph_id, list) else _settings(graph_id)
        OurController(graphs=present()).evaluate_sync(several)

    @OnEither
    async def evaluate(self: Any, graph_id: Any = None) -> None:
        Controller.evaluate_sync(graph_id)

    @staticmethod
    def safe_node_name(node_type_name: str, abbreviated: bool = False) -> str:
        return (node_type_name.rpartition(".")[2] if abbreviated else node_type_name).replace(".", "_")


GraphController = NodeController = Controller


def find_listed(entries: Any) -> list[Any]:
    """The entries of one key."""
    return entries if isinstance(entries, list) else [entries]


def _bare(spec: Any) -> Any:
    """A name for the engine's look-ups: handles and prims as text."""
    if isinstance(spec, tuple):
        return tuple(_bare(one) for one in spec)
    if isinstance(spec, (Graph, Node, Attribute)):
        return spec.path
    if hasattr(spec, "GetPath") and not isinstance(spec, str):
        return str(spec.GetPath())
    return str(spec) if type(spec).__name__ == "Path" else spec


def _end(owner: Any, spec: Any) -> Any:
    bare = _bare(spec)
    graph = getattr(owner, "_graph_id", None)
    if isinstance(bare, str) and not bare.startswith("/") and graph is not None:
        return f"{find.graph_path(_settings(graph))}/{bare}"
    return bare


def _settings(graph_id: Any) -> Any:
    """A graph id with OmniGraph's enumerations in the words of `graph.isaac.og`."""
    if not isinstance(graph_id, Mapping):
        return _bare(graph_id)
    words = {}
    for key, value in graph_id.items():
        if key == "pipeline_stage":
            value = STAGES.get(value, value)
        elif key == "evaluation_mode":
            value = MODES.get(value, value)
        elif key == "graph_path":
            value = _bare(value)
        words[key] = value
    return words


def _commands(commands: Mapping[str, Any]) -> dict[str, Any]:
    """An edit without handles, prims and paths of other kinds."""
    return {key: _entry(value) for key, value in commands.items()}


def _entry(value: Any) -> Any:
    if type(value) in (str, float, int, bool):
        return value
    if isinstance(value, (list, tuple)):
        return type(value)(_entry(one) for one in value) if type(value) in (list, tuple) else value
    if isinstance(value, Mapping):
        return {key: _entry(one) for key, one in value.items()}
    if isinstance(value, NodeType):
        return value.id
    if isinstance(value, Type):
        return value.name
    return editing.plain(value)


def get_graph_by_path(path: Any) -> Graph | None:
    found: Graph | None = ObjectLookup.graph(path)
    return found


def get_node_by_path(path: Any) -> Node | None:
    return node_or_none(present(), str(_bare(path)))


def get_all_graphs() -> list[Graph]:
    graphs = present()
    return [Graph(graphs, path) for path in graphs.graphs]


def get_graphs_in_pipeline_stage(pipeline_stage: Any) -> list[Graph]:
    return [one for one in get_all_graphs() if one.get_pipeline_stage() == pipeline_stage]


def is_global_graph_prim(prim_path: str) -> bool:
    return get_graph_by_path(prim_path) is not None
