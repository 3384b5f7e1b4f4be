"""The static layer: looks, ground, buildings, instanced props and the invisible shapes that bodies hit."""

from __future__ import annotations

from pathlib import Path

from pxr import Gf, Usd, UsdGeom, UsdPhysics

from .buildings import BACK, FRONT, HEIGHT, LEFT, RIGHT, build_tank, build_warehouse
from .ground import HALF_LENGTH, HALF_WIDTH, build_ground
from .mesh import Mesh, bind, material, place
from .props import CONTAINERS, build_prototypes, place_instances

Box = tuple[str, tuple[float, float, float], tuple[float, float, float], float]
"""Name, middle [m], edge lengths [m], turn about z [deg]."""


def write_static(path: Path) -> None:
    """Write the static layer (binary, default prim /Yard) to `path`."""
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/Yard").GetPrim())
    looks = _looks(stage)
    build_ground(stage, _scope(stage, "/Yard/Ground"), looks)
    build_warehouse(stage, _scope(stage, "/Yard/Warehouse"), looks)
    build_tank(stage, _scope(stage, "/Yard/TankFarm"), looks)
    _build_stands(stage, _scope(stage, "/Yard/Stands"), looks)
    build_prototypes(stage, "/Prototypes")
    place_instances(stage, _scope(stage, "/Yard/Props"), "/Prototypes")
    _build_colliders(stage, _scope(stage, "/Yard/Colliders"))
    stage.GetRootLayer().Export(str(path))


def _scope(stage: Usd.Stage, path: str) -> str:
    UsdGeom.Scope.Define(stage, path)
    return path


def _looks(stage: Usd.Stage) -> dict[str, str]:
    _scope(stage, "/Yard/Looks")
    return {
        key: material(stage, f"/Yard/Looks/{key.title().replace('_', '')}", base, color, coating)
        for key, base, color, coating in (
            ("asphalt", "asphalt", (0.2, 0.2, 0.21), "none"),
            ("grass", "leaf_grass", (0.25, 0.42, 0.16), "none"),
            ("concrete", "concrete", (0.6, 0.6, 0.58), "none"),
            ("brick", "brick", (0.55, 0.28, 0.2), "none"),
            ("plastic", "plastic", (0.9, 0.9, 0.88), "none"),
            ("steel", "steel", (0.55, 0.57, 0.6), "none"),
            ("painted_steel", "steel", (0.75, 0.78, 0.8), "paint"),
        )
    }


def _build_stands(stage: Usd.Stage, root: str, looks: dict[str, str]) -> None:
    """What the joints of the moving parts hang from: the sign's arm, the portal of the pendulum, the barrier's foot."""
    Mesh().add_tube([(-8.0, 3.0, 0), (-8.0, 3.0, 2.9)], 0.06, sides=16).add_tube(
        [(-8.0, 3.0, 2.8), (-6.4, 3.0, 2.8)], 0.03, sides=12
    ).define(stage, f"{root}/SignPost", looks["steel"])
    portal = Mesh().add_tube([(6.0, -6.6, 3.0), (6.0, -3.4, 3.0)], 0.06, sides=12)
    for y in (-6.6, -3.4):
        portal.add_tube([(5.4, y, 0), (6.0, y, 3.0), (6.6, y, 0)], 0.05, sides=12)
    portal.define(stage, f"{root}/Portal", looks["steel"])
    Mesh().add_tube([(0.5, -8.0, 0), (0.5, -8.0, 0.85)], 0.14, sides=24).define(
        stage, f"{root}/BarrierFoot", looks["painted_steel"]
    )


def _build_colliders(stage: Usd.Stage, root: str) -> None:
    """Plain shapes in place of the detailed meshes: bodies rest on them, sensors do not see them."""
    UsdGeom.Imageable(stage.GetPrimAtPath(root)).MakeInvisible()
    grip = UsdPhysics.MaterialAPI.Apply(
        stage.GetPrimAtPath(material(stage, f"{root}/Grip", "asphalt", (0.2, 0.2, 0.2)))
    )
    grip.CreateStaticFrictionAttr(0.8)
    grip.CreateDynamicFrictionAttr(0.8)
    grip.CreateRestitutionAttr(0.0)

    ground = UsdGeom.Plane.Define(stage, f"{root}/Ground")
    ground.CreateAxisAttr(UsdGeom.Tokens.z)
    _collide(ground.GetPrim(), f"{root}/Grip")
    for name, middle, size, turn in _collider_boxes():
        cube = UsdGeom.Cube.Define(stage, f"{root}/{name}")
        cube.CreateSizeAttr(1.0)
        cube.CreateExtentAttr([Gf.Vec3f(-0.5), Gf.Vec3f(0.5)])
        place(cube.GetPrim(), middle, turn)
        cube.AddScaleOp().Set(Gf.Vec3f(*size))
        _collide(cube.GetPrim(), f"{root}/Grip")
    for index, y in enumerate((-6.6, -3.4)):
        _post(stage, f"{root}/Portal_{index}", (6.0, y, 0.5), 0.5, 1.0)
    _post(stage, f"{root}/SignPost", (-8.0, 3.0, 1.4), 0.06, 2.8)
    _post(stage, f"{root}/Tank", (-23.0, 12.0, 3.0), 2.4, 6.0)


def _collider_boxes() -> list[Box]:
    middle = (FRONT + BACK) / 2
    boxes: list[Box] = [
        ("Warehouse", (0, middle, HEIGHT / 2), (RIGHT - LEFT, BACK - FRONT, HEIGHT), 0),
        ("Kerb", (0, 11.2, 0.075), (26.0, 0.18, 0.15), 0),
        ("Island", (8.5, -12.0, 0.075), (9.0, 4.0, 0.15), 0),
        ("FenceEast", (HALF_LENGTH, 0, 1), (0.1, 2 * HALF_WIDTH, 2), 0),
        ("FenceSouth", (0, -HALF_WIDTH, 1), (2 * HALF_LENGTH, 0.1, 2), 0),
        ("FenceNorth", (0, HALF_WIDTH, 1), (2 * HALF_LENGTH, 0.1, 2), 0),
        ("FenceWestA", (-HALF_LENGTH, -11.25, 1), (0.1, 17.5, 2), 0),
        ("FenceWestB", (-HALF_LENGTH, 11.25, 1), (0.1, 17.5, 2), 0),
        ("RacksA", (17.0, -1.8, 2), (1.1, 11.2, 4), 0),
        ("RacksB", (22.0, -1.8, 2), (1.1, 11.2, 4), 0),
    ]
    for index, (x, y, z, turn, _) in enumerate(CONTAINERS):
        boxes.append((f"Container_{index}", (x, y, z + 1.295), (6.06, 2.44, 2.59), turn))
    return boxes


def _post(stage: Usd.Stage, path: str, middle: tuple[float, float, float], radius: float, height: float) -> None:
    post = UsdGeom.Cylinder.Define(stage, path)
    post.CreateAxisAttr(UsdGeom.Tokens.z)
    post.CreateRadiusAttr(radius)
    post.CreateHeightAttr(height)
    place(post.GetPrim(), middle)
    _collide(post.GetPrim(), f"{path.rsplit('/', 1)[0]}/Grip")


def _collide(prim: Usd.Prim, grip: str) -> None:
    UsdPhysics.CollisionAPI.Apply(prim)
    bind(prim, grip)
