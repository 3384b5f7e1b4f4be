"""`Controller`: makes, changes, reads and evaluates graphs from Python, with the calls that OmniGraph scripts use.

(graph, nodes, prims, names) = Controller.edit(
    {"graph_path": "/World/G", "evaluator_name": "execution"},
    {
        Controller.Keys.CREATE_NODES: [("tick", "omni.graph.action.OnTick"), ("count", "omni.graph.action.Counter")],
        Controller.Keys.CONNECT: [("tick.outputs:tick", "count.inputs:execIn")],
    },
)
Controller.evaluate_sync(graph)
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from types import MethodType
from typing import Any, Concatenate, Generic, ParamSpec, TypeVar, overload

from graph.base.gc_pause import collector_paused
from graph.base.suggest import did_you_mean
from graph.editing.errors import OmniGraphError, OmniGraphValueError
from graph.editing.graph_set import GraphSet
from graph.editing.model import Model
from graph.evaluate import Graph, Node
from graph.evaluate.omnigraph_names import AttributeOf, Variable
from graph.node.registry import Registry
from graph.session.runner import graphs_of
from graph.spec.file_spec import GraphSpec

from . import find
from .edit import Edit, plain_value
from .evaluating import evaluate_all
from .handles import Compound
from .keys import GraphEvaluationMode, GraphPipelineStage, Keys, PrimExposureType, TypedValue
from .present import present_set
from .specs import new_spec

P = ParamSpec("P")
R = TypeVar("R")
UNGIVEN: Any = object()


class OnEither(Generic[P, R]):
    """A method of the class and of its instances; called on the class, it works on the present set of graphs."""

    def __init__(self, function: Callable[Concatenate[Any, P], R]) -> None:
        self._function = function
        self.__doc__ = function.__doc__

    def __get__(self, instance: Any, owner: type) -> Callable[P, R]:
        return MethodType(self._function, instance if instance is not None else owner())


class Controller:
    """Edits, reads and evaluates the graphs of the most recently entered App; without an App, those of this process.

    Every call works on the class and on an instance. An instance may be bound to an attribute (`Controller(attribute)`
    with `get`, `set`), to an App or to its own set of graphs.

    An edit is checked completely before it is applied: either it raises OmniGraphError with every problem and changes
    nothing, or it is done. It takes effect at the next evaluation of its graph. An edit that a node makes during the
    evaluation of the graph is checked at once and applied when that evaluation has ended. Nodes that stay keep their
    memory, state, outputs and sleep. Values (`set`) are set at once.

    >>> keys = Controller.Keys
    >>> graph, (add,), _, _ = Controller.edit(
    ...     "/World/Sum",
    ...     {
    ...         keys.CREATE_NODES: [("add", "omni.graph.nodes.Add")],
    ...         keys.SET_VALUES: [("add.inputs:a", 2.0, "double"), ("add.inputs:b", 3.0, "double")],
    ...     },
    ... )
    >>> Controller.evaluate_sync(graph)
    >>> Controller.get("outputs:sum", add)
    5.0
    >>> Controller.delete_graph(graph)
    """

    Keys = Keys
    PrimExposureType = PrimExposureType
    TypedValue = TypedValue
    GraphPipelineStage = GraphPipelineStage
    GraphEvaluationMode = GraphEvaluationMode

    def __init__(
        self,
        attribute: Any = None,
        *,
        app: Any = None,
        graphs: GraphSet | None = None,
        registry: Registry | None = None,
    ) -> None:
        """attribute: for `get` and `set`; app, graphs: whose graphs; registry: makes an own set of graphs of these
        types.
        """
        if graphs is None and registry is not None:
            graphs = GraphSet(registry=registry)
        self._set = graphs if graphs is not None else graphs_of(app) if app is not None else None
        self._attribute = attribute

    @property
    def graphs(self) -> GraphSet:
        """The graphs it works on."""
        return self._set if self._set is not None else present_set()

    # -- structure ---------------------------------------------------------------------------------------------------

    @OnEither
    def edit(
        self: Any, graph_id: Any, edit_commands: Mapping[str, Any] | None = None
    ) -> tuple[Graph, list[Any], list[Any], dict[str, Any]]:
        """Makes or changes a graph; returns the graph, the new nodes, the new prims, and the new nodes by short name.

        graph_id: the path of a graph (a missing one is made with the default settings, push), a Graph, the path of a
        compound's inside (`.../compound/Subgraph`), or a dict with graph_path, evaluator_name, pipeline_stage and
        evaluation_mode, which makes a new graph. edit_commands: lists by key, see `Keys`; a single entry may stand for
        a list of one. Raises OmniGraphError with every problem, or OmniGraphValueError if only values are wrong; then
        nothing has changed.
        """
        graphs: GraphSet = self.graphs
        with collector_paused():
            work, graph, prims = _edited(graphs, graph_id, {} if edit_commands is None else edit_commands)
        latest = graphs.latest(graph.path) or graph

        def made(name: str) -> Any:
            return latest.members.get(name) or Compound(graph, name)

        names = {short: made(name) for short, name in work.names.items()}
        return graph, [made(name) for name in work.created], prims, names

    @OnEither
    def create_graph(self: Any, graph_id: Any) -> Graph:
        """Makes a graph; `graph_id` as in `edit`. Raises OmniGraphError if the path is already a graph."""
        path = find.existing(self.graphs, graph_id)
        if path:
            raise OmniGraphError(f"graph {path} already exists")
        graph: Graph = self.edit(graph_id)[0]
        return graph

    @OnEither
    def delete_graph(self: Any, graph_id: Any) -> None:
        """Removes a graph and releases what its nodes hold."""
        self.graphs.remove(find.graph_path(graph_id))

    @OnEither
    def create_node(self: Any, node_id: Any, node_type_id: Any, allow_exists: bool = False) -> Any:
        """Makes a node; `node_id`: its path, or (name, graph). With `allow_exists` an existing one is returned."""
        graph, name = find.graph_and_name(self.graphs, node_id)
        there = graph.members.get(name)
        if there is not None and allow_exists:
            return there
        return self.edit(graph, {Keys.CREATE_NODES: [(name, node_type_id)]})[1][0]

    @OnEither
    def delete_node(self: Any, node_id: Any, graph_id: Any = None, ignore_if_missing: bool = False) -> bool:
        """Removes a node with its connections; False if it is missing and `ignore_if_missing`."""
        node = find.node(self.graphs, node_id, graph_id, missing=ignore_if_missing)
        if node is None:
            return False
        self.edit(node.graph, {Keys.DELETE_NODES: [node.path]})
        return True

    @OnEither
    def create_variable(self: Any, graph_id: Any, name: str, var_type: Any, value: Any = None) -> Variable:
        """Makes a variable of a graph."""
        graph = find.graph(self.graphs, graph_id)
        return Variable(self.edit(graph, {Keys.CREATE_VARIABLES: [(name, var_type, value)]})[0], name)

    @OnEither
    def create_attribute(self: Any, node_id: Any, attr_name: str, attr_type: Any) -> AttributeOf:
        """Adds an attribute to a node; a name without prefix is an input."""
        node = find.node(self.graphs, node_id)
        self.edit(node.graph, {Keys.CREATE_ATTRIBUTES: [(f"{node.path}.{attr_name}", attr_type)]})
        full = attr_name if attr_name.partition(":")[0] in ("inputs", "outputs", "state") else f"inputs:{attr_name}"
        return AttributeOf(node, full)

    @OnEither
    def connect(self: Any, src_spec: Any, dst_spec: Any) -> None:
        """Connects two attributes; an existing connection is not an error."""
        graph = find.graph_of_end(self.graphs, dst_spec)
        self.edit(graph, {Keys.CONNECT: [(src_spec, dst_spec)]})

    @OnEither
    def disconnect(self: Any, src_spec: Any, dst_spec: Any) -> None:
        """Removes a connection. Raises OmniGraphError if it does not exist."""
        graph = find.graph_of_end(self.graphs, dst_spec)
        self.edit(graph, {Keys.DISCONNECT: [(src_spec, dst_spec)]})

    # -- looking up --------------------------------------------------------------------------------------------------

    @OnEither
    def graph(self: Any, graph_id: Any) -> Graph:
        """The graph with that path. Raises OmniGraphError with the nearest one."""
        return find.graph(self.graphs, graph_id)

    @OnEither
    def node(self: Any, node_id: Any, graph_id: Any = None) -> Any:
        """The node with that path, of that name in a graph, or of (name, graph).

        Raises OmniGraphError if there is no such node.
        """
        return find.node(self.graphs, node_id, graph_id)

    @OnEither
    def attribute(self: Any, attribute_id: Any, node_id: Any = None, graph_id: Any = None) -> AttributeOf:
        """The attribute with that path, of that name on a node, or of (name, node).

        Raises OmniGraphError if it does not exist.
        """
        return find.attribute(self.graphs, attribute_id, node_id, graph_id)

    @OnEither
    def variable(self: Any, variable_id: Any, graph_id: Any = None) -> Variable:
        """The variable with that name in a graph, or of (graph, name)."""
        if isinstance(variable_id, tuple):
            graph_id, variable_id = variable_id
        graph = find.graph(self.graphs, graph_id)
        if variable_id not in graph.variables:
            near = did_you_mean(str(variable_id), graph.variables)
            raise OmniGraphError(f'graph {graph.path} has no variable "{variable_id}"{near}')
        return Variable(graph, str(variable_id))

    @OnEither
    def prim(self: Any, prim_id: Any) -> Any:
        """The prim with that path on the App's stage. Raises OmniGraphError if it does not exist."""
        from .names import node_text

        path = node_text(prim_id, "prim")
        app = self.graphs.app
        found = app.stage.GetPrimAtPath(path) if app is not None else None
        if not found:
            raise OmniGraphError(f"there is no prim {path}" + ("" if app is not None else "; there is no stage"))
        return found

    # -- values ------------------------------------------------------------------------------------------------------

    @OnEither
    def get(self: Any, attribute: Any = None, node: Any = None) -> Any:
        """The present value of an attribute (or variable); without argument, of the attribute of this Controller."""
        found = _value_of(self, attribute, node)
        if isinstance(found, AttributeOf) and found.full_name not in found.node.types:
            self.edit(found.node.graph, {Keys.CREATE_ATTRIBUTES: [(found, "any")]})  # for example a field of a message
        return found.get()

    @OnEither
    def set(self: Any, attribute: Any = UNGIVEN, value: Any = UNGIVEN, node: Any = None) -> None:
        """Sets the value of an attribute (or variable), now and for every start after a stop.

        `Controller(attribute).set(value)` takes the value alone. Raises OmniGraphValueError for a value that does not
        fit the type, is not allowed, or that a connection would overwrite.
        """
        if value is UNGIVEN:
            attribute, value = None, attribute
        if value is UNGIVEN:
            raise OmniGraphError("set needs a value")
        target = _value_of(self, attribute, node)
        if isinstance(target, AttributeOf) and (
            _may_wait(self.graphs, target, value) or target.node.types.get(target.full_name) is None
        ):
            self.edit(target.node.graph, {Keys.SET_VALUES: [(target, value)]})
            return
        try:
            target.set(_untyped(value))
        except ValueError as error:
            raise OmniGraphValueError(str(error)) from None

    # -- evaluating --------------------------------------------------------------------------------------------------

    @OnEither
    def evaluate_sync(self: Any, graph_id: Any = None) -> None:
        """Evaluates once a graph, several, or (without argument) every graph of the simulation stage.

        Raises OmniGraphError for graphs that do not exist and for those of the pre-render and post-render stages, which
        the renderer evaluates.
        """
        graphs: GraphSet = self.graphs
        chosen: Iterable[Any] | None = None
        if graph_id is not None:
            chosen = graph_id if isinstance(graph_id, (list, set)) else [graph_id]
        evaluate_all(graphs, None if chosen is None else [find.graph(graphs, one) for one in chosen])

    @OnEither
    async def evaluate(self: Any, graph_id: Any = None) -> None:
        """`evaluate_sync` as a coroutine."""
        self.evaluate_sync(graph_id)


