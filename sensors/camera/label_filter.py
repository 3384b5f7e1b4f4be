"""Which labels count: Replicator's options semanticTypes and semanticFilter."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from fnmatch import fnmatchcase
from typing import Any

from sensors.annotators.types import Reading
from sensors.errors import SensorValueError
from sensors.surfaces.semantics import Labels

OPTIONS: Mapping[str, Any] = {"semanticTypes": None, "semanticFilter": None}


def kept_labels(labels: Labels, options: Mapping[str, Any]) -> Labels:
    """Those of a prim's labels that the options let through: all of them by default.

    semanticTypes: names of taxonomies, or one. semanticFilter: "class:car & !red | truck; shape:*" lets a taxonomy
    through if any clause names it and its expression holds: ! binds strongest, then &, then |; a comma is a | between
    labels, or a ; before taxonomy:label; * stands for any text. Raises SensorValueError for a filter without a colon.
    """
    types: str | Iterable[str] | None = options.get("semanticTypes")
    wanted = {types} if isinstance(types, str) else types
    kept = labels if wanted is None else {name: label for name, label in labels.items() if name in set(wanted)}
    text = options.get("semanticFilter")
    if not text:
        return kept
    clauses = _clauses(text)
    return {name: label for name, label in kept.items() if _named(name, label, clauses)}


def check_filter(reading: Reading) -> None:
    """Raises SensorValueError for a filter that says nothing: before the first frame."""
    if reading.options.get("semanticFilter"):
        _clauses(reading.options["semanticFilter"])


def _clauses(text: Any) -> list[tuple[str, str]]:
    """(taxonomy, expression) pairs of a filter, of which any may hold."""
    if not isinstance(text, str):
        raise SensorValueError(f"semanticFilter {text!r} is not text, such as 'class:car|truck'")
    found: list[tuple[str, str]] = []
    for segment in text.split(";"):
        own: list[tuple[str, str]] = []
        for part in segment.split(",") if segment.strip() else ():
            kind, colon, expression = part.partition(":")
            if colon and kind.strip().startswith("!"):
                raise SensorValueError(f"semanticFilter {text!r}: write ! before a label, as in class:!car")
            if colon:
                own.append((kind.strip(), expression.strip() or "*"))
            elif own:
                own[-1] = own[-1][0], f"{own[-1][1]}|{part}"
            else:
                raise SensorValueError(f"semanticFilter {text!r}: {part.strip()!r} is not taxonomy:label")
        found += own
    return found


def _named(taxonomy: str, label: str, clauses: Iterable[tuple[str, str]]) -> bool:
    parts = [part.strip() for part in label.split(",")]
    return any(fnmatchcase(taxonomy, kind) and _holds(expression, parts) for kind, expression in clauses)


def _holds(expression: str, labels: Iterable[str]) -> bool:
    def factor(text: str) -> bool:
        name = text.strip()
        there = any(fnmatchcase(label, name.removeprefix("!").strip()) for label in labels)
        return there != name.startswith("!")

    return any(all(map(factor, term.split("&"))) for term in expression.split("|") if term.strip())
