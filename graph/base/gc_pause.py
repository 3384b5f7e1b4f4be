"""Python's garbage collector while a large graph is made."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager

LARGE = 50_000
"""Objects from which on what was made is spared the walk through the young generations."""


@contextmanager
def collector_paused() -> Iterator[None]:
    """Without the garbage collector, which would walk a large half-made graph again and again.

    Where much was made it counts as old afterwards: nearly all of it stays, so that walking it at once would be a
    waste, too. Small makings stay young, so that what is soon dropped is soon freed.
    """
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            if gc.get_count()[0] > LARGE and gc.get_freeze_count() == 0:
                gc.freeze()
                gc.unfreeze()  # to the oldest generation
            gc.enable()
