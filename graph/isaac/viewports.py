"""The four cameras of Kit's viewport, in the session layer of a stage."""

from __future__ import annotations

from typing import Any

CAMERAS = {
    "/OmniverseKit_Persp": ((5.0, 5.0, 5.0), (54.735610317245, 0.0, 135.0)),
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
            camera.AddTranslateOp().Set(Gf.Vec3d(*place))
            camera.AddRotateXYZOp(UsdGeom.XformOp.PrecisionDouble).Set(Gf.Vec3d(*turn))
