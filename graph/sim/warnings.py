"""Warnings of a run: a stable code, a place, and a message; shown once and counted."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from typing import Any

from graph.base.records import dataclass
from graph.base.shorten import brief
from graph.base.warning_keys import Key, key_of

_log = logging.getLogger("tickgraph.warnings")


@dataclass(slots=True)
class RunWarning:
    """One warning; `count` is how often it was raised."""

    code: str
    where: str
    message: str
    count: int = 1

    def as_dict(self) -> dict[str, Any]:
        """The warning as `report.json` holds it."""
        return {"code": self.code, "where": self.where, "message": self.message, "count": self.count}


class WarningList:
    """The distinct warnings of a run in the order of their first appearance; `warning_keys` says which count as the
    same.
    """

    def __init__(self) -> None:
        self._seen: dict[Key, RunWarning] = {}

    def add(self, code: str, where: str, message: str) -> None:
        """Adds a warning; its first appearance is also logged to "tickgraph.warnings"."""
        key = key_of(code, where, message, self._seen)
        known = self._seen.get(key)
        if known is not None:
            known.count += 1
            return
        message = brief(message)
        self._seen[key] = RunWarning(code, where, message)
        _log.warning("%s: %s: %s", code, where, message)

    def __iter__(self) -> Iterator[RunWarning]:
        return iter(self._seen.values())

    def __len__(self) -> int:
        return len(self._seen)

    def codes(self) -> list[str]:
        """The codes in order of first appearance, one per warning."""
        return [warning.code for warning in self]
