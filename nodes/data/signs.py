"""Signs, remainders and zeros of numbers, tuples and arrays."""

from __future__ import annotations

import math
import operator
from typing import Any

from graph.node import Attribute, Database, KnownTypes, node_type
from graph.values.types import TYPES

from .like_inputs import same_type, signed
from .numbers import aligned, changed, input_type, settled
from .promotion import promoted

NUMERICS = ("numerics",)
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
