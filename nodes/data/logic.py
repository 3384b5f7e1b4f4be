"""Comparisons, boolean logic and selection; arrays element by element."""

from __future__ import annotations

import operator
from collections.abc import Callable, Sequence
from functools import reduce
from typing import Any

from graph import Attribute, node_type

from .promotion import condition_type, selected_type

VALUES = ("bool", "bool[]", "numerics", "path", "string", "token", "token[]")
BOOLS = ("bool", "bool[]")
EXTRA = Attribute(BOOLS, "one more operand")

_OPERATIONS: dict[str, Callable[[Any, Any], bool]] = {
    ">": operator.gt,
    "<": operator.lt,
    ">=": operator.ge,
    "<=": operator.le,
    "==": operator.eq,
    "!=": operator.ne,
}


def _plain(value: Any) -> Any:
    """The value with lists for arrays: Python compares lists as the original compares tuples, in order."""
    return value.tolist() if hasattr(value, "tolist") else value


def _is_array(db: Any, name: str) -> bool:
    return str(db.input_type(name)).endswith("[]")


def stretch(db: Any, operands: Sequence[tuple[Any, bool]]) -> list[list[Any]]:
    """Operands (value, whether it is an array) as lists of one length; single values repeat.

    Fails the node where two arrays differ in length.
    """
    lengths = {len(value) for value, is_array in operands if is_array}
    if len(lengths) > 1:
        db.fail(f"the arrays have {' and '.join(map(str, sorted(lengths)))} elements; they need one length")
    [length] = lengths
    return [list(value) if is_array else [value] * length for value, is_array in operands]


@node_type(
    "omni.graph.nodes.Compare",
    version=1,
    inputs={
        "a": Attribute(VALUES, "left side"),
        "b": Attribute(VALUES, "right side"),
        "operation": Attribute("token", "how to compare", default=">", allowed_tokens=tuple(_OPERATIONS)),
    },
    outputs={"result": Attribute(BOOLS, "whether it holds; an array where a or b is one")},
    resolve=condition_type("result", "a", "b"),
)
def compare(db: Any) -> None:
    """Compare numbers, texts and tuples (component by component, the first difference decides)."""
    inputs = db.inputs
    if inputs.operation not in _OPERATIONS:
        db.fail(f"input operation is {inputs.operation!r}; it must be one of {' '.join(_OPERATIONS)}")
    holds = _OPERATIONS[inputs.operation]
    operands = [(_plain(getattr(inputs, name)), _is_array(db, name)) for name in ("a", "b")]
    if any(is_array for _, is_array in operands):
        db.outputs.result = [holds(a, b) for a, b in zip(*stretch(db, operands), strict=True)]
    else:
        db.outputs.result = holds(operands[0][0], operands[1][0])


def _combine(db: Any, operation: Callable[[Any, Any], Any]) -> None:
    names = ["a", "b", *db.dynamic_input_names()]
    operands = [(_plain(value), _is_array(db, name)) for name, value in zip(names, _values(db), strict=True)]
    if any(is_array for _, is_array in operands):
        rows = zip(*stretch(db, operands), strict=True)
        db.outputs.result = [bool(reduce(operation, row)) for row in rows]
    else:
        db.outputs.result = bool(reduce(operation, (value for value, _ in operands)))


def _values(db: Any) -> list[Any]:
    return [db.inputs.a, db.inputs.b, *db.dynamic_inputs()]


@node_type(
    "omni.graph.nodes.BooleanAnd",
    version=2,
    inputs={"a": Attribute(BOOLS, "first operand"), "b": Attribute(BOOLS, "second operand")},
    outputs={"result": Attribute(BOOLS, "whether all operands are true")},
    dynamic_inputs={"{x}": EXTRA},
    resolve=condition_type("result"),
)
def boolean_and(db: Any) -> None:
    """Tell whether all operands are true."""
    _combine(db, operator.and_)


@node_type(
    "omni.graph.nodes.BooleanOr",
    version=2,
    inputs={"a": Attribute(BOOLS, "first operand"), "b": Attribute(BOOLS, "second operand")},
    outputs={"result": Attribute(BOOLS, "whether an operand is true")},
    dynamic_inputs={"{x}": EXTRA},
    resolve=condition_type("result"),
)
def boolean_or(db: Any) -> None:
    """Tell whether any operand is true."""
    _combine(db, operator.or_)


@node_type(
    "omni.graph.nodes.BooleanNot",
    version=1,
    inputs={"valueIn": Attribute(BOOLS, "the operand")},
    outputs={"valueOut": Attribute(BOOLS, "the opposite")},
    resolve=condition_type("valueOut", "valueIn"),
)
def boolean_not(db: Any) -> None:
    """Turn true into false and back."""
    value = _plain(db.inputs.valueIn)
    db.outputs.valueOut = [not one for one in value] if _is_array(db, "valueIn") else not value


@node_type(
    "omni.graph.nodes.SelectIf",
    version=1,
    inputs={
        "condition": Attribute(BOOLS, "which one to take; an array decides element by element"),
        "ifFalse": Attribute(VALUES, "taken where the condition is false"),
        "ifTrue": Attribute(VALUES, "taken where the condition is true"),
    },
    outputs={"result": Attribute(VALUES, "what was taken")},
    resolve=selected_type,
)
def select_if(db: Any) -> None:
    """Take one of two values."""
    inputs = db.inputs
    if not _is_array(db, "condition"):
        db.outputs.result = inputs.ifTrue if inputs.condition else inputs.ifFalse
        return
    sides = [(_plain(getattr(inputs, name)), _is_array(db, name)) for name in ("ifTrue", "ifFalse")]
    rows = zip(*stretch(db, [(_plain(inputs.condition), True), *sides]), strict=True)
    db.outputs.result = [if_true if condition else if_false for condition, if_true, if_false in rows]
