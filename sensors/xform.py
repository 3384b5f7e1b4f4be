"""Poses of a prim on the stage, in the form of Isaac Sim's Xform wrapper classes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from graph.sim.transforms import from_usd, inverse_rigid, pose_matrices, quaternion, rigid_part

from .errors import SensorValueError

if TYPE_CHECKING:
    from pxr import Usd

Vector = Sequence[float] | Sequence[Sequence[float]] | np.ndarray | None


def one_row(values: Vector, width: int, name: str) -> np.ndarray | None:
    """(width,) float64 of a shape (width,) or (1, width) argument; None stays None. Raises SensorValueError."""
    if values is None:
        return None
    try:
        array = np.asarray(values, np.float64)
    except (TypeError, ValueError):
        raise SensorValueError(f"{name}: not numbers; give {width} of them") from None
    if array.shape not in ((width,), (1, width)) or not np.all(np.isfinite(array)):
        raise SensorValueError(
            f"{name}: give {width} finite numbers, shape ({width},) or (1, {width}), not {array.shape}"
        )
    return array.reshape(width)


def place(
    prim: Usd.Prim,
    *,
    positions: Vector = None,
    translations: Vector = None,
    orientations: Vector = None,
    scales: Vector = None,
) -> None:
    """Writes translate, orient and scale ops; parts that are not given stay unchanged.

    translations are local, positions world (stage units), and exclude each other; orientations are w, x, y, z: local
    with translations or alone, world with positions. Raises SensorValueError.
    """
    if positions is not None and translations is not None:
        raise SensorValueError(f"{prim.GetPath()}: positions (world) and translations (local) exclude each other")
    translation = one_row(translations, 3, "translations")
    position = one_row(positions, 3, "positions")
    orientation = one_row(orientations, 4, "orientations")
    scale = one_row(scales, 3, "scales")
    if orientation is not None:
        length = float(np.linalg.norm(orientation))
        if length < 1e-9:
            raise SensorValueError("orientations: a quaternion w, x, y, z cannot be zero")
        orientation = orientation / length
    if position is not None:
        translation, orientation = _local(prim, position, orientation)
    if translation is not None or orientation is not None or scale is not None:
        _write(prim, translation, orientation, scale)


def local_pose(prim: Usd.Prim) -> tuple[np.ndarray, np.ndarray]:
    """Translation (3,) and orientation (4,) w, x, y, z below the parent, stage units."""
    return _parts(from_usd(_xformable(prim).GetLocalTransformation()))


def world_pose(prim: Usd.Prim) -> tuple[np.ndarray, np.ndarray]:
    """Position (3,) and orientation (4,) w, x, y, z in the world, stage units, as authored on the stage."""
    return _parts(_to_world(prim))


def _parts(matrix: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    rigid = rigid_part(matrix)
    return rigid[:3, 3].copy(), quaternion(rigid[:3, :3])


def _local(
    prim: Usd.Prim, position: np.ndarray, orientation: np.ndarray | None
) -> tuple[np.ndarray, np.ndarray | None]:
    parent = _to_world(prim.GetParent())
    translation = np.linalg.solve(parent[:3, :3], position - parent[:3, 3])
    if orientation is None:
        return translation, None
    world = pose_matrices(np.zeros(3), orientation)
    return translation, quaternion((inverse_rigid(rigid_part(parent)) @ world)[:3, :3])


def _write(
    prim: Usd.Prim, translation: np.ndarray | None, orientation: np.ndarray | None, scale: np.ndarray | None
) -> None:
    """Rewrites the ops as translate, orient, scale; each without a new value keeps its present one.

    An op that a referenced layer declares keeps its precision; all others are double.
    """
    from graph.sim.usd import Gf, UsdGeom

    xformable = _xformable(prim)
    old = from_usd(xformable.GetLocalTransformation())
    old_translation, old_orientation = _parts(old)
    lengths = np.sqrt((old[:3, :3] ** 2).sum(axis=0))
    xformable.ClearXformOpOrder()
    for name in prim.GetPropertyNames():
        if str(name).startswith("xformOp:"):
            prim.RemoveProperty(name)
    kinds = UsdGeom.XformOp
    vectors = {kinds.PrecisionDouble: Gf.Vec3d, kinds.PrecisionFloat: Gf.Vec3f, kinds.PrecisionHalf: Gf.Vec3h}
    turns = {kinds.PrecisionDouble: Gf.Quatd, kinds.PrecisionFloat: Gf.Quatf, kinds.PrecisionHalf: Gf.Quath}
    for name, add, types, value in (
        ("translate", xformable.AddTranslateOp, vectors, old_translation if translation is None else translation),
        ("orient", xformable.AddOrientOp, turns, old_orientation if orientation is None else orientation),
        ("scale", xformable.AddScaleOp, vectors, lengths if scale is None else scale),
    ):
        declared = prim.GetAttribute(f"xformOp:{name}")
        precision = kinds(declared).GetPrecision() if declared else kinds.PrecisionDouble
        add(precision=precision).Set(types[precision](*map(float, value)))


def _xformable(prim: Usd.Prim) -> Any:
    from graph.sim.usd import UsdGeom

    return UsdGeom.Xformable(prim)


def _to_world(prim: Usd.Prim) -> np.ndarray:
    from graph.sim.usd import Usd, UsdGeom

    return from_usd(UsdGeom.XformCache(Usd.TimeCode.Default()).GetLocalToWorldTransform(prim))
