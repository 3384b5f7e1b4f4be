"""Says in plain words which slip of the keyboard broke a YAML text, and what to do about it."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from typing import Any

from ruamel.yaml.error import MarkedYAMLError

from .text import quoted

Slip = tuple[int, str]
"""The offset in the text, and what is wrong there."""
CLOSES = {"{": "}", "[": "]"}
SHOWN = 40
"""Most characters of a line that are quoted."""


def slip(text: str, error: MarkedYAMLError) -> Slip:
    """Where a text is broken, and what to do; the parser's own words where no rule fits."""
    mark = error.problem_mark or error.context_mark
    at = 0 if mark is None else mark.index
    began = at if error.context_mark is None else error.context_mark.index
    problem = _one_line(error.problem or error.context or "unreadable text")
    if text[at : at + 1] == "\t":
        indents = not text[text.rfind("\n", 0, at) + 1 : at].strip()
        return at, "a tab cannot indent YAML; use spaces" if indents else "a tab stands between words; use a space"
    for begins, rule in RULES.items():
        if problem.startswith(begins):
            found = rule(_Lines(text), at, began, problem)
            if found is not None:
                return found
    return at, f"this is not YAML: {problem}"


class _Lines:
    """The lines of a text, without comments."""

    def __init__(self, text: str) -> None:
        self.text = text
        self.lines = text.splitlines()

    def number(self, at: int) -> int:
        """The index of the line of an offset."""
        return self.text.count("\n", 0, at)

    def start(self, number: int) -> int:
        """The offset of the first character of a line after its spaces."""
        offset = 0
        for _ in range(number):
            offset = self.text.index("\n", offset) + 1
        return offset + self.indent(number)

    def indent(self, number: int) -> int:
        """The spaces that begin a line."""
        return len(self.lines[number]) - len(self.lines[number].lstrip(" "))

    def content(self, number: int) -> str:
        """A line without the spaces around it."""
        return self.lines[number].strip()

    def above(self, number: int) -> Iterator[int]:
        """The lines above one that hold more than a comment, the next first."""
        return (one for one in range(number - 1, -1, -1) if self.content(one)[:1] not in ("", "#"))


def _no_colon(text: _Lines, at: int, began: int, _: str) -> Slip | None:
    """A key without a colon, or with one that no space follows."""
    number = text.number(began)
    return text.start(number), _as_key(text.content(number))


def _as_key(line: str) -> str:
    glued = re.match(r"""([\w/.$-]+):([^\s:].*)""", line)
    if glued:
        return f"a space is missing after the colon; write {_short(f'{glued[1]}: {glued[2]}')}"
    equal = re.match(r"([\w/.$-]+) *= *(.*)", line)
    key, _, value = (equal[1], "", equal[2]) if equal else line.partition(" ")
    return f"a colon is missing; write {_short(f'{key}: {value}'.rstrip())}"


def _second_colon(text: _Lines, at: int, _began: int, _problem: str) -> Slip | None:
    """A colon where no key can be: the line is too deep, the one above has no colon, or the value holds one."""
    number = text.number(at)
    line = text.content(number)
    if re.match(r"[^\s:]+: +[^\"'{\[]*: ", line.removeprefix("- ") + " "):
        key, _, value = line.removeprefix("- ").partition(":")
        return at, f"a value with a colon in it needs quotes; write {key}: {quoted(value.strip()[:SHOWN])}"
    before = next(text.above(number), None)
    if before is None:
        return None
    above = text.content(before).removeprefix("- ")
    if not re.search(r":(\s|$)", above):
        return text.start(before), _as_key(above)
    if text.indent(number) > text.indent(before):
        return text.start(number), (
            f"this line is indented by {_spaces(text.indent(number))}, deeper than {_short(above)} above it, which has "
            f"its value already; indent both by {text.indent(before)}"
        )
    return None


def _bad_start(text: _Lines, at: int, _began: int, _problem: str) -> Slip | None:
    """A value that begins with a character that YAML keeps for itself."""
    return at, f"a value cannot begin with {text.text[at]}; put it in quotes"


def _open_quote(text: _Lines, _at: int, began: int, problem: str) -> Slip | None:
    """A quote that nothing closes."""
    quote = text.text[began]
    return (began, f"the quote {quote} that opens here is not closed; add a {quote}") if quote in "\"'" else None


def _half_quoted(text: _Lines, first: int, last: int) -> Slip | None:
    """The first of these lines with a double quote that another line closes."""
    for number in range(first, last):
        quotes = [one.start() for one in re.finditer(r'(?<!\\)"', text.content(number))]
        if len(quotes) % 2 and text.content(number)[0] != "#":
            return text.start(number) + quotes[-1], 'the quote " that opens here is not closed in its line; add a "'
    return None


def _bad_escape(text: _Lines, at: int, _began: int, _problem: str) -> Slip | None:
    """A backslash in double quotes before a letter that makes no escape."""
    letter = text.text[at]
    return at, f"\\{letter} is no escape in double quotes; write \\\\{letter}, or take single quotes"


