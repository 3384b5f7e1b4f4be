"""Lets signals end a run only between two updates."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from graph.base.signals import ENDING, HANGUP


@contextmanager
def between_updates() -> Iterator[list[int]]:
    """After Ctrl-C, SIGTERM or a closed terminal the present update is finished; a second Ctrl-C stops at once.

    Outside of the main thread, which alone gets signals, nothing is changed.
    """
    received: list[int] = []
    if threading.current_thread() is not threading.main_thread():
        yield received
        return

    def note(signum: int, frame: Any) -> None:
        if received and signum != HANGUP:  # a closing terminal may send it twice
            raise KeyboardInterrupt
        received.append(signum)

    # nohup ignores the signal of a closing terminal
    numbers = [one for one in ENDING if one != HANGUP or signal.getsignal(one) != signal.SIG_IGN]
    previous = {number: signal.signal(number, note) for number in numbers}
    try:
        yield received
    except OSError as error:  # of a progress bar whose terminal was closed
        if HANGUP in received:
            raise KeyboardInterrupt from error
        raise
    finally:
        if HANGUP is not None and HANGUP in received:
            previous[HANGUP] = signal.SIG_IGN  # the report is still to be written
        for number, handler in previous.items():
            signal.signal(number, handler)
