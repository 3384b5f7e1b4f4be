"""Comparison of numbers, texts, tuples and arrays; boolean logic and selection."""

from __future__ import annotations

import operator
from collections.abc import Callable, Sequence
from functools import reduce
from operator import and_, or_, xor
from typing import TYPE_CHECKING, Any

from graph.node import Attribute, Database, node_type

from .numbers import check_lengths, input_type
from .promotion import comparison_type, condition_type, selected_type

if TYPE_CHECKING:
    from graph.node.declaration import Compute, Specialize

VALUES = ("bool", "bool[]", "numerics", "path", "string", "token", "token[]")
BOOLS = ("bool", "bool[]")


def plain(value: Any) -> Any:
    """The value with lists instead of arrays: Python compares lists in order, as the original compares tuples."""
    return value.tolist() if hasattr(value, "tolist") else value


def is_array_input(db: Database, name: str) -> bool:
    """Whether the resolved type of an input is an array."""
    return str(db.input_type(name)).endswith("[]")


def stretch(db: Database, operands: Sequence[tuple[Any, bool]]) -> list[list[Any]]:
    """Operands (value, whether it is an array) as lists of one length; single values repeat.

    Fails the node if two arrays differ in length.
    """
    arrays = [value for value, is_array in operands if is_array]
    check_lengths(db, arrays)
    length = len(arrays[0])
    return [list(value) if is_array else [value] * length for value, is_array in operands]


def _combined(
    name: str, version: int, operation: Callable[[Any, Any], Any], opposite: bool, doc: str, result: str
) -> None:
    """Declares the node type `name`: `operation` over all operands, row by row if one is an array.

    opposite: whether the result is negated. result: the description of the output. Version 2 takes further operands.
    """

    def compute(db: Database) -> None:
        names = ["a", "b", *db.dynamic_input_names()]
        operands = [(plain(getattr(db.inputs, name)), is_array_input(db, name)) for name in names]
        if any(is_array for _, is_array in operands):
            rows = zip(*stretch(db, operands), strict=True)
            db.outputs.result = [bool(reduce(operation, row)) is not opposite for row in rows]
        else:
            db.outputs.result = bool(reduce(operation, (value for value, _ in operands))) is not opposite

    compute.__doc__ = doc
    node_type(
        f"omni.graph.nodes.{name}",
        version=version,
        inputs={"a": Attribute(BOOLS, "first operand"), "b": Attribute(BOOLS, "second operand")},
        outputs={"result": Attribute(BOOLS, result)},
        dynamic_inputs={"{operand}": Attribute(BOOLS, "one more operand")} if version > 1 else {},
        resolve=condition_type("result"),
        specialize=_two_bools(operation, opposite=opposite),
    )(compute)


def _two_bools(operation: Callable[[Any, Any], Any], *, opposite: bool) -> Specialize:
    """The compute function of a node with exactly two single operands."""

    def specialize(db: Database) -> Compute | None:
        if db.dynamic_input_names() or not db.input_type("a") == db.input_type("b") == "bool":
            return None
        inputs, outputs = db.inputs, db.outputs

        def compute(db: Database) -> None:
            outputs.result = operation(inputs.a, inputs.b)

        def compute_opposite(db: Database) -> None:
            outputs.result = not operation(inputs.a, inputs.b)

        return compute_opposite if opposite else compute

    return specialize


for _row in (
    ("BooleanAnd", 2, and_, False, "Give whether all operands are true.", "whether all operands are true"),
    (
        "BooleanNand",
        2,
        and_,
        True,
        "Give whether at least one operand is false.",
        "whether an operand is false",
    ),
    ("BooleanOr", 2, or_, False, "Give whether any operand is true.", "whether an operand is true"),
    ("BooleanNor", 2, or_, True, "Give whether no operand is true.", "whether all operands are false"),
    ("BooleanXor", 1, xor, False, "Give whether the operands differ.", "whether just one operand is true"),
):
    _combined(*_row)


