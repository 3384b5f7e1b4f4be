"""Metrics of a run: expressions over its report and its recorded topics, and values that its nodes wrote.

An expression is data: it is parsed, and only what this module lists is evaluated. It reaches numbers and texts of the
run, no object of the program.
"""

from __future__ import annotations

import ast
import json
import math
import operator
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from graph.base.inputs import read
from graph.base.outputs import write
from graph.base.suggest import did_you_mean

NAME, REPORT = "metrics.json", "report.json"
LONGEST, MOST_PARTS = 2000, 300
"""Most characters and parts of an expression."""

REPORT_NAME, TOPIC_NAME = "report", "topic"
CONSTANTS = {"pi": math.pi, "inf": math.inf}


class Topic:
    """The messages of a topic; a field of it is that field of each message."""

    def __init__(self, messages: list[Any], times: list[int]) -> None:
        self.messages, self.times = messages, times

    def field(self, name: str) -> Any:
        """`time`: when each message was published [s]; else a field of the messages: numbers as an array."""
        if name == "time":
            return np.array(self.times) / 1e9
        values = [_member(message, name) for message in self.messages]
        first = values[0] if values else 0.0
        if isinstance(first, bool | int | float | np.number):
            return np.array(values, dtype=np.float64)
        if isinstance(first, np.ndarray) and first.dtype.kind in "fiub":
            if len({one.shape for one in values}) > 1:
                raise ValueError(f"{name} has another length in each message; take one of its numbers")
            return np.array(values, dtype=np.float64)
        if isinstance(first, str):
            return values
        return Topic(values, self.times)


def _member(message: Any, name: str) -> Any:
    fields = getattr(type(message), "__dataclass_fields__", {})
    if name not in fields or name.startswith("_"):
        raise ValueError(f'messages have no field "{name}"{did_you_mean(name, fields)}')
    return getattr(message, name)


def _reduced(function: Callable[[Any], Any]) -> Callable[[Any], Any]:
    def reduce(values: Any) -> float:
        array = np.asarray(values, dtype=np.float64)
        if not array.size:
            raise ValueError("there are no values")
        return float(function(array))

    return reduce


def _count(values: Any) -> int:
    return len(values.messages) if isinstance(values, Topic) else len(values)


def _at(place: int) -> Callable[[Any], Any]:
    def pick(values: Any) -> Any:
        if not _count(values):
            raise ValueError("there are no values")
        return values[place]

    return pick


def _extreme(function: Callable[[Any], Any]) -> Callable[..., Any]:
    return lambda *values: _reduced(function)(values[0] if len(values) == 1 else values)


FUNCTIONS: dict[str, Callable[..., Any]] = {
    "abs": np.abs,
    "all": lambda values: bool(np.all(np.asarray(values))),
    "any": lambda values: bool(np.any(np.asarray(values))),
    "count": _count,
    "cos": np.cos,
    "diff": lambda values: np.diff(np.asarray(values, dtype=np.float64), axis=0),
    "exp": np.exp,
    "first": _at(0),
    "hypot": np.hypot,
    "last": _at(-1),
    "log": np.log,
    "max": _extreme(np.max),
    "mean": _reduced(np.mean),
    "median": _reduced(np.median),
    "min": _extreme(np.min),
    "norm": lambda values: np.linalg.norm(np.asarray(values, dtype=np.float64), axis=-1),
    "percentile": lambda values, share: _reduced(lambda array: np.percentile(array, float(share)))(values),
    "rms": _reduced(lambda array: np.sqrt(np.mean(array**2))),
    "sin": np.sin,
    "sqrt": np.sqrt,
    "std": _reduced(np.std),
    "sum": lambda values: float(np.sum(np.asarray(values, dtype=np.float64))),
}
"""What expressions can call, beside `topic(NAME)`."""

