"""`graph schema`: prints the JSON Schema of graph files, for editors."""

from __future__ import annotations

import argparse
import json


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the command's options: there are none."""


def run(args: argparse.Namespace) -> int:
    """Runs the command."""
    from graph.files import json_schema

    print(json.dumps(json_schema(), indent=2))
    return 0
