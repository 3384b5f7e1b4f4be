"""Work-precision diagrams: error over cost, both logarithmic, with the settings that pay.

Matplotlib has log axes, legends and text, and writes PNG by itself: plotly, which comes with
Open3D, needs a browser for that, and the pictures of `--preview` are pixels that Pillow writes.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from graph.base.plotting import png, sheet
from graph.session.meter import PARTS
from graph.sim.fidelity import KNOBS
from graph.sim.knob import word

from .float32 import KINDS, POINTS
from .metrics import LEADING, METRICS
from .outcome import OK, Outcome, Row
from .study import label

INCH = (6.4, 4.6)
MARKERS = "osD^vP*X<>hp"
MOST_PANELS = 4
PALE = 0.4
"""Opacity of settings whose error is below what the reference resolves."""
COST = "processor time per simulated second [s]"


def overview(outcome: Outcome) -> bytes:
    """The diagrams of the metrics that matter most, in one PNG: those of the budget, then the leading ones."""
    leading = [name for name in outcome.shown if name in outcome.study.budget or name in LEADING]
    return diagrams(outcome, (leading or outcome.shown)[:MOST_PANELS])


def diagrams(outcome: Outcome, metrics: Sequence[str]) -> bytes:
    """A work-precision diagram for each metric, in one PNG."""
    across = 1 if len(metrics) < 2 else 2
    down = max(1, math.ceil(len(metrics) / across))
    figure = sheet(INCH[0] * across, INCH[1] * down + 0.9)
    axes = figure.subplots(down, across, squeeze=False).ravel()
    for axis in axes[len(metrics) :]:
        axis.set_axis_off()
    if not metrics:
        axes[0].text(0.5, 0.5, "no error differs between these settings", ha="center", va="center")
    lines: dict[str, Any] = {}
    for axis, metric in zip(axes, metrics, strict=False):
        diagram(axis, outcome, metric)
        lines |= {text: handle for handle, text in zip(*axis.get_legend_handles_labels(), strict=True)}
    handles = _keys(outcome) | lines
    figure.legend(handles.values(), handles, loc="outside lower center", ncols=2 * across, fontsize=8, frameon=False)
    study = outcome.study
    figure.suptitle(
        f"{study.scene.file.name}: {float(study.duration):g} s, errors up to {outcome.horizon.time:.4g} s, "
        + ("each run once" if study.repeat == 1 else f"medians of {study.repeat} runs"),
        fontsize=10,
    )
    return png(figure)


def parts(outcome: Outcome) -> bytes:
    """Where the processor time of each setting goes, as a PNG."""
    rows = [row for row in outcome.rows if row.timed]
    figure = sheet(9, 1.6 + 0.3 * len(rows))
    axis = figure.subplots()
    names = [_name(row) for row in rows]
    left = [0.0] * len(rows)
    for part in PARTS:
        widths = [row.parts[part].cpu for row in rows]
        axis.barh(names, widths, left=left, label=part)
        left = [one + two for one, two in zip(left, widths, strict=True)]
    axis.invert_yaxis()
    axis.set_xlabel(COST)
    axis.tick_params(labelsize=8)
    axis.spines[["top", "right"]].set_visible(False)
    figure.legend(loc="outside lower center", ncols=len(PARTS), fontsize=8)
    return png(figure)


def growth(outcome: Outcome) -> bytes:
    """How far physics in float32 on a device is from MuJoCo's, over time, as a PNG."""
    figure = sheet(INCH[0] * len(KINDS), INCH[1])
    axes = figure.subplots(1, len(KINDS))
    for row in outcome.rows:
        if row.float32 is None or len(row.float32.times) < 2:
            continue
        times, until = row.float32.growth(POINTS)
        for axis, (kind, unit) in zip(axes, KINDS.items(), strict=True):
            axis.set_title(f"largest difference of a {kind} until then [{unit}]", fontsize=8.5, loc="left")
            axis.set_xlabel("simulated time [s]", fontsize=8)
            axis.set_yscale("log")
            if kind in until:
                axis.plot(times, until[kind], label=_name(row))
    axes[0].legend(fontsize=8)
    return png(figure)


