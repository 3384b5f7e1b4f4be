"""Suggests the name that a misspelt one was probably meant to be."""

from __future__ import annotations

import difflib  # noqa: TID251  the one module that does
import heapq
from collections.abc import Iterable, Sequence
from functools import lru_cache

_CLOSEST = 12
_FEW = 8


def did_you_mean(name: str, known: Iterable[str], otherwise: str = "") -> str:
    """The tail of an error message: `; did you mean "X"?`. If no name is close: `; OTHERWISE`, or ""."""
    best = closest(name, known)
    return f'; did you mean "{best}"?' if best else f"; {otherwise}" if otherwise else ""


def did_you_mean_id(name: str, known: Iterable[str]) -> str:
    """As `did_you_mean`, for ids such as `omni.graph.nodes.Add`: a shared namespace does not make two ids similar."""
    best = closest(name, known)
    if not best or "." not in name:
        return f'; did you mean "{best}"?' if best else ""
    wrong, right = (one[:200].rpartition(".")[2].lower() for one in (name, best))
    same = sum(
        block.size for block in difflib.SequenceMatcher(None, wrong, right, autojunk=False).get_matching_blocks()
    )
    return f'; did you mean "{best}"?' if len(wrong) + len(right) - 2 * same <= max(3, len(wrong) // 3) else ""


def closest(name: str, known: Iterable[str], cutoff: float = 0.6) -> str | None:
    """The most similar known name, or None; `cutoff`: the least similarity, 0 to 1 (`difflib`)."""
    return next(iter(nearest(name, known, 1, cutoff)), None)


def nearest(name: str, known: Iterable[str], most: int, cutoff: float = 0.6) -> list[str]:
    """The similar known names, most similar first. A name that differs only in case is the only answer.

    Fast enough for a file with a thousand mistakes: only the names that share most letter pairs are compared in full.
    """
    name = name[:200]
    folded = name.lower()
    pairs = _pairs(folded)
    scored = []
    for position, candidate in enumerate(dict.fromkeys(known)):
        lowered = candidate.lower()
        if lowered == folded and candidate != name:
            return [candidate]
        shared = len(pairs & _pairs(lowered))
        if shared:
            scored.append((shared - abs(len(candidate) - len(name)) / 2, -position, candidate))
    few = [candidate for _, _, candidate in heapq.nlargest(_CLOSEST, scored)]
    return difflib.get_close_matches(name, few, n=most, cutoff=cutoff)


def one_of(name: str, known: Sequence[str]) -> str:
    """As `did_you_mean`; if no name is close, lists all of them when they are few."""
    if near := did_you_mean(name, known):
        return near
    return f"; there {'is' if len(known) == 1 else 'are'} {', '.join(known)}" if 0 < len(known) <= _FEW else ""


@lru_cache(maxsize=20_000)
def _pairs(text: str) -> frozenset[str]:
    """Pairs of neighbouring letters, with the ends marked, so that short names have pairs in common too."""
    marked = f"^{text[:200]}$"
    return frozenset(marked[i : i + 2] for i in range(len(marked) - 1))
