"""Entry points that other packages declare for TickGraph.

Most packages declare nothing for us. Only where one does is `importlib.metadata` imported, which reads all that is
installed.
"""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterator
from typing import TYPE_CHECKING

from .inputs import start_of

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

LARGEST = 1 << 20
"""Bytes of a package's table of entry points that are looked at."""
OWN = re.compile(r"tickgraph-[^-]+\.(?:dist|egg)-info")
"""The folder of facts on TickGraph itself, whose declarations `graph.base.plugins` reads."""


def entry_points(*groups: str) -> list[list[EntryPoint]]:
    """The entry points of each group, sorted by name and value; without TickGraph's own."""
    wanted = [f"[{group}]".encode() for group in groups]
    if not any(group in table for table in _tables(b"".join(wanted)) for group in wanted):
        return [[] for _ in groups]
    from importlib import metadata

    found = (metadata.entry_points(group=group) for group in groups)
    return [
        sorted((entry for entry in entries if _of_others(entry)), key=lambda entry: (entry.name, entry.value))
        for entries in found
    ]


def _of_others(entry: EntryPoint) -> bool:
    return entry.dist is None or entry.dist.name != "tickgraph"


def _tables(any_group: bytes) -> Iterator[bytes]:
    """The tables of the packages on Python's path; for an archive on it, which may hold one, a table of every group."""
    for folder in dict.fromkeys(sys.path):
        if os.path.isfile(folder):
            yield any_group
            continue
        try:
            names = os.listdir(folder or os.curdir)
        except OSError:
            continue
        for name in names:
            if name.endswith((".dist-info", ".egg-info")) and not OWN.fullmatch(name):
                try:
                    yield start_of(os.path.join(folder, name, "entry_points.txt"), LARGEST)
                except OSError:
                    continue