def diagram(axis: Any, outcome: Outcome, metric: str) -> None:
    """Draws one metric of a study: its errors over the costs of the settings."""
    about = METRICS[metric]
    points = [
        (row, row.cost.cpu, about.error(value))
        for row in outcome.rows
        if row.status == OK and row.cost is not None and (value := row.errors.get(metric)) is not None
    ]
    drawn = [error for _, _, error in points if 0 < error < math.inf]
    bound = outcome.study.budget.get(metric)
    allowed = None if bound is None else about.error(bound)
    doubt = outcome.doubt(metric)
    scale = [*drawn, *([allowed] if allowed else []), *([doubt] if doubt > 0 else [])]
    exact = any(error <= 0 for _, _, error in points)
    floor = _log_errors(axis, min(scale, default=1.0), max(scale, default=1.0), exact)
    where = {id(row): (cost, floor if error <= 0 else error) for row, cost, error in points}
    axis.set_xscale("log")
    axis.grid(which="major", color="0.9", linewidth=0.6)
    axis.set_axisbelow(True)
    if doubt > 0:
        axis.axhspan(axis.get_ylim()[0], doubt, color="0.93", label="less than the reference's own error")
    if allowed:
        axis.axhline(allowed, color="tab:red", linestyle="--", linewidth=1, label="budget")
    for row, cost, error in points:
        colour, marker = _look(outcome, row)
        axis.errorbar(
            *where[id(row)],
            xerr=cost * row.spread.cpu if row.spread else None,
            fmt=marker,
            color=colour,
            markerfacecolor="none" if error <= 0 else colour,
            markersize=7,
            elinewidth=1,
            capsize=2,
            alpha=PALE if outcome.unresolved(row, metric) else 1.0,
            clip_on=False,
        )
    front = outcome.front(metric)
    places = [where[id(row)] for row in front if id(row) in where]
    axis.plot(*zip(*places, strict=True), color="0.35", linewidth=1, zorder=1, label="settings that pay")
    best, word_of_it = outcome.recommended, "recommended"
    if best is None and outcome.study.budget:
        best, word_of_it = outcome.nearest, "nearest to the budget"
    if best is not None and id(best) in where:
        _mark(axis, where[id(best)], word_of_it, _name(best))
    _few_ticks(axis, [end for row, cost, _ in points for end in _bar(row, cost)])
    _number(axis, places)
    unit = f" [{about.unit}]" if about.unit else ""
    axis.set_title(f"{metric}: {about.doc}", fontsize=8.5, loc="left")
    axis.set_ylabel(f"{f'1 - {metric}' if about.more else metric}{unit}", fontsize=9)
    names = "\n".join(f"{number}  {_name(row)}" for number, row in enumerate(front, 1))
    axis.set_xlabel(f"{COST}, bars: spread of the runs\n{names}", fontsize=8)
    axis.spines[["top", "right"]].set_visible(False)


def _log_errors(axis: Any, low: float, high: float, exact: bool) -> float:
    """Makes the errors' axis logarithmic, for errors from `low` to `high`; gives the place of an error of 0.

    A logarithm has no 0: it has a line of its own below a gap, with its own tick.
    """
    from matplotlib.ticker import FixedLocator, FuncFormatter, LogFormatterSciNotation, LogLocator, NullLocator

    step = max(0.15, 0.09 * math.log10(3 * high / low))  # decades
    gap, zero, end = (low / 10 ** (part * step) for part in (1, 2, 3))
    axis.set_yscale("log")
    axis.set_ylim(end if exact else gap, high * 3)
    if not exact:
        return zero
    axis.axhspan(end, gap, facecolor="0.97", zorder=0)
    axis.axhline(gap, color="0.4", linewidth=1, linestyle=(0, (1, 2)))
    few = high / low < 100
    found = LogLocator(subs=(1, 2, 5) if few else (1,), numticks=9).tick_values(low, high)
    powers = LogFormatterSciNotation()
    powers.axis = axis.yaxis
    axis.yaxis.set_major_locator(FixedLocator([zero, *(tick for tick in found if gap < tick < 3 * high)]))
    said = FuncFormatter(lambda value, _: "0" if value < gap else f"{value:.3g}" if few else powers(value))
    axis.yaxis.set_major_formatter(said)
    axis.yaxis.set_minor_locator(NullLocator())
    return zero


