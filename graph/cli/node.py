"""`graph node`: describes one node type."""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

from .arguments import add_nodes
from .describe import default_of, node_type_as_dict, type_name
from .printing import aligned, safe_line, say, say_json

if TYPE_CHECKING:
    from graph.node.declaration import Attribute, NodeType

WIDEST = 24
"""Characters of names and types from which on they do not widen their column: unions may be long."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the command's options."""
    parser.add_argument("type", metavar="TYPE", help="type id, or its last part where that is unambiguous")
    parser.add_argument("--json", action="store_true", help="print the description as JSON")
    add_nodes(parser)


def run(args: argparse.Namespace) -> int:
    """Runs the command."""
    from graph.node import registry

    node_type = registry.get(args.type)
    if args.json:
        say_json({node_type.id: node_type_as_dict(node_type)})
    else:
        for line in describe(node_type):
            say(line)
    return 0


def describe(node_type: NodeType) -> Iterator[str]:
    """The lines that describe a type."""
    from nodes.catalog.example import example

    yield f"{node_type.id} (version {node_type.version})"
    if node_type.doc:
        yield ""
        yield from aligned((line,) for line in node_type.doc.splitlines())
    yield from _section("inputs", {**node_type.inputs, **node_type.dynamic_inputs})
    yield from _section("outputs", {**node_type.outputs, **node_type.dynamic_outputs})
    yield from _section("state", node_type.state)
    yield ""
    yield "example:"
    for line in example(node_type).splitlines():
        yield f"  {line}"
    if node_type.origin:
        yield ""
        yield f"declared in {node_type.origin}"


def _section(title: str, attributes: Mapping[str, Attribute]) -> Iterator[str]:
    if not attributes:
        return
    yield ""
    yield f"{title}:"
    rows = []
    for name, attribute in attributes.items():
        notes = "; ".join(_notes(attribute))
        rows.append((name, type_name(attribute), safe_line(attribute.doc) + (f" ({notes})" if notes else "")))
    yield from aligned(rows, most=WIDEST)


def _notes(attribute: Attribute) -> Iterator[str]:
    if attribute.unit:
        yield attribute.unit
    default = default_of(attribute)
    if default is not None:
        yield f"default {json.dumps(default)}"
    if attribute.allowed_tokens:
        yield f"one of {', '.join(attribute.allowed_tokens)}"
    if attribute.minimum is not None:
        yield f"at least {attribute.minimum}"
    if attribute.maximum is not None:
        yield f"at most {attribute.maximum}"
    if attribute.optional:
        yield "optional"
    if attribute.literal_only:
        yield "cannot be connected"
    if attribute.deprecated:
        yield f"deprecated: {attribute.deprecated}"
