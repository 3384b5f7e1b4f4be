"""`graph help`: lists the pages of the manual, or prints one."""

from __future__ import annotations

import argparse
import re
import sys

from graph.base.errors import UserError
from graph.base.suggest import closest
from graph.manual import ORDER, page, pages

from .printing import print_table, say

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

    from .rendering import rendered

    Console().print(rendered(text))
