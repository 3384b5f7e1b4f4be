"""Comparisons, boolean logic and selection; arrays element by element."""

from __future__ import annotations

import operator
from collections.abc import Callable, Sequence
from functools import reduce
from typing import TYPE_CHECKING, Any

from graph.node import Attribute, Database, node_type

from .promotion import condition_type, selected_type

if TYPE_CHECKING:
    from graph.node.declaration import Compute, Specialize

VALUES = ("bool", "bool[]", "numerics", "path", "string", "token", "token[]")
BOOLS = ("bool", "bool[]")
FIRST, SECOND = Attribute(BOOLS, "first operand"), Attribute(BOOLS, "second operand")
EXTRA = Attribute(BOOLS, "one more operand")


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
    lengths = {len(value) for value, is_array in operands if is_array}
    if len(lengths) > 1:
        db.fail(f"the arrays have {' and '.join(map(str, sorted(lengths)))} elements; they need one length")
    [length] = lengths
    return [list(value) if is_array else [value] * length for value, is_array in operands]


def _combined(operation: Callable[[Any, Any], Any], *, opposite: bool = False) -> Callable[[Any], None]:
    """A compute function: `operation` over all operands, row by row if one is an array; `opposite`: negated."""

    def compute(db: Database) -> None:
        names = ["a", "b", *db.dynamic_input_names()]
        operands = [(plain(getattr(db.inputs, name)), is_array_input(db, name)) for name in names]
        if any(is_array for _, is_array in operands):
            rows = zip(*stretch(db, operands), strict=True)
            db.outputs.result = [bool(reduce(operation, row)) is not opposite for row in rows]
        else:
            db.outputs.result = bool(reduce(operation, (value for value, _ in operands))) is not opposite

    return compute


def _two_bools(operation: Callable[[Any, Any], Any], *, opposite: bool = False) -> Specialize:
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


_and, _or, _xor = _combined(operator.and_), _combined(operator.or_), _combined(operator.xor)
_nand, _nor = _combined(operator.and_, opposite=True), _combined(operator.or_, opposite=True)


@node_type(
    "omni.graph.nodes.BooleanAnd",
    version=2,
    inputs={"a": FIRST, "b": SECOND},
    outputs={"result": Attribute(BOOLS, "whether all operands are true")},
    dynamic_inputs={"{operand}": EXTRA},
    resolve=condition_type("result"),
    specialize=_two_bools(operator.and_),
)
def boolean_and(db: Database) -> None:
    """Give whether all operands are true."""
    _and(db)


@node_type(
    "omni.graph.nodes.BooleanNand",
    version=2,
    inputs={"a": FIRST, "b": SECOND},
    outputs={"result": Attribute(BOOLS, "whether an operand is false")},
    dynamic_inputs={"{operand}": EXTRA},
    resolve=condition_type("result"),
    specialize=_two_bools(operator.and_, opposite=True),
)
def boolean_nand(db: Database) -> None:
    """Give whether at least one operand is false."""
    _nand(db)


@node_type(
    "omni.graph.nodes.BooleanOr",
    version=2,
    inputs={"a": FIRST, "b": SECOND},
    outputs={"result": Attribute(BOOLS, "whether an operand is true")},
    dynamic_inputs={"{operand}": EXTRA},
    resolve=condition_type("result"),
    specialize=_two_bools(operator.or_),
)
def boolean_or(db: Database) -> None:
    """Give whether any operand is true."""
    _or(db)


@node_type(
    "omni.graph.nodes.BooleanNor",
    version=2,
    inputs={"a": FIRST, "b": SECOND},
    outputs={"result": Attribute(BOOLS, "whether all operands are false")},
    dynamic_inputs={"{operand}": EXTRA},
    resolve=condition_type("result"),
    specialize=_two_bools(operator.or_, opposite=True),
)
def boolean_nor(db: Database) -> None:
    """Give whether no operand is true."""
    _nor(db)


@node_type(
    "omni.graph.nodes.BooleanXor",
    version=1,
    inputs={"a": FIRST, "b": SECOND},
    outputs={"result": Attribute(BOOLS, "whether just one operand is true")},
    resolve=condition_type("result"),
    specialize=_two_bools(operator.xor),
)
def boolean_xor(db: Database) -> None:
    """Give whether the operands differ."""
    _xor(db)


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
