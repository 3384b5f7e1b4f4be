"""Seeded random values: distributions written as text, and streams that depend on a seed and a purpose alone.

A value is a function of the seed and the purpose, not of what was drawn before: another variable, another machine or
another order changes none of them.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from hashlib import sha256
from math import exp, floor, isfinite, log
from statistics import NormalDist
from typing import Any

from graph.base.records import dataclass
from graph.base.suggest import did_you_mean

Scalar = bool | int | float | str
Value = Scalar | list[Any]

DIGITS = 9
"""Significant digits of a drawn number, so that it is the same with every C library, and short in reports."""
DEEPEST, LONGEST = 4, 10_000
"""Most brackets inside one another, and most characters."""

_CALL = re.compile(r"\s*([A-Za-z_]\w*)\s*\((.*)\)\s*", re.DOTALL)


class Stream:
    """Random numbers of one purpose.

    The n-th number comes from SHA-256 of seed, purpose and n.
    """

    def __init__(self, seed: int, purpose: str) -> None:
        self._head = f"{seed}\0{purpose}\0"
        self._drawn = 0

    def unit(self) -> float:
        """The next number, uniform in [0, 1), a multiple of 2**-53."""
        found = sha256(f"{self._head}{self._drawn}".encode("utf-8", "surrogatepass")).digest()
        self._drawn += 1
        return float((int.from_bytes(found[:8], "big") >> 11) * 2.0**-53)


@dataclass(frozen=True, slots=True)
class Distribution:
    """A distribution and its arguments, such as `uniform(0, 1)`; lists give a list of independent numbers."""

    name: str
    arguments: tuple[Value, ...]
    text: str

    def draw(self, stream: Stream) -> Value:
        """The next value of a stream: a number, a list of numbers, or one of the choices."""
        if self.name == "choice":
            return self.arguments[floor(stream.unit() * len(self.arguments))]
        lengths = {len(one) for one in self.arguments if isinstance(one, list)}
        if not lengths:
            return _number(self.name, self.arguments, stream)
        [length] = lengths
        rows = [one if isinstance(one, list) else [one] * length for one in self.arguments]
        return [_number(self.name, [row[index] for row in rows], stream) for index in range(length)]


@dataclass(frozen=True, slots=True)
class _Kind:
    form: str
    doc: str
    most: int
    least: int
    check: Callable[[Sequence[Any]], str]
    """What is wrong with the arguments; "" if nothing is."""


def _ordered(values: Sequence[Any]) -> str:
    return "" if values[0] <= values[1] else "the first number is above the second; exchange them"


def _positive(values: Sequence[Any]) -> str:
    return _ordered(values) if min(values) > 0 else "its numbers must be above 0"


def _whole(values: Sequence[Any]) -> str:
    if any(not isinstance(one, int) or isinstance(one, bool) for one in values):
        return "its numbers must be whole"
    return _ordered(values)


def _spread(values: Sequence[Any]) -> str:
    if values[1] < 0:
        return "the standard deviation is below 0"
    if len(values) == 3:
        return "give both bounds, or none"
    return _ordered(values[2:]) if len(values) == 4 else ""


KINDS = {
    "uniform": _Kind("uniform(LOW, HIGH)", "a number from LOW up to HIGH", 2, 2, _ordered),
    "loguniform": _Kind("loguniform(LOW, HIGH)", "a number above 0 whose logarithm is uniform", 2, 2, _positive),
    "normal": _Kind(
        "normal(MEAN, DEVIATION[, LOW, HIGH])", "a normal number, between bounds if they are given", 4, 2, _spread
    ),
    "integers": _Kind("integers(FIRST, LAST)", "a whole number from FIRST to LAST, both included", 2, 2, _whole),
    "choice": _Kind("choice(V1, V2, ...)", "one of the values: numbers, texts or lists", LONGEST, 1, lambda _: ""),
}
"""The distributions by name."""


def is_distribution(text: str) -> bool:
    """Whether a text has the form NAME(...) of a distribution, known or not."""
    return _CALL.fullmatch(text) is not None


def parse(text: Any) -> Distribution:
    """The distribution of a text. Raises ValueError, with a message for the user, for anything else."""
    forms = ", ".join(kind.form for kind in KINDS.values())
    call = _CALL.fullmatch(text) if isinstance(text, str) and len(text) <= LONGEST else None
    if call is None:
        raise ValueError(f"{_shown(text)} is not a distribution; write one of {forms}")
    name, inner = call[1], call[2]
    if name not in KINDS:
        near = did_you_mean(name, KINDS) or f"; write one of {forms}"
        raise ValueError(f'there is no distribution "{_shown(name)}"{near}')
    kind = KINDS[name]
    arguments = tuple(_value(one, 0) for one in split(inner))
    if not kind.least <= len(arguments) <= kind.most:
        raise ValueError(f"{name} has {len(arguments)} arguments; write {kind.form}")
    if name != "choice":
        _check(kind, arguments)
    return Distribution(name, arguments, " ".join(text.split()))


def _check(kind: _Kind, arguments: Sequence[Value]) -> None:
    lengths = {len(one) for one in arguments if isinstance(one, list)}
    if len(lengths) > 1:
        raise ValueError(f"its lists have different lengths, {', '.join(map(str, sorted(lengths)))}")
    length = lengths.pop() if lengths else 1
    if not length:
        raise ValueError("a list is empty")
    rows = [one if isinstance(one, list) else [one] * length for one in arguments]
    for values in zip(*rows, strict=True):
        for one in values:
            if isinstance(one, bool) or not isinstance(one, int | float) or not isfinite(one):
                raise ValueError(f"{one} is not a number; write {kind.form}")
        if wrong := kind.check(values):
            raise ValueError(f"{wrong}: {kind.form}")


def split(text: str) -> list[str]:
    """The parts between commas outside brackets and quotes; none of an empty text. Raises ValueError for open ones."""
    parts, depth, quote, start = [], 0, "", 0
    for index, c in enumerate(text):
        if quote:
            quote = "" if c == quote else quote
        elif c in "\"'":
            quote = c
        elif c in "[({":
            depth += 1
        elif c in "])}":
            depth -= 1
        elif c == "," and not depth:
            parts.append(text[start:index])
            start = index + 1
        if depth < 0:
            break
    if depth or quote:
        raise ValueError("its brackets or quotes are not closed")
    if not parts and not text.strip():
        return []
    return [one.strip() for one in (*parts, text[start:])]


def _value(text: str, depth: int) -> Value:
    if not text:
        raise ValueError("a value is missing between two commas")
    if text.startswith("["):
        if not text.endswith("]") or depth >= DEEPEST:
            raise ValueError(f"{_shown(text)} is not a list of values")
        return [_value(one, depth + 1) for one in split(text[1:-1])]
    if text[0] in "\"'" and len(text) > 1 and text[-1] == text[0]:
        return text[1:-1]
    if text in ("true", "false"):
        return text == "true"
    try:
        return int(text) if re.fullmatch(r"[+-]?\d{1,18}", text) else float(text)
    except ValueError:
        return text


def _shown(value: Any) -> str:
    text = str(value)
    return text if len(text) <= 60 else f"{text[:57]}..."


def _number(name: str, values: Sequence[Any], stream: Stream) -> Scalar:
    """One number; arguments as `_check` leaves them."""
    first, second = values[:2]
    if name == "integers":
        return int(first) + floor(stream.unit() * (int(second) - int(first) + 1))
    unit = stream.unit()
    if name == "uniform":
        return _within(first + (second - first) * unit, first, second)
    if name == "loguniform":
        return _within(exp(log(first) + (log(second) - log(first)) * unit), first, second)
    low, high = values[2:] if len(values) == 4 else (None, None)
    return _normal(first, second, low, high, unit)


def _normal(mean: float, deviation: float, low: float | None, high: float | None, unit: float) -> float:
    if low is None or high is None:
        return _rounded(mean + deviation * NormalDist().inv_cdf(unit + 2.0**-54))
    if not deviation:
        return _within(mean, low, high)
    below, above = NormalDist().cdf((low - mean) / deviation), NormalDist().cdf((high - mean) / deviation)
    share = min(max(below + (above - below) * unit, 2.0**-54), 1 - 2.0**-53)
    return _within(mean + deviation * NormalDist().inv_cdf(share), low, high)


def _within(value: float, low: float, high: float) -> float:
    return min(max(_rounded(value), low), high)


def _rounded(value: float) -> float:
    return float(f"{value:.{DIGITS}g}")
