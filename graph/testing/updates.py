"""Update indices as written in tests: `3`, `0..11`."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import chain
from typing import Any

from graph.base.errors import UserError
from graph.values.coercion import shown

_RANGE = re.compile(r"([0-9]{1,9})(?:\.\.([0-9]{1,9}))?")


@dataclass(frozen=True, slots=True)
class UpdateList:
    """Updates as ranges. A short text may name a million of them, so they are listed only when they are used."""

    ranges: tuple[range, ...] = ()

    def __iter__(self) -> Iterator[int]:
        return chain.from_iterable(self.ranges)

    def __len__(self) -> int:
        return sum(map(len, self.ranges))


def read_range(item: Any, most: int) -> range | None:
    """The updates that an index, or a range with its ends, means; None if it is neither.

    Both may be text (keys of mappings are). Indices are 0 or more and below `most`; ranges must not be reversed.
    """
    found = _RANGE.fullmatch(str(item)) if type(item) in (int, str) else None
    if found is None:
        return None
    first = int(found[1])
    last = first if found[2] is None else int(found[2])
    return range(first, last + 1) if first <= last < most else None


def count_updates(times: Iterable[int], last: int) -> dict[int, int]:
    """How often each update is in a list. Raises ValueError for a value that is not an index, or above `last`."""
    counted: dict[int, int] = {}
    for update in times:
        if not _is_count(update):
            raise ValueError(f"updates are numbered 0, 1, 2 ...; {shown(update)} is not one of them")
        if update > last:
            raise ValueError(f"update {update} comes after the last one, {last}; give more updates")
        counted[update] = counted.get(update, 0) + 1
    return counted


def check_length(updates: int) -> None:
    """Raises UserError unless it is a number of updates."""
    if not _is_count(updates):
        raise UserError(f"updates: expected a whole number from 0, got {shown(updates)}")


def _is_count(value: Any) -> bool:
    return hasattr(value, "__index__") and not isinstance(value, bool) and value >= 0


def show_updates(updates: Iterable[int], most: int = 40) -> str:
    """A list of updates as written in tests, neighbours joined to ranges; the middle of a long list is left out."""
    parts: list[str] = []
    runs: list[list[int]] = []
    for update in updates:
        if runs and update == runs[-1][-1] + 1:
            runs[-1][1:] = [update]
        else:
            runs.append([update])
    for run in runs:
        parts += [f"{run[0]}..{run[1]}"] if len(run) == 2 and run[1] - run[0] > 1 else [str(update) for update in run]
    if len(parts) > most:
        parts = [*parts[: most - 4], "...", *parts[-3:]]
    return f"[{', '.join(parts)}]"
