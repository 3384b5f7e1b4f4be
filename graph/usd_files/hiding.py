"""Hides graphs, or parts of them, that the scene below a written layer has and the file does not.

A layer cannot delete what a sublayer defines. So prims become inactive, connection lists explicit, values blocked. What
USD always merges (variables, dictionaries) is listed in our own customData.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from graph.spec.file_spec import FileSpec, GraphSpec, NodeSpec

from .custom_data import texts
from .graph_prims import read_graphs
from .json_values import kept, noted
from .properties import RawAttribute
from .raw_graph import KEY, RawGraph, RawNode
from .values import from_usd
from .variables import VARIABLE, variable_name


def scene_graphs(path: Path, allow: Iterable[Path] = (), *, skip_outside: bool = False) -> list[RawGraph]:
    """The graphs in the scene itself; empty for a missing file.

    Opens the scene as a run does (see `open_stage`): only with files below its own folder or one of `allow`;
    skip_outside: files elsewhere are left out.
    """
    from graph.sim.scene.stage import open_stage

    if not path.is_file():
        return []
    stage = open_stage(path, [path.parent, *allow], lambda *_: None, skip_outside=skip_outside)
    return read_graphs(stage, lambda *_: None)


class Hiding:
    """Adds to the layer of a file what hides the scene's own graphs where they differ from the file."""

    def __init__(self, layer: Any, spec: FileSpec) -> None:
        self._layer = layer
        self._graphs = {graph.path: graph for graph in spec.graphs}
        self._nodes = {f"{graph.path}/{node.name}": node for graph in spec.graphs for node in graph.nodes}
        self._needed: set[str] = set()
        """Paths of prims at or below which the file has something."""
        for path in (*self._graphs, *self._nodes, *(one for graph in spec.graphs for one in graph.instances)):
            while path and path not in self._needed:
                self._needed.add(path)
                path = path.rpartition("/")[0]

    def hide(self, scene: Sequence[RawGraph]) -> None:
        """Hides the parts of these graphs that the file does not have."""
        for raw in scene:
            graph = self._graphs.get(raw.path)
            if graph is None:
                self._remove(raw.path)
            else:
                self._variables(raw, graph)
                _documentation(self._layer.GetPrimAtPath(raw.path))
            self._instances(raw, graph)
            for node in (*raw.nodes, *raw.compounds):
                written = self._nodes.get(node.path)
                if written is None:
                    self._remove(node.path)
                else:
                    self._node(node, written)
        for path in dict.fromkeys(raw.path for raw in scene if raw.path in self._graphs):
            self._order(path)

    def _order(self, path: str) -> None:
        """Makes the order of nodes and variables that of the file; the scene's own record does not count."""
        prim, graph = self._layer.GetPrimAtPath(path), self._graphs[path]
        names = [node.name for node in graph.nodes]
        if names:
            prim.nameChildrenOrder = list(dict.fromkeys(name.partition("/")[0] for name in names))
        ours = {**prim.customData[KEY], "nodes": noted(names), "variables": noted(graph.variables)}
        prim.customData = {**prim.customData, KEY: ours}

    def _remove(self, path: str) -> None:
        """Deactivates a prim of the scene; if the file has something below it, the prim becomes a plain Scope."""
        from graph.sim.usd import Sdf

        prim = self._layer.GetPrimAtPath(path) or Sdf.CreatePrimInLayer(self._layer, path)
        if path in self._needed:
            prim.specifier = Sdf.SpecifierDef
            prim.typeName = prim.typeName or "Scope"
        else:
            prim.active = False

    def _variables(self, raw: RawGraph, graph: GraphSpec) -> None:
        prim = self._layer.GetPrimAtPath(raw.path)
        removed = []
        for one in raw.variables:
            name = variable_name(one)
            if name in graph.variables:
                self._value(prim, one, graph.variables[name].value, graph.variables[name].type)
            else:
                removed.append(name)
        ours = dict(prim.customData[KEY])
        ours["removedVariables"] = texts(removed)
        prim.customData = {**prim.customData, KEY: ours}

    def _instances(self, raw: RawGraph, graph: GraphSpec | None) -> None:
        """Removes graphs, and their values, from prims that have them only in the scene."""
        from graph.sim.usd import Sdf

        for path, values in raw.instances.items():
            given: Mapping[str, Any] = graph.instances.get(path, {}) if graph else {}
            prim = self._layer.GetPrimAtPath(path) or Sdf.CreatePrimInLayer(self._layer, path)
            targets = (prim.relationships.get("omniGraphs") or Sdf.RelationshipSpec(prim, "omniGraphs")).targetPathList
            if not targets.isExplicit:
                targets.ClearEditsAndMakeExplicit()
            for name in values.keys() - given.keys():
                full = f"{VARIABLE}{name}"
                if full not in prim.properties:
                    Sdf.AttributeSpec(prim, full, Sdf.ValueTypeNames.Token).default = Sdf.ValueBlock()

    def _node(self, raw: RawNode, node: NodeSpec) -> None:
        prim = self._layer.GetPrimAtPath(raw.path)
        _documentation(prim)
        for one in raw.attributes:
            self._links(prim, one)
            if not one.name.startswith("outputs:"):
                value = node.inputs.get(one.name.removeprefix("inputs:"))
                self._value(prim, one, value)
        ours = {"order": noted(node.inputs), **prim.customData[KEY]}
        prim.customData = {KEY: {"attributes": "{}", "inputs": "{}", **ours} if raw.custom else ours}

    def _links(self, prim: Any, raw: RawAttribute) -> None:
        """Keeps only the connections and targets of the layer."""
        from graph.sim.usd import Sdf

        prop = prim.properties.get(raw.name)
        if raw.is_relationship and raw.value:
            if prop is None:
                prop = Sdf.RelationshipSpec(prim, raw.name)
            if isinstance(prop, Sdf.RelationshipSpec) and not prop.targetPathList.isExplicit:
                prop.targetPathList.ClearEditsAndMakeExplicit()
        elif raw.sources:
            prop = prop or _attribute(prim, raw)
            if isinstance(prop, Sdf.AttributeSpec) and not prop.connectionPathList.isExplicit:
                prop.connectionPathList.ClearEditsAndMakeExplicit()

    def _value(self, prim: Any, raw: RawAttribute, value: Any, type_name: str = "") -> None:
        """Keeps only the value of the layer.

        If the scene's customData holds a value, the layer's says which one counts.
        """
        from graph.sim.usd import Sdf

        if raw.is_relationship:
            return
        prop = prim.properties.get(raw.name)
        if raw.value is not None and (
            prop is None or (isinstance(prop, Sdf.AttributeSpec) and not prop.HasInfo("default"))
        ):
            prop = prop or _attribute(prim, raw)
            prop.default = Sdf.ValueBlock()
        ours = raw.custom.get(KEY)
        stale = {"value", "type"} & ours.keys() if isinstance(ours, dict) else set()
        if prop is None:
            if not raw.extended and not stale:
                return
            prop = _attribute(prim, raw)
        mine = dict(prop.customData.get(KEY, {}))
        if any(key.startswith("omni:") for key in raw.custom):  # the older form, which would be preferred
            mine["noValue"] = True
            mine["value"] = kept(value, None)
        elif raw.extended.get("attrValue") is not None:
            mine["noValue"] = "omni" not in prop.customData
        if "value" in stale and "value" not in mine:
            stored = prop.default if isinstance(prop, Sdf.AttributeSpec) and prop.HasInfo("default") else None
            sdf = str(prop.typeName) if isinstance(prop, Sdf.AttributeSpec) else ""
            plain = None if stored is None or isinstance(stored, Sdf.ValueBlock) else from_usd(stored, sdf)
            mine["value"] = kept(value, plain)
        if "type" in stale and type_name:
            mine.setdefault("type", type_name)
        if mine:
            prop.customData = {**prop.customData, KEY: mine}


def _attribute(prim: Any, raw: RawAttribute) -> Any:
    from graph.sim.usd import Sdf

    attribute = Sdf.AttributeSpec(prim, raw.name, Sdf.ValueTypeNames.Find(raw.sdf_type) or Sdf.ValueTypeNames.Token)
    attribute.custom = True
    return attribute


def _documentation(prim: Any) -> None:
    """Hides a comment of the scene."""
    if not prim.HasInfo("documentation"):
        prim.SetInfo("documentation", "")
