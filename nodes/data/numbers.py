"""How data nodes calculate: two plain numbers directly, everything else element by element.

Operands are converted to the result's precision first. One rule holds for numbers, tuples and arrays: an integer result
that its type cannot hold fails the node, a real one beyond its type's largest number becomes infinite.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Mapping, Sequence
from functools import reduce
from typing import TYPE_CHECKING, Any

from graph.node import Database
from graph.node.attribute_names import python_name
from graph.values.coercion import LARGEST, dtype_of
from graph.values.types import INTEGER_RANGES, TYPES, Type

if TYPE_CHECKING:
    from graph.node.declaration import Compute, Specialize

Operation = Callable[[Any, Any], Any]


def folded(operation: Operation, output: str) -> Callable[[Any], None]:
    """A compute function: `operation` over a, b and the operands that the file adds, from left to right."""

    def compute(db: Database) -> None:
        values = aligned(db, ["a", "b", *db.dynamic_input_names()], settled(db, output))
        db.claim(max(getattr(value, "nbytes", 0) for value in values))
        setattr(db.outputs, output, quietly(lambda: reduce(operation, values)))

    return compute


def for_types(operation: Operation, output: str) -> Specialize:
    """The compute function of a node with operands as in `folded`, made when the types are resolved."""
    numbers = two_numbers(operation, output)

    def specialize(db: Database) -> Compute | None:
        names = ["a", "b", *db.dynamic_input_names()]
        result, kinds = settled(db, output), [input_type(db, name) for name in names]
        known = [kind for kind in kinds if kind is not None]
        if result is None or len(known) < len(kinds):
            return None
        return numbers(db) or _shaped(db, operation, output, dict(zip(names, known, strict=True)), result)

    return specialize


def _shaped(db: Database, operation: Operation, output: str, kinds: Mapping[str, Type], result: Type) -> Compute:
    """A compute function for operands of these types, by name, with an integer or a real result."""
    inputs, outputs = db.inputs, db.outputs
    operands = [(python_name(name), kind) for name, kind in kinds.items()]
    arrays = [place for place, kind in enumerate(kinds.values()) if kind.array]
    alike = all(kind.number or (kind.storage, kind.count) == (result.storage, result.count) for kind in kinds.values())
    whole = result.storage in INTEGER_RANGES
    reach = operator.mul if operation is operator.mul else operator.add
    most = reduce(reach, [max(map(abs, INTEGER_RANGES[kind.storage])) for kind in kinds.values()]) if whole else 0

    def compute(db: Database) -> None:
        values = [getattr(inputs, name) for name, _ in operands]
        if arrays:
            check_lengths(db, [values[place] for place in arrays])
            db.claim(max(values[place].nbytes for place in arrays))
        if whole:
            values = widened(values, most if most < 2**63 else reduce(reach, map(bound, values)))
        if not alike:
            values = [_facing(value, kind, result) for value, (_, kind) in zip(values, operands, strict=True)]
        setattr(outputs, output, fitting(db, quietly(lambda: reduce(operation, values)), result))

    return compute


def two_numbers(operation: Operation, output: str, *, nonzero: str = "") -> Specialize:
    """The compute function of a node with two plain numbers a and b, without any look-up of shapes.

    A result that its type cannot hold is handled as in `fitting`; 0 in the input named `nonzero` fails the node.
    """

    def specialize(db: Database) -> Compute | None:
        result = settled(db, output)
        if result is None or not result.number or db.dynamic_input_names():
            return None
        if not all((one := input_type(db, name)) is not None and one.number for name in "ab"):
            return None
        inputs, outputs = db.inputs, db.outputs
        largest = LARGEST.get(result.storage, math.inf)
        low, high = INTEGER_RANGES.get(result.storage, (-largest, largest))

        def compute_double(db: Database) -> None:
            setattr(outputs, output, operation(inputs.a, inputs.b))

        def compute_checked(db: Database) -> None:
            if nonzero and not getattr(inputs, nonzero):
                db.fail(f"input {nonzero} contains 0; division by zero")
            value = operation(inputs.a, inputs.b)
            setattr(outputs, output, value if low <= value <= high else fitting(db, value, result))

        return compute_double if high == math.inf and not nonzero else compute_checked

    return specialize


def quietly(calculate: Callable[[], Any]) -> Any:
    """The result of a calculation, without NumPy's warnings about infinity and NaN."""
    import numpy as np

    with np.errstate(all="ignore"):
        return calculate()


