"""Work for a second core: compiled loops and packing, which need the interpreter's lock only in between.

Nothing depends on who works: results are collected in the order in which the work was begun, so bytes do not depend on
the number of threads. What no thread has begun when its result is wanted is done by the one that wants it, so nothing
waits for a thread that gets no core.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from functools import cache
from threading import Lock
from typing import TYPE_CHECKING, Generic, TypeVar

if TYPE_CHECKING:
    from concurrent.futures import ThreadPoolExecutor

R = TypeVar("R")


class Work(Generic[R]):
    """A call that one of several threads makes, once."""

    __slots__ = ("_begun", "_call", "_error", "_found", "_running")

    def __init__(self, call: Callable[[], R]) -> None:
        self._call: Callable[[], R] | None = call
        self._begun, self._running = Lock(), Lock()
        self._running.acquire()
        self._found: R
        self._error: BaseException | None = None

    def do(self) -> None:
        """Makes the call, unless a thread has begun it."""
        if self._begun.acquire(blocking=False) and self._call is not None:
            try:
                self._found = self._call()
            except BaseException as error:
                self._error = error
            self._call = None
            self._running.release()

    def result(self) -> R:
        """What the call gives; raises what it raised."""
        self.do()
        with self._running:
            if self._error is not None:
                raise self._error
            return self._found


def begin(threads: int, call: Callable[[], R]) -> Work[R]:
    """Work that another thread of this process begins as soon as it can; the caller does it at once if `threads` is 1.

    threads: how many work, with the caller (0: one for each core).
    """
    work = Work(call)
    others = (threads or usable_cores()) - 1
    if others:
        _pool(os.getpid(), others).submit(work.do)
    else:
        work.do()
    return work


def results(works: Sequence[Work[R]]) -> list[R]:
    """The results of several, in order."""
    for work in reversed(works):  # other threads begin with the first
        work.do()
    return [work.result() for work in works]


@cache
def usable_cores() -> int:
    """The cores that this process could use when it first asked: a run of a campaign keeps to one."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@cache
def _pool(process: int, threads: int) -> ThreadPoolExecutor:
    """Threads of a process, which a forked child does not have."""
    from concurrent.futures import ThreadPoolExecutor

    return ThreadPoolExecutor(threads, "work")
