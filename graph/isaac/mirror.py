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
from graph.spec.file_spec import FileSpec, GraphSpec

if TYPE_CHECKING:
    from graph.evaluate import Node
    from graph.sim import App

GRAPH_TYPES = ("OmniGraph", "OmniGraphNode")
BEFORE_ALL = -(1 << 28)


class Mirror:
    """The prims of one App's graphs."""

    def __init__(self, app: App) -> None:
        self._app, self._graphs = app, graphs_of(app)
        self._said: dict[str, GraphSpec] = {}
        """What the stage said of each graph when it was last written or read."""
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
        self._said = self._read() if has_graphs else {}
        self._changed = False

    def _end(self) -> None:
        if self._listener is not None:
            self._listener.Revoke()
            self._listener = None
        self._said = {}

    def _noticed(self, notice: Any, sender: Any) -> None:
        if self._muted or self._changed or self._app.fabric.muted:
            return
        roots = tuple(f"{path}/" for path in self._said)
        for path in (*notice.GetResyncedPaths(), *notice.GetChangedInfoOnlyPaths()):
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
        """Writes the prims of a graph as it is now; of one that is gone, removes them."""
        from graph.sim.usd import Sdf
        from graph.usd_files.writing import layer_of

        graph = self._graphs.latest(path)
        with self._silence():
            layer = self._app.stage.GetEditTarget().GetLayer()
            if graph is None:
                self._app.stage.RemovePrim(path)
                self._said.pop(path, None)
                return
            try:
                spec = _with_short_names(self._graphs.current_spec(path))
                written = layer_of(FileSpec(graphs=(spec,)), {}, Path.cwd())
            except UserError as error:  # a name that USD does not accept
                self._app.warn("graph-not-on-stage", path, str(error))
                return
            with Sdf.ChangeBlock():
                Sdf.CreatePrimInLayer(layer, path)
                for prefix in Sdf.Path(path).GetParentPath().GetPrefixes():
                    spec = layer.GetPrimAtPath(prefix)
                    if spec.specifier != Sdf.SpecifierDef and not self._app.stage.GetPrimAtPath(prefix):
                        spec.specifier, spec.typeName = Sdf.SpecifierDef, "Xform"
                Sdf.CopySpec(written, path, layer, path)
        said = self._read().get(path)
        if said is not None:
            self._said[path] = said

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
        short = full.removeprefix("inputs:")
        nodes = (
            replace(one, inputs={**one.inputs, short: plain(value)}) if one.name == node.name else one
            for one in said.nodes
        )
        self._said[node.graph.path] = replace(said, nodes=tuple(nodes))
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
        self._changed = False
        for path in list(self._graphs.graphs):
            self.write(path)

    # -- from prims to graphs ------------------------------------------------------------------------------------------

    def sync(self) -> None:
        """Applies what a script has changed on the prims of graphs since the last call."""
        if not self._changed:
            return
        from graph.isaac.og import Controller

        self._changed = False
        now = self._read()
        for path in [path for path in self._said if path not in now]:
            self._said.pop(path)
            if self._graphs.latest(path) is not None:
                self._attempt(path, partial(self._graphs.remove, path))
        for path, spec in now.items():
            before = self._said.get(path)
            self._said[path] = spec
            if self._graphs.latest(path) is None:
                self._attempt(path, partial(self._graphs.apply, [replace(spec, unfinished=True)], {}))
            elif before is not None:
                for commands in _differences(before, spec):
                    self._attempt(path, partial(Controller(graphs=self._graphs).edit, path, commands))

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
        specs = graph_specs(raw, lambda place: Mark(place, 0, 0), tell)
        return {one.path: one for one in migrate(FileSpec(graphs=specs)).graphs}


def _with_short_names(spec: GraphSpec) -> GraphSpec:
    """The spec with inputs named as in files, `x` for `inputs:x`."""
    nodes = (
        replace(one, inputs={key.removeprefix("inputs:"): value for key, value in one.inputs.items()})
        for one in spec.nodes
    )
    return replace(spec, nodes=tuple(nodes))


def _differences(before: GraphSpec, now: GraphSpec) -> Iterator[dict[str, Any]]:
    """What makes the second of the first, as edits; each may fail without the others."""
    from graph.isaac.og import Keys

    old, new = {one.name: one for one in before.nodes}, {one.name: one for one in now.nodes}
    gone = [name for name, one in old.items() if name not in new or new[name].type != one.type]
    if gone:
        yield {Keys.DELETE_NODES: gone}
    for name, one in now.variables.items():
        if name not in before.variables:
            yield {Keys.CREATE_VARIABLES: [(name, one.type, one.value)]}
    cut = {(one.source, one.target) for one in before.connections} - {
        (one.source, one.target) for one in now.connections
    }
    for source, target in sorted(cut):
        if not {source.rpartition(".")[0], target.rpartition(".")[0]} & set(gone):
            yield {Keys.DISCONNECT: [(source, target)]}
    for name, node in new.items():
        fresh = name not in old or name in gone
        if fresh:
            yield {Keys.CREATE_NODES: [(name, node.type)]}
        known: dict[str, Any] = {} if fresh else dict(old[name].attributes)
        for full, kind in node.attributes.items():
            if full not in known:
                yield {Keys.CREATE_ATTRIBUTES: [(f"{name}.{full}", kind)]}
        values: dict[str, Any] = {} if fresh else dict(old[name].inputs)
        for key, value in node.inputs.items():
            if key not in values or values[key] != value:
                full = key if ":" in key else f"inputs:{key}"
                yield {Keys.SET_VALUES: [(f"{name}.{full}", value)]}
    linked = {(one.source, one.target) for one in before.connections}
    for link in now.connections:
        if (link.source, link.target) not in linked:
            yield {Keys.CONNECT: [(link.source, link.target)]}
