"""One edit: its entries are applied to models of the graphs, which are then compiled and applied as a whole."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from graph.base.errors import Mark, Problem, UserError
from graph.base.paths import at_or_below
from graph.base.suggest import did_you_mean
from graph.editing.errors import OmniGraphError, OmniGraphValueError
from graph.editing.graph_set import GraphSet
from graph.editing.model import PREFIXES, SUBGRAPH, EditPlace, Model, NodeModel
from graph.evaluate import Graph, Node
from graph.node.declaration import NodeType
from graph.node.registry import UnknownNodeTypeError
from graph.spec.file_spec import VariableSpec
from graph.spec.migration import migrated_type
from graph.values.coercion import shown
from graph.values.types import concrete_type

from .edit_names import EditNames, ToldError
from .keys import FORMS, ORDER, PrimExposureType, TypedValue
from .names import end_text, listed, node_text
from .prims import PrimPlan

COMPOUND = "omni.graph.nodes.CompoundSubgraph"


class Edit:
    """Collects what one call of `Controller.edit` changes. Nothing is changed before `apply`."""

    def __init__(self, graphs: GraphSet, model: Model) -> None:
        """model: of the graph to edit."""
        self._graphs = graphs
        self._main = model
        self._names = EditNames(graphs, model)
        self._problems: list[Problem] = []
        self._value_marks: set[Mark] = set()
        self._prims = PrimPlan(graphs, model.path)
        self.created: list[str] = []
        """Names of new nodes in this graph, compounds included, in order."""
        self.names = self._names.short
        """Name in this graph by short name."""

    def collect(self, operations: Mapping[str, Any], scope: str = "") -> None:
        """Applies all entries to the models; `scope` is the prefix of the names inside a compound."""
        if not isinstance(operations, Mapping):
            raise OmniGraphError(
                f"{shown(operations)} is not an edit; write a dict, of lists by key: {', '.join(ORDER)}"
            )
        unknown = [key for key in operations if key not in ORDER]
        for key in unknown:
            self._problems.append(Problem(f'"{key}" is not a key of an edit{did_you_mean(str(key), ORDER)}'))
        for key in ORDER:
            if key not in operations:
                continue
            work: Callable[[Any, str, Mark], None] = getattr(self, f"_{key}")
            for position, entry in enumerate(listed(operations[key])):
                mark = EditPlace(f"{self._main.path} {scope}{key.upper()}[{position}]", 0, 0)
                try:
                    work(entry, scope, mark)
                except ToldError:
                    continue
                except UserError as error:
                    self._problems += [Problem(one.message, one.mark or mark) for one in error.problems]
                except (TypeError, ValueError):
                    message = f"{shown(entry)} is not an entry of {key.upper()}; write {FORMS[key]}"
                    self._problems.append(Problem(message, mark))

    def apply(self) -> tuple[Graph, list[Any]]:
        """Makes the edit; returns the graph and the prims. Raises OmniGraphError, with nothing changed."""
        models, alone = self._names.models, len(self._names.models) == 1
        done = alone and not self._problems and self._graphs.defer(self._main)
        applied = {} if done else self._compile()
        for model in models.values():
            self._graphs.accept(model, applied.get(model.path))
        graph = applied.get(self._main.path) or self._graphs.get(self._main.path)
        self._warn()
        return graph, self._prims.apply()

    def _compile(self) -> dict[str, Graph]:
        models = self._names.models
        for path in list(models):
            for other in self._graphs.linked_with(path):
                self._names.model(other)
        specs = [model.spec() for model in models.values()]
        if self._problems:
            self._problems += self._graphs.problems(specs)  # of the entries that were applied
            self._raise_problems()
        touched = {path: [*model.touched] for path, model in models.items()}
        try:
            return self._graphs.apply(specs, touched)
        except UserError as error:
            self._problems += error.problems
            self._raise_problems()
            raise

    def undo(self) -> None:
        """Takes back what was collected."""
        for model in self._names.models.values():
            model.undo()

    def _warn(self) -> None:
        for note in self._names.notes:
            self._graphs.context.warn(*note)

    def _raise_problems(self) -> None:
        if not self._problems:
            return
        only_values = all(one.mark in self._value_marks for one in self._problems)
        raise (OmniGraphValueError if only_values else OmniGraphError)(self._problems)

    # -- the keys ----------------------------------------------------------------------------------------------------

    def _delete_nodes(self, entry: Any, scope: str, mark: Mark) -> None:
        model, name = self._names.known_name(node_text(entry), scope)
        inside = [one for one in model.nodes if at_or_below(one, name)]
        gone = {f"{model.path}{separator}{one}" for separator in "/." for one in inside}
        for other in self._graphs.linked_with(model.path):
            self._names.model(other).drop(gone)
        model.remove_node(name)

    def _create_nodes(self, entry: Any, scope: str, mark: Mark) -> None:
        written, kind = entry
        name = self._names.new_name(written, scope)
        short = name.removeprefix(scope)
        if name in self._main.nodes or name in self._main.compounds:
            raise OmniGraphError(f'node "{name}" already exists in graph {self._main.path}; choose another name')
        if isinstance(kind, Mapping) or kind == COMPOUND:
            self._main.others = True
            self._main.compounds[name] = {}
            self._note_created(short, name)
            self.collect(kind if isinstance(kind, Mapping) else {}, f"{name}/{SUBGRAPH}/")
            return
        type_id = kind.id if isinstance(kind, NodeType) else str(kind)
        if type_id not in self._graphs.registry:
            type_id = migrated_type(type_id, self._graphs.registry)[0]
        try:
            self._graphs.registry.get(type_id)
        except UnknownNodeTypeError as error:
            self._names.broken.add(name)
            raise OmniGraphError(f'node "{name}": {error}') from None
        self._main.nodes[name] = NodeModel(type_id, mark=mark)
        self._main.touched[name] = None
        self._note_created(short, name)

    def _note_created(self, short: str, name: str) -> None:
        self.created.append(name)
        self.names.setdefault(short, name)

    def _create_prims(self, entry: Any, scope: str, mark: Mark) -> None:
        self._prims.add(entry)

    def _create_attributes(self, entry: Any, scope: str, mark: Mark) -> None:
        written, type_ = entry
        owner, _, attribute = end_text(written).rpartition(".")
        model, name = self._names.known_name(owner, scope)
        full = attribute if attribute.partition(":")[0] in PREFIXES else f"inputs:{attribute}"
        if name in model.compounds:
            raise OmniGraphError(f"{owner} is a compound; make its ports with PROMOTE_ATTRIBUTES")
        node = model.nodes[name]
        declared = self._declared(node, full)
        if declared or full in node.attributes:
            raise OmniGraphError(f"{owner}.{full} already exists")
        node = model.change(name)
        node.attributes[full] = type_name(type_)
        model.others = True

    def _flag(self, node: NodeModel, full: str, value: Any) -> Any:
        """0 and 1 as False and True if the attribute is a bool, as OmniGraph does."""
        if type(value) is not int or value not in (0, 1):
            return value
        prefix, _, name = full.partition(":")
        declared = self._graphs.registry.get(node.type).find(prefix, name) if prefix in PREFIXES else None
        return bool(value) if declared is not None and declared.type == "bool" else value

    def _declared(self, node: NodeModel, full: str) -> bool:
        prefix, _, name = full.partition(":")
        try:
            return name in getattr(self._graphs.registry.get(node.type), prefix)
        except UnknownNodeTypeError:
            return False

    def _create_variables(self, entry: Any, scope: str, mark: Mark) -> None:
        name, kind, *value = entry
        if name in self._main.variables:
            raise OmniGraphError(f'variable "{name}" already exists in graph {self._main.path}')
        self._main.others = True
        given = value[0] if value else None
        if isinstance(given, TypedValue):
            given = given.value
        self._main.variables[str(name)] = VariableSpec(type_name(kind), given, mark)

    def _expose_prims(self, entry: Any, scope: str, mark: Mark) -> None:
        kind, prim, name = entry
        known = {getattr(PrimExposureType, one): one for one in vars(PrimExposureType) if one.isupper()}
        if kind not in known:
            raise OmniGraphError(f"{shown(kind)} is not one of {', '.join(known.values())} of PrimExposureType")
        self._create_nodes((name, kind), scope, mark)
        full = self._names.new_name(name, scope)
        self._main.nodes[full].inputs["inputs:prim"] = [node_text(prim, "prim")]
        self._main.nodes[full].marks["inputs:prim"] = mark

    def _promote_attributes(self, entry: Any, scope: str, mark: Mark) -> None:
        inner, name = entry
        if not scope:
            raise OmniGraphError("PROMOTE_ATTRIBUTES stands inside the dict of a compound in CREATE_NODES")
        compound = scope.removesuffix(f"/{SUBGRAPH}/")
        ends = self._names.ends(inner, scope, "target")
        prefix = ends[0][2].partition(":")[0]
        if not all(node.startswith(scope) for _, node, _ in ends):
            raise OmniGraphError(f"{end_text(inner)} is not inside the compound {compound}")
        port = str(name) if str(name).partition(":")[0] in PREFIXES else f"{prefix}:{name}"
        if port.partition(":")[0] != prefix:
            raise OmniGraphError(f"{end_text(inner)} is one of {prefix}; it cannot be promoted to {port}")
        ports = self._main.compounds[compound]
        if port in ports and prefix == "outputs":
            raise OmniGraphError(f"the compound {compound} has a port {port} already")
        self._main.others = True
        ports[port] = (*ports.get(port, ()), *(f"{node}.{full}" for _, node, full in ends))

    def _disconnect(self, entry: Any, scope: str, mark: Mark) -> None:
        for source, target in self._pairs(entry, scope):
            for model in self._names.models.values():
                ends = _seen_from(model, source), _seen_from(model, target)
                if model.disconnect(ends):
                    target[0].touched[target[1]] = None
                    break
            else:
                raise OmniGraphError(f"{_shown(source)} and {_shown(target)} are not connected")

    def _connect(self, entry: Any, scope: str, mark: Mark) -> None:
        for source, target in self._pairs(entry, scope):
            model = target[0]
            ends = _seen_from(model, source), _seen_from(model, target)
            if ends not in model.connections:
                model.connect(ends, mark)

    def _pairs(self, entry: Any, scope: str) -> list[tuple[tuple[Model, str, str], tuple[Model, str, str]]]:
        if not isinstance(entry, Sequence) or isinstance(entry, str) or len(entry) != 2:
            raise OmniGraphError(f"{shown(entry)} is not a connection; write (source, destination)")
        sources = self._names.present_ends(entry[0], scope, "source")
        targets = self._names.present_ends(entry[1], scope, "target")
        return [(source, target) for source in sources[:1] for target in targets]

    def _set_values(self, entry: Any, scope: str, mark: Mark) -> None:
        written, value, *kind = entry
        self._value_marks.add(mark)
        for model, name, full in self._names.present_ends(written, scope, "target"):
            node = model.change(name)
            bare = full.partition(":")[2]
            if full.startswith("inputs:") and bare in node.inputs:
                del node.inputs[bare]
                node.marks.pop(bare, None)
            node.inputs[full] = self._flag(node, full, plain_value(value, kind[0] if kind else None))
            node.marks[full] = mark


def _seen_from(model: Model, end: tuple[Model, str, str]) -> str:
    owner, name, full = end
    return f"{name}.{full}" if owner is model else f"{owner.path}/{name}.{full}"


def _shown(end: tuple[Model, str, str]) -> str:
    return f"{end[0].path}/{end[1]}.{end[2]}"


def type_name(kind: Any) -> str:
    """The OGN name of a type given as text or as a `Type`. Raises OmniGraphError for an unknown one."""
    text = str(getattr(kind, "name", kind))
    if text != "any":
        try:
            concrete_type(text)
        except ValueError as error:
            raise OmniGraphError(str(error)) from None
    return text


def plain_value(value: Any, kind: Any = None) -> Any:
    """The value as a spec holds it: with its type if one is given; nodes and paths as text."""
    if isinstance(value, TypedValue):
        value, kind = value.value, value.type
    if kind is not None:
        return {"type": type_name(kind), "value": plain_value(value)}
    if isinstance(value, (Node, Graph)):
        return value.path
    if type(value).__name__ == "Path":  # Sdf.Path; a pathlib path is not a value
        return str(value)
    if isinstance(value, list) and any(type(one).__name__ in ("Path", "Node") for one in value):
        return [plain_value(one) for one in value]
    return value
