"""What names without behaviour do: those of class B exist, do nothing and say so once; those of class C refuse."""

from __future__ import annotations

import ast
from collections.abc import Callable
from functools import wraps
from typing import Any, TypeVar, cast

from graph.base.errors import UserError

from .names import Row
from .session import warn

F = TypeVar("F", bound=Callable[..., Any])


class UnsupportedError(UserError, NotImplementedError):
    """A part of Isaac Sim that TickGraph does not have; says why, and what to do instead."""

    def __str__(self) -> str:
        return Exception.__str__(self)


def outcome(name: str, row: Row) -> Any:
    """The object for a name of class B or C."""
    if row.kind == "C":
        return refused(name, row.text)
    if row.text == "class":
        return _inert_class(name)
    value = ast.literal_eval(row.text)

    def inert(*_: Any, **__: Any) -> Any:
        tell_inert(name)
        return value

    inert.__name__ = inert.__qualname__ = name.rpartition(".")[2]
    return inert


def tell_inert(name: str, message: str = "it exists and does nothing here") -> None:
    """Says, once for each name, that it does nothing. Raises UnsupportedError in strict runs."""
    from .session import strict

    if strict():
        raise UnsupportedError(f"{name}: {message}; --strict refuses that")
    warn("isaac-inert", name, message)


def inert(module: str) -> Callable[[F], F]:
    """Declares a function of class B: each call says, once, that it does nothing, then gives what its body returns.

    module: the module of Isaac Sim by which scripts know the function or its class.
    """

    def declare(function: F) -> F:
        name = f"{module}.{function.__qualname__}"

        @wraps(function)
        def told(*args: Any, **named: Any) -> Any:
            tell_inert(name)
            return function(*args, **named)

        return cast(F, told)

    return declare


def tell_old_name(name: str, instead: str) -> None:
    """Says, once, that a module has another name now."""
    warn("isaac-old-name", name, f"Isaac Sim 6 has no such module; it stands for {instead}")


class _Inert(type):
    """Classes of interfaces: every attribute is there, and every call gives another such object."""

    _name: str

    def __getattr__(cls, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return _inert_class(cls._name)()


def _inert_class(name: str) -> Any:
    def attribute(self: Any, one: str) -> Any:
        if one.startswith("__"):
            raise AttributeError(one)
        return self

    body = {
        "__module__": name.rpartition(".")[0],
        "_name": name,
        "__init__": lambda self, *_, **__: tell_inert(name),
        "__getattr__": attribute,
        "__call__": lambda self, *_, **__: self,
        "__enter__": lambda self: self,
        "__exit__": lambda self, *_: None,
        "__iter__": lambda self: iter(()),
        "__bool__": lambda self: False,
        "__len__": lambda self: 0,
    }
    return _Inert(name.rpartition(".")[2], (), body)


class _Refused(type):
    """A name that may be imported and subclassed; using it raises UnsupportedError."""

    _why: str
    _name: str

    def __call__(cls, *_: Any, **__: Any) -> Any:
        raise UnsupportedError(f"{cls._name}: {cls._why}")

    def __getattr__(cls, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return refused(f"{cls._name}.{name}", cls._why)


def refusal(value: Any) -> str:
    """Why an object refuses at its first use; "" if it does not."""
    return value._why if isinstance(value, _Refused) else ""


def refused(name: str, why: str) -> Any:
    """A class that refuses at its first use, for the reason `why`."""
    return _Refused(name.rpartition(".")[2], (), {"_why": why, "_name": name, "__module__": name.rpartition(".")[0]})


class Refusing:
    """A namespace whose further names are refused at their use, each with its reason."""

    def __init__(self, name: str, why: str) -> None:
        self._name, self._why = name, why

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return refused(f"{self._name}.{name}", self._why)
