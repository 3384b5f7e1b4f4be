"""Writes graphs as prims: a node is a copy of its type's prim, and then only what differs is written."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cache
from typing import Any

from graph.editing.model import Model
from graph.node.declaration import Attribute
from graph.node.registry import Registry
from graph.sim.usd import Sdf
from graph.spec.file_spec import GraphSpec, NodeSpec
from graph.values.types import Extended

from .mirror_changes import Ends, State, same


class GraphPrims:
    """The prims of graphs on one stage, in the layer that is edited."""

    def __init__(self, stage: Any, registry: Registry) -> None:
        self._stage, self._registry = stage, registry
        self._templates = Sdf.Layer.CreateAnonymous("node_types.usda")
        self._places: dict[str, Any] = {}
        """Where the prim of each node type is in `_templates`."""
        self._declared: dict[str, Mapping[str, Attribute]] = {}

    @property
    def layer(self) -> Any:
        """The layer that is edited."""
        return self._stage.GetEditTarget().GetLayer()

    def declared(self, node: NodeSpec) -> Mapping[str, Attribute]:
        """The attributes of a node by full name."""
        if node.type not in self._declared:
            known = self._registry.get(node.type) if node.type in self._registry else None
            self._declared[node.type] = _writing().declared_attributes(known, {})
        found = self._declared[node.type]
        return {**found, **_writing().declared_attributes(None, node.attributes)} if node.attributes else found

    def default(self, node: NodeSpec, full: str) -> Any:
        """The default of an attribute of a node; None without one."""
        found = self.declared(node).get(full)
        return None if found is None else found.default

    def write(self, said: State, model: Model, names: Iterable[str], rest: GraphSpec) -> list[str]:
        """Writes the graph's own prim, and these nodes as they are in the model; returns names that USD does not take.

        said: what the stage says; it is updated.
        """
        from graph.sim.scene.prim_paths import is_path

        layer, path, bad = self.layer, model.path, []
        gone = [name for name in names if name not in model.nodes and name in said.nodes]
        with Sdf.ChangeBlock():
            self._graph(layer, said, rest)
            for name in gone:
                self._cut(layer, f"{path}/{name}")
            for name in names:
                if name not in model.nodes:
                    continue
                if not (name.isascii() and name.isidentifier()) and not is_path(f"{path}/{name}"):
                    bad.append(name)
                    continue
                self._node(layer, path, said, short(model.node_spec(name)))
                self._feed(layer, path, said, model, name)
        for name in gone:
            said.nodes.pop(name, None)
            said.links.pop(name, None)
            if prim := self._stage.GetPrimAtPath(f"{path}/{name}"):  # of a layer that is not edited
                prim.SetActive(False)
        return bad

    def remove(self, path: str) -> None:
        """Removes the prim of a graph or node; one that another layer defines is deactivated."""
        self._stage.RemovePrim(path)
        if prim := self._stage.GetPrimAtPath(path):
            prim.SetActive(False)

    def set(self, said: State, path: str, full: str, value: Any, type_name: str | None) -> None:
        """Writes one value of a node; type_name: the attribute's OGN type if it is known."""
        writing = _writing()
        name = path.removeprefix(f"{said.rest.path}/")
        node, layer = said.nodes[name], self.layer
        declared = self.declared(node).get(full)
        if declared is not None:
            if type_name is not None and isinstance(declared.parsed, Extended):
                value = {"type": type_name, "value": value}
            writing.change_attribute(layer, path, full, declared, value)
        else:
            prim = writing.prim_spec(layer, path)
            if full in prim.properties:
                del prim.properties[full]
            writing.write_value(prim, full, type_name, value)
        inputs = {**node.inputs, full.removeprefix("inputs:"): value}
        said.nodes[name] = NodeSpec(name, node.type, inputs, node.mark, node.input_marks, node.attributes)

    def _graph(self, layer: Any, said: State, rest: GraphSpec) -> None:
        from graph.usd_files.variables import VARIABLE
        from graph.usd_files.writing import defined, note_graph, write_settings, write_variables

        path, before = rest.path, said.rest
        there = layer.GetPrimAtPath(path)
        if before is rest and there is not None:
            return
        prim = there
        if prim is None and self._stage.GetPrimAtPath(path):
            prim = Sdf.CreatePrimInLayer(layer, path)
        elif prim is None:
            prim = defined(layer, path, "OmniGraph", "Xform")
        if not self._stage.GetPrimAtPath(path):
            prim.typeName = "OmniGraph"
        write_settings(prim, rest)
        new = {key: one for key, one in rest.variables.items() if not same(before.variables.get(key), one)}
        for old in list(prim.attributes):
            name = old.name.removeprefix(VARIABLE)
            if name != old.name and (name in new or name not in rest.variables):
                prim.RemoveProperty(old)
        write_variables(prim, new)
        if there is None:
            note_graph(prim, rest, ())
        said.rest = rest

    def _node(self, layer: Any, path: str, said: State, node: NodeSpec) -> None:
        writing = _writing()
        place, old = f"{path}/{node.name}", said.nodes.get(node.name)
        said.nodes[node.name] = node
        if new := old is None or old.type != node.type:
            old = NodeSpec(node.name, node.type)
            if "/" in node.name:
                _scope(layer, place.rpartition("/")[0])
            Sdf.CopySpec(self._templates, self._template(node.type), layer, place)
            said.links.pop(node.name, None)
        assert old is not None
        changed = [
            key for key, value in node.inputs.items() if key not in old.inputs or not same(old.inputs[key], value)
        ]
        changed += [key for key in old.inputs if key not in node.inputs]
        if not changed and old.attributes == node.attributes:
            return
        declared = self.declared(node)
        for full in old.attributes:
            if full not in node.attributes and (prop := layer.GetPropertyAtPath(f"{place}.{full}")) is not None:
                layer.GetPrimAtPath(place).RemoveProperty(prop)
        for full in node.attributes:
            if full not in old.attributes:
                writing.change_attribute(layer, place, full, declared[full], None)
        for key in changed:
            full, value = key if key.startswith("state:") else f"inputs:{key}", node.inputs.get(key)
            if full in declared:
                writing.change_attribute(layer, place, full, declared[full], value)
            elif Sdf.Path.IsValidNamespacedIdentifier(full):
                prim = writing.prim_spec(layer, place)
                if full in prim.properties:
                    prim.RemoveProperty(prim.properties[full])
                if value is not None:
                    writing.write_value(prim, full, None, value)
        named = Sdf.Path.IsValidNamespacedIdentifier
        bad = {key: one for key, one in node.inputs.items() if one is None or not named(f"inputs:{key}")}
        plain_new = new and len(node.inputs) < 2 and not node.attributes and not bad  # its template says the same
        if not plain_new and ((prim := writing.prim_spec(layer, place)).HasInfo("customData") or new):
            writing.note_node(prim, node, bad)

    def _feed(self, layer: Any, path: str, said: State, model: Model, name: str) -> None:
        links: dict[Ends, None] = dict.fromkeys(model.into(name))
        before: dict[Ends, None] = said.links.get(name, {})
        if list(links) == list(before):
            return
        from graph.usd_files.written_links import fed_property

        place = f"{path}/{name}"
        for target in dict.fromkeys(target for _, target in (*before, *links)):
            feeds = [source for source, end in links if end == target]
            full = target.rpartition(".")[2]
            if full.startswith("outputs:") or not Sdf.Path.IsValidNamespacedIdentifier(full):
                continue
            prop = layer.GetPropertyAtPath(f"{place}.{full}")
            if prop is None and feeds:
                prop = fed_property(_writing().prim_spec(layer, place), full, self._source_type(model, feeds[0]))
            if prop is not None:
                _set_sources(prop, [one if one.startswith("/") else f"{path}/{one}" for one in feeds])
        if links:
            said.links[name] = links
        else:
            said.links.pop(name, None)

    def _source_type(self, model: Model, end: str) -> str:
        from graph.usd_files.written_links import usd_type_name

        name, _, full = end.rpartition(".")
        node = model.nodes.get(name)
        return "token" if node is None else usd_type_name(self.declared(model.node_spec(name)).get(full))

    def _template(self, type_: str) -> Any:
        """The path of the prim of a node of that type without values."""
        if type_ not in self._places:
            prim = Sdf.CreatePrimInLayer(self._templates, f"/type{len(self._places)}")
            prim.specifier, prim.typeName = Sdf.SpecifierDef, "OmniGraphNode"
            node = NodeSpec(prim.name, type_)
            _writing().NodeWriter(prim, node, self._registry).write()
            for full, declared in self.declared(node).items():
                if full.startswith("inputs:"):
                    _writing().write_default(prim.properties[full], declared)
            self._places[type_] = prim.path
        return self._places[type_]

    def _cut(self, layer: Any, path: str) -> None:
        """Removes a node from the layer, and the compounds around it that are empty then."""
        prim = layer.GetPrimAtPath(path)
        while prim is not None:
            parent = prim.nameParent
            del parent.nameChildren[prim.name]
            empty = parent is not None and parent.typeName == "Scope" and not parent.nameChildren
            prim = parent if empty else None


