"""Writes one node as an OmniGraphNode prim: every attribute of its type, with the values that the file sets."""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import cache
from math import isfinite
from typing import Any

from graph.node.declaration import Attribute, NodeType
from graph.node.registry import Registry
from graph.sim.scene.prim_paths import is_path
from graph.spec.file_spec import NodeSpec
from graph.values.coercion import coerce
from graph.values.equality import same
from graph.values.types import TYPES, Extended, Type
from graph.values.untyped import natural_type, typed_value

from .custom_data import survives
from .json_values import kept, noted
from .ports import as_source
from .raw_graph import KEY
from .values import from_usd, ogn_name, plain, sdf_name, to_usd

EXECUTION = {"isExecution": True}
TARGET = {"omni": {"graph": {"relType": "target"}}}
_PREFIXES = ("inputs", "outputs", "state")
_EXACT = {"bool": bool, "int": int, "double": float, "token": str, "string": str}


class NodeWriter:
    """Writes one node's prim; connections are written later (`written_links`)."""

    def __init__(self, prim: Any, node: NodeSpec, registry: Registry) -> None:
        self.prim = prim
        self.node = node
        self.type = registry.get(node.type) if node.type in registry else None

    def write(self) -> None:
        """The type, its version, the attributes."""
        from graph.sim.usd import Sdf

        prim, node = self.prim, self.node
        Sdf.AttributeSpec(prim, "node:type", Sdf.ValueTypeNames.Token).default = (
            self.type.id if self.type else node.type
        )
        version = self.type.version if self.type else 1
        Sdf.AttributeSpec(prim, "node:typeVersion", Sdf.ValueTypeNames.Int).default = version
        values = {key if key.startswith("state:") else f"inputs:{key}": value for key, value in node.inputs.items()}
        # USD has no attribute for these: an empty value, or a name that it does not accept.
        unnameable = {full.removeprefix("inputs:"): None for full, value in values.items() if value is None}
        for full, declared in declared_attributes(self.type, node.attributes).items():
            write_attribute(prim, full, declared, values.pop(full, None))
        for full, value in values.items():
            if Sdf.Path.IsValidNamespacedIdentifier(full):
                write_value(prim, full, None, value)
            else:
                unnameable[full.removeprefix("inputs:")] = value
        note_node(prim, node, unnameable)


def note_node(prim: Any, node: NodeSpec, unnameable: Mapping[str, Any]) -> None:
    """Records what the attributes of a node's prim do not say; unnameable: inputs without one."""
    ours: dict[str, Any] = {"type": node.type}
    if len(node.inputs) > 1:
        ours["order"] = noted(node.inputs)
    if node.attributes:
        ours["attributes"] = json.dumps(dict(node.attributes))
    if unnameable:
        ours["inputs"] = json.dumps(unnameable)
    prim.customData = {KEY: ours}


def declared_attributes(node_type: NodeType | None, added: Mapping[str, str]) -> dict[str, Attribute]:
    """Every attribute of a node by full name: those of its type and those that the file adds."""
    found = {
        f"{prefix}:{name}": attribute
        for prefix in (_PREFIXES if node_type else ())
        for name, attribute in getattr(node_type, prefix).items()
    }
    for full, type_name in added.items():
        found[full] = Attribute(type_name, "")
    return found


def write_attribute(prim: Any, full: str, declared: Attribute, value: Any) -> None:
    """Writes one attribute with the value that the file gives it (None: no value)."""
    from graph.sim.usd import Sdf

    if not Sdf.Path.IsValidNamespacedIdentifier(full):
        return
    parsed = declared.parsed
    if isinstance(parsed, Extended):
        _write_extended(prim, full, parsed, value)
    elif parsed.storage == "bundle" and full.startswith("outputs:"):
        Sdf.PrimSpec(prim, full.replace(":", "_"), Sdf.SpecifierDef)
    else:
        attribute = write_value(prim, full, parsed.name, value)
        if parsed.storage == "execution":
            attribute.customData = {**attribute.customData, **EXECUTION}
        elif parsed.storage == "target":
            attribute.customData = {**attribute.customData, **TARGET}
        elif declared.allowed_tokens:
            from graph.sim.usd import Vt

            attribute.SetInfo("allowedTokens", Vt.TokenArray(list(declared.allowed_tokens)))


