"""Faults of a scene that USD takes without a word, or fails over much later."""

from __future__ import annotations

import math
from typing import Any

from graph.errors import Problem, UserError
from graph.sim.usd import Tf, UsdGeom

from .stage import Warn, meters_per_unit, scene_name, up_axis


def check_metadata(stage: Any) -> None:
    """Raises UserError with every one of units, up axis and time codes that makes no sense."""
    problems: list[Problem] = []
    for check in (meters_per_unit, up_axis):
        try:
            check(stage)
        except UserError as error:
            problems.extend(error.problems)
    rate = float(stage.GetTimeCodesPerSecond())
    if not 0 < rate < math.inf:
        text = f"{scene_name(stage)}: timeCodesPerSecond is {rate:g}; it must be greater than 0."
        problems.append(Problem(text))
    if problems:
        raise UserError(problems)


def repair_transforms(stage: Any, warn: Warn) -> None:
    """Overrule, in the root layer, every `xformOpOrder` that USD cannot work with: the ops it does not know are left
    out, with a warning `bad-transform-op`.
    """
    for prim in stage.TraverseAll():
        if not prim.HasAttribute("xformOpOrder"):
            continue
        order = prim.GetAttribute("xformOpOrder").Get() or ()
        bad = [op for op in order if not _known(prim, op)]
        if bad:
            prim.GetAttribute("xformOpOrder").Set([op for op in order if op not in bad])
            left_out = ", ".join(dict.fromkeys(map(str, bad)))
            warn("bad-transform-op", str(prim.GetPath()), f"its transform names {left_out}; that is left out.")


_ANGLES = ("X", "Y", "Z", "XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX")
OPS = frozenset(("translate", "scale", "orient", "transform", *(f"rotate{angles}" for angles in _ANGLES)))
"""Ops that need no closer look."""


def _known(prim: Any, op: str) -> bool:
    """Whether an entry of an `xformOpOrder` is an op that USD can evaluate on this prim."""
    name = op.removeprefix("!invert!")
    if name == "!resetXformStack!":
        return True
    if not prim.HasAttribute(name):
        return False
    if name.split(":")[1:2] and name.split(":")[1] in OPS:
        return True
    try:
        return bool(UsdGeom.XformOp(prim.GetAttribute(name), op != name))
    except Tf.ErrorException:
        return False