def _edited(graphs: GraphSet, graph_id: Any, commands: Mapping[str, Any]) -> tuple[Edit, Graph, list[Any]]:
    path, scope = find.inside_compound(graphs, graph_id)
    path = path or find.existing(graphs, graph_id)
    work = Edit(graphs, graphs.model(path) if path else Model(new_spec(graphs, graph_id), graphs.registry))
    try:
        work.collect(commands, scope)
        return work, *work.apply()
    except BaseException:
        work.undo()
        raise


def _may_wait(graphs: GraphSet, target: AttributeOf, value: Any) -> bool:
    """Whether setting a value is an edit that may wait for others that do; a connected input is refused at once."""
    node, full = target.node, target.full_name
    if node.graph.stale is None or full.startswith("outputs:") or graphs.model(node.graph.path).is_fed(node.name, full):
        return False
    return not (type(value) is int and node.attribute(full).type == "bool")  # an edit takes 0 and 1


def _value_of(controller: Any, attribute: Any, node: Any) -> Any:
    chosen = attribute if attribute is not None else controller._attribute
    if chosen is None:
        raise OmniGraphError("name an attribute: Controller.get(attribute) or Controller(attribute).get()")
    return chosen if isinstance(chosen, Variable) else find.attribute(controller.graphs, chosen, node)


def _untyped(value: Any) -> Any:
    plain = plain_value(value)
    if isinstance(plain, dict) and set(plain) == {"type", "value"}:
        return plain["value"]
    return plain


@overload
def get_graph_by_path(path: str) -> Graph: ...
@overload
def get_graph_by_path(path: str, default: None) -> Graph | None: ...
def get_graph_by_path(path: str, default: Any = UNGIVEN) -> Graph | None:
    """The graph with that path, or `default`; without a default, raises OmniGraphError if it does not exist."""
    graph = present_set().graphs.get(path)
    if graph is None and default is UNGIVEN:
        return present_set().get(path)
    return graph


def get_node_by_path(path: str) -> Node:
    """The node with that path. Raises OmniGraphError if it does not exist."""
    node: Node = find.node(present_set(), path)
    return node


def get_registered_nodes() -> list[str]:
    """The ids of all registered node types."""
    return [one.id for one in present_set().registry.all()]


__all__ = [
    "Controller",
    "GraphSpec",
    "get_graph_by_path",
    "get_node_by_path",
    "get_registered_nodes",
]