def _in_brackets(text: _Lines, at: int, began: int, problem: str) -> Slip | None:
    """A bracket that is not closed, or closed by another, or without a comma between two entries."""
    opener = text.text[began]
    if opener not in CLOSES:
        return None
    closer, found = CLOSES[opener], text.text[at : at + 1]
    if half := _half_quoted(text, text.number(began), text.number(at)):
        return half
    if found in ("}", "]") and found != closer:
        return at, f"this {found} closes the {opener} of line {text.number(began) + 1}; write {closer}"
    if not _is_closed(text.text, began):
        return began, f"the {opener} that opens here is not closed; add a {closer}"
    if found == ":":
        key = re.search(r"[^\s,{}\[\]:]+\s*$", text.text[began:at])
        return (began + key.start(), f"a comma is missing before {quoted(key[0].strip())}") if key else None
    return at, "a comma is missing here, or quotes around the whole value"


def _no_value(text: _Lines, at: int, _began: int, _problem: str) -> Slip | None:
    """A bracket that another closes, or a comma with nothing before it."""
    found, opened = text.text[at : at + 1], _open_brackets(text.text[:at])
    if opened and found in ("}", "]"):
        opener = text.text[opened[-1]]
        return at, f"this {found} closes the {opener} of line {text.number(opened[-1]) + 1}; write {CLOSES[opener]}"
    return at, "a value is missing here" if found == "," else f"{found or 'nothing'} cannot begin a value"


def _is_closed(text: str, began: int) -> bool:
    """Whether the bracket at an offset has its closing one."""
    return not _open_brackets(text[began:], until_closed=True)


def _open_brackets(text: str, until_closed: bool = False) -> list[int]:
    """The offsets of the brackets that are not closed, outermost first; those in quotes do not count.

    until_closed: ends where the first one is closed.
    """
    opened: list[int] = []
    for one in re.finditer(r"""(?<=[\s,:\[{])"(?:\\.|[^"\\])*"|(?<=[\s,:\[{])'[^']*'|[{}\[\]]""", text):
        if one[0] in CLOSES:
            opened.append(one.start())
        elif one[0] in ("}", "]") and opened:
            opened.pop()
            if until_closed and not opened:
                break
    return opened


def _wrong_depth(text: _Lines, at: int, _began: int, problem: str) -> Slip | None:
    """A line at a depth that no line above has, a list item among keys, a closing bracket too many."""
    found, number = text.text[at : at + 1], text.number(at)
    if found in ("}", "]"):
        return at, f"this {found} closes nothing; remove it"
    if text.start(number) != at:
        return _half_quoted(text, 0, number) or (
            at,
            "text follows a value that has ended; put quotes around it all",
        )
    if text.content(number).startswith("- "):
        return at, _list_item(text, number)
    return at, _indentation(text, number)


def _list_item(text: _Lines, number: int) -> str:
    own = text.indent(number)
    for one in text.above(number):
        if text.content(one).startswith("- "):
            depth = text.indent(one)
            if depth == own:
                break
            return (
                f"this item of a list is indented by {_spaces(own)}, the one in line {one + 1} by {depth}; indent both "
                "alike"
            )
        if text.content(one).endswith(":") and text.indent(one) > own:
            key = text.content(one)[:-1]
            return f"indent the items of {quoted(key)} at least as far as its line, by {_spaces(text.indent(one))}"
        if text.indent(one) <= own:
            break
    return 'a list item ("- ") stands among keys; remove the "- ", or write all of them as items'


def _indentation(text: _Lines, number: int) -> str:
    own = text.indent(number)
    depths: dict[int, int] = {}
    for one in text.above(number):
        depth = text.indent(one)
        if not depths or depth < min(depths):
            depths[depth] = one
    if own in depths:
        return (
            f"a key stands beside the items of a list (line {depths[own] + 1}); indent it by 2 more, or write it above"
        )
    near = sorted(
        (*(depth for depth in depths if depth > own), *(depth for depth in depths if depth < own)),
        key=lambda depth: abs(depth - own),
    )[:2]
    known = " or ".join(f"{depth} (as line {depths[depth] + 1})" for depth in sorted(near))
    return f"no line above is indented by {_spaces(own)} as this one is; indent it by {known}"


def _short(line: str) -> str:
    return quoted(line if len(line) <= SHOWN else f"{line[:SHOWN]}...")


def _spaces(count: int) -> str:
    return f"{count} space{'' if count == 1 else 's'}"


def _one_line(text: Any) -> str:
    return " ".join(str(text).split())


RULES: dict[str, Callable[[_Lines, int, int, str], Slip | None]] = {
    "could not find expected ':'": _no_colon,
    "mapping values are not allowed": _second_colon,
    "found character": _bad_start,
    "found unexpected end of stream": _open_quote,
    "found unexpected document separator": _open_quote,
    "found unknown escape character": _bad_escape,
    "expected ',' or": _in_brackets,
    "expected the node content": _no_value,
    "expected <block end>": _wrong_depth,
}
"""The beginning of the parser's words, and what explains them."""
