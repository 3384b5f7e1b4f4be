"""`graph schema`: prints the JSON Schema of graph, test or campaign files, for editors."""

from __future__ import annotations

import argparse
from typing import Any

from .arguments import add_nodes
from .printing import say_json


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the command's options."""
    kind = parser.add_mutually_exclusive_group()
    kind.add_argument("--tests", action="store_true", help="the schema of test files (*.test.yaml) instead")
    kind.add_argument("--campaign", action="store_true", help="the schema of campaign files of graph sweep instead")
    add_nodes(parser)


def run(args: argparse.Namespace) -> int:
    """Runs the command."""
    if args.campaign:
        from graph.campaign.file import campaign_schema

        say_json(campaign_schema())
        return 0
    from graph.files import json_schema
    from graph.node import registry
    from graph.sim.fidelity import KNOBS
    from graph.sim.scene.prim_keys import concrete_types
    from graph.sim.settings import DEFAULTS
    from graph.spec.migration import former_names
    from sensors.configs.summary import all_assets
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
        from graph.testing.schema import tests_schema

        schema = tests_schema(schema)
    say_json(schema)
    return 0