def fitting(db: Database, value: Any, kind: Type | None) -> Any:
    """A result in its type's storage: out of range, an integer fails the node, a real number becomes infinite.

    Integers must be exact, as operands of `widened` give them.
    """
    if kind is None or not kind.numeric:
        return value
    if kind.storage not in INTEGER_RANGES:
        if hasattr(value, "dtype") and value.dtype == dtype_of(kind):
            return value
        if not hasattr(value, "dtype"):
            beyond = abs(value) > LARGEST.get(kind.storage, math.inf)
            return math.copysign(math.inf, value) if beyond else value
        import numpy as np

        with np.errstate(over="ignore"):
            return value.astype(dtype_of(kind), copy=False)
    low, high = INTEGER_RANGES[kind.storage]
    array = hasattr(value, "dtype")
    for end in () if array and not value.size else (value.min(), value.max()) if array else (value,):
        whole = int(end) if end - end == 0 else None  # neither infinite nor NaN
        if whole is None or not low <= whole <= high:
            shown = end if whole is None else whole
            db.fail(f"the result {shown} does not fit {kind} ({low} to {high}); make an operand wider, or a double")
    return value.astype(dtype_of(kind), copy=False) if array else value


def widened(values: Sequence[Any], most: int) -> list[Any]:
    """Integer operands of a calculation whose result is at most `most` away from 0, such that the result is exact.

    Arrays become int64, or Python's own integers if that is too small.
    """
    wide: Any = "int64" if most < 2**63 and all(_in_int64(value) for value in values) else object
    return [value.astype(wide, copy=False) if hasattr(value, "dtype") else value for value in values]


def _in_int64(value: Any) -> bool:
    return bool(value.dtype != "uint64" or bound(value) < 2**63) if hasattr(value, "dtype") else abs(value) < 2**63


def changed(db: Database, change: Callable[[Any], Any], value: Any, kind: Type | None) -> Any:
    """`change`, such as abs, of every number.

    The smallest integer of a type has no positive counterpart there and fails.
    """
    if kind is None or kind.storage not in INTEGER_RANGES:
        return change(value)
    return fitting(db, change(widened([value], bound(value))[0]), kind)


def bound(value: Any) -> int:
    """The largest distance from 0 of the integers of a value."""
    if not hasattr(value, "dtype"):
        return abs(int(value))
    return max(abs(int(value.min())), abs(int(value.max()))) if value.size else 0


def input_type(db: Database, name: str) -> Type | None:
    """The resolved type of an input; None while it is open."""
    type_name = db.input_type(name)
    return None if type_name is None else TYPES[type_name]


def settled(db: Database, output: str) -> Type | None:
    """The resolved type of an output; None while it is open."""
    type_name = db.output_type(output)
    return None if type_name is None else TYPES[type_name]


def aligned(db: Database, names: Sequence[str], result: Type | None) -> list[Any]:
    """The values of inputs for NumPy: in the precision of `result`, arrays of numbers shaped to match tuples.

    Fails the node if two arrays differ in length (NumPy would repeat an array of length 1).
    """
    values = [getattr(db.inputs, name) for name in names]
    types = [input_type(db, name) for name in names]
    if result is None or None in types:
        _check_untyped(db, values)
        return values
    known = [one for one in types if one is not None]
    check_lengths(db, [value for value, one in zip(values, known, strict=True) if one.array])
    return [_aligned(db, value, one, result) for value, one in zip(values, known, strict=True)]


def _aligned(db: Database, value: Any, given: Type, result: Type) -> Any:
    if not hasattr(value, "astype"):
        return value
    other = result.numeric and value.dtype != dtype_of(result)
    return _facing(fitting(db, value, result) if other else value, given, result)


def _facing(value: Any, given: Type, result: Type) -> Any:
    """An array of numbers, shaped so that each number meets a whole tuple; other values unchanged.

    Real numbers have the precision of the result.
    """
    if not hasattr(value, "astype"):
        return value
    if given.array and given.count == 1 and result.count > 1:
        value = value.reshape(-1, *[1] * len(result.shape))
    return (
        value if result.storage in INTEGER_RANGES or not result.numeric else value.astype(dtype_of(result), copy=False)
    )


def _check_untyped(db: Database, values: Sequence[Any]) -> None:
    """Checks values of unknown types: those with the most axes must have one length."""
    depth = max((getattr(value, "ndim", 0) for value in values), default=0)
    check_lengths(db, [value for value in values if depth and getattr(value, "ndim", 0) == depth])


def check_lengths(db: Database, arrays: Sequence[Any]) -> None:
    """Fails the node if two of these arrays differ in length."""
    lengths = {len(one) for one in arrays}
    if len(lengths) > 1:
        db.fail(f"the arrays have {' and '.join(map(str, sorted(lengths)))} elements; they need one length")
