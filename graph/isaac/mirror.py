"""Graphs and their prims, both ways: a script's edit leaves OmniGraph prims, and edits of these prims change graphs.

Prims are written to the edit target right after each edit; edits of the stage are collected by USD's notice and applied
before the next update, and before the Controller reads. What the stage said last is kept for each graph, so that only
what a script has changed on the stage since then is applied. Neither way costs more in a larger graph, as long as no
compound, variable or setting of the graph changes on the stage.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

from graph.base.errors import Mark, UserError
from graph.session.runner import graphs_of
from graph.spec.file_spec import FileSpec, GraphSpec, NodeSpec

from .mirror_changes import Ends, State, edits, owner, same
from .mirror_writing import GraphPrims, plain_value
from .watched import tell_changed

if TYPE_CHECKING:
    from graph.editing.model import Model
    from graph.evaluate import Node

    from .managers.app import App

GRAPH_TYPES = ("OmniGraph", "OmniGraphNode")
BEFORE_ALL = -(1 << 28)


class Mirror:
    """The prims of one App's graphs."""

    def __init__(self, app: App) -> None:
        self._app, self._graphs = app, graphs_of(app)
        self._said: dict[str, State] = {}
        """What the stage said of each graph when it was last written or read."""
        self._lost: dict[str, set[str]] = {}
        """Paths of nodes that are not there, and of the nodes that they would feed."""
        self._dirty: dict[str, None] = {}
        """Paths of prims of nodes that have changed on the stage since the last `sync`."""
        self._changed = False
        """Whether more than such prims has changed."""
        self._kept: dict[str, set[str]] = {}
        """Names of the nodes of each graph that have changed since the physics was built; "" is the graph itself."""
        self._taking = False
        self._silence = _Silence(app)
        self._listener: Any = None
        self._graphs.edited = self._edited
        app.on("timeline_state", self.sync, BEFORE_ALL)
        app.on("stage_closing", self._end)
        app.on("stage_opened", self._begin)
        app.on("stop", self._put_back)
        app.on("close", self._end)
        self._begin()

    def _begin(self) -> None:
        from graph.sim.usd import Tf, Usd

        self._prims = GraphPrims(self._app.stage, self._graphs.registry)
        self._listener = Tf.Notice.Register(Usd.Notice.ObjectsChanged, self._noticed, self._app.stage)
        # Most scripts have no graph; reading loads what compiles them.
        has_graphs = any(str(prim.GetTypeName()) in GRAPH_TYPES for prim in self._app.stage.TraverseAll())
        self._forget()
        self._said = {path: state for path, (_, state) in self._read().items()} if has_graphs else {}

    def _forget(self) -> None:
        self._said, self._lost, self._dirty, self._kept, self._changed = {}, {}, {}, {}, False

    def _end(self) -> None:
        if self._listener is not None:
            self._listener.Revoke()
            self._listener = None
        self._forget()

    def _noticed(self, notice: Any, sender: Any) -> None:
        if self._silence.on or self._changed or self._app.fabric.muted:
            return
        for path in notice.GetChangedInfoOnlyPaths():
            self._note(path)
        for path in notice.GetResyncedPaths():
            self._note(path)

    def _note(self, path: Any) -> None:
        """Notes what has changed at a path of the stage: a node, more of a graph, or nothing of one."""
        prim = str(path.GetPrimPath())
        if self._home(prim) is not None:
            self._dirty[prim] = None
        else:
            below = any(f"{root}/".startswith(f"{prim.rstrip('/')}/") for root in self._said)
            self._changed = self._changed or below or self._has_graph(path)

    def _home(self, prim: str) -> str | None:
        """The graph whose node a prim is or may be."""
        while (prim := prim.rpartition("/")[0]) and prim not in self._said:
            pass
        return prim or None

    def _has_graph(self, path: Any) -> bool:
        """Whether a prim, or one below it if the prim is new, is part of a graph."""
        from graph.sim.usd import Usd

        prim = self._app.stage.GetPrimAtPath(path.GetPrimPath())
        if not prim:
            return False
        prims = Usd.PrimRange(prim) if path.IsPrimPath() else (prim,)
        return any(str(one.GetTypeName()) in GRAPH_TYPES for one in prims)

    # -- from graphs to prims ------------------------------------------------------------------------------------------

    def _edited(self, model: Model) -> None:
        """Writes what an edit has changed of a graph."""
        if not self._taking and self._listener is not None:
            self._write(model, [*model.touched, *model.removed] if model.path in self._said else list(model.nodes))

    def write(self, path: str) -> None:
        """Writes what has changed of a graph by other means than an edit; of one that is gone, removes the prims."""
        if self._graphs.latest(path) is None:
            said = self._said.pop(path, None)
            self._keep(path, ("", *(said.nodes if said is not None else ())))
            with self._silence:
                self._prims.remove(path)
            return
        model, said = self._graphs.model(path), self._said.get(path)
        names = [*model.nodes, *(said.nodes if said is not None else ())]
        self._write(model, list(dict.fromkeys(names)))

    def _write(self, model: Model, names: list[str]) -> None:
        path = model.path
        graph, said = self._graphs.latest(path), self._said.get(path)
        rest = replace(
            model.base,
            nodes=(),
            connections=(),
            variables=dict(model.variables),
            pipeline_stage=model.base.pipeline_stage if graph is None else graph.pipeline_stage,
        )
        if said is None:
            said = self._said[path] = State(GraphSpec(path), {}, {})
        elif _same_settings(said.rest, rest):
            rest = said.rest
        self._keep(path, names if rest is said.rest else (*names, ""))
        with self._silence:
            bad = self._prims.write(said, model, names, rest)
        for name in bad:
            self._app.warn("graph-not-on-stage", f"{path}/{name}", f'"{name}" cannot be the name of a prim')

    def set_value(self, node: Node, full: str) -> None:
        """Writes the value of one input or state attribute; one that an edit has set is written with the edit."""
        if node.graph.stale is not None:
            return None
        path, said = node.graph.path, self._said.get(node.graph.path)
        if said is None or node.name not in said.nodes:
            return self.write(path)
        value, type_ = plain_value(node.initial(full)), node.types.get(full)
        before = said.nodes[node.name].inputs.get(full.removeprefix("inputs:"))
        if before is not None and same(before, value):
            return None
        self._keep(path, (node.name,))
        with self._silence:
            self._prims.set(said, node.path, full, value, None if type_ is None else type_.name)
        return None

    def _keep(self, path: str, names: Iterable[str]) -> None:
        """Notes what a stop must write again; "" is the graph itself."""
        if self._app.simulation.built:
            self._kept.setdefault(path, set()).update(names)

    def _put_back(self) -> None:
        """A stop restores every layer, and graphs keep their edits: what was edited since play is written again."""
        self._changed, self._dirty = False, {}
        kept, self._kept = self._kept, {}
        for path, names in kept.items():
            said = self._said.pop(path, State(GraphSpec(path), {}, {}))
            if self._graphs.latest(path) is None:
                with self._silence:
                    self._prims.remove(path)
                continue
            self._said[path], model = said, self._graphs.model(path)
            if "" in names:
                said.rest = GraphSpec(path)
            gone = names - model.nodes.keys() - {""}
            for name in names:
                said.nodes.pop(name, None)
            said.nodes |= {name: NodeSpec(name, "") for name in gone}
            self._write(model, [*(name for name in model.nodes if name in names), *gone])

    # -- from prims to graphs ------------------------------------------------------------------------------------------

    def sync(self) -> None:
        """Applies what a script has changed on the prims of graphs since the last call."""
        if not (self._changed or self._dirty):
            return
        taking, self._taking = self._taking, True
        try:
            if not self._changed:
                self._take_nodes()
            if self._changed:
                self._take_all()
        finally:
            self._taking = taking

    def _take_nodes(self) -> None:
        """Applies what has changed of some nodes, without reading the rest of their graphs."""
        dirty, self._dirty = list(self._dirty), {}
        by_graph: dict[str, set[str]] = {}
        for prim in dirty:
            home = self._home(prim)
            assert home is not None
            by_graph.setdefault(home, set()).add(prim[len(home) + 1 :])
        for path, names in by_graph.items():
            said = self._said[path]
            if said.rest.compounds or not all(self._is_plain(said, path, name) for name in names):
                self._changed = True
                return
        for path, names in by_graph.items():
            self._take_some(path, names)

    def _is_plain(self, said: State, path: str, name: str) -> bool:
        """Whether what the stage has of a name is a node outside of compounds, or nothing."""
        from graph.usd_files.graph_prims import is_plain_node

        prim = self._app.stage.GetPrimAtPath(f"{path}/{name}")
        if prim and prim.IsActive() and prim.IsDefined():
            return is_plain_node(prim) and ("/" not in name or name in said.nodes)
        return name in said.nodes

    def _take_some(self, path: str, names: set[str]) -> None:
        from graph.usd_files.specs import node_and_links

        said, stage = self._said[path], self._app.stage
        before, now = said.part(names), State(said.rest, {}, {})
        for name in names:
            prim = stage.GetPrimAtPath(f"{path}/{name}")
            if not (prim and prim.IsActive() and prim.IsDefined()):
                said.nodes.pop(name, None)
                continue
            said.nodes[name], links = node_and_links(prim, path, name, _mark, self._app.warn)
            now.nodes[name] = said.nodes[name]
            now.links[name] = links
        for name in before.nodes.keys() - now.nodes.keys():
            self._lose(said, name)
        for name, links in now.links.items():
            said.links[name] = now.links[name] = self._found(said, name, links)
        for name in now.nodes.keys() - before.nodes.keys():
            for waiting in self._lost.pop(f"{path}/{name}", ()):
                self._dirty[waiting] = None
        self._apply(path, before, now)
        self._keep(path, names)
        if self._dirty:
            self._take_nodes()

    def _lose(self, said: State, gone: str) -> None:
        """Removes the links from a node that is gone; they count again when it is back."""
        said.links.pop(gone, None)
        for name, links in said.links.items():
            if any(owner(source) == gone for source, _ in links):
                said.links[name] = {ends: None for ends in links if owner(ends[0]) != gone}
                self._lost.setdefault(f"{said.rest.path}/{gone}", set()).add(f"{said.rest.path}/{name}")

    def _found(self, said: State, name: str, links: dict[Ends, None]) -> dict[Ends, None]:
        """The links whose source is there."""
        path, found = said.rest.path, dict[Ends, None]()
        for source, target in links:
            node = owner(source)
            if source.startswith("/") or node in said.nodes:
                found[source, target] = None
            else:
                self._lost.setdefault(f"{path}/{node}", set()).add(f"{path}/{name}")
                message = f"{path}/{target} is fed by {path}/{source}, but that is not a node of a graph"
                self._app.warn("usd-lost-connection", f"{path}/{target}", message)
        return found

    def _take_all(self) -> None:
        self._changed, self._dirty, self._lost = False, {}, {}
        now = self._read()
        for path in [path for path in self._said if path not in now]:
            self._keep(path, ("", *self._said.pop(path).nodes))
            if self._graphs.latest(path) is not None:
                self._attempt(path, partial(self._graphs.remove, path))
        for path, (spec, state) in now.items():
            before, self._said[path] = self._said.get(path), state
            self._keep(path, state.nodes)
            if self._graphs.latest(path) is None:
                self._attempt(path, partial(self._graphs.apply, [replace(spec, unfinished=True)], {}))
            elif before is not None:
                self._apply(path, before, state)

    def _apply(self, path: str, before: State, now: State) -> None:
        from graph.isaac.og import Controller, Keys

        self._set_variables(path, before.rest, now.rest)
        controller = Controller(graphs=self._graphs)

        def assign(end: str, value: Any) -> None:
            controller.set(end, value)
            tell_changed(self._graphs, end)

        for commands in edits(before, now, self._prims.default):
            for end, value in commands.pop(Keys.SET_VALUES, ()):  # without compiling the graph
                self._attempt(path, partial(assign, f"{path}/{end}", value))
            if commands:
                self._attempt(path, partial(controller.edit, path, commands))

    def _set_variables(self, path: str, before: GraphSpec, now: GraphSpec) -> None:
        """Gives variables the values that they have on the stage now: at present, and at each start."""
        was = before.variables
        new = {name: one for name, one in now.variables.items() if name in was and not same(was[name].value, one.value)}
        if not new:
            return
        spec = self._graphs.current_spec(path)
        values = {
            name: replace(one, value=new[name].value) if name in new else one for name, one in spec.variables.items()
        }
        self._attempt(path, partial(self._graphs.apply, [replace(spec, variables=values)], {}))
        graph = self._graphs.get(path)
        for name, one in new.items():
            if one.value is not None and name in graph.variables:
                graph.variables[name] = one.value

    def _attempt(self, path: str, action: Any) -> None:
        try:
            action()
        except UserError as error:
            self._app.warn("stage-edit-refused", path, "; ".join(str(one.message) for one in error.problems))

    def _read(self) -> dict[str, tuple[GraphSpec, State]]:
        from graph.spec.migration import migrate
        from graph.usd_files.graph_prims import read_graphs
        from graph.usd_files.specs import graph_specs, links_of

        def tell(code: str, place: str, message: str) -> None:
            self._app.warn(code, place, message)

        raw = read_graphs(self._app.stage, tell)
        links = links_of(raw)
        specs = migrate(FileSpec(graphs=graph_specs(raw, _mark, tell))).graphs
        return {
            one.path: (one, State(replace(one, nodes=(), connections=()), {n.name: n for n in one.nodes}, each))
            for one, each in zip(specs, links, strict=True)
        }


class _Silence:
    """While it is entered, neither the mirror nor the world takes a change of the stage for an edit of the script's."""

    def __init__(self, app: App) -> None:
        self._app, self._before = app, list[bool]()
        self.on = False

    def __enter__(self) -> None:
        fabric = self._app.fabric
        self._before.append(fabric.muted)
        self.on = fabric.muted = True

    def __exit__(self, *_: object) -> None:
        self._app.fabric.muted = self._before.pop()
        self.on = bool(self._before)


def _same_settings(before: GraphSpec, now: GraphSpec) -> bool:
    names = ("evaluator", "pipeline_stage", "evaluation_mode", "saved")
    return all(getattr(before, name) == getattr(now, name) for name in names) and same(before.variables, now.variables)


def _mark(place: str) -> Mark:
    return Mark(place, 0, 0)
