"""Values between two others: at constant speed, eased, step by step, and along given samples."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

from graph.node import Attribute, Database, KnownTypes, node_type
from graph.values.coercion import dtype_of
from graph.values.types import Type
from nodes.bounds import at_least

from .numbers import aligned, input_type, settled
from .promotion import common_type, input_types, promoted, tuples_of_one_size

DECIMALS = ("decimals",)


@node_type(
    "omni.graph.nodes.InterpolateTo",
    version=2,
    check=at_least(exponent=0),
    inputs={
        "current": Attribute(DECIMALS, "where it is"),
        "deltaSeconds": Attribute("double", "how long this step lasts", default=0.0, unit="s"),
        "exponent": Attribute("float", "how much the start is quickened: 1 is a constant share", default=2.0),
        "speed": Attribute("double", "share of the way that a second covers at the start", default=1.0, unit="1/s"),
        "target": Attribute(DECIMALS, "where it is to go"),
    },
    outputs={"result": Attribute(("numerics",), "where it is after the step")},
    resolve=promoted("result", "current", "target"),
)
def interpolate_to(db: Database) -> None:
    """Take a step towards a target: 1 - (1 - s)^exponent of the way, s = speed x deltaSeconds within 0 to 1.

    Quaternions turn along the shortest arc.
    """
    inputs = db.inputs
    _check_power(db, "exponent", inputs.exponent)
    share = 1 - (1 - min(max(inputs.speed * inputs.deltaSeconds, 0.0), 1.0)) ** inputs.exponent
    result = settled(db, "result")
    current, target = aligned(db, ("current", "target"), result)
    if result is not None and "quat" in {kind.role for kind in (input_type(db, "current"), result) if kind is not None}:
        from graph.sim.transforms import slerp

        db.outputs.result = slerp(current, target, share).astype(dtype_of(result))
        return
    value = current + (target - current) * share
    db.outputs.result = value.astype(dtype_of(result)) if hasattr(value, "astype") and result is not None else value


_EASES: dict[str, Callable[[Any, int, Any], Any]] = {
    "EaseIn": lambda alpha, power, np: alpha**power,
    "EaseOut": lambda alpha, power, np: 1 - (1 - alpha) ** power,
    "EaseInOut": lambda alpha, power, np: np.where(
        alpha < 0.5, (2 * alpha) ** power / 2, 1 - (2 * (1 - alpha)) ** power / 2
    ),
    "Linear": lambda alpha, power, np: alpha,
    "SinIn": lambda alpha, power, np: 1 - np.cos(alpha * math.pi / 2),
    "SinOut": lambda alpha, power, np: np.sin(alpha * math.pi / 2),
    "SinInOut": lambda alpha, power, np: (1 - np.cos(alpha * math.pi)) / 2,
}


def _eased_type(known: KnownTypes) -> Mapping[str, Type]:
    """The common type of start and end, an array if alpha is one."""
    alpha = known["inputs:alpha"]
    if alpha is None or not input_types(known, "start", "end"):
        return {}
    chosen = common_type(tuples_of_one_size(known, "start", "end"))
    return {"outputs:result": chosen.array_of() if alpha.array and not chosen.array else chosen}


@node_type(
    "omni.graph.nodes.Ease",
    version=2,
    check=at_least(blendExponent=0),
    inputs={
        "alpha": Attribute(("float", "float[]"), "how much of the time has passed, 0 to 1; beyond that the ends count"),
        "blendExponent": Attribute("int", "power of the Ease functions: 1 is linear, 2 quadratic", default=2),
        "easeFunc": Attribute("token", "how it goes", default="EaseInOut", allowed_tokens=tuple(_EASES)),
        "end": Attribute(DECIMALS, "the value at 1"),
        "start": Attribute(DECIMALS, "the value at 0"),
    },
    outputs={"result": Attribute(DECIMALS, "the value at alpha")},
    resolve=_eased_type,
)
def ease(db: Database) -> None:
    """Ease from one value to another: slowly at the start (In), the end (Out), both, or at constant speed (Linear)."""
    import numpy as np

    inputs = db.inputs
    if inputs.easeFunc not in _EASES:
        db.fail(f"input easeFunc is {inputs.easeFunc!r}; it must be one of {' '.join(_EASES)}")
    _check_power(db, "blendExponent", inputs.blendExponent)
    result = settled(db, "result")
    start, end = aligned(db, ("start", "end"), result)
    alpha = np.clip(np.asarray(inputs.alpha, float), 0, 1)
    share = _EASES[inputs.easeFunc](alpha, inputs.blendExponent, np)
    shape = result.shape if result is not None else ()
    if alpha.ndim:
        arrays = [len(one) for one, name in ((start, "start"), (end, "end")) if str(db.input_type(name)).endswith("[]")]
        if any(length != len(alpha) for length in arrays):
            db.fail(f"input alpha has {len(alpha)} elements, start or end {arrays[0]}; they need one length")
        share = share.reshape(-1, *[1] * len(shape))
    value = np.asarray(start + (np.asarray(end) - start) * share)
    value = value if result is None else value.astype(dtype_of(result.component))
    db.outputs.result = value if value.ndim else value.item()


@node_type(
    "omni.graph.nodes.Interpolator",
    version=1,
    inputs={
        "knots": Attribute("float[]", "where the samples are, in rising order", default=[]),
        "param": Attribute("float", "where to look", default=0.0),
        "values": Attribute("float[]", "the samples, one for each knot", default=[]),
    },
    outputs={"value": Attribute("float", "the value there: on the line between two samples, at the ends the last one")},
)
def interpolator(db: Database) -> None:
    """Interpolate between samples."""
    import numpy as np

    knots, values = db.inputs.knots, db.inputs.values
    if len(knots) != len(values) or not len(knots):
        db.lack(f"there are {len(knots)} knots and {len(values)} values; give it as many of each, one at least")
    if (np.diff(knots) < 0).any():
        db.fail("input knots does not rise; sort knots and values by knots")
    db.outputs.value = float(np.interp(db.inputs.param, knots, values))


def _check_power(db: Database, name: str, power: float) -> None:
    """Fails the node if the fraction of the way would not be between 0 and 1."""
    if not power >= 0:
        db.fail(f"input {name} is {power}; give it 0 or more")
