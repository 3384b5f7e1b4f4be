"""Powers, roots and logarithms, element by element; e and pi."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any

from graph.node import Attribute, Database, NodeAtLoad, node_type

from .like_inputs import real_like
from .numbers import settled

NUMERICS = ("numerics",)


def _real(db: Database, name: str, output: str, function: Callable[[Any], Any]) -> None:
    """Writes function(value), calculated in doubles, in the type of the output.

    A result that is not real (a root of a negative number) is NaN, a result that is too large is infinite.
    """
    import numpy as np

    from graph.values.coercion import dtype_of

    value = np.asarray(getattr(db.inputs, name), float)
    with np.errstate(all="ignore"):
        result = function(value)
        kind = settled(db, output)
        result = result if kind is None or not result.ndim else result.astype(dtype_of(kind.component))
    setattr(db.outputs, output, result if result.ndim else result.item())


@node_type(
    "omni.graph.nodes.Exponent",
    version=1,
    inputs={
        "base": Attribute(NUMERICS, "what is multiplied with itself"),
        "exponent": Attribute("int", "how often; the reciprocal where negative", default=2),
    },
    outputs={"result": Attribute(NUMERICS, "base to the power of the exponent; double where the base is whole")},
    resolve=real_like("base", "result"),
)
def exponent(db: Database) -> None:
    """Raise numbers to an integer power; matrices element by element."""
    power = float(db.inputs.exponent)
    _real(db, "base", "result", lambda value: value**power)


@node_type(
    "omni.graph.nodes.NthRoot",
    version=1,
    inputs={
        "nthRoot": Attribute("int", "which root: 2 is the square root, 3 the cube root", default=2),
        "value": Attribute(NUMERICS, "what the root is taken of"),
    },
    outputs={"result": Attribute(NUMERICS, "the root; double where the value is whole")},
    resolve=real_like("value", "result"),
)
def nth_root(db: Database) -> None:
    """Take a root: an even root of a negative number is NaN, an odd one negative, the 0th infinite."""
    import numpy as np

    which = db.inputs.nthRoot

    def root(value: Any) -> Any:
        if which == 0:
            return np.full_like(value, math.inf)
        if which % 2 == 0:
            return value ** (1 / which)
        return np.sign(value) * (np.cbrt(np.abs(value)) if which == 3 else np.abs(value) ** (1 / which))

    _real(db, "value", "result", root)


def _check_base(node: NodeAtLoad) -> Iterator[tuple[str, str]]:
    """A written base to which there is no logarithm."""
    base = node.db.inputs.base
    if "base" in node.given and (not base > 0 or base == 1):
        yield "base", f"{base:g} is not the base of a logarithm; it must be above 0 and not 1"


@node_type(
    "omni.graph.nodes.Logarithm",
    version=1,
    check=_check_base,
    inputs={
        "base": Attribute("double", "what is raised to the logarithm: above 0, but not 1", default=10.0),
        "value": Attribute(NUMERICS, "numbers above 0"),
    },
    outputs={"result": Attribute(NUMERICS, "the logarithm; double where the value is whole")},
    resolve=real_like("value", "result"),
)
def logarithm(db: Database) -> None:
    """Give the logarithm of a value to a base; a value that is not above 0 fails."""
    import numpy as np

    base, value = db.inputs.base, np.asarray(db.inputs.value)
    if not base > 0 or base == 1:
        db.fail(f"input base is {base}; it must be above 0 and not 1")
    if not (value > 0).all():
        db.fail("input value holds a number that is not above 0; it has no logarithm")
    function = {2.0: np.log2, 10.0: np.log10}.get(base, lambda one: np.log(one) / math.log(base))
    _real(db, "value", "result", function)


@node_type(
    "omni.graph.nodes.ConstantE",
    version=1,
    inputs={"exponent": Attribute("double", "the power that e is raised to", default=1.0)},
    outputs={"value": Attribute("double", "e to that power")},
)
def constant_e(db: Database) -> None:
    """Give e (2.718...) or a power of it; a power too large for a double is infinite."""
    try:
        db.outputs.value = math.exp(db.inputs.exponent)
    except OverflowError:
        db.outputs.value = math.inf


@node_type(
    "omni.graph.nodes.ConstantPi",
    version=1,
    inputs={"factor": Attribute("double", "how many times pi", default=1.0)},
    outputs={"value": Attribute("double", "factor x pi")},
)
def constant_pi(db: Database) -> None:
    """Give pi (3.141...) or a multiple of it."""
    db.outputs.value = db.inputs.factor * math.pi
