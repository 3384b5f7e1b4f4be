"""The table of a campaign as a picture, and as one HTML page that needs nothing else."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from html import escape
from pathlib import Path
from typing import Any

from graph.base.html import page_of, picture, table_of
from graph.base.outputs import write
from graph.base.plotting import png, sheet

from .conduct import OK
from .folder import Folder
from .specification import Campaign
from .table import ATTEMPTS, EXIT, RUN, STATUS, WHY, Row, cell, columns_of, rows_of

PAGE, PICTURE = "campaign.html", "campaign.png"
MOST_PANELS, MOST_LINES, MOST_ROWS = 6, 8, 2000
"""Most plots, values of the second key that have a colour of their own, and rows on the page."""
INCH = (5.2, 3.4)


def write_page(campaign: Campaign, folder: Folder) -> list[Path]:
    """Writes `campaign.html` and `campaign.png` and returns their paths. Raises OSError."""
    rows = rows_of(campaign, folder)
    columns = columns_of(campaign, rows)
    drawn = plots(campaign, rows, columns)
    contents: dict[str, bytes | str] = {PAGE: page(campaign, rows, columns, drawn), PICTURE: drawn}
    for name, content in contents.items():
        write(folder.root / name, content)
    return [folder.root / name for name in contents]


def page(campaign: Campaign, rows: Sequence[Row], columns: Sequence[str], drawn: bytes) -> str:
    """The HTML text."""
    states = Counter(row[STATUS] for row in rows)
    title = f"Campaign of {len(rows):,} runs"
    counts = ", ".join(f"{number:,} {state}" for state, number in states.most_common())
    body = [f"<h1>{title}</h1>", f"<p>{escape(counts)}</p>"]
    if campaign.common:
        body.append(f"<p>Every run: <code>{escape(' '.join(campaign.common))}</code></p>")
    body += [picture(drawn, "metrics over the varied keys"), "<h2>Runs</h2>"]
    shown = [name for name in columns if any(row.get(name) not in (None, "") for row in rows)]
    text = [index for index, name in enumerate(shown) if name in (*campaign.varied, STATUS, WHY)]
    cells = [[_short(row.get(name)) for name in shown] for row in rows[:MOST_ROWS]]
    marks = ["" if row[STATUS] == OK else "bad" for row in rows[:MOST_ROWS]]
    body.append(table_of(shown, cells, text=text, marks=marks))
    if len(rows) > MOST_ROWS:
        body.append(f"<p>The first {MOST_ROWS:,} of {len(rows):,} runs; campaign.csv has all.</p>")
    if campaign.metrics:
        body += ["<h2>Metrics</h2>", table_of(("metric", "expression"), [*campaign.metrics.items()], text=(0, 1))]
    return page_of(title, body)


def _short(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float) else cell(value)


def plots(campaign: Campaign, rows: Sequence[Row], columns: Sequence[str]) -> bytes:
    """A PNG: each metric over the first varied key that is a number; if only the seed differs, its distribution."""
    done = [row for row in rows if row[STATUS] == OK]
    names = [name for name in columns if name not in (RUN, STATUS, EXIT, ATTEMPTS, WHY, *campaign.varied)]
    differing = [
        name for name in names if len({number for row in done if (number := _number(row.get(name))) is not None}) > 1
    ]
    chosen = ([name for name in differing if name in campaign.metrics] or differing)[:MOST_PANELS]
    across = min(2, max(1, len(chosen)))
    down = max(1, math.ceil(len(chosen) / across))
    figure = sheet(INCH[0] * across, INCH[1] * down)
    axes = figure.subplots(down, across, squeeze=False).ravel()
    for axis in axes[len(chosen) :]:
        axis.set_axis_off()
    if not chosen:
        axes[0].text(0.5, 0.5, "no metric differs between the runs", ha="center", va="center")
    keys = [key for key in campaign.varied if key != "seed"]
    over = next((key for key in keys if _is_numeric(done, key)), "")
    by = next((key for key in keys if key != over and 1 < len({row[key] for row in done}) <= MOST_LINES), "")
    for axis, name in zip(axes, chosen, strict=False):
        _panel(axis, done, name, over, by)
    return png(figure)


def _panel(axis: Any, rows: Sequence[Row], name: str, over: str, by: str) -> None:
    groups: dict[str, list[tuple[float, float]]] = {}
    for row in rows:
        value = _number(row.get(name))
        place = _number(row[over]) if over else 0.0
        if value is not None and place is not None:
            groups.setdefault(str(row[by]) if by else "", []).append((place, value))
    for label, points in groups.items():
        if over:
            axis.plot(*zip(*sorted(points), strict=True), "o", alpha=0.7, markersize=4, label=label)
        else:
            axis.hist([value for _, value in points], bins="auto", alpha=0.7, label=label)
            axis.yaxis.get_major_locator().set_params(integer=True)
    axis.set_xlabel(over or name, fontsize=9)
    axis.set_ylabel(name if over else "runs", fontsize=9)
    axis.grid(alpha=0.3)
    if by:
        axis.legend(title=by, fontsize=7, title_fontsize=7)


def _is_numeric(rows: Sequence[Row], key: str) -> bool:
    values = {_number(row[key]) for row in rows if row[key] != ""}
    return None not in values and len(values) > 1


def _number(value: Any) -> float | None:
    if isinstance(value, bool) or value is None:
        return None
    try:
        found = float(value)
    except (TypeError, ValueError):
        return None
    return found if math.isfinite(found) else None
