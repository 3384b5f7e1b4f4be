"""Progress on the terminal: of counted things, and of a recording that is read."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.progress import Progress

    from graph.recording.run_reader import RunReader


def counting(what: str, total: int | None = None, *, shown: bool = True) -> Progress:
    """A bar with one task, for a `with`: what is counted, how many of `total`, the time taken and the time left."""
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    columns = (TextColumn(what), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), TimeRemainingColumn())
    made = Progress(*columns, console=Console(stderr=True), transient=True, disable=not shown)
    made.add_task(what, total=total)
    return made


@contextmanager
def reading(recording: RunReader) -> Iterator[None]:
    """Counts the messages that are read, on a terminal; elsewhere it shows nothing."""
    if not sys.stderr.isatty():
        yield
        return
    from rich.console import Console
    from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    columns = (SpinnerColumn(), TextColumn("{task.completed:,.0f} messages read"), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("reading", total=None)
        recording.on_read = lambda: bar.advance(task)
        yield
