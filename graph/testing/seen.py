"""What a test observed, for whole graphs and for a single node alike."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from graph.base.errors import RunError, UserError
from graph.values.types import Type

from .node import Trace
from .trace import GraphTrace
from .world import Observed


def _nothing(reference: str) -> Any:
    raise KeyError("nothing ran")


@dataclass
class Seen:
    """What a run did, and, if it ended early, the exit code of `graph run` and the error.

    The functions take references as written in tests and raise KeyError for unknown ones.
    """

    updates: int = 0
    in_world: bool = False
    error: RunError | UserError | None = None
    exit: int = 0
    fired: Callable[[str], Sequence[int]] = _nothing
    values: Callable[[str], tuple[Sequence[Any], Type | None]] = _nothing
    computes: Callable[[str], int] = _nothing
    warnings: Sequence[Any] = ()
    messages: Mapping[str, Sequence[int]] = field(default_factory=dict)
    """The updates in which a message came, by topic."""
    frames: Mapping[str, Sequence[int]] = field(default_factory=dict)
    """The updates in which a frame came, by sensor prim."""


def of_graphs(trace: GraphTrace) -> Seen:
    """The observations of a run of graphs."""

    def values(reference: str) -> tuple[Sequence[Any], Type | None]:
        node, full = trace.attribute(reference)
        return trace.values(reference), node.types[full]

    return Seen(
        trace.updates,
        trace.in_world,
        trace.error,
        1 if trace.error else 0,
        trace.fired,
        values,
        trace.computes,
        trace.warnings,
        {topic: [update for update, _ in found] for topic, found in trace.messages.items()},
        trace.frames,
    )


def of_node(trace: Trace, world: Observed | None) -> Seen:
    """The observations of a run of one node."""

    def values(reference: str) -> tuple[Sequence[Any], Type | None]:
        return trace.values(reference), trace.node.types[trace.full_name(reference)]

    return Seen(
        trace.updates,
        world is not None,
        trace.error,
        1 if trace.error else 0,
        trace.fired,
        values,
        lambda reference: trace.computes,
        [*trace.warnings, *(world.app.warnings if world else ())],
        {topic: [update for update, _ in found] for topic, found in world.messages.items()} if world else {},
        world.frames if world else {},
    )