def write_value(prim: Any, full: str, type_name: str | None, value: Any, *, note_type: bool = False) -> Any:
    """Writes a property of that OGN type (None: whatever fits the value), with the value in USD's form.

    If USD would return something else, the value as written is stored beside it. note_type: the type is stored too, if
    the USD type stands for several.
    """
    from graph.sim.usd import Sdf

    type_ = TYPES.get(type_name) if type_name else next(iter(_natural(value)), TYPES["token"])
    ours: dict[str, Any] = {}
    if note_type and type_name and (type_ is None or _ambiguous(type_)):
        ours["type"] = type_name
    type_ = type_ or TYPES["token"]
    sdf = sdf_name(type_)
    is_relationship = sdf == "rel"
    prop = Sdf.RelationshipSpec(prim, full) if is_relationship else Sdf.AttributeSpec(prim, full, _sdf_type(sdf))
    prop.custom = True
    ours |= _store(prop, type_, sdf, value)
    if ours:
        prop.customData = {KEY: ours}
    return prop


def _store(prop: Any, type_: Type, sdf: str, value: Any) -> dict[str, str]:
    """Writes a value to a property; returns what must be recorded if USD would return something else."""
    if value is None:
        return {}
    stored = None
    if sdf == "rel":
        stored = _write_targets(prop, value)
    elif type_.storage != "execution" and survives(value):
        try:
            held = _as_text_holds_it(coerce(type_, value), type_)
            prop.default = held
            stored = from_usd(held, sdf)
        except (ValueError, TypeError, OverflowError, UnicodeError):
            stored = None  # stored as text
    if stored is None and sdf != "rel":
        prop.ClearInfo("default")
    return {} if same(stored, value) else {"value": kept(value, stored)}


def change_attribute(layer: Any, place: str, full: str, declared: Attribute, value: Any) -> None:
    """Gives an attribute of a node's prim at that place another value, None for its default; its sources stay."""
    prop = layer.GetPropertyAtPath(f"{place}.{full}")
    if prop is not None and _is_exact(declared.type, value):
        prop.default = value
        _annotate(prop, {})
        return
    parsed = declared.parsed
    if prop is None or isinstance(parsed, Extended):
        prim = prim_spec(layer, place)
        feeds = [] if prop is None else list(prop.connectionPathList.explicitItems)
        if prop is not None:
            prim.RemoveProperty(prop)
        write_attribute(prim, full, declared, value)
        if feeds:
            prim.attributes[full].connectionPathList.explicitItems = feeds
        return
    sdf, feeds = sdf_name(parsed), []
    if sdf == "rel":
        feeds = [one for one in prop.targetPathList.explicitItems if as_source(str(one))]
        prop.targetPathList.ClearEdits()
    elif value is None:
        prop.ClearInfo("default")
    ours = _store(prop, parsed, sdf, value)
    _annotate(prop, ours)
    if feeds:
        prop.targetPathList.explicitItems += feeds
    if value is None and full.startswith("inputs:"):
        write_default(prop, declared)


def _annotate(prop: Any, ours: dict[str, str]) -> None:
    """Records what a property does not say by itself, in the place of what was recorded before."""
    if ours or prop.HasInfo("customData"):
        prop.SetInfoDictionaryValue("customData", KEY, ours or None)
        if not ours and len(prop.customData) == 0:  # the truth of the proxy says something else
            prop.ClearInfo("customData")


def _is_exact(type_name: str | tuple[str, ...], value: Any) -> bool:
    """Whether a value of that OGN type is stored as it is, without a note."""
    if not isinstance(type_name, str) or type(value) is not _EXACT.get(type_name):
        return False
    match value:
        case float():
            return isfinite(value)
        case str():
            return value.isascii() and value.isprintable()
        case int():
            return -(2**31) <= value < 2**31
    return False


