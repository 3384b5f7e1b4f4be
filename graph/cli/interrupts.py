"""Signals that end a run between two updates."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any


@contextmanager
def between_updates() -> Iterator[list[int]]:
    """Ctrl-C, SIGTERM or a terminal that closes let the update in progress finish; a second Ctrl-C stops at once."""
    received: list[int] = []

    def note(signum: int, frame: Any) -> None:
        if received and signum != signal.SIGHUP:  # a closing terminal may say so twice
            raise KeyboardInterrupt
        received.append(signum)

    numbers = [signal.SIGINT, signal.SIGTERM]
    if signal.getsignal(signal.SIGHUP) != signal.SIG_IGN:  # as nohup asks for
        numbers.append(signal.SIGHUP)
    previous = {number: signal.signal(number, note) for number in numbers}
    try:
        yield received
    except OSError as error:  # of a progress bar whose terminal has gone
        if signal.SIGHUP in received:
            raise KeyboardInterrupt from error
        raise
    finally:
        if signal.SIGHUP in received:
            previous[signal.SIGHUP] = signal.SIG_IGN  # what is left to do is to write the report
        for number, handler in previous.items():
            signal.signal(number, handler)
