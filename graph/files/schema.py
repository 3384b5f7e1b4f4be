"""The JSON Schema of the file format, for editors: made from the models that check files, and from the registries."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping
from typing import TYPE_CHECKING, Any

from graph.values.types import TYPES, Type

from . import file_forms

if TYPE_CHECKING:
    from graph.node.declaration import Attribute, NodeType

JsonSchema = dict[str, Any]

_INTEGERS = {"int", "uint", "int64", "uint64", "uchar"}
_NUMBERS = {"half", "float", "double", "timecode"}
_TEXTS = {"token", "string", "path"}

OWN_TYPE = r"^(?!(omni|isaacsim)\.)[^.]+\..+$"
"""Names of node types that a schema cannot know: ids outside the namespaces of the original."""


def json_schema(
    node_types: Iterable[NodeType] = (),
    knobs: Mapping[str, JsonSchema] | None = None,
    settings: Mapping[str, JsonSchema] | None = None,
    prims: Mapping[str, JsonSchema] | None = None,
    former: Mapping[str, Collection[str]] | None = None,
) -> JsonSchema:
    """The schema (draft 2020-12) of graph files.

    With node types given, an editor completes types and their inputs, and underlines unknown ones; types of other
    packages pass by their ids (`OWN_TYPE`). `former`: by present id ("" for every type) the names that old files have:
    of types under "types", of inputs under the id. `knobs` and `settings` are the schemas of the known keys of those
    sections, `prims` those of keys of inline prims (`config`); settings that are not listed stay legal.
    """
    schema = {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "TickGraph graph file",
        **file_forms.GraphFile.schema(),
    }
    schema["$defs"]["Variable"]["properties"]["type"] |= {"enum": [*TYPES]}
    types = [*node_types]
    if types:
        _add_node_types(schema["$defs"], types, former or {})
    if knobs:
        _add_keys(schema["properties"]["fidelity"], knobs, others=False)
    if settings:
        _add_keys(schema["properties"]["settings"], settings, others=True)
    for key, described in (prims or {}).items():
        keys = schema["$defs"]["Scene"]["properties"]["prims"]["anyOf"][0]["additionalProperties"]["anyOf"][0]
        keys["properties"][key] = {"description": keys["properties"][key]["description"], **described}
    return schema


def _add_keys(section: JsonSchema, keys: Mapping[str, JsonSchema], *, others: bool) -> None:
    mapping = section["anyOf"][0]
    mapping["properties"] = dict(keys)
    if not others:
        mapping["additionalProperties"] = False


def _add_node_types(definitions: JsonSchema, types: list[NodeType], former: Mapping[str, Collection[str]]) -> None:
    names = _names(types)
    offered = {name for one in types for name in (one.id, one.short_name)}
    known = [
        {"const": name, "description": one.doc.partition("\n")[0]}
        for one in types
        for name in names[one.id]
        if name in offered
    ]
    spellings = sorted({name for group in names.values() for name in group} - offered | {*former.get("types", ())})
    definitions["NodeType"] = {
        "description": definitions["Node"]["properties"]["type"]["description"],
        "anyOf": [
            *known,
            *([{"enum": spellings, "deprecated": True}] if spellings else ()),
            {"type": "string", "pattern": OWN_TYPE, "description": "a type of your own or of a package, by its id"},
        ],
    }
    definitions["FormerInput"] = {"enum": sorted(former.get("", ()))}
    definitions["Node"]["properties"]["type"] = {"$ref": "#/$defs/NodeType"}
    definitions["Node"]["allOf"] = [_when_type(names[one.id], one, former.get(one.id, ())) for one in types]
    entry = definitions["Graph"]["properties"]["nodes"]["anyOf"][0]
    entry["additionalProperties"]["anyOf"][0] = {"$ref": "#/$defs/NodeType"}


def _names(types: Iterable[NodeType]) -> dict[str, list[str]]:
    """The names of each type that files may write: its id, and the short names that mean no other type."""
    from graph.node.registry import short_names

    owners: dict[str, list[NodeType]] = {}
    for one in types:
        for name in short_names(one.id):
            owners.setdefault(name, []).append(one)
    names = {one.id: [one.id] for one in types}
    for name in sorted(owners):
        group = [one for one in owners[name] if one.shipped] or owners[name]
        if len(group) == 1 and name != group[0].id:
            names[group[0].id].append(name)
    return names


def _when_type(names: list[str], node_type: NodeType, former: Collection[str]) -> JsonSchema:
    sections: JsonSchema = {}
    for section, attributes in (("inputs", node_type.inputs), ("state", node_type.state)):
        settable = {name: attribute for name, attribute in attributes.items() if not attribute.is_execution}
        sections[section] = {"properties": {name: _attribute(one) for name, one in settable.items()}}
    inputs = [*node_type.inputs, *former]
    return {
        "if": {"properties": {"type": {"enum": names}}, "required": ["type"]},
        "then": {
            "properties": sections,
            # A node may declare inputs of its own in the file.
            "if": {"not": {"required": ["attributes"]}},
            "then": {
                "properties": {
                    "inputs": {
                        "propertyNames": {
                            "anyOf": [
                                {"enum": [*inputs, *(f"inputs:{name}" for name in inputs)]},
                                *({"pattern": f"^(inputs:)?{one}$"} for one in node_type.dynamic_patterns("inputs")),
                                {"$ref": "#/$defs/FormerInput"},
                            ]
                        }
                    }
                }
            },
        },
    }


def _attribute(attribute: Attribute) -> JsonSchema:
    described: JsonSchema = {"description": attribute.doc + (f" [{attribute.unit}]" if attribute.unit else "")}
    described |= _value(attribute)
    if attribute.minimum is not None:
        described["minimum"] = attribute.minimum
    if attribute.maximum is not None:
        described["maximum"] = attribute.maximum
    if attribute.deprecated:
        described["deprecated"] = True
    default = attribute.default
    if isinstance(default, (bool, int, str)) or (isinstance(default, float) and math.isfinite(default)):
        described["default"] = default
    return described


def _value(attribute: Attribute) -> JsonSchema:
    """The allowed values, for simple types; matrices and open types are left to the compiler."""
    match attribute.type:
        case "bool":
            return {"type": "boolean"}
        case str(name) if name in _INTEGERS:
            return {"type": "integer"}
        case str(name) if name in _NUMBERS:
            return {"type": "number"}
        case str(name) if name in _TEXTS:
            return {"type": "string", **({"enum": _choices(attribute)} if attribute.allowed_tokens else {})}
        case "target":
            return {"anyOf": [{"type": "string"}, {"type": "array", "items": {"type": "string"}}]}
    type_ = attribute.parsed
    if not isinstance(type_, Type) or type_.square or not (type_.array or type_.count > 1):
        return {}
    value = _scalar(type_.storage)
    if value and type_.count > 1:
        value = {"type": "array", "items": value, "minItems": type_.count, "maxItems": type_.count}
    return {"type": "array", "items": value} if type_.array else value


def _scalar(storage: str) -> JsonSchema:
    for names, kind in ((_INTEGERS, "integer"), (_NUMBERS, "number"), (_TEXTS, "string"), (("bool",), "boolean")):
        if storage in names:
            return {"type": kind}
    return {}


def _choices(attribute: Attribute) -> list[str]:
    """The tokens that a file may write, with the default added if it is not one of the choices."""
    return list(dict.fromkeys([*attribute.allowed_tokens, str(attribute.initial)]))
