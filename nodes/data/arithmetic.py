"""Arithmetic on numbers, tuples and arrays, element by element; a number is repeated to fit any shape."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Iterator
from typing import Any

from graph.node import Attribute, Database, KnownTypes, NodeAtLoad, node_type
from graph.values.types import INTEGER_RANGES, TYPES

from .like_inputs import incremented, same_type, signed
from .numbers import aligned, changed, fitting, folded, for_types, input_type, quietly, settled, two_numbers
from .promotion import promoted, quotient

NUMERICS = ("numerics",)
INTEGRAL = ("integral_scalers",)
EXTRA = Attribute(NUMERICS, "one more operand")


def _operand(which: str) -> Attribute:
    return Attribute(NUMERICS, f"{which} operand")


def _folded(name: str, operation: Callable[[Any, Any], Any], output: str, doc: str, result: str) -> None:
    """Declares the node type `name`: `operation` over all operands; result: what its output says."""
    fold = folded(operation, output)

    def compute(db: Database) -> None:
        fold(db)

    compute.__doc__ = doc
    node_type(
        f"omni.graph.nodes.{name}",
        version=2,
        inputs={"a": _operand("first"), "b": _operand("second")},
        outputs={output: Attribute(NUMERICS, result)},
        dynamic_inputs={"{operand}": EXTRA},
        resolve=promoted(output),
        specialize=for_types(operation, output),
    )(compute)


_folded("Add", operator.add, "sum", "Add the operands.", "a + b, and any further operands")
_folded(
    "Subtract",
    operator.sub,
    "difference",
    "Subtract the other operands from the first.",
    "a - b, less any further operands",
)
_folded(
    "Multiply",
    operator.mul,
    "product",
    "Multiply the operands element by element (matrices too).",
    "a x b, times any further operands",
)


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


TOLERANCE = Attribute("double", "how far from 0 still counts as 0", default=0.0, minimum=0.0)


@node_type(
    "omni.graph.nodes.Absolute",
    version=1,
    inputs={"input": Attribute(NUMERICS, "numbers, of any shape")},
    outputs={"absolute": Attribute(NUMERICS, "the same numbers without their signs")},
    resolve=same_type("input", "absolute"),
)
def absolute(db: Database) -> None:
    """Give the absolute value, element by element; for the length of a vector use Magnitude."""
    db.outputs.absolute = changed(db, abs, db.inputs.input, settled(db, "absolute"))


@node_type(
    "omni.graph.nodes.Negate",
    version=1,
    inputs={"input": Attribute(NUMERICS, "numbers of a type that has signs, of any shape")},
    outputs={"output": Attribute(NUMERICS, "the same numbers with the other sign")},
    resolve=signed("input", "output"),
)
def negate(db: Database) -> None:
    """Negate numbers, element by element."""
    db.outputs.output = changed(db, operator.neg, db.inputs.input, settled(db, "output"))


@node_type(
    "omni.graph.nodes.FMod",
    version=1,
    inputs={"a": Attribute(("decimals",), "the dividend"), "b": Attribute(("decimals",), "the divisor")},
    outputs={"result": Attribute(("decimals",), "what remains of a, with its sign; 0 where b is 0")},
    resolve=promoted("result"),
)
def float_remainder(db: Database) -> None:
    """Give the remainder of real numbers, as C does: -7.5 by 2 leaves -1.5."""
    a, b = aligned(db, "ab", settled(db, "result"))
    if not hasattr(a, "dtype") and not hasattr(b, "dtype"):
        db.outputs.result = math.fmod(a, b) if b and not math.isinf(a) else 0.0 if not b else math.nan
        return
    import numpy as np

    with np.errstate(all="ignore"):
        db.outputs.result = np.where(np.equal(b, 0), np.zeros_like(a), np.fmod(a, b))


def _near_zero(db: Database) -> Any:
    """Which numbers of the input are 0: a bool, or an array of bools of the same shape."""
    return abs(db.inputs.value) <= db.inputs.tolerance


@node_type(
    "omni.graph.nodes.IsZero",
    version=1,
    inputs={"tolerance": TOLERANCE, "value": Attribute(NUMERICS, "what to look at")},
    outputs={"result": Attribute("bool", "whether all of it is 0")},
)
def is_zero(db: Database) -> None:
    """Give whether a number, or every number of a tuple or array, is 0."""
    found = _near_zero(db)
    db.outputs.result = bool(found.all()) if hasattr(found, "all") else found


@node_type(
    "omni.graph.nodes.AnyZero",
    version=1,
    inputs={"tolerance": TOLERANCE, "value": Attribute(NUMERICS, "what to look at")},
    outputs={"result": Attribute("bool", "whether some of it is 0")},
)
def any_zero(db: Database) -> None:
    """Give whether a number, or any number of a tuple or array, is 0."""
    found = _near_zero(db)
    db.outputs.result = bool(found.any()) if hasattr(found, "any") else found


def _each_type(known: KnownTypes) -> Any:
    given = known["inputs:value"]
    return {} if given is None else {"outputs:result": TYPES["bool" if given.scalar else "bool[]"]}


@node_type(
    "omni.graph.nodes.EachZero",
    version=1,
    inputs={"tolerance": TOLERANCE, "value": Attribute(NUMERICS, "what to look at")},
    outputs={"result": Attribute(("bool", "bool[]"), "whether it is 0, one answer for each part")},
    resolve=_each_type,
)
def each_zero(db: Database) -> None:
    """Give which parts are 0: elements of an array (all numbers of a tuple), numbers of a tuple, rows of a matrix."""
    found, kind = _near_zero(db), input_type(db, "value")
    if not hasattr(found, "ndim") or kind is None:
        db.outputs.result = found
    else:
        db.outputs.result = found.reshape(len(found), -1).all(axis=1) if len(found) else found.reshape(0)
