"""The value of a plain scalar: the core schema of YAML 1.2 (section 10.3.2), and no more.

`on`, `yes`, `0777` as octal, `1_000` and `12:30:00` have a special meaning in YAML 1.1; here they are text, or the
decimal number as written.
"""

from __future__ import annotations

import math
import re

Scalar = bool | int | float | str | None

_WORDS: dict[str, Scalar] = {
    **dict.fromkeys(("", "~", "null", "Null", "NULL")),
    **dict.fromkeys(("true", "True", "TRUE"), True),
    **dict.fromkeys(("false", "False", "FALSE"), False),
    **dict.fromkeys((".nan", ".NaN", ".NAN"), math.nan),
    **{sign + word: math.inf for sign in ("", "+") for word in (".inf", ".Inf", ".INF")},
    **dict.fromkeys(("-.inf", "-.Inf", "-.INF"), -math.inf),
}
# Every number and every special word starts with one of these; any other first character means text.
_MAY_BE_SPECIAL = frozenset("0123456789+-.~ntfNTF")
_NUMBER = re.compile(
    r"(?P<int>[-+]?[0-9]+)|(?P<oct>0o[0-7]+)|(?P<hex>0x[0-9a-fA-F]+)"
    r"|(?P<float>[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?)"
)
DIGITS_LIMIT = 400
"""Most characters of a number; a double has at most 309 digits before its point."""
STAND_IN = 1
"""The value of a number that could not be read. Later stages accept it, so that each mistake is reported once."""


def resolve(text: str) -> Scalar:
    """The value of a plain scalar. Raises ValueError for a number that no double or sensible integer can hold."""
    if text and text[0] not in _MAY_BE_SPECIAL:
        return text
    if text in _WORDS:
        return _WORDS[text]
    found = _NUMBER.fullmatch(text)
    return text if found is None else number(text, str(found.lastgroup))


def number(text: str, kind: str) -> int | float:
    """The value of a number written as `int`, `oct`, `hex` or `float`. Raises ValueError if it is too large."""
    if len(text) > DIGITS_LIMIT:
        raise ValueError(f"a number of {len(text)} digits is too long")
    if kind == "float":
        value = float(text)
        if math.isinf(value):
            raise ValueError(f"{text} is larger than any double")
        return value
    whole = int(text, {"int": 10, "oct": 8, "hex": 16}[kind])
    try:
        float(whole)
    except OverflowError:
        raise ValueError(f"a number of {len(text)} digits is larger than any double") from None
    return whole
