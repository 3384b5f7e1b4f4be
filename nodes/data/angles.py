"""Angles in degrees and radians, and the angle of a direction."""

from __future__ import annotations

import math
from typing import Any

from graph.node import Attribute, Database, node_type

from .like_inputs import same_type
from .numbers import aligned, settled
from .promotion import promoted

DECIMALS = ("decimals",)


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
