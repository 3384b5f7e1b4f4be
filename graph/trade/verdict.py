"""What a trade says in sentences: what was compared, what to know of single settings, and the answer to the budget."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from .metrics import COSTS, METRICS
from .outcome import Outcome, Row, bounds_of, unit_of
from .study import text_of

PAYS = "* pays: no other setting has both less processor time and less error"
UNRESOLVED = "~ less than the reference is known to: refining it alone makes as much"


def summary(outcome: Outcome) -> list[str]:
    """What was compared with what, and how far it holds, a sentence or two each."""
    study, horizon = outcome.study, outcome.horizon
    lines = [f"reference: {text_of(study.reference)}, over {float(study.duration):g} s, seed {study.scene.seed}"]
    if study.refined is None:
        lines.append("the reference has no finer setting to check it with")
    elif not outcome.refined:
        lines.append(f"the reference is unchecked: it does not run at {text_of(study.refined)}")
    else:
        lines.append(f"checked with: {text_of(study.refined)} (its error is twice the difference, at first order)")
    lines.append(f"errors count up to {horizon.time:.4g} s{f'; {horizon.why}' if horizon.why else ', the whole run'}")
    if outcome.timed < study.duration:
        lines.append(
            f"times are of {float(outcome.timed):g} s after the first frames, to keep the whole short; fewer settings "
            "are timed for longer"
        )
    if not outcome.complete:
        lines.append("interrupted: this is what was measured by then")
    return lines


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
        if own := [code for code in row.warnings if code not in outcome.reference_warnings]:
            yield f"warnings: {text_of(row.setting)}: {', '.join(own)}"
    if outcome.complete:
        yield from (f"{name} changes no error here: take the cheapest value" for name in outcome.idle)


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
        f"no setting is known to keep {bounds_of({name: study.budget[name]})}: refining the reference alone gives "
        f"{outcome.moved[name]:.3g}{unit_of(name)}; give a wider budget, a finer --reference or a shorter --duration"
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
