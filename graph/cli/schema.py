"""`graph schema`: prints the JSON Schema of graph files, or of test files, for editors."""

from __future__ import annotations

import argparse

from .arguments import add_nodes
from .printing import say_json

PRIM_TYPES = (
    *("Xform", "Scope", "Cube", "Sphere", "Cylinder", "Cone", "Capsule", "Plane", "Mesh", "PhysicsScene"),
    *("PhysicsFixedJoint", "PhysicsRevoluteJoint", "PhysicsPrismaticJoint", "PhysicsSphericalJoint"),
)
"""Types that an editor offers besides sensors; every other type stays legal."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the command's options."""
    parser.add_argument("--tests", action="store_true", help="the schema of test files (*.test.yaml) instead")
    add_nodes(parser)


def run(args: argparse.Namespace) -> int:
    """Runs the command."""
    from graph.files import json_schema
    from graph.node import registry
    from graph.sim.fidelity import KNOBS
    from graph.sim.settings import DEFAULTS
    from sensors.configs.summary import all_assets
    from sensors.sensor_types import sensor_types

    knobs = {name: knob.schema for name, knob in KNOBS.items()}
    settings = {path: {"default": value} for path, value in DEFAULTS.items()}
    prims = {
        "type": (*PRIM_TYPES, *sensor_types()),
        "config": [asset.short_name for asset in all_assets()],
    }
    schema = json_schema(registry.all(), knobs, settings, prims)
    if args.tests:
        from graph.testing.schema import tests_schema

        schema = tests_schema(schema)
    say_json(schema)
    return 0
