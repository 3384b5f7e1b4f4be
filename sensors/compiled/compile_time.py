"""How long this process compiled, and what it says meanwhile: the first run on a machine compiles for a while."""

from __future__ import annotations

import sys
import time
from functools import cache
from typing import Any

from .kept import numba

WHAT = "the sensors' loops, once on this machine"


class CompileTime:
    """Counts the compilations of this process, one inside another once, and says on stderr that it compiles.

    seconds: wall time of those that ended. loops: how many these were.
    """

    def __init__(self) -> None:
        self.seconds, self.loops = 0.0, 0
        self._depth, self._began, self._said = 0, 0.0, False

    @property
    def elapsed(self) -> float:
        """`seconds`, with what has passed of the compilation that runs now."""
        return self.seconds + (time.perf_counter() - self._began if self._depth else 0.0)

    def start(self) -> None:
        """A compilation begins."""
        self._depth += 1
        if self._depth > 1:
            return
        self._began = time.perf_counter()
        if not self._said:
            self._said = True
            print(f"compiling {WHAT}; the first frames take up to a minute", file=sys.stderr, flush=True)

    def end(self) -> None:
        """A compilation ends."""
        self._depth -= 1
        if self._depth == 0:
            self.seconds += time.perf_counter() - self._began
            self.loops += 1


COMPILING = CompileTime()
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
