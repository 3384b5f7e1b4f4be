"""How the commands print: plain, stable lines; nothing in a file can send commands to the terminal."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator, Sequence

from graph.base.errors import Problem
from graph.base.shorten import brief


def problem_line(problem: Problem) -> str:
    """A problem as one line of printable text, without a mark led by the program's name."""
    return safe_line(str(problem) if problem.mark else f"graph: {problem}")


def note_line(note: tuple[str, str, str]) -> str:
    """A warning (code, where, message) as one line of printable text."""
    code, where, message = note
    return safe_line(f"warning {code}: {where}: {brief(message)}")


def safe_line(text: str) -> str:
    """Text on one line: line breaks become spaces, other control characters are shown as escapes."""
    return "".join(c if c.isprintable() else " " if c in "\n\t" else f"\\u{ord(c):04x}" for c in text.strip())


def aligned(rows: Iterable[Sequence[str]]) -> Iterator[str]:
    """Rows as indented lines whose cells stand below each other; rows may be shorter than the longest."""
    table = [tuple(row) for row in rows]
    widths: list[int] = []
    for row in table:
        widths += [0] * (len(row) - len(widths))
        widths[: len(row)] = [max(width, len(cell)) for width, cell in zip(widths, row, strict=False)]
    for row in table:
        cells = (f"{cell:{width}}" for cell, width in zip(row, widths, strict=False))
        yield "  " + "  ".join(cells).rstrip()


def print_table(rows: Iterable[Sequence[str]], headings: Sequence[str]) -> None:
    """Prints rows: as a table on a terminal; elsewhere one line each, cells parted by tabs, without headings."""
    if not sys.stdout.isatty():
        for row in rows:
            print("\t".join(map(safe_line, row)))
        return
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    table = Table(box=None, pad_edge=False, header_style="bold")
    for heading in headings:
        table.add_column(heading, overflow="fold")
    for row in rows:
        table.add_row(*(Text(safe_line(cell)) for cell in row))
    Console().print(table)
