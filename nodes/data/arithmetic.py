"""Arithmetic on numbers, tuples and arrays, element by element; a number stretches to any shape."""

from __future__ import annotations

import operator
from collections.abc import Callable
from functools import reduce
from typing import Any

from graph import Attribute, node_type

from .promotion import promoted, quotient

NUMERICS = ("numerics",)
EXTRA = Attribute(NUMERICS, "one more operand")


def _operand(which: str) -> Attribute:
    return Attribute(NUMERICS, f"{which} operand")


def _fold(db: Any, operation: Callable[[Any, Any], Any]) -> Any:
    operands = [db.inputs.a, db.inputs.b, *db.dynamic_inputs()]
    check_lengths(db, operands)
    return reduce(operation, operands)


def check_lengths(db: Any, operands: list[Any]) -> None:
    """Fails the node where two arrays differ in length (NumPy would stretch an array of length 1)."""
    lengths = {len(one) for one in operands if getattr(one, "ndim", 0) == _depth(operands)}
    if len(lengths) > 1:
        db.fail(f"the arrays have {' and '.join(map(str, sorted(lengths)))} elements; they need one length")


def _depth(operands: list[Any]) -> int:
    return max((getattr(one, "ndim", 0) for one in operands), default=0) or -1


@node_type(
    "omni.graph.nodes.Add",
    version=2,
    inputs={"a": _operand("first"), "b": _operand("second")},
    outputs={"sum": Attribute(NUMERICS, "a + b, and any further operands")},
    dynamic_inputs={"{x}": EXTRA},
    resolve=promoted("sum"),
)
def add(db: Any) -> None:
    """Add the operands."""
    db.outputs.sum = _fold(db, operator.add)


@node_type(
    "omni.graph.nodes.Subtract",
    version=2,
    inputs={"a": _operand("first"), "b": _operand("second")},
    outputs={"difference": Attribute(NUMERICS, "a - b, less any further operands")},
    dynamic_inputs={"{x}": EXTRA},
    resolve=promoted("difference"),
)
def subtract(db: Any) -> None:
    """Subtract the further operands from the first."""
    db.outputs.difference = _fold(db, operator.sub)


@node_type(
    "omni.graph.nodes.Multiply",
    version=2,
    inputs={"a": _operand("first"), "b": _operand("second")},
    outputs={"product": Attribute(NUMERICS, "a x b, times any further operands")},
    dynamic_inputs={"{x}": EXTRA},
    resolve=promoted("product"),
)
def multiply(db: Any) -> None:
    """Multiply the operands element by element (matrices too)."""
    db.outputs.product = _fold(db, operator.mul)


@node_type(
    "omni.graph.nodes.Divide",
    version=1,
    inputs={"a": _operand("first"), "b": _operand("second")},
    outputs={"result": Attribute(NUMERICS, "a / b; double where both are integers")},
    resolve=quotient("result"),
)
def divide(db: Any) -> None:
    """Divide element by element; a zero anywhere in b fails."""
    a, b = db.inputs.a, db.inputs.b
    check_lengths(db, [a, b])
    if not (b.all() if hasattr(b, "all") else b):
        db.fail("input b holds a 0; it must not")
    db.outputs.result = a / b
