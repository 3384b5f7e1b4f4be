"""Faults of a scene that USD accepts silently, or fails over much later."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from graph.base.errors import Problem, UserError
from graph.sim.usd import Gf, Pcp, Tf, Usd, UsdGeom, Vt

from .diagnostics import Warn
from .stage_metadata import meters_per_unit, scene_name, up_axis


def check_metadata(stage: Any) -> None:
    """Raises UserError with every invalid value of units, up axis and time codes."""
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
    """Warns (`units-assumed`) if the scene's root layer does not author units or up axis:

    USD's defaults fit few robots.

    A layer without prims that have a transform (only graphs, for example) does not need them.
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


def tell_other_units(stage: Any, warn: Warn) -> None:
    """Warn (`units-mismatch`) of references to files in other units, or with another up axis:

    USD converts neither. One warning for each file. A prim that compensates for it, by an op `unitsResolve` or a scale
    of exactly that ratio, gives no warning.
    """
    units = {layer: _units(layer) for layer in stage.GetUsedLayers()}
    if len({unit for unit in units.values() if unit is not None}) < 2:
        return
    found: dict[str, list[tuple[str, str]]] = {}
    for prim in stage.TraverseAll():
        if prim.HasAuthoredReferences() or prim.HasAuthoredPayloads():
            for parent, child in _arcs(prim.GetPrimIndex().rootNode):
                asset = child.layerStack.identifier.rootLayer
                if lack := _conversion(prim, units.get(parent.layerStack.identifier.rootLayer), units.get(asset)):
                    found.setdefault(asset.GetDisplayName(), []).append((str(prim.GetPath()), lack))
    for asset, places in found.items():
        path, lack = places[0]
        more = f"; the same holds for {', '.join(other for other, _ in places[1:4])}" if len(places) > 1 else ""
        more += f" and {len(places) - 4:,} more" if len(places) > 4 else ""
        warn("units-mismatch", path, f"it refers to {asset}, which USD does not convert: {lack}{more}")


def _units(layer: Any) -> tuple[float, str] | None:
    """Metres in a unit, and the up axis, that a layer authors; None where it authors no unit."""
    info = layer.pseudoRoot
    if not info.HasInfo("metersPerUnit"):
        return None
    return float(info.GetInfo("metersPerUnit")), str(info.GetInfo("upAxis") if info.HasInfo("upAxis") else "")


def _arcs(node: Any) -> Iterator[tuple[Any, Any]]:
    """(parent, child) of each reference and payload of a prim index that the prim itself has."""
    for child in node.children:
        if child.arcType in (Pcp.ArcTypeReference, Pcp.ArcTypePayload) and not child.IsDueToAncestor():
            yield node, child
        yield from _arcs(child)


def _conversion(prim: Any, ours: tuple[float, str] | None, theirs: tuple[float, str] | None) -> str:
    """What is missing on a prim that refers to a file in other units; "" if nothing."""
    if ours is None or theirs is None or any("unitsResolve" in str(name) for name in prim.GetPropertyNames()):
        return ""
    lacks, ratio = [], theirs[0] / ours[0]
    local = UsdGeom.Xformable(prim).GetLocalTransformation() if prim.IsA(UsdGeom.Xformable) else Gf.Matrix4d(1)
    if not any(math.isclose(each, ratio, rel_tol=1e-3) for each in (1.0, local.GetRow3(0).GetLength())):
        lacks.append(f"its unit is {theirs[0]:g} m, that of the stage {ours[0]:g} m, so scale the prim by {ratio:g}")
    if {theirs[1], ours[1]} == {"Y", "Z"}:
        up = local.TransformDir(Gf.Vec3d.YAxis() if theirs[1] == "Y" else Gf.Vec3d.ZAxis()).GetNormalized()
        if up["XYZ".index(ours[1])] < 0.999:
            degrees = 90 if theirs[1] == "Y" else -90
            lacks.append(
                f"its up axis is {theirs[1]}, that of the stage {ours[1]}, so turn the prim by {degrees} deg about X"
            )
    return "; ".join(lacks)


def _has_place(stage: Any) -> bool:
    """Whether any prim of the stage has a transform; nodes of graphs, of which there may be many, do not."""
    prims = iter(Usd.PrimRange(stage.GetPseudoRoot(), Usd.PrimAllPrimsPredicate))
    for prim in prims:
        if prim.IsA(UsdGeom.Imageable):
            return True
        if prim.GetTypeName() == "OmniGraph":
            prims.PruneChildren()
    return False


