"""Tables for a terminal of any width, in which no word is broken.

Columns of text wrap at spaces. Where these would become too narrow, the first cell of a row gets a line of its own,
above the others; where that does not suffice either, so does each cell, after its heading.
"""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Sequence

TEXT = 24
"""Characters from which on a cell is text, which may wrap; its column keeps as many."""
GAPS = (2, 1)
"""Spaces between columns; fewer where more do not fit."""
INDENT = "  "

Row = Sequence[str]


def table_lines(rows: Sequence[Row], headings: Row, width: int) -> tuple[list[str], list[str]]:
    """The lines of the headings and of the rows, each of at most `width` characters if the words are not longer."""
    everything = [headings, *rows]
    found = _fitted(everything, width)
    if found is not None:
        head, *body = (list(_wrapped(row, *found)) for row in everything)
        return head, [line for lines in body for line in lines]
    found = _fitted([row[1:] for row in everything], width - len(INDENT)) if len(headings) > 2 else None
    if found is not None:
        head, *body = ([row[0], *(INDENT + line for line in _wrapped(row[1:], *found))] for row in everything)
        return head, [line for lines in body for line in lines]
    return [headings[0]], [line for row in rows for line in _record(row, headings, width)]


class Grid:
    """A table with a line below its headings: texts at the left, numbers at the right. Cells may have several lines."""

    def __init__(self, *headings: str, texts: Sequence[int] = (0,)) -> None:
        self._rows: list[Row] = [headings]
        self._texts = frozenset(texts)
        """Columns of texts."""

    def add(self, *cells: str) -> None:
        """Adds a row."""
        self._rows.append(cells)

    def lines(self) -> Iterator[str]:
        """The table between two empty lines."""
        rows = [[cell.split("\n") for cell in row] for row in self._rows]
        widths = [max(len(line) for cell in column for line in cell) for column in zip(*rows, strict=True)]
        yield ""
        for number, row in enumerate(rows):
            for place in range(max(map(len, row))):
                cells = [cell[place] if place < len(cell) else "" for cell in row]
                yield "  ".join(
                    cell.ljust(width) if column in self._texts else cell.rjust(width)
                    for column, (cell, width) in enumerate(zip(cells, widths, strict=True))
                )
            if not number:
                yield "─" * (sum(widths) + 2 * (len(widths) - 1))
        yield ""


def wrapped_last(rows: Sequence[Row], width: int, most: int) -> Iterator[str]:
    """Rows as indented lines with aligned columns, of which the last wraps at spaces; rows may differ in length.

    most: characters from which on a cell does not widen its column.
    """
    longest = max(map(len, rows), default=0)
    widths = [
        max((min(len(row[place]), most) for row in rows if place < len(row)), default=0) for place in range(longest)
    ]
    for row in rows:
        start = INDENT + "".join(f"{cell:{widths[place]}}  " for place, cell in enumerate(row[:-1]))
        room = width - len(start)
        lines = _text(row[-1], room) if row and room >= TEXT else list(row[-1:])
        yield from ((start if not number else " " * len(start)) + line for number, line in enumerate(lines or [""]))


def hanging(text: str, width: int) -> list[str]:
    """A text wrapped at spaces, indented from the second line on."""
    first, *rest = _text(text, width) or [""]
    return [first, *(INDENT + line for line in _text(" ".join(rest), width - len(INDENT)))]


def _fitted(rows: Sequence[Row], width: int) -> tuple[list[int], int] | None:
    """Widths of the columns and the gap between them with which the rows fit; None if they do not."""
    columns = list(zip(*rows, strict=True))
    natural = [max(map(len, column)) for column in columns]
    least = [
        max([TEXT, *(len(word) for cell in column for word in cell.split())]) if place and wide > TEXT else wide
        for place, (column, wide) in enumerate(zip(columns, natural, strict=True))
    ]
    for gap in GAPS:
        spare = width - sum(least) - gap * (len(least) - 1)
        if spare >= 0:
            return _widened(least, natural, spare), gap
    return None


def _widened(least: Sequence[int], natural: Sequence[int], spare: int) -> list[int]:
    """The least widths, and what is spare for the columns that want more, in equal parts."""
    found = list(least)
    while spare and (short := [place for place, wide in enumerate(found) if wide < natural[place]]):
        for place in short[:spare]:
            found[place] += 1
        spare -= len(short[:spare])
    return found


def _wrapped(row: Row, widths: Sequence[int], gap: int) -> Iterator[str]:
    cells = [_text(cell, wide) if len(cell) > wide else [cell] for cell, wide in zip(row, widths, strict=True)]
    for number in range(max(map(len, cells))):
        parts = (lines[number] if number < len(lines) else "" for lines in cells)
        yield (" " * gap).join(f"{part:{wide}}" for part, wide in zip(parts, widths, strict=True)).rstrip()


def _record(row: Row, headings: Row, width: int) -> Iterator[str]:
    yield row[0]
    for cell, heading in zip(row[1:], headings[1:], strict=True):
        if cell:
            said = _text(f"{heading}: {cell}", width - 2 * len(INDENT))
            yield from (INDENT * (1 if not number else 2) + line for number, line in enumerate(said))


def _text(text: str, width: int) -> list[str]:
    return textwrap.wrap(text, max(1, width), break_long_words=False, break_on_hyphens=False)
