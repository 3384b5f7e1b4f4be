"""`graph help`: lists the pages of the manual, or prints one."""

from __future__ import annotations

import argparse
import re
import sys
from typing import TYPE_CHECKING, ClassVar

from graph.base.errors import UserError
from graph.base.suggest import closest
from graph.manual import ORDER, page, pages

from .printing import print_table, say

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rich.markdown import Markdown

LINK = re.compile(r"\[([^\]]+)\]\(([\w-]+)\.md(?:#[\w-]+)?\)")
"""A link to another page of the manual."""
ALIKE = 0.75
"""How similar a topic must be to be suggested; else pages with the word are named."""
IN_BRACKETS = re.compile(r"\(\[[^\]]+\]\(([\w-]+)\.md(?:#[\w-]+)?\)\)")
COMMENT = re.compile(r"^<!--.*-->\n", re.MULTILINE)
MOST_PAGES = 4
"""Pages that an error message names for an unknown topic."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the command's options."""
    parser.add_argument("topic", nargs="?", metavar="TOPIC", help="a page of the manual, or a command (default: list)")


def run(args: argparse.Namespace) -> int:
    """Runs the command. Raises UserError for an unknown topic."""
    if args.topic is None:
        print_table([(one.topic, one.line) for one in pages()], ("TOPIC", "ANSWERS"))
        say()
        say("graph help TOPIC prints a page; graph COMMAND --help the options of a command")
        return 0
    _print(_text(args.topic))
    return 0


def _text(topic: str) -> str:
    """The page of a topic, or the section of a command."""
    from .commands import every

    commands = every()

    if topic in ORDER:
        return page(topic).text
    if topic in commands:
        section = page("commands").section(f"graph {topic}") or f"`graph {topic}`: {commands[topic].help}.\n"
        return f"{section}\n`graph {topic} --help` prints its options, `graph help commands` all commands.\n"
    near = closest(topic, [*ORDER, *commands], ALIKE)
    advice = f'; did you mean "{near}"?' if near else ""
    if not near and (found := _mentioned(topic)):
        advice = f"; the word stands on {', '.join(found)}: graph help {found[0]}"
    raise UserError(f'graph help: there is no page "{topic}"{advice or "; graph help lists the pages"}')


def _mentioned(word: str) -> list[str]:
    """The pages with a word, those with most of it first."""
    counts = {one.topic: one.text.lower().count(word.lower()) for one in pages()}
    return sorted(filter(counts.get, counts), key=lambda topic: -counts[topic])[:MOST_PAGES]


def _print(text: str) -> None:
    text = IN_BRACKETS.sub(r"(`graph help \1`)", COMMENT.sub("", text))
    text = LINK.sub(r"\1 (`graph help \2`)", text)
    if not sys.stdout.isatty():
        print(text, end="")
        return
    from rich.console import Console

    Console().print(rendered(text))


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