def repair_transforms(stage: Any, warn: Warn) -> None:
    """Overrides, in the root layer, what USD cannot evaluate or reads as something else, each with a warning.

    Unknown ops of an `xformOpOrder` are left out (`bad-transform-op`); quaternions that are not of length 1, which USD
    takes for another rotation, are normalised (`orient-not-unit`).
    """
    for prim in stage.TraverseAll():
        if not prim.HasAttribute("xformOpOrder"):
            continue
        order = prim.GetAttribute("xformOpOrder").Get()
        if not isinstance(order, Vt.TokenArray):  # of a prim without a place, or nothing
            continue
        bad = [op for op in order if not _known(prim, op)]
        if bad:
            prim.GetAttribute("xformOpOrder").Set([op for op in order if op not in bad])
            left_out = ", ".join(dict.fromkeys(_described(prim, op) for op in bad))
            warn("bad-transform-op", str(prim.GetPath()), f"its transform names {left_out}; that is left out")
        for op in dict.fromkeys(order):
            if op.startswith(ORIENT) and op not in bad:
                make_unit(prim.GetAttribute(op), warn)


ORIENT = "xformOp:orient"
UNIT = 1e-3
"""How far the length of a quaternion may be from 1: half precision rounds it by up to 1e-3."""


def repair_turns(stage: Any, warn: Warn) -> None:
    """Normalises the quaternions `xformOp:orient` of a stage that may have changed since it was opened."""
    for prim in stage.TraverseAll():
        if attribute := prim.GetAttribute(ORIENT):
            make_unit(attribute, warn)


def make_unit(attribute: Any, warn: Warn) -> None:
    """Normalises the value of an orient op; one without direction becomes no turn. Time samples stay as they are."""
    value = attribute.Get()
    if not isinstance(value, (Gf.Quatd, Gf.Quatf, Gf.Quath)):
        return
    if abs(value.GetLength() - 1) <= UNIT or attribute.GetNumTimeSamples():
        return
    op = attribute.GetName()
    parts = np.array([value.GetReal(), *value.GetImaginary()], np.float64)
    length = float(np.linalg.norm(parts))
    if abs(length - 1) <= UNIT:
        return
    if not 0 < length < math.inf:
        parts, length = np.array([1.0, 0, 0, 0]), 1.0
        text = f"{op} is {value}, which is no rotation; it counts as no turn"
    else:
        text = f"{op} has the length {length:.6g}, which USD takes for another rotation; it is normalised"
    real, *imaginary = (parts / length).tolist()
    attribute.Set(type(value)(real, *imaginary))
    warn("orient-not-unit", str(attribute.GetPrimPath()), text)


_ONE, _THREE = ("GfHalf", "float", "double"), ("GfVec3h", "GfVec3f", "GfVec3d")
OPS: dict[str, tuple[str, ...]] = {
    **dict.fromkeys(("translate", "scale"), _THREE),
    **{"orient": ("GfQuath", "GfQuatf", "GfQuatd"), "transform": ("GfMatrix4d",)},
    **{f"rotate{axis}": _ONE for axis in "XYZ"},
    **{f"rotate{axes}": _THREE for axes in ("XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX")},
}
"""Kinds of ops, each with the types of C++ that USD takes for it; values of others make it raise."""


def _described(prim: Any, op: str) -> str:
    """An op that is left out, for messages; the type of one that is there says why."""
    name = op.removeprefix("!invert!")
    if not name or not prim.HasAttribute(name):
        return op or '""'
    kind = str(prim.GetAttribute(name).GetTypeName())
    return f"{op} ({f'a {kind}' if kind else 'of an unknown type'})"


def _known(prim: Any, op: str) -> bool:
    """Whether an entry of an `xformOpOrder` is an op that USD can evaluate on this prim."""
    name = op.removeprefix("!invert!")
    if name == "!resetXformStack!":
        return True
    if not name or not prim.HasAttribute(name):
        return False
    kind = name.partition(":")[2].partition(":")[0]
    if kind in OPS:
        return prim.GetAttribute(name).GetTypeName().cppTypeName in OPS[kind]
    try:
        return bool(UsdGeom.XformOp(prim.GetAttribute(name), op != name))
    except Tf.ErrorException:
        return False
