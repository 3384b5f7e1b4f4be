"""Comparison of numbers, texts, tuples and arrays."""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from graph.node import Attribute, Database, node_type

from .logic import BOOLS, VALUES, is_array_input, plain, stretch
from .numbers import input_type
from .promotion import comparison_type

if TYPE_CHECKING:
    from graph.node.declaration import Compute

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
