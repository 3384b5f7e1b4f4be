"""The values of expressions that a script writes out: constants, and what is made of constants."""

from __future__ import annotations

import ast
from collections.abc import Callable
from typing import Any

MOST_PARTS = 10_000
"""Expressions that are looked at for one value; a script may double them with every line."""
LONGEST_TEXT = 10_000
"""Characters of a text; likewise."""
TEXTS = ("Path", "str")
"""Calls, by their last name, whose value is the text that they get, such as `Sdf.Path("/World")`."""


class NotConstant(Exception):  # noqa: N818  (no mistake)
    """The value is known only to a run."""


class Folder:
    """Evaluates one expression. named: the expression that a name stands for, None if unknown."""

    def __init__(self, named: Callable[[str], ast.expr | None]) -> None:
        self._named, self._left = named, MOST_PARTS

    def value(self, node: ast.AST | None) -> Any:
        """The value. Raises NotConstant, and RecursionError for names that stand for themselves."""
        self._left -= 1
        if node is None or self._left < 0:
            raise NotConstant
        match node:
            case ast.Constant(value=found):
                return found
            case ast.Name(id=name):
                return self.value(self._named(name))
            case ast.List(elts=parts):
                return [self.value(one) for one in parts]
            case ast.Tuple(elts=parts):
                return tuple(self.value(one) for one in parts)
            case ast.Dict(keys=keys, values=values):
                return dict(self._entry(key, value) for key, value in zip(keys, values, strict=True))
            case ast.JoinedStr(values=parts):
                return _short("".join(str(self.value(one)) for one in parts))
            case ast.FormattedValue(value=inner, format_spec=None, conversion=-1):
                return self.value(inner)
            case ast.UnaryOp(op=ast.USub(), operand=inner):
                return -_number(self.value(inner))
            case ast.BinOp(left=left, op=operation, right=right):
                return _combined(self.value(left), operation, self.value(right))
            case ast.Call(func=ast.Name(id=name) | ast.Attribute(attr=name), args=[inner], keywords=[]):
                if name in TEXTS and isinstance(found := self.value(inner), str):
                    return found
        raise NotConstant

    def _entry(self, key: ast.expr | None, value: ast.expr) -> tuple[Any, Any]:
        name = self.value(key)
        if not isinstance(name, str | int | float):
            raise NotConstant
        return name, self.value(value)


def _combined(left: Any, operation: ast.operator, right: Any) -> Any:
    if isinstance(left, str) and isinstance(right, str) and isinstance(operation, ast.Add):
        return _short(left + right)
    first, second = _number(left), _number(right)
    try:
        match operation:
            case ast.Add():
                return first + second
            case ast.Sub():
                return first - second
            case ast.Mult():
                return first * second
            case ast.Div():
                return first / second
    except (ZeroDivisionError, OverflowError):
        pass
    raise NotConstant


def _number(value: Any) -> int | float:
    if isinstance(value, float) or (isinstance(value, int) and abs(value) < 1 << 64):
        return value
    raise NotConstant


def _short(text: str) -> str:
    if len(text) > LONGEST_TEXT:
        raise NotConstant
    return text
