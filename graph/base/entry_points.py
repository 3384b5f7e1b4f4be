"""Entry points that installed packages declare for TickGraph.

Most packages declare nothing for us. Only where one does is `importlib.metadata` imported, which reads all that is
installed.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from typing import TYPE_CHECKING

from .inputs import start_of

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

LARGEST = 1 << 20
"""Bytes of a package's table of entry points that are looked at."""


def entry_points(*groups: str) -> list[list[EntryPoint]]:
    """The entry points of each group, sorted by name and value."""
    wanted = [f"[{group}]".encode() for group in groups]
    if not any(group in table for table in _tables() for group in wanted):
        return [[] for _ in groups]
    from importlib import metadata

    found = metadata.entry_points()
    return [sorted(found.select(group=group), key=lambda entry: (entry.name, entry.value)) for group in groups]


def _tables() -> Iterator[bytes]:
    """The tables of the packages on Python's path; of an archive on it a table that may name any group."""
    for folder in dict.fromkeys(sys.path):
        if os.path.isfile(folder):
            yield b"[tickgraph.nodes][tickgraph.ogn][tickgraph.sensors]"
            continue
        try:
            names = os.listdir(folder or os.curdir)
        except OSError:
            continue
        for name in names:
            if name.endswith((".dist-info", ".egg-info")):
                try:
                    yield start_of(os.path.join(folder, name, "entry_points.txt"), LARGEST)
                except OSError:
                    continue
