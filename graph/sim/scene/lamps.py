"""The lamp of default scenes."""

from __future__ import annotations

from typing import Any

LAMP_RADIUS, LAMP_HEIGHT = 0.5, 7.0


def sphere_light(stage: Any, path: str, height: float = LAMP_HEIGHT) -> None:
    """A lamp that gives the ground below it, at its centre, about as much light as a dome of intensity 500 does."""
    from graph.sim.usd import Gf, UsdGeom, UsdLux

    light = UsdLux.SphereLight.Define(stage, path)
    light.CreateRadiusAttr(LAMP_RADIUS)
    light.CreateIntensityAttr(500.0 * (height / LAMP_RADIUS) ** 2)
    light.AddTranslateOp().Set(Gf.Vec3d(0, 0, height))
    light.AddOrientOp(UsdGeom.XformOp.PrecisionDouble).Set(Gf.Quatd(1))
    light.AddScaleOp(UsdGeom.XformOp.PrecisionDouble).Set(Gf.Vec3d(1))
