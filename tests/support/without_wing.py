"""The project without one of its wings: `python -m tests.support.without_wing ucx [pytest's arguments]`.

Runs all tests but those of that wing, or those that the arguments name, in a tree of links without its folder.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tempfile
from importlib.util import find_spec
from pathlib import Path

import pytest

from graph.base.plugins import COMMANDS, NODES, shipped
from tests.support.places import ROOT

WINGS = sorted(path.name for path in (ROOT / "wings").iterdir() if (path / "__init__.py").exists())
"""The names of all wings."""
MISSING = {type_id for type_id, plugin in shipped(NODES).items() if plugin.absence}
"""The node types whose wing is missing in this tree: none in a whole one."""
MISSING_NAMES = {type_id.rpartition(".")[2] for type_id in MISSING}
"""Their names without the packages."""
MISSING_WINGS = {
    wing
    for wing in re.findall(r'"wings\.(\w+)', (ROOT / "pyproject.toml").read_text(encoding="utf8"))
    if find_spec(f"wings.{wing}") is None
}
"""The wings that are declared and missing in this tree."""
MISSING_EXAMPLES = {
    name
    for name, wing in {"arm": "mjcf", "camera_pipeline": "replicator", "physx_sensors": "physx"}.items()
    if wing in MISSING_WINGS
}
"""The files in graphs/, without their endings, that need a wing which is missing in this tree."""


def is_missing(place: str) -> bool:
    """Whether a module or file, as "wings.ucx.wire" or "tests/wings/ucx", is of a missing wing."""
    return not MISSING_WINGS.isdisjoint(re.findall(r"wings[./](\w+)", place))


def needs_wing(wing: str) -> pytest.MarkDecorator:
    """Skips a test where the wing that it uses is missing."""
    return pytest.mark.skipif(wing in MISSING_WINGS, reason=f"needs the wing {wing}")


needs_every_command = pytest.mark.skipif(
    any(plugin.absence for plugin in shipped(COMMANDS).values()), reason="needs the wings that bring commands"
)
"""Skips a test of pages that list all commands."""


def tree_without(wing: str, folder: Path) -> Path:
    """Links in `folder` to everything in the repository but the wing and its tests; returns the folder."""
    for path in ROOT.iterdir():
        if path.name not in ("wings", "tests", ".git", "build"):
            (folder / path.name).symlink_to(path)
    for parts in ("wings", "tests", "tests/wings"):
        (folder / parts).mkdir()
        for path in (ROOT / parts).iterdir():
            if path.name not in ("__pycache__", "wings" if parts == "tests" else wing):
                (folder / parts / path.name).symlink_to(path)
    return folder


def environment(folder: Path) -> dict[str, str]:
    """Variables of a process that takes the packages from that tree."""
    return {**os.environ, "PYTHONPATH": str(folder)}


def main(arguments: list[str]) -> int:
    """Runs pytest in the tree; returns its exit code."""
    with tempfile.TemporaryDirectory() as folder:
        tree = tree_without(arguments[0], Path(folder))
        command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", *arguments[1:]]
        return subprocess.run(command, cwd=tree, env=environment(tree), check=False).returncode


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
