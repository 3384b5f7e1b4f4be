"""Checks the files that a graph file names: they must lie below its folder, or below a folder that the user allowed."""

from __future__ import annotations

import re
import shlex
from collections.abc import Sequence
from pathlib import Path

from graph.base import asset_roots
from graph.base.suggest import did_you_mean

from .text import quoted

REPORT = "report.json"
"""The file that `graph run --out` writes beside the recording."""

_LONGEST_NAME = 255
_LONGEST_PATH = 1000
_URL = re.compile(r"[A-Za-z][A-Za-z0-9+.-]+:")


def confined(text: str, folder: Path, allow: Sequence[Path] = ()) -> Path:
    """The absolute path, symbolic links resolved, of an existing file that a graph file in `folder` names.

    Raises ValueError, with a message for the user, for a missing file and for a file outside `folder` and `allow`.
    """
    mapped = asset_roots.local_file(text)
    if mapped is not None and mapped.is_file():
        return mapped
    if _URL.match(text):
        raise ValueError(f"{quoted(text)} is a URL; only files below the graph file's folder are read")
    path = _resolved(text, folder)
    roots = [root.resolve() for root in (folder, *allow)]
    if not any(path.is_relative_to(root) for root in roots):
        raise ValueError(
            f"{quoted(text)} is outside the graph file's folder; move it there, or allow its folder with "
            f"--allow {shlex.quote(str(path.parent))}"
        )
    if path.is_dir():
        raise ValueError(f"{quoted(text)} is a folder, not a file")
    if not path.is_file():
        raise ValueError(f"there is no file {quoted(text)} (relative to the graph file){_near(text, folder)}")
    return path


def is_own_file(key: str, text: str) -> bool:
    """Whether a prim's key names a file beside the graph file, not a configuration or an asset of the product."""
    return not asset_roots.names_asset(text) if key == "reference" else text.lower().endswith(".json")


def output_name(text: str) -> str:
    """The name of a file to write below the output folder. Raises ValueError for a name that leads out of it."""
    path = Path(text)
    if not path.name or "\0" in text or text.endswith("/"):
        raise ValueError(f"{quoted(text)} is not a file name")
    if any(len(part.encode(errors="replace")) > _LONGEST_NAME for part in path.parts):
        raise ValueError(f"{quoted(text)} is longer than {_LONGEST_NAME} bytes")
    if len(text) > _LONGEST_PATH:
        raise ValueError(f"{quoted(text)} is longer than {_LONGEST_PATH} characters")
    if path.as_posix() in (REPORT, "report.previous.json"):
        raise ValueError(f"{quoted(text)} is where the report goes; give another name such as run.mcap")
    if path.is_absolute() or ".." in path.parts or "\\" in text or _URL.match(text):
        raise ValueError(f"{quoted(text)} could leave the output folder; give a plain name such as run.mcap")
    return text


def _resolved(text: str, folder: Path) -> Path:
    if not text or "\0" in text:
        raise ValueError(f"{quoted(text)} is not a file name")
    try:
        return (folder / text).resolve()
    except (OSError, RuntimeError, ValueError) as error:  # the name is too long, or links form a loop
        raise ValueError(f"{quoted(text)} is not a usable file name") from error


def _near(text: str, folder: Path) -> str:
    wanted = folder / text
    try:
        return did_you_mean(wanted.name, sorted(entry.name for entry in wanted.parent.iterdir()))
    except OSError:
        return ""
