"""A small disk of its own for a command."""

from __future__ import annotations

import subprocess
from pathlib import Path

from tests.support.places import ROOT


def in_a_disk(size: int, folder: Path, script: str) -> subprocess.CompletedProcess[str]:
    """Runs a shell script in the repository's root with a tmpfs of `size` bytes at `folder`."""
    mounted = f"mkdir -p {folder} && mount -t tmpfs -o size={size} none {folder} && cd {ROOT} && {script}"
    command = ["unshare", "--user", "--map-root-user", "--mount", "sh", "-c", mounted]
    return subprocess.run(command, capture_output=True, text=True, check=False)
