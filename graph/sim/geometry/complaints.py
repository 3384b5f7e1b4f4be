"""Collects warnings about many prims, given once for each kind."""

from __future__ import annotations

import re

from graph.sim.scene.stage import Warn

NAMED = 3
"""Further prims named in one line."""


class Complaints:
    """Collects mistakes of prims and reports each kind in one line: the first prim in full, the others by name."""

    def __init__(self, warn: Warn) -> None:
        self._warn = warn
        self._kinds: dict[tuple[str, str], list[tuple[str, str]]] = {}

    def add(self, code: str, path: str, message: str) -> None:
        """Adds a mistake of a prim; messages that differ only in their numbers are of one kind."""
        kind = code, re.sub(r"-?\d[\d.e+-]*", "#", message)
        entries = self._kinds.setdefault(kind, [])
        if all(path != known for known, _ in entries[:1]):
            entries.append((path, message))

    def flush(self) -> None:
        """Gives the warnings, in the order of their first occurrence; all mistakes of one prim in one line."""
        lines: dict[tuple[str, str], list[str]] = {}
        for (code, _), entries in self._kinds.items():
            path, message = entries[0]
            others = list(dict.fromkeys(other for other, _ in entries[1:]))
            if others:
                more = f" and {len(others) - NAMED} more" if len(others) > NAMED else ""
                message = f"{message}; the same holds for {', '.join(others[:NAMED])}{more}"
            lines.setdefault((code, path), []).append(message)
        for (code, path), messages in lines.items():
            self._warn(code, path, "; ".join(messages))
        self._kinds.clear()
