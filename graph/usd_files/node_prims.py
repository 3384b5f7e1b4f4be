"""One node prim as it is written: its attributes with values, types, sources and targets; nothing is judged here."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from .values import from_usd, ogn_name, plain

PREFIXES = ("inputs:", "outputs:", "state:")
GRAPH_TYPES = ("OmniGraph", "ComputeGraph")
NODE_TYPES = ("OmniGraphNode", "ComputeNode")
COMPOUND_TYPE = "omni:graph:compoundType"
"""The attribute of a node that has a graph inside; it says of which kind."""
_ABOUT = ("node:type", "node:typeVersion")
"""The attributes that say what a node is, of which nothing but the value counts."""
_NOTHING: Mapping[str, Any] = {}
KEY = "tickgraph"
"""Key of our own data in customData and customLayerData."""
COMMENTS = "comments"
"""Key, in the layer's own data, of the comments that are no prim's documentation, as JSON."""


@dataclass(slots=True)
class RawAttribute:
    """A property of a node. `sources` are the property paths that it is connected from, composed and absolute."""

    name: str
    sdf_type: str
    """The Sdf type name; "rel" for a relationship."""
    value: Any = None
    """Plain data; None where none is authored. The list of targets for a relationship."""
    sources: tuple[str, ...] = ()
    custom: Mapping[str, Any] = field(default_factory=dict)
    """Its customData as plain data."""

    @property
    def is_execution(self) -> bool:
        """Whether the file itself marks it as execution; inputs of old files are not marked."""
        return bool(self.custom.get("isExecution"))

    @property
    def extended(self) -> Mapping[str, Any]:
        """What the file says of an extended attribute: attrType, resolvedType, attrValue."""
        nested = self.custom.get("omni")
        inner = nested.get("graph") if isinstance(nested, dict) else None
        found = dict(inner) if isinstance(inner, dict) else {}
        for key in ("attrType", "resolvedType", "attrValue"):
            if f"omni:graph:{key}" in self.custom:
                found[key] = self.custom[f"omni:graph:{key}"]
        return found


@dataclass(slots=True)
class RawNode:
    """A node prim. `name` is its path from the graph's."""

    path: str
    name: str
    type: str
    version: int | None
    attributes: list[RawAttribute]
    custom: Mapping[str, Any] = field(default_factory=dict)
    has_compound_type: bool = False
    """Whether `COMPOUND_TYPE` is among its attributes."""


def read_node(prim: Any, path: Any, name: str) -> RawNode:
    """The node of a prim, whose path is `path`."""
    alone = _only_spec(prim, path)
    node = RawNode(path.pathString, name, "", None, [])
    for attribute in _properties(prim, alone):
        full = attribute.name
        if full.startswith(PREFIXES):
            node.attributes.append(attribute)
        elif full == "node:type":
            node.type = str(attribute.value or "")
        elif full == "node:typeVersion":
            node.version = attribute.value if isinstance(attribute.value, int) else None
        elif full == COMPOUND_TYPE:
            node.has_compound_type = True
    if prim.HasCustomData() if alone is None else alone.HasInfo("customData"):
        custom = plain(prim.GetCustomDataByKey(KEY))
        if isinstance(custom, dict):
            node.custom = custom
    return node


def read_properties(prim: Any) -> Iterator[RawAttribute]:
    """The authored properties of a prim: as the file has them if one layer alone wrote them, else as composed."""
    return _properties(prim, _only_spec(prim, prim.GetPath()))


def _only_spec(prim: Any, path: Any) -> Any | None:
    """What one layer says of a prim, if no other says anything."""
    stack = prim.GetPrimStack()
    return stack[0] if len(stack) == 1 and stack[0].path == path else None


# Every call into USD costs as much as ten lines of Python, and a large file has half a million properties.


def _properties(prim: Any, alone: Any | None) -> Iterator[RawAttribute]:
    if alone is None:
        for prop in prim.GetAuthoredProperties():
            yield _composed(prop)
        return
    find, before = alone.layer.GetPropertyAtPath, f"{alone.path.pathString}."
    for name in alone.GetInfo("properties"):  # as quick again as `alone.properties`
        if not name.startswith("ui:"):  # how an editor lays the graph out
            yield _of_spec(find(before + name), name, prim)


def _of_spec(spec: Any, name: str, prim: Any) -> RawAttribute:
    value = spec.default
    if value is not None and name in _ABOUT:
        return RawAttribute(name, "", _plain(value, ""))
    has = spec.HasInfo
    custom = (plain(spec.GetInfo("customData")) or _NOTHING) if has("customData") else _NOTHING
    type_name = getattr(spec, "typeName", None)
    if type_name is None:
        listed = spec.GetInfo("targetPaths").GetAppliedItems() if has("targetPaths") else ()
        return RawAttribute(name, "rel", [str(path) for path in listed], (), custom)
    sdf = str(type_name)
    if value is None and has("timeSamples"):
        value = _earliest(prim.GetAttribute(name))
    sources: tuple[str, ...] = ()
    if has("connectionPaths"):
        sources = tuple(path.pathString for path in spec.GetInfo("connectionPaths").GetAppliedItems())
    return RawAttribute(name, sdf, None if value is None else _plain(value, sdf), sources, custom)


def _composed(prop: Any) -> RawAttribute:
    from graph.sim.usd import Usd

    name = prop.GetName()
    custom = plain(prop.GetCustomData())
    if isinstance(prop, Usd.Relationship):
        return RawAttribute(name, "rel", [str(path) for path in prop.GetTargets()], (), custom)
    sdf = str(prop.GetTypeName())
    sources = tuple(map(str, prop.GetConnections())) if prop.HasAuthoredConnections() else ()
    return RawAttribute(name, sdf, _plain(_earliest(prop), sdf), sources, custom)


def _earliest(attribute: Any) -> Any:
    from graph.sim.usd import EARLIEST

    return attribute.Get(EARLIEST)


def _plain(value: Any, sdf: str) -> Any:
    return None if value is None or type(value).__name__ == "ValueBlock" else from_usd(value, sdf)


def ogn_type(attribute: RawAttribute) -> str | None:
    """The OGN type of an attribute as the file declares it; None for tokens that may stand for any type."""
    if attribute.is_execution:
        return "execution"
    if attribute.sdf_type == "rel":
        return "target"
    return ogn_name(attribute.sdf_type)
