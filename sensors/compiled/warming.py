"""Compiles ahead what the first run would compile: each listed loop, the longest first, on all cores."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_all_start_methods, get_context
from typing import Any

from graph.base.work import usable_cores

from .compile_time import COMPILING
from .functions import Inlined
from .signatures import listed


def missing() -> list[int]:
    """The numbers, in the list, of the forms that neither the package nor the user's folder holds; longest first."""
    lacking = [number for number, (loop, types) in enumerate(listed()) if not loop.kept.has(types, loop.code.targetctx)]
    loops = [loop for loop, _ in listed()]
    return sorted(lacking, key=lambda number: -_length(loops[number]))


def warm(jobs: int | None = None) -> Iterator[tuple[int, int]]:
    """Compiles what is missing in some processes (default: one a core); yields how many are done, of how many.

    The results are kept as those of a run are (`sensors.compiled.kept`).
    """
    numbers = missing()
    yield 0, len(numbers)
    if not numbers:
        return
    # Forked processes need not import Numba again.
    context = get_context("fork" if "fork" in get_all_start_methods() else "spawn")
    with ProcessPoolExecutor(min(jobs or usable_cores(), len(numbers)), context) as pool:
        waiting = [pool.submit(_compile, number) for number in numbers]
        for done, one in enumerate(as_completed(waiting), start=1):
            one.result()
            yield done, len(numbers)


def _compile(number: int) -> None:
    COMPILING.silence()
    loop, types = listed()[number]
    loop.code.compile(types)


def _length(loop: Inlined[Any, Any]) -> int:
    """How much there is to compile: the length of the byte code, with all that it takes in."""
    return len(loop.python.__code__.co_code) + sum(map(_length, loop.used.values()))
