"""Everything that can be said about a graph file before it runs, as plain data: the JSON of `graph explain`."""

from __future__ import annotations

from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

from graph.session.graph_links import Links

from .explain_clocks import MOST_PLANNED_UPDATES, clock_facts, duration_of, plan_updates, updates_of
from .explain_graphs import graph_facts
from .explain_run import observe
from .explain_sensors import sensors_of
from .explain_topics import topic_facts
from .explain_traps import find_traps
from .left_out import left_out

if TYPE_CHECKING:
    from graph.session.open import Session


def explain(session: Session, file: str | Path) -> dict[str, Any]:
    """Plays the first updates of a session (without casting rays) and plans the rest.

    Times and rates are exact numbers (int or Fraction) [s, Hz]. The App is left playing; the caller closes it.
    """
    app, updates = session.app, updates_of(session)
    links = Links(session.runner.graphs.values())
    seen = observe(session)
    planned = max(min(updates, MOST_PLANNED_UPDATES), len(seen.substeps))
    steps = list(islice(plan_updates(app), planned))
    sensors = sensors_of(app, seen, steps[: min(updates, planned)])
    topics = topic_facts(session)
    return {
        "file": str(file),
        "duration_s": duration_of(session),
        "updates": updates,
        "counted_updates": min(updates, MOST_PLANNED_UPDATES),
        "clocks": clock_facts(app, steps) | {"substeps": seen.substeps},
        "physics": None if app.physics is None else app.physics.facts(),
        "graphs": graph_facts(session.runner.graphs.values()),
        "sensors": sensors,
        "topics": topics,
        "left_out": left_out(session, seen, sensors, topics),
        "traps": [
            {"code": code, "where": where, "message": message}
            for code, where, message in find_traps(session, links, seen, sensors, steps)
        ],
    }
