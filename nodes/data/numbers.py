"""How data nodes calculate: two plain numbers by the shortest way, everything else element by element.

Operands take the result's precision before they meet. Whole numbers that their type cannot hold fail the node where
they are plain numbers; in tuples and arrays they wrap round, as NumPy's do.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import reduce
from typing import TYPE_CHECKING, Any

from graph.types import INTEGER_RANGES, TYPES, Type
from graph.values import dtype_of

if TYPE_CHECKING:
    from graph.declaration import Compute, Specialize

Operation = Callable[[Any, Any], Any]


def folded(operation: Operation, output: str) -> Callable[[Any], None]:
    """A compute: `operation` over a, b and the operands that the file adds, from left to right."""

    def compute(db: Any) -> None:
        names = ["a", "b", *db.dynamic_input_names()]
        values = aligned(db, names, settled(db, output))
        db.claim(max(getattr(value, "nbytes", 0) for value in values))
        setattr(db.outputs, output, reduce(operation, values))

    return compute


def two_numbers(operation: Operation, output: str, *, nonzero: str = "") -> Specialize:
    """The compute of a node with two plain numbers a and b: no shapes to look up.

    A result that its type cannot hold fails the node; so does 0 in the input named `nonzero`.
    """

    def specialize(db: Any) -> Compute | None:
        result = settled(db, output)
        if result is None or not result.number or db.dynamic_input_names():
            return None
        if not all((one := input_type(db, name)) is not None and one.number for name in "ab"):
            return None
        inputs, outputs = db.inputs, db.outputs
        low, high = INTEGER_RANGES.get(result.storage, (None, None))

        def compute_real(db: Any) -> None:
            setattr(outputs, output, operation(inputs.a, inputs.b))

        def compute_checked(db: Any) -> None:
            if nonzero and not getattr(inputs, nonzero):
                db.fail(f"input {nonzero} holds a 0; it must not")
            value = operation(inputs.a, inputs.b)
            if low is not None and not low <= value <= high:
                db.fail(
                    f"the result {value} does not fit {result} ({low} to {high}); make an operand wider, or a double"
                )
            setattr(outputs, output, value)

        return compute_real if low is None and not nonzero else compute_checked

    return specialize


def input_type(db: Any, name: str) -> Type | None:
    """The settled type of an input; None while it is open."""
    type_name = db.input_type(name)
    return None if type_name is None else TYPES[type_name]


def settled(db: Any, output: str) -> Type | None:
    """The settled type of an output; None while it is open."""
    type_name = db.output_type(output)
    return None if type_name is None else TYPES[type_name]


def aligned(db: Any, names: Sequence[str], result: Type | None) -> list[Any]:
    """The values of inputs, ready to meet in NumPy: in the precision of `result`, elements of arrays facing tuples.

    Fails the node where two arrays differ in length (NumPy would stretch an array of length 1).
    """
    values = [getattr(db.inputs, name) for name in names]
    types = [input_type(db, name) for name in names]
    if result is None or None in types:
        _check_untyped(db, values)
        return values
    known = [one for one in types if one is not None]
    check_lengths(db, [value for value, one in zip(values, known, strict=True) if one.array])
    return [_aligned(value, one, result) for value, one in zip(values, known, strict=True)]


def _aligned(value: Any, given: Type, result: Type) -> Any:
    if not hasattr(value, "astype"):
        return value
    value = value.astype(dtype_of(result), copy=False) if result.numeric else value
    if given.array and given.count == 1 and result.count > 1:
        value = value.reshape(-1, *[1] * len(result.shape))
    return value


def _check_untyped(db: Any, values: Sequence[Any]) -> None:
    """Values whose types nobody knows: those with the most axes need one length."""
    depth = max((getattr(value, "ndim", 0) for value in values), default=0)
    check_lengths(db, [value for value in values if depth and getattr(value, "ndim", 0) == depth])


def check_lengths(db: Any, arrays: Sequence[Any]) -> None:
    """Fails the node where two of these arrays differ in length."""
    lengths = {len(one) for one in arrays}
    if len(lengths) > 1:
        db.fail(f"the arrays have {' and '.join(map(str, sorted(lengths)))} elements; they need one length")
