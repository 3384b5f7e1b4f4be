"""Keeps what C and C++ libraries print away from the standard streams of the process."""

from __future__ import annotations

import ctypes
import io
import os
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, redirect_stderr, redirect_stdout, suppress
from functools import cache
from threading import Lock

_lock = Lock()
_blocks = 0
_undo = ExitStack()


@contextmanager
def silenced() -> Iterator[None]:
    """Drops what is printed in the block, by all threads: through Python's streams, C's, and their descriptors.

    Blocks may be nested or overlap in several threads: the streams are back when the last one has ended.
    """
    global _blocks
    with _lock:
        if not _blocks:
            _redirect(_undo)
        _blocks += 1
    try:
        yield
    finally:
        with _lock:
            _blocks -= 1
            if not _blocks:
                _undo.close()


def _redirect(undo: ExitStack) -> None:
    _flush()
    nowhere = os.open(os.devnull, os.O_WRONLY)
    undo.callback(os.close, nowhere)
    for number in (1, 2):
        with suppress(OSError):  # closed
            copy = os.dup(number)
            os.dup2(nowhere, number)
            undo.callback(os.close, copy)
            undo.callback(os.dup2, copy, number)
    undo.callback(_flush)
    undo.enter_context(redirect_stdout(io.StringIO()))
    undo.enter_context(redirect_stderr(io.StringIO()))


def _flush() -> None:
    """Writes what the streams of Python and of C hold to where they go now."""
    for stream in (sys.stdout, sys.stderr):
        with suppress(OSError, ValueError, AttributeError):  # closed, or none
            stream.flush()
    if os.name == "posix":
        _c_library().fflush(None)


@cache
def _c_library() -> ctypes.CDLL:
    """The process's own C library; made once, since a handle is in a reference cycle."""
    return ctypes.CDLL(None)