_BINARY: dict[type, Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: np.true_divide,
    ast.FloorDiv: np.floor_divide,
    ast.Mod: np.mod,
    ast.Pow: np.power,
}
_COMPARED: dict[type, Callable[[Any, Any], Any]] = {
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
}
_PARTS = (
    *(
        ast.Expression,
        ast.Constant,
        ast.Name,
        ast.Load,
        ast.Attribute,
        ast.Subscript,
        ast.Slice,
        ast.Call,
        ast.IfExp,
        ast.List,
    ),
    *(ast.BinOp, ast.UnaryOp, ast.USub, ast.UAdd, ast.Not, ast.BoolOp, ast.And, ast.Or, ast.Compare),
    *(*_BINARY, *_COMPARED),
)


def parsed(text: str) -> ast.Expression:
    """A metric's expression. Raises ValueError, with what is wrong, for anything that is not evaluated."""
    if len(text) > LONGEST:
        raise ValueError(f"it has more than {LONGEST} characters")
    try:
        tree = ast.parse(text.strip(), mode="eval")
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        raise ValueError(f"this is not an expression: {getattr(error, 'msg', error)}") from None
    parts = list(ast.walk(tree))
    if len(parts) > MOST_PARTS:
        raise ValueError(f"it has more than {MOST_PARTS} parts")
    called = {id(part.func) for part in parts if isinstance(part, ast.Call)}
    for part in parts:
        _check(part, called)
    return tree


def _check(part: ast.AST, called: set[int]) -> None:
    if not isinstance(part, _PARTS):
        raise ValueError(f"{type(part).__name__} cannot be part of a metric")
    if isinstance(part, ast.Constant) and type(part.value) not in (bool, int, float, str):
        raise ValueError(f"{part.value!r} cannot be part of a metric")
    if isinstance(part, ast.Call) and (not isinstance(part.func, ast.Name) or part.keywords):
        raise ValueError("only functions are called, with values alone")
    if isinstance(part, ast.Name):
        known = (*FUNCTIONS, TOPIC_NAME) if id(part) in called else (*CONSTANTS, REPORT_NAME)
        if part.id not in known:
            near = did_you_mean(part.id, known) or f"; there are {', '.join(known)}"
            raise ValueError(f'there is no "{part.id}"{near}')


