"""Markdown on a terminal, by rich: headings at the left, tables whose columns keep their longest word whole."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rich.markdown import Markdown

GAP = 2


def rendered(text: str) -> Markdown:
    """Markdown that rich prints; links show their text alone."""
    from rich.console import Console, ConsoleOptions, RenderResult
    from rich.markdown import Heading, Markdown, TableElement
    from rich.table import Table

    class LeftHeading(Heading):
        LEVEL_ALIGN = dict.fromkeys(Heading.LEVEL_ALIGN, "left")

    class WholeWords(TableElement):
        def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
            head = [cell.content.copy() for cell in self.header.row.cells] if self.header and self.header.row else []
            rows = [[cell.content for cell in row.cells] for row in (self.body.rows if self.body else ())]
            widths = column_widths(
                [[text.plain for text in column] for column in zip(head, *rows, strict=True)], options.max_width
            )
            tall = any(len(text.plain) > 2 * width for row in rows for text, width in zip(row, widths, strict=True))
            table = Table(box=None, pad_edge=False, padding=(0, GAP, int(tall), 0), header_style="bold")
            for text, width in zip(head, widths, strict=True):
                table.add_column(text, width=width, overflow="fold")
            for row in rows:
                table.add_row(*row)
            yield table

    class Manual(Markdown):
        elements: ClassVar = {**Markdown.elements, "heading_open": LeftHeading, "table_open": WholeWords}

    return Manual(text, hyperlinks=False)


def column_widths(columns: Sequence[Sequence[str]], width: int) -> list[int]:
    """Widths of columns of text that fit into a width: each at least its longest word, if they all fit."""
    wanted = [max(map(len, cells)) for cells in columns]
    words = [max(len(word) for cell in cells for word in cell.split() or [""]) for cells in columns]
    room = width - GAP * len(columns)
    if sum(wanted) <= room:
        return wanted
    if sum(words) > room:  # some words are broken: the longest ones
        most = max(words)
        while sum(min(word, most) for word in words) > room and most > 1:
            most -= 1
        return [min(word, most) for word in words]
    # What is left is shared in proportion to the text that still does not fit.
    spare, lacks = room - sum(words), [want - word for want, word in zip(wanted, words, strict=True)]
    return [word + spare * lack // sum(lacks) for word, lack in zip(words, lacks, strict=True)]
