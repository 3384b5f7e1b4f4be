"""The one module that prints: plain, stable lines, in which no text from a file can control the terminal.

Names, values and messages come from files. A terminal would obey a control character in one (ESC ]0;...), so every line
goes through `safe_line` or `printable`; no other module of the commands prints.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any

from graph.base.errors import Problem
from graph.base.shorten import brief, printable


def problem_line(problem: Problem) -> str:
    """A problem as one line of printable text; without a mark, it starts with the program's name."""
    return safe_line(str(problem) if problem.mark else f"graph: {problem}")


def note_line(note: tuple[str, str, str]) -> str:
    """A warning (code, place, message) as one line of printable text."""
    code, where, message = note
    return safe_line(f"warning {code}: {where}: {brief(message)}")


def say(text: str = "") -> None:
    """Prints one line on stdout, made printable; keeps its indentation."""
    print(printable(text.rstrip()))


def say_json(value: Any, default: Callable[[Any], Any] | None = None) -> None:
    """Prints a value as indented JSON on stdout; unprintable characters are JSON escapes."""
    import json

    print(json.dumps(value, indent=2, default=default).replace("\x7f", "\\u007f"))


def tell(line: str) -> None:
    """Prints one line on stderr, made printable."""
    print(safe_line(line), file=sys.stderr)


def safe_line(text: str) -> str:
    """Text without surrounding space, made printable."""
    return printable(text.strip())


def aligned(rows: Iterable[Sequence[str]]) -> Iterator[str]:
    """Rows as indented lines with aligned columns; rows may be shorter than the longest."""
    table = [tuple(row) for row in rows]
    widths: list[int] = []
    for row in table:
        widths += [0] * (len(row) - len(widths))
        widths[: len(row)] = [max(width, len(cell)) for width, cell in zip(widths, row, strict=False)]
    for row in table:
        cells = (f"{cell:{width}}" for cell, width in zip(row, widths, strict=False))
        yield "  " + "  ".join(cells).rstrip()


def print_table(rows: Iterable[Sequence[str]], headings: Sequence[str]) -> None:
    """Prints rows: as a table on a terminal; otherwise one line each, with tabs between cells and without headings."""
    if not sys.stdout.isatty():
        for row in rows:
            print("\t".join(map(safe_line, row)))
        return
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    table = Table(box=None, pad_edge=False, header_style="bold")
    for index, heading in enumerate(headings):
        table.add_column(heading, overflow="fold", no_wrap=index == 0)
    for row in rows:
        table.add_row(*(Text(safe_line(cell)) for cell in row))
    Console().print(table)


def counted(number: int, plural: str) -> str:
    """A number of things: `2 nodes`, `1 node`."""
    return f"{number:,} {plural if number != 1 else plural[:-1]}"
