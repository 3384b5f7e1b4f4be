"""The signals that end a process, as far as this system has them (Windows has no SIGHUP)."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

HANGUP: int | None = getattr(signal, "SIGHUP", None)
"""The signal of a closed terminal; None on systems without it."""

ENDING: tuple[int, ...] = (signal.SIGINT, signal.SIGTERM, *(() if HANGUP is None else (HANGUP,)))
"""Ctrl-C, a request to terminate, a closed terminal."""


@contextmanager
def deferred() -> Iterator[None]:
    """Lets a signal that ends the process take effect after the block instead of inside it.

    For blocks in which C++ calls Python: it prints and swallows the KeyboardInterrupt that a handler raises there.
    """
    if threading.current_thread() is not threading.main_thread():  # which alone gets signals
        yield
        return
    came: list[int] = []

    def note(number: int, frame: FrameType | None) -> None:
        came.append(number)

    before = {number: signal.getsignal(number) for number in ENDING}
    before = {number: handler for number, handler in before.items() if callable(handler)}
    for number in before:
        signal.signal(number, note)
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        for number in dict.fromkeys(came):
            signal.raise_signal(number)
