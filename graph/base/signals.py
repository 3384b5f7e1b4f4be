"""The signals that end a process, as far as this system has them (Windows has no SIGHUP)."""

from __future__ import annotations

import signal

HANGUP: int | None = getattr(signal, "SIGHUP", None)
"""The signal of a closed terminal; None on systems without it."""

ENDING: tuple[int, ...] = (signal.SIGINT, signal.SIGTERM, *(() if HANGUP is None else (HANGUP,)))
"""Ctrl-C, a request to terminate, a closed terminal."""
