"""What the metadata of a stage say: units, up axis, time codes, rate of physics."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

from graph.base.errors import UserError

from .diagnostics import Warn, ignore_warning

NEW_STAGE_TIME_CODES = 60.0
"""timeCodesPerSecond of a stage without a file; also the timeline's default."""
NEW_STAGE_RANGE = (0.0, 100.0)
"""Start and end time code of a new stage."""


LARGEST_UNIT = 1e18
"""The largest unit [m], a hundred light-years; one divided by it is the smallest."""


def meters_per_unit(stage: Any) -> float:
    """Metres in one stage unit. Raises UserError unless positive and of a size that numbers of the scene can have."""
    from graph.sim.usd import UsdGeom

    value = float(UsdGeom.GetStageMetersPerUnit(stage))
    if not 0 < value < float("inf"):
        raise UserError(f"{scene_name(stage)}: metersPerUnit is {value:g}; it must be greater than 0")
    if not 1 / LARGEST_UNIT <= value <= LARGEST_UNIT:
        raise UserError(f"{scene_name(stage)}: metersPerUnit is {value:g}; give 1e-18 to 1e18")
    return value


def time_range(stage: Any, warn: Warn = ignore_warning) -> tuple[Fraction, Fraction] | None:
    """Start and end [s] of the stage's time codes; None if it authors none, or an empty range.

    The range that a new stage has counts as not authored: it plays on, as in Isaac Sim's applications.
    A range that ends before it starts, or is not finite, gives a warning (`time-range-ignored`).
    """
    if not stage.HasAuthoredMetadata("endTimeCode"):
        return None
    rate = Fraction(str(stage.GetTimeCodesPerSecond()))
    codes = float(stage.GetStartTimeCode()), float(stage.GetEndTimeCode())
    if not stage.GetRootLayer().subLayerPaths and stage.GetRootLayer().anonymous and codes == NEW_STAGE_RANGE:
        return None
    if not all(map(math.isfinite, codes)) or codes[1] < codes[0]:
        message = f"its time codes run from {codes[0]:g} to {codes[1]:g}; it plays as if it named none"
        warn("time-range-ignored", scene_name(stage), message)
        return None
    start, end = (Fraction(str(code)) / rate for code in codes)
    return (start, end) if start < end else None


def up_axis(stage: Any) -> str:
    """'Y' or 'Z': the stage's up axis. Raises UserError for another, which USD itself accepts silently."""
    from graph.sim.usd import UsdGeom

    axis = str(UsdGeom.GetStageUpAxis(stage))
    if axis not in ("Y", "Z"):
        raise UserError(f"{scene_name(stage)}: upAxis is {axis}; it must be Y or Z")
    return axis


def scene_name(stage: Any) -> str:
    """The scene file of a stage, for messages."""
    root = stage.GetRootLayer()
    return str(next(iter(root.subLayerPaths), root.GetDisplayName()) if root.anonymous else root.identifier)


def physics_scene_rate(stage: Any) -> Fraction | None:
    """Steps per second that the stage's first physics scene authors (see `scene_attributes`); None: nothing."""
    from .scene_attributes import authored_rate, scene_prims

    first = next(scene_prims(stage), None)
    return None if first is None else authored_rate(first)
