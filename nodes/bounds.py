"""Bounds of numbers that a file writes, for `check` of node types."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from graph.node import NodeAtLoad

if TYPE_CHECKING:
    from graph.node.declaration import Check


def at_least(**least: float) -> Check:
    """A check of written numbers: each input by its name with the smallest value that works."""

    def check(node: NodeAtLoad) -> Iterator[tuple[str, str]]:
        for name, bound in least.items():
            value = getattr(node.db.inputs, name)
            if name in node.given and isinstance(value, int | float) and not value >= bound:
                yield name, f"{value:g} is too small; give it {bound:g} or more"

    return check
