"""Helping after a typo."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """The tail of an error message: `; did you mean "X"?`, or nothing when no known name is close."""
    names = list(dict.fromkeys(known))
    folded = {candidate.lower(): candidate for candidate in reversed(names)}
    if name.lower() in folded:
        return f'; did you mean "{folded[name.lower()]}"?'
    close = difflib.get_close_matches(name[:200], names, n=1, cutoff=0.6)
    return f'; did you mean "{close[0]}"?' if close else ""
