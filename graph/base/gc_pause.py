"""Python's garbage collector while a large graph is made."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def collector_paused() -> Iterator[None]:
    """Without the garbage collector, which would walk a large half-made graph again and again.

    Afterwards what was made counts as old: nearly all of it stays, so that walking it at once would be a waste, too.
    """
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            if gc.get_freeze_count() == 0:
                gc.freeze()
                gc.unfreeze()  # to the oldest generation
            gc.enable()
