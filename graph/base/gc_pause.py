"""Pauses Python's garbage collector while much is built or imported."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager

LARGE = 50_000
"""Above this number of new objects, the built objects go straight to the oldest generation."""


@contextmanager
def collector_paused() -> Iterator[None]:
    """Pauses the garbage collector, which would walk a large unfinished graph again and again.

    If more than `LARGE` objects were made, they are moved to the oldest generation: nearly all of them stay, so walking
    them now would be a waste. Fewer objects stay in the young generation and are freed soon if they are dropped.
    """
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            if gc.get_count()[0] > LARGE and gc.get_freeze_count() == 0:
                gc.freeze()
                gc.unfreeze()  # moves everything to the oldest generation
            gc.enable()
