"""The one module that prints: plain, stable lines, in which no text from a file can control the terminal.

Names, values and messages come from files. A terminal would obey a control character in one (ESC ]0;...), so every line
goes through `safe_line` or `printable`; no other module of the commands prints.
"""

from __future__ import annotations

import shutil
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any, TextIO

from graph.base.errors import Problem
from graph.base.shorten import brief, printable

from .tables import hanging, table_lines, wrapped_last

EXIT_INTERRUPTED = 130
"""Exit code of a command that a signal ended."""


def problem_line(problem: Problem) -> str:
    """A problem as one line of printable text; without a mark, it starts with the program's name."""
    return safe_line(str(problem) if problem.mark else f"graph: {problem}")


def note_line(note: tuple[str, str, str]) -> str:
    """A warning (code, place, message) as one line of printable text."""
    code, where, message = note
    return safe_line(f"warning {code}: {where}: {brief(message)}")


def say(text: str = "", stream: TextIO | None = None) -> None:
    """Prints one line on stdout, or another stream, made printable; keeps its indentation."""
    print(printable(text.rstrip()), file=stream)


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


def aligned(rows: Iterable[Sequence[str]], most: int = sys.maxsize) -> Iterator[str]:
    """Rows as indented lines with aligned columns; rows may be shorter than the longest. A terminal wraps the last.

    most: characters from which on a cell does not widen its column.
    """
    table = [tuple(row) for row in rows]
    yield from (line.rstrip() for line in wrapped_last(table, columns() if on_terminal() else sys.maxsize, most))


def print_table(rows: Iterable[Sequence[str]], headings: Sequence[str]) -> None:
    """Prints rows: as a table on a terminal; otherwise one line each, with tabs between cells and without headings."""
    table = [tuple(map(safe_line, row)) for row in rows]
    if not on_terminal():
        for row in table:
            print("\t".join(row))
        return
    from rich.console import Console
    from rich.text import Text

    console = Console()
    head, body = table_lines(table, headings, console.width)
    for line, style in (*((line, "bold") for line in head), *((line, "") for line in body)):
        console.print(Text(line, style), soft_wrap=True)


def say_hanging(text: str) -> None:
    """Prints one line on stdout as `say` does; a terminal wraps it at spaces, what follows is indented."""
    text = printable(text.rstrip())
    for line in hanging(text, columns()) if on_terminal() else [text]:
        print(line)


def on_terminal() -> bool:
    """Whether stdout is a terminal."""
    return sys.stdout.isatty()


def page_width(stream: TextIO) -> int:
    """Characters of a line of a stream; a file or a pipe has no width of its own."""
    return columns() if stream.isatty() else 120


def columns() -> int:
    """Characters of a line on the terminal."""
    return shutil.get_terminal_size().columns


def counted(number: int, plural: str) -> str:
    """A number of things: `2 nodes`, `1 node`."""
    return f"{number:,} {plural if number != 1 else plural[:-1]}"
