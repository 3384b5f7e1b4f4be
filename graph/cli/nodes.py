"""`graph nodes`: lists the node types."""

from __future__ import annotations

import argparse
import re
from fnmatch import fnmatchcase
from typing import TYPE_CHECKING

from graph.base.errors import UserError
from graph.base.suggest import did_you_mean

from .arguments import add_nodes
from .describe import first_line, node_type_as_dict
from .printing import print_table, say_json

if TYPE_CHECKING:
    from graph.node.declaration import NodeType

WORD = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+")
"""A word of a name such as IsaacReadIMU."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the command's options."""
    parser.add_argument(
        "pattern",
        nargs="?",
        metavar="PATTERN",
        help="part of the id, or a pattern with * and ?, in upper or lower case",
    )
    parser.add_argument("--json", action="store_true", help="print everything known of each type as JSON")
    add_nodes(parser)


def run(args: argparse.Namespace) -> int:
    """Runs the command; a pattern without a match is the user's mistake."""
    from graph.node import registry

    types = [one for one in registry.all() if args.pattern is None or fits(one, args.pattern)]
    if not types and args.pattern is not None:
        words = sorted({word for one in registry.all() for word in WORD.findall(one.short_name)})
        near = did_you_mean(args.pattern, words, otherwise="graph nodes lists them all")
        raise UserError(f'no node type fits "{args.pattern}"{near}')
    if args.json:
        say_json({one.id: node_type_as_dict(one) for one in types})
    else:
        rows = [[one.id, str(one.version), first_line(one.doc)] for one in types]
        headings = ["TYPE", "VERSION", "WHAT IT DOES"]
        if any(not one.shipped for one in types):
            headings.append("FROM")
            rows = [[*row, "" if one.shipped else one.origin] for row, one in zip(rows, types, strict=True)]
        print_table(rows, headings)
    return 0


def fits(node_type: NodeType, pattern: str) -> bool:
    """Whether a type's id or short name matches a pattern, or contains it if it has no wildcards."""
    pattern = pattern.lower()
    names = (node_type.id.lower(), node_type.short_name.lower())
    if any(wildcard in pattern for wildcard in "*?["):
        return any(fnmatchcase(name, pattern) for name in names)
    return pattern in names[0]
