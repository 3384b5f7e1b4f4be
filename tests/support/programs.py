"""Python in a process of its own: signals as a shell starts it, ended with the test."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from graph.base.signals import ENDING
from tests.support.places import ROOT


def _default_signals() -> None:
    """A child inherits ignored signals: under `nohup` or a CI runner no interrupt would reach it."""
    for number in ENDING:
        signal.signal(number, signal.SIG_DFL)


@contextmanager
def started(*arguments: str, **options: Any) -> Iterator[subprocess.Popen[Any]]:
    """`python ARGUMENTS...` in the repository's root, running; killed at the end of the block if it still runs.

    `options` are those of `subprocess.Popen`.
    """
    reset = _default_signals if os.name == "posix" else None
    with subprocess.Popen([sys.executable, *arguments], cwd=ROOT, preexec_fn=reset, **options) as process:
        try:
            yield process
        finally:
            process.kill()
