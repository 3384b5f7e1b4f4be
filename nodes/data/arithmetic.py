"""Arithmetic on numbers, tuples and arrays, element by element; a number is repeated to fit any shape."""

from __future__ import annotations

import math
import operator
from collections.abc import Iterator

from graph.node import Attribute, Database, NodeAtLoad, node_type
from graph.values.types import INTEGER_RANGES

from .like_inputs import incremented
from .numbers import aligned, fitting, folded, for_types, quietly, settled, two_numbers
from .promotion import promoted, quotient

NUMERICS = ("numerics",)
INTEGRAL = ("integral_scalers",)
EXTRA = Attribute(NUMERICS, "one more operand")


def _operand(which: str) -> Attribute:
    return Attribute(NUMERICS, f"{which} operand")


_add = folded(operator.add, "sum")
_subtract = folded(operator.sub, "difference")
_multiply = folded(operator.mul, "product")


@node_type(
    "omni.graph.nodes.Add",
    version=2,
    inputs={"a": _operand("first"), "b": _operand("second")},
    outputs={"sum": Attribute(NUMERICS, "a + b, and any further operands")},
    dynamic_inputs={"{operand}": EXTRA},
    resolve=promoted("sum"),
    specialize=for_types(operator.add, "sum"),
)
def add(db: Database) -> None:
    """Add the operands."""
    _add(db)


@node_type(
    "omni.graph.nodes.Subtract",
    version=2,
    inputs={"a": _operand("first"), "b": _operand("second")},
    outputs={"difference": Attribute(NUMERICS, "a - b, less any further operands")},
    dynamic_inputs={"{operand}": EXTRA},
    resolve=promoted("difference"),
    specialize=for_types(operator.sub, "difference"),
)
def subtract(db: Database) -> None:
    """Subtract the other operands from the first."""
    _subtract(db)


@node_type(
    "omni.graph.nodes.Multiply",
    version=2,
    inputs={"a": _operand("first"), "b": _operand("second")},
    outputs={"product": Attribute(NUMERICS, "a x b, times any further operands")},
    dynamic_inputs={"{operand}": EXTRA},
    resolve=promoted("product"),
    specialize=for_types(operator.mul, "product"),
)
def multiply(db: Database) -> None:
    """Multiply the operands element by element (matrices too)."""
    _multiply(db)


def _nonzero_b(node: NodeAtLoad) -> Iterator[tuple[str, str]]:
    """A written divisor that is, or holds, 0."""
    b = node.db.inputs.b
    if "b" in node.given and not (b.all() if hasattr(b, "all") else b):
        yield "b", "it contains 0; division by zero"


@node_type(
    "omni.graph.nodes.Divide",
    version=1,
    inputs={"a": _operand("first"), "b": _operand("second")},
    outputs={"result": Attribute(NUMERICS, "a / b; double where both are integers")},
    resolve=quotient("result"),
    check=_nonzero_b,
    specialize=two_numbers(operator.truediv, "result", nonzero="b"),
)
def divide(db: Database) -> None:
    """Divide element by element; a zero anywhere in b fails."""
    a, b = aligned(db, "ab", settled(db, "result"))
    if not (b.all() if hasattr(b, "all") else b):
        db.fail("input b contains 0; division by zero")
    db.outputs.result = quietly(lambda: a / b)


@node_type(
    "omni.graph.nodes.Modulo",
    version=1,
    inputs={"a": Attribute(INTEGRAL, "the dividend"), "b": Attribute(INTEGRAL, "the divisor; 0 fails")},
    outputs={"result": Attribute(INTEGRAL, "what remains of a, with the sign of a")},
    resolve=promoted("result"),
    check=_nonzero_b,
)
def modulo(db: Database) -> None:
    """Give the remainder of whole numbers, as C does: -7 modulo 3 is -1."""
    a, b = db.inputs.a, db.inputs.b
    if b == 0:
        db.fail("input b is 0; division by zero")
    remainder = abs(a) % abs(b)
    db.outputs.result = -remainder if a < 0 else remainder


@node_type(
    "omni.graph.nodes.Increment",
    version=1,
    inputs={
        "increment": Attribute("double", "what is added", default=1.0),
        "value": Attribute(NUMERICS, "the value to start from"),
    },
    outputs={"result": Attribute(NUMERICS, "value + increment, of the value's type")},
    resolve=incremented,
)
def increment(db: Database) -> None:
    """Add a number to a value of any shape; for an integer result the sum is truncated towards zero."""
    value, step, result = db.inputs.value, db.inputs.increment, settled(db, "result")
    total = quietly(lambda: value + step)
    if result is not None and result.storage in INTEGER_RANGES and not hasattr(total, "dtype"):
        total = math.trunc(total) if math.isfinite(total) else total
    db.outputs.result = fitting(db, total, result)


@node_type(
    "omni.graph.nodes.Clamp",
    version=1,
    inputs={
        "input": Attribute(NUMERICS, "the value to keep within bounds"),
        "lower": Attribute(NUMERICS, "the least it may be: a number, or one for each component"),
        "upper": Attribute(NUMERICS, "the most it may be: a number, or one for each component"),
    },
    outputs={"result": Attribute(NUMERICS, "the value within its bounds")},
    resolve=promoted("result"),
)
def clamp(db: Database) -> None:
    """Limit a value to a range, element by element; a lower bound above the upper one fails."""
    value, lower, upper = aligned(db, ("input", "lower", "upper"), settled(db, "result"))
    crossed = lower > upper
    if crossed.any() if hasattr(crossed, "any") else crossed:
        db.fail(f"input lower ({lower}) is above input upper ({upper}); swap them")
    if not any(hasattr(one, "ndim") for one in (value, lower, upper)):
        db.outputs.result = min(max(value, lower), upper)
        return
    import numpy as np

    db.outputs.result = np.minimum(np.maximum(value, lower), upper)
