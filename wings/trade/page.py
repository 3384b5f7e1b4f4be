"""A trade as one HTML page that needs nothing else: pictures are inside, nothing is loaded, no script runs."""

from __future__ import annotations

from html import escape

from graph.base.html import page_of, picture, table_of

from .diagrams import diagrams, growth, overview, parts
from .metrics import METRICS
from .outcome import Outcome, columns_of
from .outputs import block
from .study import label
from .verdict import PAYS, UNRESOLVED, answer, marked, remarks, summary, values_in


def page(outcome: Outcome) -> str:
    """The HTML text."""
    study = outcome.study
    title = f"Speed against accuracy: {study.scene.file.name}"
    body = [f"<h1>{escape(title)}</h1>", *(f"<p>{escape(line)}</p>" for line in summary(outcome))]
    said, chosen = answer(outcome)
    body += [f"<p><strong>{escape(line)}</strong></p>" for line in said]
    if chosen is not None:
        body += [f"<pre>{escape(block(outcome, chosen))}</pre>"]
    body += [picture(overview(outcome), "error over cost"), "<h2>Settings</h2>", _settings(outcome)]
    body += [f"<p>{escape(line)}</p>" for line in (PAYS, UNRESOLVED, *remarks(outcome))]
    body += ["<h2>Where the time goes</h2>", picture(parts(outcome), "processor time by part")]
    if len(outcome.shown) > 1:
        body += ["<h2>Every error that differs</h2>", picture(diagrams(outcome, outcome.shown), "all diagrams")]
    if any(row.float32 is not None and len(row.float32.times) > 1 for row in outcome.rows):
        body += ["<h2>Physics in float32 against MuJoCo</h2>", picture(growth(outcome), "difference over time")]
    rows = [(name, METRICS[name].unit, METRICS[name].doc) for name in columns_of(outcome)]
    body += ["<h2>What the names mean</h2>", table_of(("metric", "unit", "meaning"), rows, text=(0, 1, 2))]
    return page_of(title, body)


def _settings(outcome: Outcome) -> str:
    names = tuple(dict.fromkeys((*outcome.shown, *columns_of(outcome))))
    best = outcome.recommended
    knobs = outcome.knobs
    heads = (*map(label, knobs), "status", "frames/s", "cpu s/s", "±", "wall s/s", "±", *names)
    rows, marks = [], []
    for row in outcome.rows:
        cost, spread = row.cost, row.spread
        figures = (
            f"{row.frames:.4g}" if row.frames is not None else "",
            f"{cost.cpu:.4g}" if cost else "",
            f"{spread.cpu:.0%}" if spread else "",
            f"{cost.wall:.4g}" if cost else "",
            f"{spread.wall:.0%}" if spread else "",
        )
        errors = (marked(outcome, row, name) for name in names)
        state = row.status if not row.why else f"{row.status}: {row.why}"
        rows.append((*(values_in(row, name) for name in knobs), state, *figures, *errors))
        marks.append("best" if row is best else "" if row.status == "ok" else "bad")
    return table_of(heads, rows, text=range(len(knobs) + 1), marks=marks)
