"""Names of attributes: their Python names, and the order of numbered ones."""

from __future__ import annotations

import re
from collections.abc import Sequence


def python_name(name: str) -> str:
    """The Python name of an attribute: the colons of namespaces (`a:b`) become underscores."""
    return name.replace(":", "_")


def names_in_order(names: Sequence[str]) -> list[str]:
    """Names sorted so that input2 comes before input10; other names keep their places."""

    def key(entry: tuple[int, str]) -> tuple[str, int, int]:
        position, name = entry
        match = re.fullmatch(r"(.*?)(\d+)", name)
        return (match[1], int(match[2]), 0) if match else ("", 0, position)

    prefixes = {re.sub(r"\d+$", "", name) for name in names}
    if len(prefixes) == 1:
        return [name for _, name in sorted(enumerate(names), key=key)]
    return list(names)
