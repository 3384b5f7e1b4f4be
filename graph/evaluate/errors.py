"""The error of a node that could not compute."""

from __future__ import annotations

from typing import TYPE_CHECKING

from graph.base.errors import RunError

if TYPE_CHECKING:
    from .node import Node


class ComputeError(RunError):
    """A node's compute raised.

    The message names the node, its place in the file and the update; the cause is chained.
    """

    def __init__(self, node: Node, update: int, message: str) -> None:
        self.node = node
        self.update = update
        place = f"{node.mark}: " if node.mark else ""
        super().__init__(f"{place}node {node.path} ({node.type.short_name}) failed in update {update}: {message}")


class RunawayError(RunError):
    """Execution wires form a loop without a latent node in it."""
