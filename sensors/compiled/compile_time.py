"""How long this process compiled, and what it says meanwhile: the first run on a machine compiles for a while."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from functools import cache
from typing import Any

from .kept import numba

WHAT = "the sensors' loops, once on this machine"


class CompileTime:
    """Counts the compilations of this process, one inside another once, and says on stderr that it compiles.

    seconds: wall time of those that ended. loops: how many these were. left: how many loops are to compile, the present
    one included, as far as the modules imported so far tell; 0 while none compiles.
    """

    def __init__(self, count_left: Callable[[], int] = lambda: 0) -> None:
        self.seconds, self.loops, self.left = 0.0, 0, 0
        self._count_left = count_left
        self._depth, self._began, self._said = 0, 0.0, False

    @property
    def elapsed(self) -> float:
        """`seconds`, with what has passed of the compilation that runs now."""
        return self.seconds + (time.perf_counter() - self._began if self._depth else 0.0)

    def silence(self) -> None:
        """From now on does not say that it compiles: who asked for it knows."""
        self._said = True

    def start(self) -> None:
        """A compilation begins."""
        self._depth += 1
        if self._depth > 1:
            return
        self._began = time.perf_counter()
        self.left = max(1, self._count_left())
        if not self._said:
            self._said = True
            number = f"{self.left} of " if self.left > 1 else ""
            print(f"compiling {number}{WHAT}; the first frames take up to a minute", file=sys.stderr, flush=True)

    def end(self) -> None:
        """A compilation ends."""
        self._depth -= 1
        if self._depth == 0:
            self.seconds += time.perf_counter() - self._began
            self.loops, self.left = self.loops + 1, 0


def _listed_and_not_kept() -> int:
    from .signatures import number_left

    return number_left()


COMPILING = CompileTime(_listed_and_not_kept)
"""That of this process."""


@cache
def watch_compiling() -> None:
    """From now on counts what Numba compiles."""
    event = numba().core.event

    class Compiling(event.Listener):  # type: ignore[misc, name-defined]
        def on_start(self, event: Any) -> None:
            COMPILING.start()

        def on_end(self, event: Any) -> None:
            COMPILING.end()

    event.register("numba:compile", Compiling())
