"""The variants of a data file: its base, changed by one choice from each of its variant sets."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import product
from typing import Any


@dataclass(frozen=True, slots=True)
class Entry:
    """One variant: what names it (text, or a choice for each variant set) and the document it describes."""

    variant: str | dict[str, str] | None
    document: Mapping[str, Any]


def entries(document: Mapping[str, Any]) -> list[Entry]:
    """Every variant, in order; one without a name where the document has no `sets`.

    `sets`: set name -> {choice: changes}. A choice may name the only choices of other sets that go with it
    (`with`: {set: [choices]}). `named` puts the choices together to one name: "OS0_{Model}ch{Mode}res".
    """
    sets: Mapping[str, Mapping[str, Any]] = document.get("sets", {})
    if not sets:
        return [Entry(None, document)]
    return [Entry(*found) for found in _combinations(document, sets)]


def _combinations(
    document: Mapping[str, Any], sets: Mapping[str, Mapping[str, Any]]
) -> Iterator[tuple[str | dict[str, str], Mapping[str, Any]]]:
    for choices in product(*sets.values()):
        chosen = dict(zip(sets, choices, strict=True))
        changes = [sets[name][choice] for name, choice in chosen.items()]
        if all(chosen[name] in allowed for change in changes for name, allowed in change.get("with", {}).items()):
            out = document
            for change in changes:
                out = merged(out, change)
            yield document["named"].format(**chosen) if "named" in document else chosen, out


def merged(base: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """`base` with `changes` in it: objects within objects, anything else replaced."""
    out = dict(base)
    for key, value in changes.items():
        known = out.get(key)
        out[key] = merged(known, value) if isinstance(known, Mapping) and isinstance(value, Mapping) else value
    return out
