"""Bounds on processor time that hold on a busy machine, too, where the same work takes several times as long."""

import contextlib
import time

QUIET = 0.01
"""Processor seconds that `_work` takes on a quiet machine, about."""


def cost(what):
    """Processor seconds that a call takes."""
    started = time.process_time()
    what()
    return time.process_time() - started


@contextlib.contextmanager
def within(seconds):
    """Fails if the block takes more processor time than a quiet machine has in so many seconds.

    Where it takes longer than that, the machine may be busy: a fixed piece of work says how much slower it is now.
    """
    started = time.process_time()
    yield
    spent = time.process_time() - started
    if spent > seconds:
        slower = max(cost(_work) for _ in range(20)) / QUIET
        assert spent <= seconds * max(1.0, slower), (
            f"{spent:.3g} s on a machine {slower:.2g} times as slow as a quiet one"
        )


def _work():
    """Strings, a dictionary and numbers."""
    return sum(len(text) for text in {number: str(number) for number in range(50_000)}.values())