_EXPRESSIONS: dict[str, Callable[[bool, bool], bool]] = {
    "AND": lambda a, b: a and b,
    "OR": lambda a, b: a or b,
    "NAND": lambda a, b: not (a and b),
    "NOR": lambda a, b: not (a or b),
    "XOR": lambda a, b: a is not b,
    "XNOR": lambda a, b: a is b,
}


@node_type(
    "omni.graph.nodes.BooleanExpr",
    version=1,
    inputs={
        "a": Attribute("bool", "first operand", default=False),
        "b": Attribute("bool", "second operand", default=False),
        "operator": Attribute("token", "how to put them together", default="AND", allowed_tokens=tuple(_EXPRESSIONS)),
    },
    outputs={"result": Attribute("bool", "what comes out")},
)
def boolean_expr(db: Database) -> None:
    """Combine two bools by an operator."""
    inputs = db.inputs
    if inputs.operator not in _EXPRESSIONS:
        db.fail(f"input operator is {inputs.operator!r}; it must be one of {' '.join(_EXPRESSIONS)}")
    db.outputs.result = _EXPRESSIONS[inputs.operator](inputs.a, inputs.b)


@node_type(
    "omni.graph.nodes.BooleanNot",
    version=1,
    inputs={"valueIn": Attribute(BOOLS, "the operand")},
    outputs={"valueOut": Attribute(BOOLS, "the opposite")},
    resolve=condition_type("valueOut", "valueIn"),
)
def boolean_not(db: Database) -> None:
    """Negate a bool."""
    value = plain(db.inputs.valueIn)
    db.outputs.valueOut = [not one for one in value] if is_array_input(db, "valueIn") else not value


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
def select_if(db: Database) -> None:
    """Select one of two values."""
    inputs = db.inputs
    if not is_array_input(db, "condition"):
        db.outputs.result = inputs.ifTrue if inputs.condition else inputs.ifFalse
        return
    sides = [(plain(getattr(inputs, name)), is_array_input(db, name)) for name in ("ifTrue", "ifFalse")]
    rows = zip(*stretch(db, [(plain(inputs.condition), True), *sides]), strict=True)
    db.outputs.result = [if_true if condition else if_false for condition, if_true, if_false in rows]


_OPERATIONS: dict[str, Callable[[Any, Any], bool]] = {
    ">": operator.gt,
    "<": operator.lt,
    ">=": operator.ge,
    "<=": operator.le,
    "==": operator.eq,
    "!=": operator.ne,
}


def _single_values(db: Database) -> Compute | None:
    """The compute for two numbers, texts or bools, not tuples or arrays."""
    if not all((one := input_type(db, name)) is not None and one.scalar for name in "ab"):
        return None
    inputs, outputs, operations = db.inputs, db.outputs, _OPERATIONS

    def compute(db: Database) -> None:
        try:
            holds = operations[inputs.operation]
        except KeyError:
            _refuse(db)
        else:
            outputs.result = holds(inputs.a, inputs.b)

    return compute


def _refuse(db: Database) -> None:
    db.fail(f"input operation is {db.inputs.operation!r}; it must be one of {' '.join(_OPERATIONS)}")


@node_type(
    "omni.graph.nodes.Compare",
    version=1,
    inputs={
        "a": Attribute(VALUES, "left side"),
        "b": Attribute(VALUES, "right side"),
        "operation": Attribute("token", "how to compare", default=">", allowed_tokens=tuple(_OPERATIONS)),
    },
    outputs={"result": Attribute(BOOLS, "whether it holds; an array where a or b is one")},
    resolve=comparison_type,
    specialize=_single_values,
)
def compare(db: Database) -> None:
    """Compare numbers, texts and tuples (component by component; the first difference decides)."""
    inputs = db.inputs
    if inputs.operation not in _OPERATIONS:
        _refuse(db)
    holds = _OPERATIONS[inputs.operation]
    operands = [(plain(getattr(inputs, name)), is_array_input(db, name)) for name in ("a", "b")]
    if any(is_array for _, is_array in operands):
        db.outputs.result = [holds(a, b) for a, b in zip(*stretch(db, operands), strict=True)]
    else:
        db.outputs.result = holds(operands[0][0], operands[1][0])
