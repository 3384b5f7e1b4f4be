"""Functions of numbers, element by element: angles in degrees and radians, rounding."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from graph.node import Attribute, Database, node_type

from .like_inputs import same_type, whole_of
from .numbers import aligned, settled
from .promotion import promoted

DECIMAL = ("decimal_scalers", "double[]", "float[]", "half[]")
DECIMALS = ("decimals",)
MOST_DECIMALS = 400
"""From here on rounding changes nothing, or leaves 0."""

WHOLE = ("int", "int[]", "int[2]", "int[3]", "int[4]", "int[2][]", "int[3][]", "int[4][]")


def _applied(name: str, function: Callable[[float], float], scale_in: float = 1.0, scale_out: float = 1.0) -> None:
    """Declares the node type `name`: scale_out times the function of (value x scale_in)."""
    inverse = name.startswith("A")
    given, found = ("a ratio", "its angle") if inverse else ("an angle", "the ratio")
    unit_in, unit_out = ("", "deg") if inverse else ("deg", "")

    def compute(db: Database) -> None:
        value = db.inputs.value
        try:
            if hasattr(value, "dtype"):
                import numpy as np

                mapped = [function(float(one) * scale_in) * scale_out for one in value.flat]
                db.outputs.value = np.array(mapped, value.dtype).reshape(value.shape)
            else:
                db.outputs.value = function(value * scale_in) * scale_out
        except ValueError:
            db.fail(f"input value is {value}; {name} is not defined there")

    compute.__doc__ = f"Give {found} of {given} by {name.lower()}; a value outside its domain fails."
    node_type(
        f"omni.graph.nodes.{name}",
        version=1,
        inputs={"value": Attribute(DECIMAL, f"{given}", unit=unit_in)},
        outputs={"value": Attribute(DECIMAL, f"{found}", unit=unit_out)},
        resolve=same_type("value", "value"),
    )(compute)


for _name, _function in (("Sin", math.sin), ("Cos", math.cos), ("Tan", math.tan)):
    _applied(_name, _function, scale_in=math.pi / 180)
for _name, _function in (("Asin", math.asin), ("Acos", math.acos), ("Atan", math.atan)):
    _applied(_name, _function, scale_out=180 / math.pi)


@node_type(
    "omni.graph.nodes.Ceil",
    version=1,
    inputs={"a": Attribute(DECIMALS, "a real number, tuple or array")},
    outputs={"result": Attribute(WHOLE, "the least whole numbers that are not below it")},
    resolve=whole_of("a", "result"),
)
def ceil(db: Database) -> None:
    """Round up to whole numbers."""
    _to_whole(db, math.ceil, "ceil")


@node_type(
    "omni.graph.nodes.Floor",
    version=1,
    inputs={"a": Attribute(DECIMALS, "a real number, tuple or array")},
    outputs={"result": Attribute(WHOLE, "the largest whole numbers that are not above it")},
    resolve=whole_of("a", "result"),
)
def floor(db: Database) -> None:
    """Round down to whole numbers."""
    _to_whole(db, math.floor, "floor")


def _to_whole(db: Database, one: Callable[[float], int], many: str) -> None:
    value = db.inputs.a
    try:
        if not hasattr(value, "dtype"):
            whole = one(value)
            fits = -(2**31) <= whole < 2**31
            result: Any = whole
        else:
            import numpy as np

            rounded = getattr(np, many)(value)
            fits = bool(((rounded >= -(2.0**31)) & (rounded < 2.0**31)).all())
            result = rounded.astype(np.int32) if fits else None
    except (ValueError, OverflowError):
        fits = False
    if not fits:
        db.fail(f"input a is {value}, which has no whole number that an int can hold")
    db.outputs.result = result


@node_type(
    "omni.graph.nodes.Round",
    version=1,
    inputs={
        "decimals": Attribute("int", "places behind the point to keep; before it where negative", default=0),
        "input": Attribute(DECIMALS, "a real number, tuple or array"),
    },
    outputs={"output": Attribute(DECIMALS, "the nearest numbers with so many places; a half goes to the even one")},
    resolve=same_type("input", "output"),
)
def round_off(db: Database) -> None:
    """Round to a number of decimal places."""
    value, decimals = db.inputs.input, db.inputs.decimals
    db.outputs.output = _rounded(value, decimals) if hasattr(value, "dtype") else round(value, decimals)


def _rounded(values: Any, decimals: int) -> Any:
    """NumPy's, also where its factor 10^decimals, or a product with it, is more than a float holds."""
    import numpy as np

    with np.errstate(all="ignore"):
        rounded = values.round(max(-MOST_DECIMALS, min(decimals, MOST_DECIMALS)))
    beyond = values if decimals > 0 else np.zeros_like(values)
    return np.where(np.isfinite(rounded) | ~np.isfinite(values), rounded, beyond)


def _scaled(value: Any, factor: float) -> Any:
    """The value times a factor, in the value's own precision."""
    return (value * factor).astype(value.dtype) if hasattr(value, "dtype") else value * factor


@node_type(
    "omni.graph.nodes.ToDeg",
    version=1,
    inputs={"radians": Attribute(DECIMALS, "angles in radians", unit="rad")},
    outputs={"degrees": Attribute(DECIMALS, "the same angles in degrees", unit="deg")},
    resolve=same_type("radians", "degrees"),
)
def to_degrees(db: Database) -> None:
    """Turn radians into degrees."""
    db.outputs.degrees = _scaled(db.inputs.radians, 180 / math.pi)


@node_type(
    "omni.graph.nodes.ToRad",
    version=1,
    inputs={"degrees": Attribute(DECIMALS, "angles in degrees", unit="deg")},
    outputs={"radians": Attribute(DECIMALS, "the same angles in radians", unit="rad")},
    resolve=same_type("degrees", "radians"),
)
def to_radians(db: Database) -> None:
    """Turn degrees into radians."""
    db.outputs.radians = _scaled(db.inputs.degrees, math.pi / 180)


@node_type(
    "omni.graph.nodes.ATan2",
    version=1,
    inputs={"a": Attribute(DECIMALS, "the part along y"), "b": Attribute(DECIMALS, "the part along x")},
    outputs={"result": Attribute(DECIMALS, "the angle from the x axis, -180 to 180", unit="deg")},
    resolve=promoted("result"),
)
def arc_tangent_2(db: Database) -> None:
    """Give the angle of the direction (b, a): the arc tangent of a / b in the right quadrant."""
    a, b = aligned(db, "ab", settled(db, "result"))
    if not hasattr(a, "dtype") and not hasattr(b, "dtype"):
        db.outputs.result = math.degrees(math.atan2(a, b))
        return
    import numpy as np

    angles = np.degrees(np.arctan2(a, b))
    db.outputs.result = angles.astype(np.result_type(*(one for one in (a, b) if hasattr(one, "dtype"))))