def _mark(axis: Any, place: tuple[float, float], what: str, name: str) -> None:
    """A ring about a setting, with its name."""
    ring = {"markersize": 15, "markerfacecolor": "none", "markeredgewidth": 1.8, "color": "tab:red"}
    axis.plot(*place, "o", **ring, label=what, zorder=4)
    axis.annotate(
        name, place, xytext=(13, 9), textcoords="offset points", fontsize=9, color="tab:red", weight="bold",
        bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1},
    )  # fmt: skip


def _number(axis: Any, places: Sequence[tuple[float, float]]) -> None:
    """Numbers the settings that pay, above their symbols; their names are below the diagram."""
    from matplotlib.patheffects import withStroke

    for number, place in enumerate(places, 1):
        axis.annotate(
            str(number), place, xytext=(0, 7), textcoords="offset points", ha="center", fontsize=9, weight="bold",
            path_effects=[withStroke(linewidth=3, foreground="white")],
        )  # fmt: skip


def _bar(row: Row, cost: float) -> tuple[float, float]:
    """The ends of the bar of a cost: the spread of its runs."""
    spread = min(row.spread.cpu, 0.9) if row.spread else 0.0  # a logarithm has no 0
    return cost * (1 - spread), cost * (1 + spread)


def _few_ticks(axis: Any, costs: Sequence[float]) -> None:
    """Some plain numbers along the cost, which often spans less than a decade."""
    from matplotlib.ticker import FixedLocator, MaxNLocator, NullLocator

    low, high = min(costs, default=1.0), max(costs, default=1.0)
    margin = max(1.06, (high / low) ** 0.12)
    axis.set_xlim(low / margin, high * margin**2.5)
    if high / low < 20:
        ticks = [tick for tick in MaxNLocator(6).tick_values(low / margin, high * margin**2.5) if tick > 0]
        axis.xaxis.set_major_locator(FixedLocator(ticks))
        axis.xaxis.set_minor_locator(NullLocator())
        axis.xaxis.set_major_formatter("{x:.3g}")


def _look(outcome: Outcome, row: Row) -> tuple[str, str]:
    """Colour and marker of a setting: the colour is the value of the first knob, the marker those of the others."""
    first, *others = outcome.study.varied
    colours, markers = _looks(outcome)
    return colours[row.setting[first]], markers[tuple(row.setting[name] for name in others)]


def _looks(outcome: Outcome) -> tuple[dict[Any, str], dict[tuple[Any, ...], str]]:
    first, *others = outcome.study.varied
    values = dict.fromkeys(row.setting[first] for row in outcome.rows)
    kinds = dict.fromkeys(tuple(row.setting[name] for name in others) for row in outcome.rows)
    colours = {value: f"C{number % 10}" for number, value in enumerate(values)}
    return colours, {kind: MARKERS[number % len(MARKERS)] for number, kind in enumerate(kinds)}


def _keys(outcome: Outcome) -> dict[str, Any]:
    """What colours and markers stand for, for the legend."""
    from matplotlib.lines import Line2D

    first, *others = outcome.study.varied
    colours, markers = _looks(outcome)
    keys = {
        f"{label(first)}={word(value)}": Line2D([], [], color=colour, linewidth=5) for value, colour in colours.items()
    }
    for kind, marker in markers.items():
        if others:
            text = " ".join(f"{label(name)}={word(value)}" for name, value in zip(others, kind, strict=True))
            keys[text] = Line2D([], [], color="0.4", marker=marker, linestyle="none")
    return keys


def _name(row: Row) -> str:
    """The values of a setting, without the names of knobs that speak for themselves."""
    return " ".join(
        word(value) if isinstance(value, str) and name in KNOBS else f"{label(name).rpartition('.')[2]}={word(value)}"
        for name, value in row.setting.items()
    )
