"""The names by which a shipped asset is found."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import PurePosixPath

ROOT = "/Isaac/Sensors"


def spellings(path: str, aliases: Sequence[str]) -> tuple[str, ...]:
    """Asset path, file stem, stem without the vendor, both with spaces for underscores; then further names."""
    asset = PurePosixPath(path)
    vendor = asset.relative_to(ROOT).parts[0]
    short = asset.stem.removeprefix(f"{vendor}_")
    names = (path, asset.stem, asset.stem.replace("_", " "), short, short.replace("_", " "), *aliases)
    return tuple(dict.fromkeys(names))


def short_name(path: str, aliases: Sequence[str]) -> str:
    """The name used in messages."""
    return aliases[0] if aliases else min(spellings(path, aliases), key=len)
