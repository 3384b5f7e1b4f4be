"""`graph schema`: prints the JSON Schema of graph files, or of another kind of file, for editors."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from importlib import import_module
from typing import Any

from .arguments import add_nodes
from .printing import say_json


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the command's options."""
    from graph.base.plugins import FILES, loaded
    from graph.files.kinds import FileKind

    parser.set_defaults(kind=None)
    group = parser.add_mutually_exclusive_group()
    group.add_argument("--tests", action="store_true", help="the schema of test files (*.test.yaml) instead")
    for plugin, kind in loaded(FILES, FileKind):
        shown = f"the schema of {kind.help} instead"
        group.add_argument(f"--{plugin.name}", action="store_const", dest="kind", const=kind, help=shown)
    add_nodes(parser)


def run(args: argparse.Namespace) -> int:
    """Runs the command."""
    if args.kind:
        say_json(import_module(args.kind.module).schema())
        return 0
    from graph.files import json_schema
    from graph.node import registry
    from graph.sim.fidelity import KNOBS
    from graph.sim.scene.prim_keys import concrete_types
    from graph.sim.settings import DEFAULTS
    from graph.spec.migration import former_names
    from sensors.configs.shipped import all_assets
    from sensors.sensor_types import sensor_types

    knobs = {name: knob.schema for name, knob in KNOBS.items()}
    settings = {path: {"default": value} for path, value in DEFAULTS.items()}
    shipped = dict.fromkeys(name for one in all_assets() for name in (*one.spellings, *one.products))
    prims: dict[str, dict[str, Any]] = {
        "type": {"enum": sorted({*sensor_types(), *concrete_types()})},
        "config": {
            "anyOf": [{"enum": [*shipped]}, {"pattern": r"\.[jJ][sS][oO][nN]$", "description": "a profile's file"}]
        },
    }
    schema = json_schema(registry.all(), knobs, settings, prims, former_names())
    if args.tests:
        schema = _tests_schema(schema)
    say_json(schema)
    return 0


def _tests_schema(graph_file: Mapping[str, Any]) -> dict[str, Any]:
    """The schema (draft 2020-12) of test files; node types as in `graph_file`, the schema of graph files."""
    from graph.testing.case_forms import CaseFile

    schema: dict[str, Any] = {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "TickGraph test file",
        **CaseFile.schema(),
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


def _described(field: Mapping[str, Any]) -> dict[str, Any]:
    return {key: field[key] for key in ("description",) if key in field}
