"""The JSON Schema of `*.test.yaml` files, for editors: made from the models that check them and from the registries."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from . import case_forms

JsonSchema = dict[str, Any]


def tests_schema(graph_file: Mapping[str, Any]) -> JsonSchema:
    """The schema (draft 2020-12) of test files; node types as in `graph_file`, the schema of graph files."""
    schema: JsonSchema = {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "TickGraph test file",
        **case_forms.CaseFile.schema(),
    }
    definitions = schema["$defs"]
    definitions.update({name: one for name, one in graph_file["$defs"].items() if name not in ("Case", "Expect")})
    for setup in (schema, definitions["Case"]):
        properties = setup["properties"]
        for section in ("settings", "fidelity"):
            properties[section] = {**graph_file["properties"][section], **_described(properties[section])}
        if "NodeType" in definitions:
            about = _described(properties["node"])
            properties["node"] = {**about, "anyOf": [{"$ref": "#/$defs/NodeType"}, {"type": "null"}]}
    return schema


def _described(field: Mapping[str, Any]) -> JsonSchema:
    return {key: field[key] for key in ("description",) if key in field}