class Run:
    """A run's report and topics, for expressions."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.report = _data(folder / REPORT)
        self._topics: dict[str, Topic] = {}

    def value(self, text: str) -> Any:
        """The number, truth or text of an expression. Raises ValueError without a value."""
        with np.errstate(all="ignore"):
            try:
                found = self._of(parsed(text).body)
            except (TypeError, ArithmeticError, IndexError, KeyError, OverflowError) as error:
                raise ValueError(f"it has no value: {error}") from None
        if isinstance(found, np.ndarray) and not found.ndim:
            found = found.item()
        if isinstance(found, np.generic):
            found = found.item()
        if not isinstance(found, bool | int | float | str):
            raise ValueError("it is not one number; take mean, max, last, ... of it")
        if isinstance(found, float) and not math.isfinite(found):
            raise ValueError(f"it is {found}")
        return found

    def topic(self, name: Any) -> Topic:
        """The messages of a topic. Raises ValueError if it is not recorded."""
        name = str(name) if str(name).startswith("/") else f"/{name}"
        if name not in self._topics:
            self._topics[name] = self._read(name)
        return self._topics[name]

    def _read(self, name: str) -> Topic:
        from graph.base.errors import UserError
        from graph.recording.run_reader import open_run

        try:
            with open_run(self.folder, whole=False) as recording:
                if name not in recording.recorded:
                    raise ValueError(f"topic {name} is not recorded{did_you_mean(name, recording.recorded)}")
                entries = list(recording.read([name]))
                return Topic([entry.load() for entry in entries], [entry.time_ns for entry in entries])
        except UserError as error:
            raise ValueError(str(error)) from None

    def _of(self, part: ast.expr) -> Any:
        match part:
            case ast.Constant():
                return part.value
            case ast.Name():
                return self.report if part.id == REPORT_NAME else CONSTANTS[part.id]
            case ast.Attribute():
                return _entry(self._of(part.value), part.attr)
            case ast.Subscript():
                return self._subscript(part)
            case ast.Call(func=ast.Name(id=name)):
                values = [self._of(one) for one in part.args]
                return self.topic(*values) if name == TOPIC_NAME else FUNCTIONS[name](*map(_numbers, values))
            case ast.List():
                return [self._of(one) for one in part.elts]
            case ast.IfExp():
                return self._of(part.body if self._of(part.test) else part.orelse)
            case ast.UnaryOp():
                value = self._of(part.operand)
                if isinstance(part.op, ast.Not):
                    return not value
                return -_number(value) if isinstance(part.op, ast.USub) else _number(value)
            case ast.BinOp():
                return _BINARY[type(part.op)](_number(self._of(part.left)), _number(self._of(part.right)))
            case ast.BoolOp():
                every = isinstance(part.op, ast.And)
                return (all if every else any)(bool(self._of(one)) for one in part.values)
            case ast.Compare():
                return self._compared(part)
        raise ValueError(f"{type(part).__name__} cannot be part of a metric")

    def _compared(self, part: ast.Compare) -> Any:
        left, found = self._of(part.left), True
        for kind, other in zip(part.ops, part.comparators, strict=True):
            right = self._of(other)
            found = _COMPARED[type(kind)](left, right) & np.True_ & found
            left = right
        return found

    def _subscript(self, part: ast.Subscript) -> Any:
        value = self._of(part.value)
        if isinstance(part.slice, ast.Slice):
            ends = [None if one is None else int(self._of(one)) for one in (part.slice.lower, part.slice.upper)]
            return value[slice(*ends)] if isinstance(value, list | np.ndarray) else _entry(value, ":")
        key = self._of(part.slice)
        if isinstance(value, np.ndarray) and value.ndim > 1 and isinstance(key, int):
            return value[:, key]
        if isinstance(value, list | np.ndarray) and isinstance(key, int):
            return value[key]
        return _entry(value, key)


def _entry(value: Any, name: Any) -> Any:
    if isinstance(value, Topic):
        return value.field(str(name))
    if isinstance(value, Mapping):
        if name not in value:
            raise ValueError(f'there is no "{name}" in the report{did_you_mean(str(name), value)}')
        return value[name]
    raise ValueError(f'a value has no "{name}"')


def _numbers(value: Any) -> Any:
    """An argument of a function: a topic, or numbers."""
    return value if isinstance(value, Topic) else [*value] if isinstance(value, list) else _number(value)


def _number(value: Any) -> Any:
    if isinstance(value, bool | int | float):
        return np.float64(value)
    if isinstance(value, np.ndarray | np.generic) and value.dtype.kind in "fiub":
        return value
    if isinstance(value, list):
        return np.asarray(value, dtype=np.float64)
    raise ValueError(f"{'text' if isinstance(value, str) else 'this'} is not a number")


def measure(folder: Path, metrics: Mapping[str, str]) -> None:
    """Writes `metrics.json`: the values of a run's metrics, and of those without a value why."""
    run = Run(folder)
    values: dict[str, Any] = {}
    failed: dict[str, str] = {}
    for name, text in metrics.items():
        try:
            values[name] = run.value(text)
        except ValueError as error:
            failed[name] = str(error)
    write(folder / NAME, json.dumps({"metrics": values, "failed": failed}, indent=1) + "\n")


def metrics_of(folder: Path) -> dict[str, Any]:
    """The metrics of a run by name: those that its nodes wrote, and those of expressions."""
    found = {**_data(folder / REPORT).get("metrics", {}), **_data(folder / NAME).get("metrics", {})}
    return {str(name): value for name, value in found.items() if isinstance(value, bool | int | float | str)}


def _data(file: Path) -> dict[str, Any]:
    try:
        found = json.loads(read(file, "campaign.table"))
    except (OSError, ValueError, RecursionError):
        return {}
    return found if isinstance(found, dict) else {}
