"""Finds the expectations of a case that were not met, each with its message."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from graph.base.errors import Problem
from graph.base.suggest import did_you_mean
from graph.values.coercion import coerce
from graph.values.types import Type

from . import case_forms
from .cases import Case
from .seen import Seen
from .updates import read_range, show_updates

_SHOWN = 120


def difference(expected: Any, got: Any, type_: Type | None, tolerance: float) -> str | None:
    """The difference between `got` and `expected`, as `expected ..., got ...`; None if they agree.

    With a type, `expected` is first converted to it. Numbers agree within `tolerance`, absolute up to 1 and relative
    above; NaN agrees with NaN; whole numbers, booleans and text agree exactly.
    """
    wanted = expected
    if type_ is not None:
        try:
            wanted = coerce(type_, expected)
        except ValueError as error:
            return f"expected {show(expected)}, which cannot be: {error}; got {show(got)}"
    off = _distance(wanted, got)
    if off is None or off <= tolerance:
        # None means two equal values that are not numbers.
        return None
    by = f" (error {off:.3g}, tolerance {tolerance:g})" if math.isfinite(off) else ""
    return f"expected {show(expected)}, got {show(got)}{by}"


def _distance(wanted: Any, got: Any) -> float | None:
    """The distance of two values: 0 or None if they are equal, inf if they have no numeric distance."""
    wanted, got = _plain(wanted), _plain(got)
    if isinstance(wanted, list) or isinstance(got, list):
        if not (isinstance(wanted, list) and isinstance(got, list)) or len(wanted) != len(got):
            return math.inf
        # Not max(), which does not handle NaN.
        return max((_distance(a, b) or 0.0 for a, b in zip(wanted, got, strict=True)), default=0.0)
    if isinstance(wanted, Mapping) and isinstance(got, Mapping):
        if wanted.keys() != got.keys():
            return math.inf
        return max((_distance(wanted[key], got[key]) or 0.0 for key in wanted), default=0.0)
    numbers = all(isinstance(one, (int, float)) and not isinstance(one, bool) for one in (wanted, got))
    if not numbers or (isinstance(wanted, int) and isinstance(got, int)):
        return None if type(wanted) is type(got) and wanted == got else math.inf
    return _apart(float(wanted), float(got))


def _apart(wanted: float, got: float) -> float:
    if wanted == got or (math.isnan(wanted) and math.isnan(got)):
        return 0.0
    if not (math.isfinite(wanted) and math.isfinite(got)):
        return math.inf
    return abs(got - wanted) / max(1.0, abs(wanted))


def _plain(value: Any) -> Any:
    """Arrays, their scalars and tuples as lists and Python numbers."""
    if hasattr(value, "dtype"):
        return value.tolist()
    return list(value) if isinstance(value, tuple) else value


def show(value: Any) -> str:
    """A value as written in a test file, shortened in the middle if it is long."""
    text = _written(_plain(value))
    return text if len(text) <= _SHOWN else f"{text[: _SHOWN - 40]} ... {text[-35:]}"


def _written(value: Any) -> str:
    if value is None:
        return "nothing"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float) and not math.isfinite(value):
        return ".nan" if math.isnan(value) else ".inf" if value > 0 else "-.inf"
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, Mapping):
        return f"{{{', '.join(f'{key}: {_written(_plain(one))}' for key, one in value.items())}}}"
    if isinstance(value, list):
        long = len(value) > 60
        shown = [_written(_plain(one)) for one in (value[:30] if long else value)]
        return f"[{', '.join(shown)}{f', ... {len(value)} in all' if long else ''}]"
    return repr(value) if isinstance(value, (int, float)) else str(value)


def failures_of(case: Case, seen: Seen) -> Iterator[Problem]:
    """Every expectation that was not met: expected and actual result, with its place in the test file."""
    expect = case.setup.expect
    unexpected = seen.error is not None and expect.error is None
    yield from _error(case, expect.error, seen)
    if unexpected:
        # It ended early: further failures would only hide the reason.
        return
    if seen.exit == 2:
        for section in sorted(expect.given - {"error"}):
            yield Problem(f"{section}: nothing ran, so nothing of it came", case.at("expect", section))
        return
    for reference, wanted in expect.fired.items():
        yield from _counted(case, ("fired", reference), wanted, lambda name=reference: seen.fired(name))
    for reference, value in expect.outputs.items():
        yield from _output(case, reference, value, seen)
    for reference, values in expect.values.items():
        yield from _values(case, reference, values, seen)
    for reference, wanted in expect.computes.items():
        got = seen.computes(reference)
        if got != wanted:
            yield Problem(
                f"computes {reference}: expected {wanted}, got {got}", case.at("expect", "computes", reference)
            )
    for section, came in (("messages", seen.messages), ("frames", seen.frames)):
        for name, wanted in getattr(expect, section).items():
            yield from _counted(case, (section, name), wanted, lambda name=name, came=came: _named(came, name, seen))
    if expect.warnings is not None:
        yield from _warnings(case, expect.warnings, seen)


def _error(case: Case, wanted: case_forms.ExpectedError | None, seen: Seen) -> Iterator[Problem]:
    if wanted is None:
        if seen.error is not None:
            what = "the run failed" if seen.exit == 1 else "this cannot be run"
            yield Problem(
                f"expected no error, but {what} (exit {seen.exit}): {_text(seen)}{_advice(case, seen)}", case.mark
            )
        return
    mark = case.at("expect", "error")
    if seen.error is None:
        yield Problem(f"error: expected {_described(wanted)}, but {seen.updates} updates ran without one", mark)
        return
    text = _text(seen)
    if wanted.exit is not None and wanted.exit != seen.exit:
        yield Problem(f"error: expected exit {wanted.exit}, got exit {seen.exit}: {text}", mark)
    for piece in wanted.message or ():
        if piece not in text:
            yield Problem(f'error: expected "{piece}" in it, got: {text}', mark)
    if wanted.update is not None and (seen.exit != 1 or wanted.update != seen.updates):
        when = f"in update {seen.updates}" if seen.exit == 1 else "before the first update"
        yield Problem(f"error: expected in update {wanted.update}, came {when}: {text}", mark)


def _text(seen: Seen) -> str:
    return "; ".join(str(seen.error).splitlines())


def _advice(case: Case, seen: Seen) -> str:
    if "needs a world" in str(seen.error) and not seen.in_world:
        return '; set "world: true" in the test'
    return ""


def _described(wanted: case_forms.ExpectedError) -> str:
    parts = [f'"{piece}"' for piece in wanted.message or ()]
    if wanted.exit is not None:
        parts.append(f"exit {wanted.exit}")
    if wanted.update is not None:
        parts.append(f"update {wanted.update}")
    return f"an error ({', '.join(parts)})" if parts else "an error"


def _named(came: Mapping[str, Sequence[int]], name: str, seen: Seen) -> Sequence[int]:
    if name in came:
        return came[name]
    if not seen.in_world:
        raise KeyError('this ran without a world; set "world: true"')
    raise KeyError(f"nothing of that name{did_you_mean(name, came)}")


def _counted(case: Case, where: tuple[str, str], wanted: Any, get: Any) -> Iterator[Problem]:
    """Compares a count, or a list of updates, with the actual updates."""
    name = " ".join(where)
    mark = case.at("expect", *where)
    wanted = wanted if isinstance(wanted, int) else list(wanted)
    try:
        got = list(get())
    except KeyError as error:
        # A name that does not exist never came, which may be what the test expects.
        if wanted not in (0, []) or "without a world" in str(error):
            yield Problem(f"{name}: expected {_shown(wanted)}, got none: {error.args[0]}", mark)
        return
    if isinstance(wanted, int):
        if len(got) != wanted:
            yield Problem(f"{name}: expected {wanted}, got {len(got)} {show_updates(got)}", mark)
    elif sorted(wanted) != got:
        shown = f"{show_updates(got)}{_updates_apart(wanted, got)}"
        yield Problem(f"{name}: expected {show_updates(wanted)}, got {shown}", mark)


def _shown(wanted: Any) -> str:
    return str(wanted) if isinstance(wanted, int) else show_updates(wanted)


def _updates_apart(wanted: Sequence[int], got: Sequence[int]) -> str:
    """The missing and the surplus updates, for long lists."""
    if max(len(wanted), len(got)) <= 8:
        return ""
    missing, extra = Counter(wanted) - Counter(got), Counter(got) - Counter(wanted)
    parts = [
        f"{word} {show_updates(sorted(one.elements()), 12)}"
        for word, one in (("missing", missing), ("extra", extra))
        if one
    ]
    return f" ({', '.join(parts)})"


def _tolerance(case: Case, reference: str) -> float:
    tolerance = case.setup.tolerance
    if isinstance(tolerance, dict):
        tolerance = tolerance.get(reference)
    return case_forms.DEFAULT_TOLERANCE if tolerance is None else tolerance


def _output(case: Case, reference: str, wanted: Any, seen: Seen) -> Iterator[Problem]:
    mark = case.at("expect", "outputs", reference)
    try:
        values, type_ = seen.values(reference)
    except KeyError as error:
        yield Problem(f"outputs {reference}: expected {show(wanted)}, got none: {error.args[0]}", mark)
        return
    if not values:
        yield Problem(f"outputs {reference}: expected {show(wanted)}, but no update was completed", mark)
    elif wrong := difference(wanted, values[-1], type_, _tolerance(case, reference)):
        yield Problem(f"outputs {reference}: {wrong}", mark)


def _values(case: Case, reference: str, wanted: Any, seen: Seen) -> Iterator[Problem]:
    where = ("expect", "values", reference)
    try:
        values, type_ = seen.values(reference)
    except KeyError as error:
        yield Problem(f"values {reference}: {error.args[0]}", case.at(*where))
        return
    if isinstance(wanted, list) and len(wanted) != len(values):
        message = f"expected one value for each of {len(wanted)} updates, got {len(values)} updates"
        yield Problem(f"values {reference}: {message}", case.at(*where))
    wrong = [*_differences(wanted, values, type_, _tolerance(case, reference))]
    if wrong:
        key, update, message = wrong[0]
        more = f" (and {len(wrong) - 1} more that differ)" if len(wrong) > 1 else ""
        yield Problem(f"values {reference}, update {update}: {message}{more}", case.at(*where, key))


def _differences(
    wanted: Any, values: Sequence[Any], type_: Type | None, tolerance: float
) -> Iterator[tuple[str | int, int, str]]:
    """The key (or list index) of each expected value that differs, the update, and the difference."""
    entries: list[tuple[str | int, range, Any]]
    if isinstance(wanted, list):
        entries = [(index, range(index, index + 1), value) for index, value in enumerate(wanted[: len(values)])]
    else:
        entries = [(key, read_range(key, 10**9) or range(0), value) for key, value in wanted.items()]
    for key, updates, value in entries:
        for update in updates:
            if update >= len(values):
                yield key, update, f"expected {show(value)}, but only {len(values)} updates were completed"
                break
            if message := difference(value, values[update], type_, tolerance):
                yield key, update, message


def _warnings(case: Case, wanted: Sequence[case_forms.ExpectedWarning], seen: Seen) -> Iterator[Problem]:
    left = list(seen.warnings)
    # The most specific expectation chooses first: otherwise a bare code would take the only warning that fits it.
    order = sorted(range(len(wanted)), key=lambda index: -len(wanted[index].given))
    for index in order:
        one = wanted[index]
        found = next((warning for warning in left if _is(warning, one)), None)
        if found is None:
            got = (
                ", ".join(f"{warning.code} ({warning.where}, {warning.count}x)" for warning in seen.warnings) or "none"
            )
            yield Problem(f"warnings: expected {_warning(one)}, got {got}", case.at("expect", "warnings", index))
        else:
            left.remove(found)
    for warning in left:
        message = f"warnings: not expected: {warning.code}: {warning.where}: {warning.message}"
        yield Problem(message, case.at("expect", "warnings"))


def _is(warning: Any, wanted: case_forms.ExpectedWarning) -> bool:
    return (
        warning.code == wanted.code
        and wanted.where in (None, warning.where)
        and (wanted.message is None or wanted.message in warning.message)
        and wanted.count in (None, warning.count)
    )


def _warning(wanted: case_forms.ExpectedWarning) -> str:
    extra = [f"{key}: {value}" for key, value in wanted.plain().items() if key != "code" and value is not None]
    return wanted.code + (f" ({', '.join(extra)})" if extra else "")
