"""Warnings about surprises in a valid file that can be known before a run, for `graph check`."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import islice
from typing import TYPE_CHECKING

from graph.base.errors import UserError
from graph.session.missed_ticks import missed_ticks

from .explain_clocks import Step, plan_updates, updates_of
from .explain_sensors import planned_ticks
from .explain_topics import named_frames, placed_frames
from .explain_traps import Trap, clock_traps, wiring_traps
from .frames import unpublished

if TYPE_CHECKING:
    from graph.evaluate import Node
    from graph.session.open import Session
    from graph.sim.app import App

MOST_UPDATES = 1_000
"""Updates that are planned; problems of later updates are found only by a run."""


def load_traps(session: Session) -> list[Trap]:
    """The traps of a session that has not played: nothing moves, no ray is cast, no physics is built."""
    app = session.app
    nodes = [node for graph in session.runner.graphs.values() for node in graph.nodes.values()]
    steps = list(islice(plan_updates(app), min(updates_of(session), MOST_UPDATES)))
    found = [
        *wiring_traps(session),
        *clock_traps(app, steps),
        *_sensor_traps(app, nodes, steps),
        *_frame_traps(session, nodes),
    ]
    return list(dict.fromkeys(found))


def _frame_traps(session: Session, nodes: Sequence[Node]) -> Iterator[Trap]:
    """Frames that publishers will name and no transform of the file places."""
    placed = placed_frames(nodes)
    if placed:
        for topic, path, frame in named_frames(session, nodes):
            yield from unpublished(topic, [path], frame, placed)


def _sensor_traps(app: App, nodes: Iterable[Node], steps: Sequence[Step]) -> Iterator[Trap]:
    """Warnings of the sensors that nodes name when their render products are made, and ticks that they will miss."""
    from sensors.products import render_product

    named = dict.fromkeys(
        str(path) for node in nodes for name in node.type.inputs_as("sensor") for path in node.get(name) or ()
    )
    before = len(list(app.warnings))
    for path in named:
        try:
            product = render_product(app, path)
        except UserError:  # of a saved scene: a problem of the file otherwise
            continue
        ticks, missed = planned_ticks(app, product, 0, steps)
        if missed:
            yield missed_ticks(app, path, product.sensor.rate, missed, len(ticks) + missed)
    for warning in list(app.warnings)[before:]:
        yield warning.code, warning.where, warning.message
