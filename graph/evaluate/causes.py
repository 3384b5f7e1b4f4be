"""The message of a failed compute."""

from __future__ import annotations

import math

from graph.base.errors import RunError, UserError
from graph.node.attribute_names import python_name
from graph.node.database import Database, NodeError
from graph.values.coercion import shown

# Errors that Python and NumPy raise for an infinite number or NaN.
_ARITHMETIC = (ArithmeticError, ValueError, TypeError)


def cause_of(db: Database, error: Exception) -> str:
    """The message of a compute's exception, on one line; names an input that is empty or not finite."""
    if isinstance(error, NodeError | RunError | UserError):
        return " ".join(str(error).split())
    text = " ".join(f"{type(error).__name__}: {error}".split())
    if isinstance(error, _ARITHMETIC):
        for name in db._node.names["inputs"]:
            value = getattr(db.inputs, python_name(name), None)
            full = f"inputs:{name}"
            if value is None and db._node.connected(full) and not db._node.attribute(full).is_execution:
                return f"input {name} has no value; see what feeds it ({text})"
            if not _finite(value):
                return f"input {name} is {shown(_plain(value))}; give it finite numbers ({text})"
    return text


def _plain(value: object) -> object:
    return value.tolist() if hasattr(value, "tolist") else value


def _finite(value: object) -> bool:
    """False for numbers, single or in an array, that are infinite or NaN; True for everything else."""
    value = _plain(value)
    if isinstance(value, list | tuple):
        return all(_finite(one) for one in value)
    return not isinstance(value, float) or math.isfinite(value)
