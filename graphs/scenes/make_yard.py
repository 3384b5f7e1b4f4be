"""Author the yard: `python graphs/scenes/make_yard.py [FOLDER]` writes yard.usda and yard_static.usdc beside this file.

The result depends on nothing but this code: run it again after a change and commit what it writes.
"""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

from pxr import Gf, Usd, UsdGeom, UsdPhysics
from yard.bodies import build_bodies, build_mechanisms
from yard.mesh import material
from yard.robot import build_robot
from yard.static import write_static

STATIC = "yard_static.usdc"


def write_root(path: Path) -> None:
    """Write the readable root layer: physics, looks, the static layer by reference, moving bodies, the robot."""
    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    stage.SetMetadata("documentation", "A logistics yard. Written by make_yard.py: change that and run it again.")
    world = UsdGeom.Xform.Define(stage, "/World").GetPrim()
    stage.SetDefaultPrim(world)

    scene = UsdPhysics.Scene.Define(stage, "/World/PhysicsScene")
    scene.CreateGravityDirectionAttr(Gf.Vec3f(0, 0, -1))
    scene.CreateGravityMagnitudeAttr(9.81)

    UsdGeom.Scope.Define(stage, "/World/Looks")
    looks = {
        key: material(stage, f"/World/Looks/{key.title().replace('_', '')}", base, color, coating)
        for key, base, color, coating in (
            ("wood", "wood", (0.6, 0.45, 0.3), "none"),
            ("rubber", "rubber", (0.1, 0.1, 0.1), "none"),
            ("plastic", "plastic", (0.9, 0.45, 0.1), "none"),
            ("painted_steel", "steel", (0.2, 0.35, 0.6), "paint"),
        )
    }
    UsdGeom.Xform.Define(stage, "/World/Static").GetPrim().GetReferences().AddReference(f"./{STATIC}")
    UsdGeom.Scope.Define(stage, "/World/Bodies")
    build_bodies(stage, "/World/Bodies", looks)
    UsdGeom.Scope.Define(stage, "/World/Mechanisms")
    build_mechanisms(stage, "/World/Mechanisms", looks)
    build_robot(stage, "/World/Robot", looks)
    stage.Save()


def main(folder: Path) -> None:
    """Write both layers into `folder`."""
    write_static(folder / STATIC)
    write_root(folder / "yard.usda")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent)
