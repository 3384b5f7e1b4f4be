"""A trade as one HTML page that needs nothing else: pictures are inside, nothing is loaded, no script runs."""

from __future__ import annotations

import html
from base64 import b64encode
from collections.abc import Iterable, Sequence

from .diagrams import diagrams, overview, parts
from .metrics import METRICS
from .outcome import Outcome, columns_of
from .outputs import block
from .study import label
from .verdict import PAYS, UNRESOLVED, answer, marked, remarks, summary, values_in

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
    said, chosen = answer(outcome)
    body += [f"<p><strong>{_safe(line)}</strong></p>" for line in said]
    if chosen is not None:
        body += [f"<pre>{_safe(block(outcome, chosen))}</pre>"]
    body += [_picture(overview(outcome), "error over cost"), "<h2>Settings</h2>", _settings(outcome)]
    body += [f"<p>{_safe(line)}</p>" for line in (PAYS, UNRESOLVED, *remarks(outcome))]
    body += ["<h2>Where the time goes</h2>", _picture(parts(outcome), "processor time by part")]
    if len(outcome.shown) > 1:
        body += ["<h2>Every error that differs</h2>", _picture(diagrams(outcome, outcome.shown), "all diagrams")]
    rows = [(name, METRICS[name].unit, METRICS[name].doc) for name in columns_of(outcome)]
    body += ["<h2>What the names mean</h2>", _table(("metric", "unit", "meaning"), rows, text=(0, 1, 2))]
    head = f'<meta charset="utf-8"><title>{_safe(title)}</title><style>{_STYLE}</style>'
    return f'<!doctype html>\n<html lang="en"><head>{head}</head>\n<body>\n' + "\n".join(body) + "\n</body></html>\n"


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
