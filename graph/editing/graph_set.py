"""A set of graphs that are evaluated together: those of one App, or those of a script without a world."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING, Any
from weakref import WeakKeyDictionary

from graph.base.errors import Problem, UserError
from graph.base.suggest import did_you_mean
from graph.evaluate import Graph, Node
from graph.node.context import Context
from graph.node.registry import DEFAULT, Registry
from graph.plan import compile_graphs
from graph.spec.file_spec import GraphSpec

from .errors import OmniGraphError

if TYPE_CHECKING:
    from .model import Model

# What only edits need is imported by the first edit: most runs, and every check, make none.


class GraphSet:
    """Graphs by path, in the order in which they were added, and the context in which they are evaluated.

    Without an App the set has its own clock: every evaluation on request is one playing update at 60 Hz.
    """

    def __init__(
        self,
        graphs: dict[str, Graph] | None = None,
        *,
        context: Context | None = None,
        app: Any = None,
        registry: Registry = DEFAULT,
        prepare: Callable[[Graph], None] | None = None,
    ) -> None:
        """prepare: called with every graph that an edit makes."""
        self.graphs: dict[str, Graph] = {} if graphs is None else graphs
        self.context = Context.standalone() if context is None else context
        self.app = app
        self.registry = registry
        self._prepare = prepare
        self.edited: Callable[[Model], None] | None = None
        """Called after every edit with what it has edited."""
        self._waiting: dict[str, Graph] = {}
        self._models: dict[str, Model] = {}
        """What edits change, by path."""
        self._touched: dict[str, set[str]] = {}
        """The nodes that edits concern that are not applied yet, by path."""

    def close(self) -> None:
        """Removes the references between the set and its App, so that a closed App is freed with its last reference."""
        self.app = self.context.app = self._prepare = self.edited = None

    def latest(self, path: str) -> Graph | None:
        """The graph with that path as last edited; edits made while it runs are included."""
        return self._waiting.get(path) or self.graphs.get(path)

    def get(self, path: str) -> Graph:
        """The graph with that path. Raises OmniGraphError with the nearest one."""
        graph = self.graphs.get(path) or self._waiting.get(path)
        if graph is None:
            raise OmniGraphError(f'there is no graph "{path}"{did_you_mean(path, self.graphs)}')
        return graph

    def owner_of(self, node_path: str) -> Graph | None:
        """The graph, as last edited, to which the path of a node belongs."""
        parent = node_path.rpartition("/")[0]
        while parent:
            graph = self.latest(parent)
            if graph is not None:
                return graph
            parent = parent.rpartition("/")[0]
        return None

    def linked_with(self, path: str) -> list[str]:
        """The graphs that exchange data with a graph, directly or through others; the graph itself is first."""
        found = [path]
        for one in found:
            graph = self.latest(one)
            found += sorted((graph.linked if graph else set()) - set(found))
        return found

    def current_spec(self, path: str) -> GraphSpec:
        """The spec to compile a graph from now: its spec with all edits and the values that were set since."""
        graph = self.latest(path)
        assert graph is not None
        return self.model(path).spec() if graph.written or graph.stale else graph.compiled_spec

    def model(self, path: str) -> Model:
        """A graph in the form that edits change, kept from one edit to the next."""
        from .model import Model

        graph = self.latest(path)
        assert graph is not None
        model = self._models.get(path)
        if model is None or model.base is not graph.compiled_spec:
            model = self._models[path] = Model(graph.compiled_spec, self.registry)
        model.take_values(graph)
        model.begin()
        return model

    def defer(self, model: Model) -> bool:
        """Makes an edit that is compiled at the next evaluation or read; False if it must be compiled at once."""
        graph = self.graphs.get(model.path)
        if graph is None or self._waiting or graph.running or graph.linked or graph.instances or _may_retype(graph):
            return False
        part = model.part()
        if part is None:
            return False
        if model.check is None:
            from graph.plan.edit_check import EditCheck

            model.check = EditCheck(graph, self.registry)
        drafts = model.check.accepts(part)
        if drafts is None:
            return False
        for name in model.removed:
            model.check.forget(name)
            graph.drop(name)
        if drafts or model.removed:
            present = [draft.node for draft in drafts if draft.node.name in model.nodes]
            graph.outdate([graph.members.setdefault(node.name, node) for node in present], self._compile_edits)
            self._touched.setdefault(model.path, set()).update(model.touched)
        graph.written.clear()  # the model contains them
        return True

    def accept(self, model: Model, compiled: Graph | None) -> None:
        """Ends an edit that was made; compiled: its graph if it was not deferred."""
        path = model.path
        graph = self.graphs[path] if compiled is None else compiled
        model.forget_marks()
        for name in model.touched.keys() & graph.members.keys():
            graph.members[name].mark = model.nodes[name].mark
        if compiled is not None:
            self._models[path] = model
            model.base = compiled.compiled_spec = model.spec()
            model.check = None
        if self.edited is not None:
            self.edited(model)

    def _compile_edits(self, path: str) -> None:
        graph, spec, check = self.graphs[path], self.current_spec(path), self._models[path].check
        touched, kept = self._touched[path], {}
        stale = graph.refresh()
        if check is not None and check.exact and not _may_retype(graph):
            kept = {node.path: node for name, node in graph.members.items() if name not in touched}
        try:
            self.apply([spec], {}, kept)
        except BaseException:
            graph.outdate(stale, self._compile_edits)
            raise
        self._models[path].base, self._models[path].check = graph.compiled_spec, None

    def problems(self, specs: Iterable[GraphSpec]) -> Sequence[Problem]:
        """What is wrong with the graphs of these specs; changes nothing."""
        try:
            compile_graphs(list(specs), self.registry)
        except UserError as error:
            return error.problems
        return ()

    def apply(
        self,
        specs: Iterable[GraphSpec],
        touched: Mapping[str, Collection[str]],
        kept: Mapping[str, Node] | None = None,
    ) -> dict[str, Graph]:
        """Compiles the specs and applies them to the graphs with these paths; creates those that do not exist yet.

        The change happens at once, or after the running evaluations have ended. `touched` names the nodes that the edit
        concerns; kept: as in `compile_graphs`. Returns the graphs as they are or will be. Raises UserError, with
        nothing changed, if one is wrong.
        """
        fresh = {graph.path: graph for graph in compile_graphs(list(specs), self.registry, kept)}
        waiting = any(path in self._waiting or self._runs(path) for path in fresh)
        into = {path: graph for path in fresh if (graph := self.latest(path)) is not None}
        if not waiting:
            self._take(into, fresh, touched)
            return {path: self.graphs[path] for path in fresh}
        from graph.evaluate.adopt import adopt

        adopt({path: self._waiting[path] for path in fresh if path in self._waiting}, fresh, touched)
        for path, graph in fresh.items():
            if path in self.graphs:
                self.graphs[path].written.clear()  # the specs contain them; later values come on top
            self._waiting.setdefault(path, graph)
            self._touched.setdefault(path, set()).update(touched.get(path, ()))
        for path in fresh:
            if self._runs(path):
                self.graphs[path].when_idle(self._settle)
        return {path: self._waiting[path] for path in fresh}

    def node(self, path: str) -> Node | None:
        """The node with that path: the running one, else one that will be added."""
        for graphs in (self.graphs, self._waiting):
            parent = path.rpartition("/")[0]
            while parent:
                name = path[len(parent) + 1 :]
                if parent in graphs and name in graphs[parent].members:
                    return graphs[parent].members[name]
                parent = parent.rpartition("/")[0]
        return None

    def remove(self, path: str) -> None:
        """Removes a graph and releases what its nodes hold.

        Raises OmniGraphError if it is running or does not exist.
        """
        graph = self.get(path)
        if graph.running:
            raise OmniGraphError(f"graph {path} is being evaluated; delete it afterwards")
        if graph.linked:
            raise OmniGraphError(
                f"graph {path} exchanges data with {', '.join(sorted(graph.linked))}; disconnect it first"
            )
        self.graphs.pop(path, None)
        self._waiting.pop(path, None)
        self._models.pop(path, None)
        if self.app is not None:
            self.app.graphs.pop(path, None)
        graph.close()

    def add(self, graph: Graph) -> None:
        """Adds a compiled graph."""
        self._take({}, {graph.path: graph}, {})

    def clear(self) -> None:
        """Removes every graph."""
        gone = {**self.graphs, **self._waiting}
        for known in (self.graphs, self._waiting, self._models):
            known.clear()
        if self.app is not None:
            self.app.graphs.clear()
        for graph in gone.values():
            graph.close()

    def _runs(self, path: str) -> bool:
        return path in self.graphs and self.graphs[path].running

    def _settle(self) -> None:
        if any(self._runs(path) for path in self._waiting):
            return
        waiting, self._waiting = self._waiting, {}
        there = {path: self.graphs[path] for path in waiting if path in self.graphs}
        written = {path: dict(graph.written) for path, graph in there.items()}
        self._take(there, waiting, {})
        for path, values in written.items():
            for (name, full), value in values.items():
                with suppress(KeyError, ValueError):  # the edit removed or connected it
                    there[path].nodes[name].set(full, value)

    def _take(
        self, into: Mapping[str, Graph], fresh: Mapping[str, Graph], touched: Mapping[str, Collection[str]]
    ) -> None:
        from graph.evaluate.adopt import adopt

        adopt(into, fresh, {path: {*touched.get(path, ()), *self._touched.pop(path, ())} for path in fresh})
        for path, graph in fresh.items():
            if path not in into:
                graph.context = self.context
                if self._prepare is not None:
                    self._prepare(graph)
                self.graphs[path] = graph
                if self.app is not None:
                    self.app.graphs[path] = graph


def _may_retype(graph: Graph) -> bool:
    """Whether types may follow from values that were set since the graph was compiled."""
    return any(graph.members[name].type.resolve is not None for name, _ in graph.written)


_OF_APP: WeakKeyDictionary[Any, GraphSet] = WeakKeyDictionary()


def bound_to(app: Any) -> GraphSet | None:
    """The set in which an App's graphs are edited; None before one was bound."""
    return _OF_APP.get(app)


def bind(app: Any, graphs: GraphSet) -> None:
    """Makes a set the one in which an App's graphs are edited."""
    _OF_APP[app] = graphs


def unbind(app: Any, graphs: GraphSet) -> None:
    """Removes the entry of a closed App, so that it can be freed; only if the App is bound to this set."""
    if _OF_APP.get(app) is graphs:
        del _OF_APP[app]
