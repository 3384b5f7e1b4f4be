"""The signals that end a process, as far as this system has them: Windows has no SIGHUP."""

from __future__ import annotations

import signal

HANGUP: int | None = getattr(signal, "SIGHUP", None)
"""The terminal has closed; None where no signal says so."""

ENDING: tuple[int, ...] = (signal.SIGINT, signal.SIGTERM, *(() if HANGUP is None else (HANGUP,)))
"""Ctrl-C, a polite request to end, a closed terminal."""
