"""`KEY=V1,V2,...`: values of a key that many runs take in turn."""

from __future__ import annotations

import re
from typing import Any

from graph.base.records import dataclass
from graph.spec.distributions import Stream, is_distribution, parse, split

MOST_VALUES = 100_000
"""Most values of one key."""

_RANGE = re.compile(r"\s*([+-]?\d{1,15})\.\.([+-]?\d{1,15})(?:\.\.(\d{1,15}))?\s*")
_SAMPLES = re.compile(r"(.*\))\s*\*\s*(\d{1,9})\s*", re.DOTALL)


@dataclass(frozen=True, slots=True)
class Varied:
    """A key and its values as text; draw: instead of values, a distribution from which each point draws."""

    name: str
    values: tuple[str, ...]
    draw: str = ""


def read_varied(name: str, text: str, seed: int = 0) -> Varied:
    """The values of a key.

    `1,2,5`; `0..99` and `0..100..5`, both ends included; `uniform(0, 1)*20`, twenty values of a distribution that the
    seed draws; `uniform(0, 1)`, a value of its own for each point. Repeated values count once, drawn ones do not.
    Raises ValueError.
    """
    if not text.strip(", "):
        raise ValueError("write it as KEY=V1,V2,...")
    if samples := _SAMPLES.fullmatch(text):
        distribution, count = parse(samples[1]), int(samples[2])
        _check_count(count)
        drawn = (distribution.draw(Stream(seed, f"vary {name} {number}")) for number in range(count))
        return Varied(name, tuple(map(word_of, drawn)))
    if is_distribution(text):
        return Varied(name, (), parse(text).text)
    values: list[str] = []
    for part in split(text):
        values += _values(part)
        _check_count(len(values))
    return Varied(name, tuple(dict.fromkeys(values)))


def drawn_at(one: Varied, seed: int, point: int) -> str:
    """The value that a point draws."""
    return word_of(parse(one.draw).draw(Stream(seed, f"vary {one.name} point {point}")))


def word_of(value: Any) -> str:
    """A value as text that reads back as itself."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(word_of, value))}]"
    return str(value)


def _values(part: str) -> list[str]:
    if not part:
        return []
    found = _RANGE.fullmatch(part)
    if not found:
        return [part]
    first, last, step = int(found[1]), int(found[2]), int(found[3] or 1)
    if last < first or not step:
        raise ValueError(f"{part} is not a range; write FIRST..LAST or FIRST..LAST..STEP, from low to high")
    _check_count((last - first) // step + 1)
    return [str(number) for number in range(first, last + 1, step)]


def _check_count(count: int) -> None:
    if not 0 < count <= MOST_VALUES:
        raise ValueError(f"{count:,} values; give 1 to {MOST_VALUES:,}")