def short(node: NodeSpec) -> NodeSpec:
    """The node with its inputs named as in files, `x` for `inputs:x`, and its values as plain data."""
    if not node.inputs:
        return node
    inputs = {key.removeprefix("inputs:"): plain_value(one) for key, one in node.inputs.items()}
    return NodeSpec(node.name, node.type, inputs, node.mark, node.input_marks, node.attributes)


def plain_value(value: Any) -> Any:
    """A value as plain data, which prims and files hold."""
    return _writing().plain(value)


@cache
def _writing() -> Any:
    from graph.usd_files import node_writing  # most scripts have no graph

    return node_writing


def _scope(layer: Any, path: str) -> None:
    for prefix in Sdf.Path(path).GetPrefixes():
        if layer.GetPrimAtPath(prefix) is None:
            prim = Sdf.CreatePrimInLayer(layer, prefix)
            prim.specifier, prim.typeName = Sdf.SpecifierDef, "Scope"


def _set_sources(prop: Any, paths: list[str]) -> None:
    from graph.sim.usd import Sdf
    from graph.usd_files.ports import as_source

    if isinstance(prop, Sdf.RelationshipSpec):
        values = [str(one) for one in prop.targetPathList.explicitItems if not as_source(str(one))]
        prop.targetPathList.explicitItems = [*values, *paths]
    elif paths:
        prop.connectionPathList.explicitItems = paths
    else:
        prop.connectionPathList.ClearEdits()
