"""The user's permission to run code from a graph file: without it, no code of the file runs."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from graph.base.errors import Problem

if TYPE_CHECKING:
    from . import Graph

REFUSED = (
    "runs Python code that the graph file brings; if you trust the file, allow it by --allow-scripts "
    "(allow_scripts=True in Python)"
)


def script_problems(graphs: Iterable[Graph]) -> list[Problem]:
    """A line for each node that would run code from the file."""
    return [
        Problem(f'node "{node.name}" ({node.type.short_name}) {REFUSED}', node.mark)
        for graph in graphs
        for node in graph.nodes.values()
        if node.type.runs_code
    ]
