"""`graph show`: draws the graphs of a file as text, Mermaid or DOT."""

from __future__ import annotations

import argparse

from graph.base.errors import UserError

from .arguments import add_allow, add_nodes, add_skip_outside
from .printing import note_line, problem_line, say, tell


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the command's options."""
    parser.add_argument("file", metavar="FILE", help="graph file (.yaml, .json or .usda)")
    parser.add_argument("--skip-unknown", action="store_true", help="leave nodes of unknown types out of the drawing")
    parser.add_argument(
        "--format",
        choices=("text", "mermaid", "dot"),
        default="text",
        help="text tree, Mermaid flowchart or Graphviz DOT (default: text)",
    )
    parser.add_argument("--values", action="store_true", help="show the values of inputs in pictures too")
    add_nodes(parser)
    add_allow(parser)
    add_skip_outside(parser)


def run(args: argparse.Namespace) -> int:
    """Runs the command. Problems of the file are printed, and the rest is drawn: a drawing helps to find mistakes."""
    from graph.files import examine
    from graph.session.partial_compile import without_unknown_types

    from . import drawing

    examined = examine(args.file, allow=args.allow, skip_outside=args.skip_outside)
    if examined.spec is None:
        raise UserError(examined.problems)
    spec = without_unknown_types(examined.spec) if args.skip_unknown else examined.spec
    drawn = drawing.read(spec)
    if args.format == "text":
        lines = drawing.as_text(drawn)
    else:
        picture = drawing.as_mermaid if args.format == "mermaid" else drawing.as_dot
        lines = picture(drawn, values=args.values)
    for line in lines:
        say(line)
    if not spec.graphs:
        tell(f"graph: {args.file}: no graphs in this file, so there is nothing to draw")
    for note in spec.notes:
        tell(note_line(note))
    for problem in examined.problems:
        tell(problem_line(problem))
    return 2 if examined.problems else 0
