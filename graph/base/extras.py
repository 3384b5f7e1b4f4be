"""The command that installs an optional package into this installation of TickGraph."""

from __future__ import annotations

import os
import shlex
import shutil
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
"""The folder that holds the packages: a checkout, or an environment's `site-packages`."""


def install_command(extra: str) -> str:
    """The shell command that adds an extra: of a checkout from its folder, of a wheel from its file, if both are there.

    Names `pip` where that is this Python's, else this Python with `-m pip`.
    """
    return f"{_pip()} install {_target(extra)}"


def _target(extra: str) -> str:
    if (ROOT / "pyproject.toml").is_file():
        return f"-e {_quoted(f'{_shown(ROOT)}[{extra}]')}"
    wheel = _origin()
    return _quoted(f"{_shown(wheel) if wheel else 'tickgraph'}[{extra}]")


def _quoted(target: str) -> str:
    return f"'{target}'" if "'" not in target else shlex.quote(target)


def _origin() -> Path | None:
    """The wheel that was installed, if it came from a file that is still there."""
    import json  # with the others only for this message: every command imports this module
    from importlib import metadata
    from urllib.parse import unquote, urlparse

    try:
        text = metadata.distribution("tickgraph").read_text("direct_url.json")
    except metadata.PackageNotFoundError:
        return None
    url = urlparse(json.loads(text)["url"] if text else "")
    file = Path(unquote(url.path))
    return file if url.scheme == "file" and file.exists() else None


def _pip() -> str:
    here, python = shutil.which("pip"), Path(sys.executable)
    if here is not None and Path(here).parent == python.parent:
        return "pip"
    return f"{shlex.quote(str(_shown(python)))} -m pip"


def _shown(path: Path) -> str:
    """A path as one would type it in the current folder."""
    try:
        inside = path.relative_to(Path.cwd())
    except (ValueError, OSError):
        return str(path)
    return str(inside) if str(inside) != "." else os.curdir
