"""Keeps what C and C++ libraries print away from the standard streams of the process."""

from __future__ import annotations

import ctypes
import io
import os
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout, suppress


@contextmanager
def silenced() -> Iterator[None]:
    """Drops what is printed in the block, by all threads: through Python's streams, C's, and their descriptors."""
    flush = ctypes.CDLL(None).fflush if os.name == "posix" else lambda _: 0
    flush(None)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    kept: dict[int, int] = {}
    for number in (1, 2):
        with suppress(OSError):  # closed
            kept[number] = os.dup(number)
            os.dup2(nowhere, number)
    try:
        with redirect_stdout(io.StringIO()), redirect_stderr(io.StringIO()):
            yield
    finally:
        flush(None)
        for number, copy in kept.items():
            os.dup2(copy, number)
            os.close(copy)
        os.close(nowhere)
