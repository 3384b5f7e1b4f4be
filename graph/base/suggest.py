"""Helping after a typo."""

from __future__ import annotations

import difflib
import heapq
from collections.abc import Iterable, Sequence
from functools import lru_cache

_CLOSEST = 12
_FEW = 8


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """The tail of an error message: `; did you mean "X"?`, or nothing when no known name is close."""
    best = closest(name, known)
    return f'; did you mean "{best}"?' if best else ""


def did_you_mean_id(name: str, known: Iterable[str]) -> str:
    """The same for ids such as `omni.graph.nodes.Add`: names in one namespace are not close for sharing it."""
    best = closest(name, known)
    if not best or "." not in name:
        return f'; did you mean "{best}"?' if best else ""
    wrong, right = (one[:200].rpartition(".")[2].lower() for one in (name, best))
    same = sum(
        block.size for block in difflib.SequenceMatcher(None, wrong, right, autojunk=False).get_matching_blocks()
    )
    return f'; did you mean "{best}"?' if len(wrong) + len(right) - 2 * same <= max(3, len(wrong) // 3) else ""


def closest(name: str, known: Iterable[str]) -> str | None:
    """The known name that is closest, if any is close.

    Cheap enough for a file of a thousand mistakes: only the names that share most letter pairs are compared in full.
    """
    name = name[:200]
    folded = name.lower()
    pairs = _pairs(folded)
    scored = []
    for position, candidate in enumerate(dict.fromkeys(known)):
        lowered = candidate.lower()
        if lowered == folded and candidate != name:
            return candidate
        shared = len(pairs & _pairs(lowered))
        if shared:
            scored.append((shared - abs(len(candidate) - len(name)) / 2, -position, candidate))
    nearest = [candidate for _, _, candidate in heapq.nlargest(_CLOSEST, scored)]
    return next(iter(difflib.get_close_matches(name, nearest, n=1, cutoff=0.6)), None)


def one_of(name: str, known: Sequence[str]) -> str:
    """As `did_you_mean`; where no name is close, all of them if they are few."""
    if near := did_you_mean(name, known):
        return near
    return f"; there {'is' if len(known) == 1 else 'are'} {', '.join(known)}" if 0 < len(known) <= _FEW else ""


@lru_cache(maxsize=20_000)
def _pairs(text: str) -> frozenset[str]:
    """Neighbouring letters, the ends marked, so that short names share something too."""
    marked = f"^{text[:200]}$"
    return frozenset(marked[i : i + 2] for i in range(len(marked) - 1))
