"""Graphs and their prims, both ways: a script's edit leaves OmniGraph prims, and edits of these prims change graphs.

Prims are written to the edit target right after each edit; edits of the stage are collected by USD's notice and applied
before the next update, and before the Controller reads. What the stage said last is kept for each graph, so that only
what a script has changed on the stage since then is applied.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from graph.base.errors import Mark, UserError
from graph.session.runner import graphs_of
from graph.spec.file_spec import ConnectionSpec, FileSpec, GraphSpec

from .mirror_changes import Change, State, change_of, edits, owner, set_values, with_short_names

if TYPE_CHECKING:
    from graph.evaluate import Node
    from graph.sim import App

GRAPH_TYPES = ("OmniGraph", "OmniGraphNode")
BEFORE_ALL = -(1 << 28)


class Mirror:
    """The prims of one App's graphs."""

    def __init__(self, app: App) -> None:
        self._app, self._graphs = app, graphs_of(app)
        self._said: dict[str, State] = {}
        """What the stage said of each graph when it was last written or read."""
        self._written: dict[str, State] = {}
        """Each graph as its prims were last written."""
        self._values: dict[str, None] = {}
        """Paths of node prims of which only values have changed since the last `sync`."""
        self._changed = False
        self._muted = False
        self._listener: Any = None
        app.on("timeline_state", self.sync, BEFORE_ALL)
        app.on("stage_closing", self._end)
        app.on("stage_opened", self._begin)
        app.on("stop", self._put_back)
        app.on("close", self._end)
        self._begin()

    def _begin(self) -> None:
        from graph.sim.usd import Tf, Usd

        self._listener = Tf.Notice.Register(Usd.Notice.ObjectsChanged, self._noticed, self._app.stage)
        # Most scripts have no graph; reading loads what compiles them.
        has_graphs = any(str(prim.GetTypeName()) in GRAPH_TYPES for prim in self._app.stage.TraverseAll())
        self._said = {path: State.of(one) for path, one in self._read().items()} if has_graphs else {}
        self._written, self._values, self._changed = {}, {}, False

    def _end(self) -> None:
        if self._listener is not None:
            self._listener.Revoke()
            self._listener = None
        self._said, self._written, self._values = {}, {}, {}

    def _noticed(self, notice: Any, sender: Any) -> None:
        if self._muted or self._changed or self._app.fabric.muted:
            return
        roots = tuple(f"{path}/" for path in self._said)
        for path in notice.GetChangedInfoOnlyPaths():
            prim = str(path.GetPrimPath())
            if path.IsPropertyPath() and set(notice.GetChangedFields(path)) == {"default"} and prim.startswith(roots):
                self._values[prim] = None
            else:
                self._structure(path, roots)
        for path in notice.GetResyncedPaths():
            self._structure(path, roots)

    def _structure(self, path: Any, roots: tuple[str, ...]) -> None:
        text = f"{path.GetPrimPath()}/"
        inside = text.startswith(roots) or any(root.startswith(text) for root in roots)
        self._changed = self._changed or inside or self._has_graph(path)

    def _has_graph(self, path: Any) -> bool:
        """Whether a prim, or one below it if the prim is new, is part of a graph."""
        from graph.sim.usd import Usd

        prim = self._app.stage.GetPrimAtPath(path.GetPrimPath())
        if not prim:
            return False
        prims = Usd.PrimRange(prim) if path.IsPrimPath() else (prim,)
        return any(str(one.GetTypeName()) in GRAPH_TYPES for one in prims)

    # -- from graphs to prims ------------------------------------------------------------------------------------------

    def write(self, path: str) -> None:
        """Writes what has changed of a graph since it was last written; of one that is gone, removes the prims."""
        if self._graphs.latest(path) is None:
            with self._silence():
                self._app.stage.RemovePrim(path)
            self._said.pop(path, None)
            self._written.pop(path, None)
            return
        now = State.of(self._graphs.current_spec(path))
        before, self._written[path] = self._written.get(path), now
        change = change_of(before, now) if before is not None and path in self._said else None
        with self._silence():
            if change is None or not self._write_nodes(now, change):
                self._write_all(now.spec)

    def _write_all(self, spec: GraphSpec) -> None:
        from graph.sim.usd import Sdf
        from graph.usd_files.writing import layer_of

        path, layer = spec.path, self._app.stage.GetEditTarget().GetLayer()
        try:
            written = layer_of(FileSpec(graphs=(with_short_names(spec, spec.nodes),)), {}, Path.cwd())
        except UserError as error:  # a name that USD does not accept
            self._written.pop(path, None)
            self._app.warn("graph-not-on-stage", path, str(error))
            return
        with Sdf.ChangeBlock():
            Sdf.CreatePrimInLayer(layer, path)
            for prefix in Sdf.Path(path).GetParentPath().GetPrefixes():
                above = layer.GetPrimAtPath(prefix)
                if above.specifier != Sdf.SpecifierDef and not self._app.stage.GetPrimAtPath(prefix):
                    above.specifier, above.typeName = Sdf.SpecifierDef, "Xform"
            Sdf.CopySpec(written, path, layer, path)
        said = self._read().get(path)
        if said is not None:
            self._said[path] = State.of(said)

    def _write_nodes(self, now: State, change: Change) -> bool:
        """Writes the changed nodes only; returns False where the whole graph must be written."""
        from graph.sim.usd import Sdf
        from graph.usd_files.custom_data import texts
        from graph.usd_files.node_prims import KEY
        from graph.usd_files.specs import node_spec
        from graph.usd_files.writing import nodes_layer

        path, stage = now.spec.path, self._app.stage
        layer, said = stage.GetEditTarget().GetLayer(), self._said[path]
        graph, names = layer.GetPrimAtPath(path), change.nodes.keys() | (change.fed & now.nodes.keys())
        if graph is None or change.rest or not all(map(Sdf.Path.IsValidIdentifier, (*names, *change.gone))):
            return False
        old, links = said.spec.connections, bool(change.cut or change.linked or change.fed)
        ours = dict(graph.customData.get(KEY, {})) if links else {}
        listed = list(ours.get("connections", ()))
        if links and len(listed) != len(old):
            return False
        into: tuple[ConnectionSpec, ...] = ()
        if links or not said.nodes.keys().isdisjoint(names):
            into = tuple(one for one in now.spec.connections if owner(one.target) in names)
        ends = {owner(one.source) for one in into} & now.nodes.keys()
        nodes = {name: now.nodes[name] for name in (*names, *ends)}
        part = replace(with_short_names(now.spec, nodes.values()), connections=into)
        written, notes = nodes_layer(part, names)
        for name in change.gone:
            self._remove(f"{path}/{name}")
        with Sdf.ChangeBlock():
            for name in now.nodes if len(names) > 1 else names:
                if name in names:
                    prim = f"{path}/{name}"
                    Sdf.CreatePrimInLayer(layer, prim)
                    Sdf.CopySpec(written, prim, layer, prim)
            if links:
                held = {(one.source, one.target): note for one, note in zip(old, listed, strict=True)} | notes
                ours["connections"] = texts([held[one.source, one.target] for one in now.spec.connections])
                graph.customData = {**graph.customData, KEY: ours}
        for name in change.gone:
            said.nodes.pop(name, None)
        for name in names:
            said.nodes[name] = node_spec(stage.GetPrimAtPath(f"{path}/{name}"), name, _mark, self._app.warn)
        said.spec = replace(said.spec, connections=now.spec.connections)
        return True

    def _remove(self, path: str) -> None:
        """Removes a prim; one that a referenced file defines is deactivated."""
        self._app.stage.RemovePrim(path)
        if prim := self._app.stage.GetPrimAtPath(path):
            prim.SetActive(False)

    def set(self, node: Node, full: str) -> None:
        """Writes the value of one input or state attribute."""
        from graph.usd_files.node_writing import write_value
        from graph.usd_files.values import plain

        layer = self._app.stage.GetEditTarget().GetLayer()
        prim, said = layer.GetPrimAtPath(node.path), self._said.get(node.graph.path)
        if prim is None or said is None:
            return self.write(node.graph.path)
        value, type_ = node.initial(full), node.types.get(full)
        with self._silence():
            if full in prim.properties:
                del prim.properties[full]
            write_value(prim, full, None if type_ is None else type_.name, plain(value))
        if (one := said.nodes.get(node.name)) is not None:
            said.nodes[node.name] = replace(one, inputs={**one.inputs, full.removeprefix("inputs:"): plain(value)})
        return None

    @contextmanager
    def _silence(self) -> Iterator[None]:
        muted, fabric = self._muted, self._app.fabric
        before = fabric.muted
        self._muted, fabric.muted = True, True
        try:
            yield
        finally:
            self._muted, fabric.muted = muted, before

    def _put_back(self) -> None:
        """A stop restores every layer, and graphs keep their edits: their prims are written again."""
        self._changed, self._values, self._written = False, {}, {}
        for path in list(self._graphs.graphs):
            self.write(path)

    # -- from prims to graphs ------------------------------------------------------------------------------------------

    def sync(self) -> None:
        """Applies what a script has changed on the prims of graphs since the last call."""
        if not self._changed:
            if self._values:
                self._take_values()
            return
        from graph.isaac.og import Controller

        self._changed, self._values = False, {}
        now = self._read()
        for path in [path for path in self._said if path not in now]:
            self._said.pop(path)
            if self._graphs.latest(path) is not None:
                self._attempt(path, partial(self._graphs.remove, path))
        for path, spec in now.items():
            before, self._said[path] = self._said.get(path), State.of(spec)
            if self._graphs.latest(path) is None:
                self._attempt(path, partial(self._graphs.apply, [replace(spec, unfinished=True)], {}))
            elif before is not None:
                for commands in edits(before, self._said[path]):
                    self._attempt(path, partial(Controller(graphs=self._graphs).edit, path, commands))
            if path in self._written and self._graphs.latest(path) is not None:
                self._written[path] = State.of(self._graphs.current_spec(path))

    def _take_values(self) -> None:
        """Applies changed values of nodes, without reading the rest of their graphs."""
        from graph.isaac.og import Controller
        from graph.usd_files.specs import node_spec

        changed, self._values = list(self._values), {}
        for prim in changed:
            path = max((one for one in self._said if prim.startswith(f"{one}/")), key=len)
            nodes, name = self._said[path].nodes, prim.removeprefix(f"{path}/")
            before = nodes.get(name)
            if before is None:  # inside a compound, or not a node of the graph
                self._changed = True
                continue
            now = node_spec(self._app.stage.GetPrimAtPath(prim), name, _mark, self._app.warn)
            nodes[name] = replace(before, inputs=now.inputs)
            for full, value in set_values(before, now):
                self._attempt(path, partial(Controller(graphs=self._graphs).set, f"{prim}.{full}", value))
        if self._changed:
            self.sync()

    def _attempt(self, path: str, action: Any) -> None:
        try:
            action()
        except UserError as error:
            self._app.warn("stage-edit-refused", path, "; ".join(str(one.message) for one in error.problems))

    def _read(self) -> dict[str, GraphSpec]:
        from graph.spec.migration import migrate
        from graph.usd_files.graph_prims import read_graphs
        from graph.usd_files.specs import graph_specs

        def tell(code: str, place: str, message: str) -> None:
            self._app.warn(code, place, message)

        raw = read_graphs(self._app.stage, tell)
        specs = graph_specs(raw, _mark, tell)
        return {one.path: one for one in migrate(FileSpec(graphs=specs)).graphs}


def _mark(place: str) -> Mark:
    return Mark(place, 0, 0)
