"""Plain words: message templates, docstrings and comments, held against lists of phrases, a length and a form."""

import ast
import re
from functools import cache

import pytest

from tests.support.places import PACKAGES, ROOT

SOURCES = [path for package in PACKAGES for path in sorted((ROOT / package).rglob("*.py"))]
TESTS = [path for path in sorted((ROOT / "tests").rglob("*.py")) if path.name != "test_wording.py"]

SPEAKERS = re.compile(
    r"_?(fail|warn|warning|warn_once|error|complain|problem|report|tell|log_warning|log_error|Problem|\w+Error)"
)
"""The names of what takes a message, called as a function or as a method."""

PRINTERS = ("graph/cli", "graph/files/writing.py", "graph/sim/messages/message.py", "nodes/catalog/example.py")
"""What yields or returns lines of output, not messages."""

DECLARERS = {"Attribute", "Knob", "Limit", "Difference", "Field", "Command"}
"""What takes a description that users read in `graph node`, `graph schema` and `--help`."""

NOT_MESSAGES = {"KeyError", "AttributeError", "AssertionError", "NotImplementedError"}
"""They speak to programs, or in Python's own words."""

RIDDLES = re.compile(
    r"\b("
    r"(is|are|was|were) (none|told)|none such|one that is|(has|have) none|(?<!there )(is|are) no (?!longer|more than)"
    r"|anew|thereof|therein|whereof|beforehand|hitherto|as it were|in vain|hindrance"
    r"|lack(s|ed|ing)?|it must not|no end\b|stands? for nothing"
    r")\b",
    re.IGNORECASE,
)
"""Phrases to say in other words: "not a path" for "is no path", "missing" for "lacks", "reported" for "is told"."""

PROSE_RIDDLES = re.compile(
    r"\b("
    r"(is|are|was|were|be|been) told|(is|are|was|were|has|have|had) none|none such"
    r"|(?<![Tt]here )(is|are) no (?!longer|more than)|where there (is|are) no"
    r"|anew|afresh|thereof|therein|whereof|beforehand|hitherto|as it were|in vain|hindrance"
    r"|lack(s|ed|ing)?|no end|stands? for nothing|hand(s|ed)? out|what is not|somebody|whoever"
    r")\b"
)
"""The same in docstrings and comments: "again" for "anew", "reported" for "is told", "gives" for "hands out"."""

LONGEST = 300
"""Characters of a message, its values left out."""


def literals(node):
    """The literal texts of an expression that makes a message: values are left as {}, alternatives are one each."""
    match node:
        case ast.Constant(value=str(text)):
            return [text]
        case ast.JoinedStr(values=parts):
            return ["".join(part.value if isinstance(part, ast.Constant) else "{}" for part in parts)]
        case ast.IfExp(body=body, orelse=other):
            return literals(body) + literals(other)
        case ast.BinOp(left=left, right=right, op=ast.Add()):
            return [a + b for a in literals(left) or ["{}"] for b in literals(right) or ["{}"]]
    return []


def called(node):
    function = node.func
    return function.attr if isinstance(function, ast.Attribute) else getattr(function, "id", "")


def messages(node, printer):
    """(line, template) of each message that a node of a syntax tree makes: several words given to what speaks."""
    match node:
        case ast.Call() if SPEAKERS.fullmatch(called(node)) and called(node) not in NOT_MESSAGES:
            given = [*node.args, *(keyword.value for keyword in node.keywords)]
        case ast.Yield(value=value) | ast.Return(value=value) if value and not printer:
            given = [value]
        case _:
            return
    yield from ((node.lineno, text) for each in given for text in literals(each) if text.count(" ") > 1)


def docstrings(node):
    """(line, text) of the docstrings in a node's body, those of attributes too."""
    if isinstance(node, ast.expr | ast.expr_context):  # most nodes of a file, and without a body
        return
    for part in ("body", "orelse", "finalbody"):
        statements = getattr(node, part, None)
        for each in statements if isinstance(statements, list) else ():
            match each:
                case ast.Expr(value=ast.Constant(value=str(text))):
                    yield each.lineno, text


def comments(source):
    """(line, text) of every comment of a file."""
    for number, line in enumerate(source.splitlines(), start=1):
        if found := re.search(r"(?:^|\s)# (.+)", line):
            yield number, found[1]


def descriptions(node):
    """(line, text) of what attributes, knobs, settings and fields of files say of themselves."""
    if isinstance(node, ast.Call) and called(node) in DECLARERS:
        given = [*node.args, *(keyword.value for keyword in node.keywords)]
        yield from ((node.lineno, text) for each in given for text in literals(each) if " " in text)


@cache
def texts():
    """(place, text) of each message, docstring and piece of prose; read in the first test, not as pytest collects."""
    templates, documented, prose = [], [], []
    shipped = set(SOURCES)
    for path in (*SOURCES, *TESTS):
        name, source = str(path.relative_to(ROOT)), path.read_text(encoding="utf8")
        printer = name.startswith(PRINTERS)
        found = list(comments(source))
        for node in ast.walk(ast.parse(source)):
            strings = list(docstrings(node))
            found += strings
            if path in shipped:
                found += descriptions(node)
                documented += ((f"{name}:{line}", text) for line, text in strings)
                templates += ((f"{name}:{line}", text) for line, text in messages(node, printer))
        prose += ((f"{name}:{line}", text) for line, text in found)
    return templates, documented, prose


def test_messages_docstrings_and_comments_are_found():
    templates, documented, prose = texts()
    assert len(templates) > 600
    assert len(documented) > 4000
    assert len(prose) > len(documented) + 1500


@pytest.mark.parametrize(
    ("rule", "broken"),
    [
        ("no riddle", RIDDLES.search),
        ("no full stop at the end", re.compile(r"(?<!\.)\.$").search),
        ("no double space", re.compile(r"\S  +\S").search),
        ("no space at the ends", re.compile(r"^ | $").search),
        ("short", lambda text: len(text.replace("{}", "")) > LONGEST),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_messages_are_plain(rule, broken):
    assert [f"{where}: {text}" for where, text in texts()[0] if broken(text)] == []


def without_code(text):
    """A text on one line, names in backticks left out."""
    return re.sub(r"`[^`]*`", "``", " ".join(text.split()))


def test_docstrings_descriptions_and_comments_are_plain():
    assert [f"{where}: {text}" for where, text in texts()[2] if PROSE_RIDDLES.search(without_code(text))] == []


def test_the_first_paragraph_of_a_docstring_is_a_sentence():
    first = [(where, text.strip().split("\n\n")[0].rstrip()) for where, text in texts()[1]]
    assert [f"{where}: {text}" for where, text in first if not text.endswith((".", "?", ":"))] == []
