"""A trade as one HTML page that needs nothing else: pictures are inside, nothing is loaded, no script runs."""

from __future__ import annotations

import html
from base64 import b64encode
from collections.abc import Iterable, Sequence

from .diagrams import diagrams, overview, parts
from .metrics import METRICS
from .outcome import Outcome, bounds_of, columns_of
from .outputs import block
from .study import text_of, word

_STYLE = """
body { font: 15px/1.45 system-ui, sans-serif; margin: 2rem auto; max-width: 76rem; padding: 0 1rem; color: #222 }
table { border-collapse: collapse; font-size: 13px; margin: 1rem 0; display: block; overflow-x: auto }
th, td { padding: .25rem .6rem; border-bottom: 1px solid #ddd; text-align: right; white-space: nowrap }
th { border-bottom: 1px solid #888 } td.text, th.text { text-align: left }
tr.best td { background: #fdeaea } tr.bad td { color: #999 } pre { background: #f4f4f4; padding: .8rem }
img { max-width: 100%; height: auto }
"""


def page(outcome: Outcome) -> str:
    """The HTML text."""
    study = outcome.study
    title = f"Speed against accuracy: {study.scene.file.name}"
    body = [f"<h1>{_safe(title)}</h1>", *(f"<p>{_safe(line)}</p>" for line in summary(outcome))]
    if best := outcome.recommended:
        body += [f"<p>The cheapest setting within {_safe(bounds_of(study.budget))}:</p>"]
        body += [f"<pre>{_safe(block(outcome, best))}</pre>"]
    body += [_picture(overview(outcome), "error over cost"), "<h2>Settings</h2>", _settings(outcome)]
    body += ["<h2>Where the time goes</h2>", _picture(parts(outcome), "processor time by part")]
    if len(outcome.shown) > 1:
        body += ["<h2>Every error that differs</h2>", _picture(diagrams(outcome, outcome.shown), "all diagrams")]
    rows = [(name, METRICS[name].unit, METRICS[name].doc) for name in columns_of(outcome)]
    body += ["<h2>What the names mean</h2>", _table(("metric", "unit", "meaning"), rows, text=(0, 1, 2))]
    head = f'<meta charset="utf-8"><title>{_safe(title)}</title><style>{_STYLE}</style>'
    return f'<!doctype html>\n<html lang="en"><head>{head}</head>\n<body>\n' + "\n".join(body) + "\n</body></html>\n"


def summary(outcome: Outcome) -> list[str]:
    """What was compared with what, and how far it holds, a sentence or two each."""
    study, horizon = outcome.study, outcome.horizon
    lines = [f"reference: {text_of(study.reference)}, over {float(study.duration):g} s, seed {study.scene.seed}"]
    if study.refined is None:
        lines.append("the reference has no finer setting to check it with")
    elif not outcome.refined:
        lines.append(f"the reference is unchecked: it does not run at {text_of(study.refined)}")
    else:
        lines.append(f"checked with: {text_of(study.refined)}")
    lines.append(f"errors count up to {horizon.time:g} s{f'; {horizon.why}' if horizon.why else ', the whole run'}")
    if not outcome.complete:
        lines.append("interrupted: this is what was measured by then")
    return lines


def _settings(outcome: Outcome) -> str:
    names = columns_of(outcome)
    best = outcome.recommended
    knobs = tuple(outcome.study.varied)
    heads = (*knobs, "status", "cpu s/s", "±", "wall s/s", "±", *names)
    rows, marks = [], []
    for row in outcome.rows:
        cost, spread = row.cost, row.spread
        figures = (
            f"{cost.cpu:.4g}" if cost else "",
            f"{spread.cpu:.0%}" if spread else "",
            f"{cost.wall:.4g}" if cost else "",
            f"{spread.wall:.0%}" if spread else "",
        )
        errors = ("" if (value := row.errors.get(name)) is None else f"{value:.3g}" for name in names)
        state = row.status if not row.why else f"{row.status}: {row.why}"
        rows.append((*(word(row.setting[name]) for name in knobs), state, *figures, *errors))
        marks.append("best" if row is best else "" if row.status == "ok" else "bad")
    return _table(heads, rows, text=range(len(knobs) + 1), marks=marks)


def _table(
    heads: Sequence[str], rows: Sequence[Sequence[str]], *, text: Iterable[int] = (), marks: Sequence[str] = ()
) -> str:
    left = set(text)

    def cells(tag: str, row: Sequence[str]) -> str:
        return "".join(
            f"<{tag}{' class=text' if number in left else ''}>{_safe(cell)}</{tag}>" for number, cell in enumerate(row)
        )

    lines = [f'<tr class="{marks[number] if marks else ""}">{cells("td", row)}</tr>' for number, row in enumerate(rows)]
    return f"<table><tr>{cells('th', heads)}</tr>{''.join(lines)}</table>"


def _picture(png: bytes, text: str) -> str:
    return f'<img alt="{_safe(text)}" src="data:image/png;base64,{b64encode(png).decode()}">'


def _safe(text: str) -> str:
    return html.escape(text)
