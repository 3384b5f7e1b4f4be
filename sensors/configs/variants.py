"""The variants of a data file: its base, changed by one choice of each variant set."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import reduce
from itertools import product
from typing import Any

from graph.base.records import dataclass


@dataclass(frozen=True, slots=True)
class Entry:
    """One variant: its name (text, or a choice for each variant set), and its changes of the base."""

    variant: str | dict[str, str] | None
    base: Mapping[str, Any]
    changes: tuple[Mapping[str, Any], ...] = ()

    @property
    def document(self) -> Mapping[str, Any]:
        """The document of this variant."""
        return reduce(merged, self.changes, self.base)


def entries(document: Mapping[str, Any]) -> Iterator[Entry]:
    """Every variant, in order; a single one without a name if the document has no `sets`.

    `sets`: set name -> {choice: changes}. A choice may restrict the choices of other sets (`with`: {set: [choices]}).
    `named` joins the choices to one name: "OS0_{Model}ch{Mode}res".
    """
    sets: Mapping[str, Mapping[str, Any]] = document.get("sets", {})
    if not sets:
        yield Entry(None, document)
        return
    for choices in product(*sets.values()):
        chosen = dict(zip(sets, choices, strict=True))
        changes = tuple(sets[name][choice] for name, choice in chosen.items())
        together = (each for change in changes for each in change.get("with", {}).items())
        if all(chosen[name] in allowed for name, allowed in together):
            yield Entry(document["named"].format(**chosen) if "named" in document else chosen, document, changes)


def merged(base: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """`base` with `changes` applied: objects are merged, anything else is replaced."""
    out = dict(base)
    for key, value in changes.items():
        known = out.get(key)
        out[key] = merged(known, value) if isinstance(known, Mapping) and isinstance(value, Mapping) else value
    return out
