"""The names of test files."""

from __future__ import annotations

from pathlib import Path

SUFFIXES = (".test.yaml", ".test.yml", ".test.json")


def is_test_file(path: Path) -> bool:
    """Whether a file name is that of a test file."""
    return path.name.lower().endswith(SUFFIXES)
