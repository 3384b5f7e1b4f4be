"""All that can be told of a graph file before it runs, as plain data: the JSON of `graph explain`."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .explain_clocks import Step, loop_dt, plan_updates
from .explain_links import Links
from .explain_run import Observed, observe
from .explain_sensors import sensors_of
from .explain_traps import find_traps

if TYPE_CHECKING:
    from graph.assembly import Session
    from graph.sim import App

DEFAULT_DURATION_S = 5
MOST_PLANNED_UPDATES = 100_000
"""How many updates are counted through, one by one; a longer run is told of by its first ones."""


def explain(session: Session, file: str | Path) -> dict[str, Any]:
    """Plays the first updates of a session (blind: no ray is cast) and plans the rest.

    Times and rates are exact numbers (int or Fraction) [s, Hz]. Leaves the App playing; the caller closes it.
    """
    app, spec = session.app, session.spec
    duration = spec.duration if spec.duration is not None else Fraction(DEFAULT_DURATION_S)
    updates = math.ceil(duration * app.loop_rate)
    links = Links(spec.graphs, session.runner.graphs)
    seen = observe(session, links)
    planned = max(min(updates, MOST_PLANNED_UPDATES), len(seen.substeps))
    steps = list(islice(plan_updates(app), planned))
    sensors = sensors_of(app, seen, steps[: min(updates, planned)])
    return {
        "file": str(file),
        "duration_s": duration,
        "updates": updates,
        "counted_updates": min(updates, MOST_PLANNED_UPDATES),
        "clocks": _clocks(app, steps, seen),
        "sensors": sensors,
        "topics": _topics(session),
        "traps": [
            {"code": code, "where": where, "message": message}
            for code, where, message in find_traps(app, links, seen, sensors, steps)
        ],
    }


def _clocks(app: App, steps: Sequence[Step], seen: Observed) -> dict[str, Any]:
    dt = loop_dt(app)
    accepted = next((step.timeline_dt for step in steps if step.timeline_dt), Fraction(0))
    gaps = [step.index for step in steps if step.timeline_dt][:2]
    every = gaps[1] - gaps[0] if len(gaps) == 2 else 1
    sps = app.simulation.steps_per_second
    return {
        "experience": app.experience,
        "physics_hz": sps,
        "loop_hz": 1 / dt,
        "timeline_step_s": accepted,
        "timeline_every_updates": every,
        "substeps_per_update": sps * accepted / every,
        "timeline_per_loop": accepted / every / dt,
        "substeps": seen.substeps,
        "multi_tick": app.rendering.multi_tick,
    }


def _topics(session: Session) -> list[dict[str, Any]]:
    """The topics announced so far, and those of publishers that have not come to it (type None)."""
    from nodes.ros2.publishing import topic_name

    bus = session.app.bus
    found: dict[str, tuple[str | None, list[str]]] = {
        topic.name: (topic.type_name, list(topic.owners)) for topic in bus.topics.values()
    }
    known = {owner for _, owners in found.values() for owner in owners}
    for node in (node for graph in session.runner.graphs.values() for node in graph.nodes.values()):
        if node.path not in known and "Publish" in node.type.short_name and "topicName" in node.type.inputs:
            found.setdefault(topic_name(node.db, node.path), (None, []))[1].append(node.path)
    return [
        {"topic": name, "type": type_name, "publishers": owners, "heard_in_file": bus.is_listened_to(name)}
        for name, (type_name, owners) in found.items()
    ]
