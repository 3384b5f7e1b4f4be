"""The four cameras of Kit's viewport, in the session layer of a stage."""

from __future__ import annotations

from typing import Any

from nodes.isaac.viewports import PERSPECTIVE

FOCAL_LENGTH = 18.147562
"""Of the perspective camera [tenths of a stage unit]: 60 degrees across its aperture."""
CAMERAS = {
    PERSPECTIVE: ((5.0, 5.0, 5.0), (54.735610317245, 0.0, 135.0)),
    "/OmniverseKit_Front": ((500.0, 0.0, 0.0), (90.0, 0.0, 90.0)),
    "/OmniverseKit_Top": ((0.0, 0.0, 500.0), (0.0, 0.0, -90.0)),
    "/OmniverseKit_Right": ((0.0, -500.0, 0.0), (90.0, 0.0, 0.0)),
}
"""Path to translation [stage units] and rotation about X, Y, Z [degrees]."""


def author_cameras(stage: Any) -> None:
    """Defines the cameras that are missing."""
    from graph.sim.usd import Gf, Usd, UsdGeom

    with Usd.EditContext(stage, stage.GetSessionLayer()):
        for path, (place, turn) in CAMERAS.items():
            if stage.GetPrimAtPath(path):
                continue
            camera = UsdGeom.Camera.Define(stage, path)
            if path == PERSPECTIVE:
                camera.CreateFocalLengthAttr(FOCAL_LENGTH)
            camera.AddTranslateOp().Set(Gf.Vec3d(*place))
            camera.AddRotateXYZOp(UsdGeom.XformOp.PrecisionDouble).Set(Gf.Vec3d(*turn))
