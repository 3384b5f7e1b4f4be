"""Which labels count: Replicator's options semanticTypes and semanticFilter."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from fnmatch import fnmatchcase
from typing import Any

from sensors.errors import SensorValueError
from sensors.surfaces.semantics import Labels

OPTIONS: Mapping[str, Any] = {"semanticTypes": None, "semanticFilter": None}


def kept_labels(labels: Labels, options: Mapping[str, Any]) -> Labels:
    """Those of a prim's labels that the options let through: all of them by default.

    semanticTypes: names of taxonomies. semanticFilter: "class:car|truck; shape:*" lets labels through that a clause
    names; * stands for any text. Raises SensorValueError for a filter without a colon.
    """
    types: Iterable[str] | None = options.get("semanticTypes")
    kept = labels if types is None else {name: label for name, label in labels.items() if name in set(types)}
    text = options.get("semanticFilter")
    if not text:
        return kept
    clauses = []
    for clause in str(text).split(";"):
        kind, colon, names = clause.partition(":")
        if not colon:
            raise SensorValueError(f"semanticFilter {text!r}: {clause.strip()!r} is not taxonomy:label")
        clauses += [(kind.strip(), name.strip()) for name in names.split("|")]
    return {name: label for name, label in kept.items() if _named(name, label, clauses)}


def _named(taxonomy: str, label: str, clauses: Iterable[tuple[str, str]]) -> bool:
    parts = [part.strip() for part in label.split(",")]
    return any(fnmatchcase(taxonomy, kind) and any(fnmatchcase(part, name) for part in parts) for kind, name in clauses)
