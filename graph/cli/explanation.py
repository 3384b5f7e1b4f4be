"""Everything that can be said about a graph file before it runs, as plain data: the JSON of `graph explain`."""

from __future__ import annotations

import math
from fractions import Fraction
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

from graph.session.graph_links import Links

from .explain_clocks import MOST_PLANNED_UPDATES, clock_facts, plan_updates
from .explain_graphs import graph_facts
from .explain_run import observe
from .explain_sensors import sensors_of
from .explain_traps import find_traps

if TYPE_CHECKING:
    from graph.session.open import Session

DEFAULT_DURATION_S = 5


def explain(session: Session, file: str | Path) -> dict[str, Any]:
    """Plays the first updates of a session (without casting rays) and plans the rest.

    Times and rates are exact numbers (int or Fraction) [s, Hz]. The App is left playing; the caller closes it.
    """
    app, spec = session.app, session.spec
    duration = spec.duration if spec.duration is not None else Fraction(DEFAULT_DURATION_S)
    updates = math.ceil(duration * app.loop_rate)
    links = Links(session.runner.graphs.values())
    seen = observe(session)
    planned = max(min(updates, MOST_PLANNED_UPDATES), len(seen.substeps))
    steps = list(islice(plan_updates(app), planned))
    sensors = sensors_of(app, seen, steps[: min(updates, planned)])
    return {
        "file": str(file),
        "duration_s": duration,
        "updates": updates,
        "counted_updates": min(updates, MOST_PLANNED_UPDATES),
        "clocks": clock_facts(app, steps) | {"substeps": seen.substeps},
        "graphs": graph_facts(session.runner.graphs.values()),
        "sensors": sensors,
        "topics": _topics(session),
        "traps": [
            {"code": code, "where": where, "message": message}
            for code, where, message in find_traps(app, links, seen, sensors, steps)
        ],
    }


def _topics(session: Session) -> list[dict[str, Any]]:
    """The topics announced so far, and those of publishers that have not computed yet (type None if not known)."""
    from nodes.ros2.publishing import planned_topic

    bus = session.app.bus
    found: dict[str, tuple[str | None, list[str]]] = {
        topic.name: (topic.type_name, list(topic.owners)) for topic in bus.topics.values()
    }
    known = {owner for _, owners in found.values() for owner in owners}
    for node in (node for graph in session.runner.graphs.values() for node in graph.nodes.values()):
        for name in node.type.inputs_as("topic") if node.path not in known else ():
            type_name = getattr(node.db.memory, "type_name", "") or None
            if topic := planned_topic(node.db, node.path, str(node.get(name))):  # otherwise the run reports the mistake
                found.setdefault(topic, (type_name, []))[1].append(node.path)
    return [
        {"topic": name, "type": type_name, "publishers": owners, "heard_in_file": bus.is_listened_to(name)}
        for name, (type_name, owners) in found.items()
    ]
