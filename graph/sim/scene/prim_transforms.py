"""Sets translation, rotation and scale of a prim, and keeps the parts of its transform that are not given."""

from __future__ import annotations

from typing import Any

import numpy as np

from graph.sim import transforms
from graph.sim.usd import EARLIEST, Gf, UsdGeom


def set_transform(
    prim: Any,
    translate: list[float] | None = None,
    orient: list[float] | None = None,
    rotate: list[float] | None = None,
    scale: list[float] | None = None,
) -> None:
    """Writes the given parts as xformOps translate, orient (w, x, y, z) or rotateXYZ (degrees), and scale.

    A prim with other ops keeps the parts that are not given, rewritten as these ops. Raises ValueError if the prim has
    no transform, or if its old one has a shear, which these parts cannot express.
    """
    if not prim.IsA(UsdGeom.Xformable):
        raise ValueError(f"{prim.GetTypeName() or 'a prim without type'} has no transform")
    schema = UsdGeom.Xformable(prim)
    names = [op.GetOpName() for op in schema.GetOrderedXformOps()]
    old = transforms.from_usd(schema.GetLocalTransformation(EARLIEST)) if names else np.eye(4)
    rigid = transforms.rigid_part(old)
    rest = (transforms.inverse_rigid(rigid) @ old)[:3, :3]
    if np.abs(rest - np.diag(np.diag(rest))).max() > 1e-9 * np.abs(rest).max() and not scale:
        raise ValueError("its transform is sheared; put the new parts on a parent Xform")
    reset = schema.GetResetXformStack()
    for name in names:
        prim.RemoveProperty(name)
    schema.ClearXformOpOrder()
    double = UsdGeom.XformOp.PrecisionDouble
    schema.AddTranslateOp(double).Set(Gf.Vec3d(*(translate or rigid[:3, 3].tolist())))
    if rotate is not None:
        schema.AddRotateXYZOp(double).Set(Gf.Vec3d(*rotate))
    else:
        schema.AddOrientOp(double).Set(Gf.Quatd(*(orient or transforms.quaternion(rigid[:3, :3]).tolist())))
    schema.AddScaleOp(double).Set(Gf.Vec3d(*(scale or np.diag(rest).tolist())))
    if reset:
        schema.SetResetXformStack(True)
