"""The variants of a data file: its base, changed by one choice from each of its variant sets."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import reduce
from itertools import product
from typing import Any


@dataclass(frozen=True, slots=True)
class Entry:
    """One variant: what names it (text, or a choice for each variant set), and how it changes the base."""

    variant: str | dict[str, str] | None
    base: Mapping[str, Any]
    changes: tuple[Mapping[str, Any], ...] = ()

    @property
    def document(self) -> Mapping[str, Any]:
        """The document that it describes."""
        return reduce(merged, self.changes, self.base)


def entries(document: Mapping[str, Any]) -> Iterator[Entry]:
    """Every variant, in order; one without a name where the document has no `sets`.

    `sets`: set name -> {choice: changes}. A choice may name the only choices of other sets that go with it
    (`with`: {set: [choices]}). `named` puts the choices together to one name: "OS0_{Model}ch{Mode}res".
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
    """`base` with `changes` in it: objects within objects, anything else replaced."""
    out = dict(base)
    for key, value in changes.items():
        known = out.get(key)
        out[key] = merged(known, value) if isinstance(known, Mapping) and isinstance(value, Mapping) else value
    return out
