"""What a trade says in sentences: what was compared, what to know of single settings, and the answer to the budget."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from graph.sim.fidelity import KNOBS
from graph.sim.knob import word

from .float32 import KINDS
from .metrics import COSTS, METRICS, ranking
from .outcome import Outcome, Row, bounds_of, group_of, unit_of
from .study import text_of

PAYS = "* pays: no other setting has both less processor time and less error"
UNRESOLVED = "~ less than the reference's own error, which is taken as twice what refining it changes"


def summary(outcome: Outcome) -> list[str]:
    """What was compared with what, and how far it holds, a sentence or two each."""
    study, horizon = outcome.study, outcome.horizon
    lines = [*_leverage(outcome)]
    lines += [f"reference: {text_of(study.reference)}, over {float(study.duration):g} s, seed {study.scene.seed}"]
    if len(outcome.tried) > 1:
        lines.append(f"it is the one that refining changes least: {_convergence(outcome)}")
    if study.refined is None:
        lines.append("the reference has no finer setting to check it with")
    elif not outcome.refined:
        lines.append(f"the reference is unchecked: it does not run at {text_of(study.refined)}")
    else:
        lines.append(
            f"checked with: {text_of(study.refined)}; the reference's own error is taken as twice the difference"
        )
    lines.append(f"errors count up to {horizon.time:.4g} s{f'; {horizon.why}' if horizon.why else ', the whole run'}")
    if outcome.timed < study.duration:
        lines.append(
            f"times are of {float(outcome.timed):g} s after the first frames, to keep the whole short; fewer settings "
            "are timed for longer"
        )
    if not outcome.complete:
        lines.append("interrupted: this is what was measured by then")
    return lines


LEAST_SHARE, MOST_NAMED = 0.05, 3
"""Groups of knobs that act on less of the time are not named; of knobs that are not varied so many are."""


def _leverage(outcome: Outcome) -> Iterator[str]:
    """Which knobs act on most of the processor time of this file, and whether they are varied."""
    study, told = outcome.study, []
    read = frozenset().union(*(row.read for row in outcome.rows))
    for group, share in outcome.leverage.items():
        knobs = [name for name in KNOBS if group_of(name) == group and name in read]
        varied = [name for name in knobs if name in study.varied]
        left = [name for name in knobs if name not in study.varied][:MOST_NAMED]
        if knobs and share >= LEAST_SHARE:
            names = f"varied: {', '.join(varied)}" if varied else f"not varied: {', '.join(left)}"
            told.append(f"{group} {share:.0%} ({names})")
    if told:
        yield f"processor time that knobs act on: {', '.join(told)}"


def _convergence(outcome: Outcome) -> str:
    """By how much refining moves each setting that could be the reference, in the first metric that tells."""
    names = [name for name in ranking(outcome.study.budget) if len({moved.get(name) for _, moved in outcome.tried}) > 1]
    told = outcome.tried[0][0]
    free = [name for name in told if len({setting[name] for setting, _ in outcome.tried}) > 1]
    found = []
    for setting, moved in outcome.tried:
        value = moved.get(names[0]) if names else None
        by = "unchecked" if not moved else f"{round(METRICS[names[0]].error(value or 0.0), 9):.3g}"
        found.append(f"{text_of({name: setting[name] for name in free})} {by}")
    return f"{', '.join(found)}{f' ({names[0]})' if names else ''}"


def values_in(row: Row, knob: str) -> str:
    """The value of a knob in a run, or all of them where several settings are the same run."""
    return "|".join(dict.fromkeys(word(setting[knob]) for setting in row.settings))


def marked(outcome: Outcome, row: Row, metric: str) -> str:
    """The error of a setting with the marks of `UNRESOLVED` and `PAYS`; "" if there is no error."""
    value = row.errors.get(metric)
    if value is None:
        return ""
    marks = ("~" if outcome.unresolved(row, metric) else "") + ("*" if row in outcome.front(metric) else "")
    return f"{value:.3g} {marks:<2}"


def remarks(outcome: Outcome) -> Iterator[str]:
    """What a reader must know of single settings: why one failed, its own warnings; and of knobs without effect."""
    for row in outcome.rows:
        if row.why:
            yield f"{row.status}: {text_of(row.setting)}: {row.why}"
        if row.also:
            equal = " = ".join(map(text_of, row.settings))
            yield f"the same run, made once: {equal}"
        yield from _float32(row)
        if own := [code for code in row.warnings if code not in outcome.reference_warnings]:
            yield f"warnings: {text_of(row.setting)}: {', '.join(own)}"
    if outcome.complete:
        for name, exactly in outcome.idle.items():
            if exactly:
                yield f"{name} changes no error here: take the cheapest value"
            else:
                yield f"{name} changes no error that this reference resolves: a finer --reference would tell more"


COLUMNS = 4
"""Times at which the difference of float32 is said."""


def _float32(row: Row) -> Iterator[str]:
    """How far a device's physics departs from MuJoCo's over time; empty if the physics is MuJoCo's own."""
    found, name = row.float32, text_of(row.setting)
    if found is None:
        return
    times, until = found.growth(COLUMNS)
    if len(times) and times[-1] > 0:
        steps = [
            f"{', '.join(f'{each[at]:.2g} {KINDS[kind]} ({kind})' for kind, each in until.items())} by {time:.3g} s"
            for at, time in enumerate(times)
        ]
        yield f"physics in float32 against MuJoCo, {name}: {'; '.join(steps)}"
    if found.ended and len(times):
        yield f"physics in float32 is compared until {times[-1]:.3g} s, {name}: {found.ended}"
    elif found.ended:
        yield f"physics in float32 is not compared, {name}: {found.ended}"
    if found.without:
        yield f"physics in float32 does without these, which is in its difference, {name}: {', '.join(found.without)}"


def answer(outcome: Outcome) -> tuple[list[str], Row | None]:
    """The answer to the budget, and the setting whose block belongs below it; nothing without a budget."""
    study, best, nearest = outcome.study, outcome.recommended, outcome.nearest
    bounds = bounds_of(study.budget)
    if not study.budget or not outcome.complete:
        return [], None
    if best is not None and best.cost is not None:
        least = outcome.sought
        if least in COSTS:
            return [f"cheapest within {bounds} ({best.cost.cpu:.3g} s/s):"], best
        return [f"least {_error(least)} within {bounds} ({_values(best, [least])}):"], best
    fine = [name for name, bound in study.budget.items() if outcome.doubt(name) > METRICS[name].error(bound)]
    lines = [
        f"no setting is known to keep {bounds_of({name: study.budget[name]})}: the reference's own error may be "
        f"{outcome.doubt(name):.3g}{unit_of(name)}; give a wider budget, a finer --reference or a shorter --duration"
        for name in fine
    ] or [f"no setting keeps {bounds}"]
    if nearest is not None:
        what = "as near as is known, the cheapest" if fine else "the nearest"
        lines.append(f"{what} is {text_of(nearest.setting)}: {_values(nearest, study.budget)}")
    return lines, nearest


def _error(metric: str) -> str:
    return f"1 - {metric}" if METRICS[metric].more else metric


def _values(row: Row, metrics: Iterable[str]) -> str:
    found = ((name, row.value(name)) for name in metrics)
    return ", ".join(f"{name} {value:.3g}{unit_of(name)}" for name, value in found if value is not None)
