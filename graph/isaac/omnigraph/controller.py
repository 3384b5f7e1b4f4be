"""`og.Controller` and its parts, with OmniGraph's arguments and results."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from typing import Any

from graph.evaluate.omnigraph_names import AttributeOf
from graph.isaac.og import Controller as OurController
from graph.isaac.og import Keys as OurKeys
from graph.isaac.og import OmniGraphError, TypedValue, find
from graph.isaac.og.controller import OnEither
from graph.isaac.og.keys import PrimExposureType
from graph.isaac.og.names import node_text

from . import editing
from .attributes import Attribute
from .enums import AttributePortType, ExtendedAttributeType, GraphPipelineStage
from .graph_parts import IVariable
from .handles import MODES, STAGES, Graph, Node, create_attribute, remove_attribute
from .lookup import ObjectLookup, bare, present
from .node_type import NodeType
from .partial_edits import one_by_one, split_existing
from .types import Type

_UNGIVEN: Any = object()


class Keys(OurKeys):
    DISCONNECT_ALL = "disconnect_all"


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
    found.get(bare(chosen), bare(node))  # makes a dynamic attribute, or says what is wrong
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
        there = split_existing(
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
                one_by_one(editor, target, commands)
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
        editing.follow(find.graph_path(_settings(graph_id)))

    @OnEither
    def create_node(self: Any, node_id: Any, node_type_id: Any, allow_exists: bool = False, *_: Any, **__: Any) -> Any:
        kind = str(getattr(node_type_id, "id", node_type_id))
        made = OurController(graphs=present()).create_node(bare(node_id), kind, allow_exists)
        return Node(present(), made.path)

    @OnEither
    def delete_node(
        self: Any, node_id: Any, graph_id: Any = None, ignore_if_missing: bool = False, *_: Any, **__: Any
    ) -> bool:
        if isinstance(node_id, list):
            each = [Controller.delete_node(one, graph_id, ignore_if_missing) for one in node_id]
            return all(each)
        return OurController(graphs=present()).delete_node(bare(node_id), bare(graph_id), ignore_if_missing)

    @OnEither
    def create_variable(
        self: Any, graph_id: Any, name: str, var_type: Any, allow_exists: bool = False, *_: Any, **__: Any
    ) -> Any:
        graph = Graph(present(), find.graph_path(bare(graph_id)))
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
        return create_attribute(ObjectLookup.node(node), attr_name, attr_type, attr_port, attr_default, extended)

    @OnEither
    def remove_attribute(self: Any, attribute: Any, node: Any = None, *_: Any, **__: Any) -> bool:
        found = ObjectLookup.attribute(attribute, node)
        return remove_attribute(found.get_node(), found.get_name())

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

        stage, path = app().stage, str(bare(prim_path))
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
        graph, name = find.graph_and_name(present(), node_text(bare(node_path_id)))
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


def _end(owner: Any, spec: Any) -> Any:
    text = bare(spec)
    graph = getattr(owner, "_graph_id", None)
    if isinstance(text, str) and not text.startswith("/") and graph is not None:
        return f"{find.graph_path(_settings(graph))}/{text}"
    return text


def _settings(graph_id: Any) -> Any:
    """A graph id with OmniGraph's enumerations in the words of `graph.isaac.og`."""
    if not isinstance(graph_id, Mapping):
        return bare(graph_id)
    words = {}
    for key, value in graph_id.items():
        if key == "pipeline_stage":
            value = STAGES.get(value, value)
        elif key == "evaluation_mode":
            value = MODES.get(value, value)
        elif key == "graph_path":
            value = bare(value)
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