def prim_spec(layer: Any, place: str) -> Any:
    """The prim at that place of a layer; one that is not there is made."""
    from graph.sim.usd import Sdf

    return layer.GetPrimAtPath(place) or Sdf.CreatePrimInLayer(layer, place)


def write_default(prop: Any, declared: Attribute) -> None:
    """Gives an input without a value its type's default, with a note that it is one: a script may read it."""
    parsed = declared.parsed
    if declared.default is None or isinstance(parsed, Extended) or parsed.storage in ("execution", "target", "bundle"):
        return
    try:
        held = to_usd(coerce(parsed, declared.default), parsed)
        note = json.dumps(from_usd(held, sdf_name(parsed)))
    except (ValueError, TypeError, OverflowError, UnicodeError):
        return
    prop.default = held
    prop.SetInfoDictionaryValue("customData", KEY, {"default": note})


@cache
def _sdf_type(sdf: str) -> Any:
    from graph.sim.usd import Sdf

    return Sdf.ValueTypeNames.Find(sdf)


def _as_text_holds_it(value: Any, type_: Type) -> Any:
    """The value for USD. USD's text has six digits for time codes, so this is the value that six digits give."""
    if type_.role != "timecode":
        return to_usd(value, type_)
    rounded = [float(f"{x:g}") for x in value] if type_.array else float(f"{value:g}")
    return to_usd(rounded, type_)


def _in_dictionary(value: Any, type_: Type) -> Any:
    """The value as an entry of a dictionary.

    A dictionary infers an integer's type from its size, and cannot hold the largest.
    """
    from graph.sim.usd import Vt

    return Vt.UInt64(value) if type_.storage == "uint64" and not type_.array else value


def _natural(value: Any) -> list[Type]:
    return [one for one in natural_type(value) if _fits(one, value)]


def _fits(type_: Type, value: Any) -> bool:
    try:
        coerce(type_, value)
    except ValueError:
        return False
    return True


def _ambiguous(type_: Type) -> bool:
    return ogn_name(sdf_name(type_)) != type_.name


def _write_targets(relationship: Any, value: Any) -> Any:
    """Writes prim paths as targets; invalid paths are left out. Returns what will be read back."""
    paths = [value] if isinstance(value, str) else value
    if not isinstance(paths, list) or not paths or not all(map(_is_target, paths)) or len(set(paths)) < len(paths):
        return None
    relationship.targetPathList.explicitItems = paths
    return paths[0] if len(paths) == 1 else paths


def _is_target(path: Any) -> bool:
    """Whether USD keeps this text unchanged as the path of a prim."""
    from graph.sim.usd import Sdf

    if not isinstance(path, str) or not path.startswith("/") or not is_path(path):
        return False
    return Sdf.Path(path).IsPrimPath() and str(Sdf.Path(path)) == path and not as_source(path)


def _write_extended(prim: Any, full: str, declared: Extended, value: Any) -> None:
    """Writes an attribute of an open type: a token, with type and value in customData if the file sets one."""
    from graph.sim.usd import Sdf

    attribute = Sdf.AttributeSpec(prim, full, Sdf.ValueTypeNames.Token)
    attribute.custom = True
    if value is None:
        return
    graph: dict[str, Any] = {"attrType": "Union" if declared.members else "Any"}
    stored = None
    try:
        typed = typed_value(value)
    except ValueError:
        typed = None
    if typed is None:
        candidates = [one for one in (*natural_type(value), *declared.members) if declared.accepts(one)]
        fitting = next((one for one in candidates if _fits(one, value)), None)
        typed = (fitting, coerce(fitting, value)) if fitting else None
    if typed is not None and survives(value) and sdf_name(typed[0]) != "rel" and typed[0].storage != "execution":
        graph["resolvedType"] = typed[0].name
        held = _as_text_holds_it(typed[1], typed[0])
        graph["attrValue"] = _in_dictionary(held, typed[0])
        stored = {"type": typed[0].name, "value": plain(held)}
    custom: dict[str, Any] = {"omni": {"graph": graph}}
    if not same(stored, value):
        custom[KEY] = {"value": kept(value, stored)}
    attribute.customData = custom
