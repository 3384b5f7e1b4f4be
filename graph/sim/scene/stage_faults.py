"""Faults of a scene that USD takes without a word, or fails over much later."""

from __future__ import annotations

import math
from typing import Any

from graph.base.errors import Problem, UserError
from graph.sim.usd import Tf, Usd, UsdGeom

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
        text = f"{scene_name(stage)}: timeCodesPerSecond is {rate:g}; it must be greater than 0"
        problems.append(Problem(text))
    if problems:
        raise UserError(problems)


def tell_assumed_units(stage: Any, warn: Warn) -> None:
    """Warn (`units-assumed`) where the scene's root layer leaves units or up axis to USD's own, which are few robots'.

    A layer without anything that has a place (graphs only, say) needs none.
    """
    assumed = {}
    if not UsdGeom.StageHasAuthoredMetersPerUnit(stage):
        assumed["metersPerUnit = 1"] = f"{UsdGeom.GetStageMetersPerUnit(stage):g} m a unit"
    if not stage.HasAuthoredMetadata("upAxis"):
        assumed['upAxis = "Z"'] = f"{UsdGeom.GetStageUpAxis(stage)} up"
    if assumed and _has_place(stage):
        names = " and ".join(name.partition(" ")[0] for name in assumed)
        warn(
            "units-assumed",
            scene_name(stage),
            f"its root layer authors no {names}, so USD takes {' and '.join(assumed.values())}; author what is meant "
            f"in its metadata, such as {', '.join(assumed)}",
        )


def _has_place(stage: Any) -> bool:
    """Whether any prim of the stage has a place; the nodes of graphs, of which there may be many, have none."""
    prims = iter(Usd.PrimRange(stage.GetPseudoRoot(), Usd.PrimAllPrimsPredicate))
    for prim in prims:
        if prim.IsA(UsdGeom.Imageable):
            return True
        if prim.GetTypeName() == "OmniGraph":
            prims.PruneChildren()
    return False


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
            warn("bad-transform-op", str(prim.GetPath()), f"its transform names {left_out}; that is left out")


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
