"""Tells campaign files from graph files, without what reads either."""

from __future__ import annotations

from pathlib import Path

from graph.base.errors import UserError
from graph.files.source import is_usd, read

FIRST = "campaign"
"""The first key of a campaign file."""


def is_campaign(path: Path) -> bool:
    """Whether a file says that it is a campaign."""
    if is_usd(str(path)) or path.suffix.lower() not in (".yaml", ".yml"):
        return False
    try:
        return any(line.startswith(f"{FIRST}:") for line in read(path, str(path)).text.splitlines())
    except UserError:
        return False
