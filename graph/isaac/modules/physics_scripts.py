"""`omni.physx.scripts` and `pxr.PhysicsSchemaTools`: bodies and colliders on prims."""

from __future__ import annotations

from typing import Any

from graph.sim.usd import Gf, Sdf, UsdGeom, UsdPhysics, UsdShade

__all__ = [
    "addGroundPlane",
    "addRigidBodyMaterial",
    "add_ground_plane",
    "add_physics_material_to_prim",
    "add_rigid_body_material",
    "createMeshBox",
    "encodeSdfPath",
    "intToSdfPath",
    "removeCollider",
    "removeRigidBody",
    "sdfPathToInt",
    "setCollider",
    "setPhysics",
    "setRigidBody",
    "setStaticCollider",
    "set_or_add_orient_op",
    "set_or_add_scale_op",
    "set_or_add_scale_orient_translate",
    "set_or_add_translate_op",
]
_PATHS: dict[int, str] = {}


def setRigidBody(prim: Any, approximationShape: str = "convexHull", kinematic: bool = False, **_: Any) -> None:
    UsdPhysics.RigidBodyAPI.Apply(prim).CreateKinematicEnabledAttr().Set(bool(kinematic))
    setCollider(prim, approximationShape)


def setPhysics(prim: Any, kinematic: bool = False, **_: Any) -> None:
    UsdPhysics.RigidBodyAPI.Apply(prim).CreateKinematicEnabledAttr().Set(bool(kinematic))


def setCollider(prim: Any, approximationShape: str = "none", **_: Any) -> None:
    from graph.sim.usd import Usd

    for one in Usd.PrimRange(prim):
        if one.IsA(UsdGeom.Gprim):
            UsdPhysics.CollisionAPI.Apply(one)
        if one.IsA(UsdGeom.Mesh):
            UsdPhysics.MeshCollisionAPI.Apply(one).CreateApproximationAttr().Set(approximationShape)


def setStaticCollider(prim: Any, approximationShape: str = "none", **_: Any) -> None:
    setCollider(prim, approximationShape)


def removeRigidBody(prim: Any) -> None:
    prim.RemoveAPI(UsdPhysics.RigidBodyAPI)


def removeCollider(prim: Any) -> None:
    prim.RemoveAPI(UsdPhysics.CollisionAPI)


def add_ground_plane(
    stage: Any, planePath: str, axis: str = "Z", size: float = 100.0, position: Any = (0, 0, 0), color: Any = None
) -> str:
    from .ground_planes import GroundPlane

    GroundPlane(str(planePath), sizes=2 * float(size), positions=[*position])
    return str(planePath)


addGroundPlane = add_ground_plane  # noqa: N816


def add_rigid_body_material(
    stage: Any,
    path: str,
    density: Any = None,
    staticFriction: Any = None,
    dynamicFriction: Any = None,
    restitution: Any = None,
) -> Any:
    material = UsdShade.Material.Define(stage, path)
    api = UsdPhysics.MaterialAPI.Apply(material.GetPrim())
    for name, value in (
        ("Density", density),
        ("StaticFriction", staticFriction),
        ("DynamicFriction", dynamicFriction),
        ("Restitution", restitution),
    ):
        if value is not None:
            getattr(api, f"Create{name}Attr")().Set(float(value))
    return material


addRigidBodyMaterial = add_rigid_body_material  # noqa: N816


def add_physics_material_to_prim(stage: Any, prim: Any, materialPath: Any) -> None:
    material = UsdShade.Material.Get(stage, materialPath)
    UsdShade.MaterialBindingAPI.Apply(prim).Bind(material, UsdShade.Tokens.weakerThanDescendants, "physics")


def _set_or_add(xformable: Any, kind: Any, value: Any, first: Any) -> Any:
    """The prim's op of a kind with a value of its own type; a new one has single precision."""
    held = UsdGeom.Xformable(xformable)
    for op in held.GetOrderedXformOps():
        if op.GetOpType() == kind and not op.IsInverseOp():
            now = op.Get()
            op.Set((first if now is None else type(now))(value))
            return op
    made = held.AddXformOp(kind, UsdGeom.XformOp.PrecisionFloat)
    made.Set(first(value))
    return made


def set_or_add_translate_op(xformable: Any, translate: Any) -> Any:
    return _set_or_add(xformable, UsdGeom.XformOp.TypeTranslate, translate, Gf.Vec3f)


def set_or_add_orient_op(xformable: Any, orient: Any) -> Any:
    return _set_or_add(xformable, UsdGeom.XformOp.TypeOrient, orient, Gf.Quatf)


def set_or_add_scale_op(xformable: Any, scale: Any) -> Any:
    return _set_or_add(xformable, UsdGeom.XformOp.TypeScale, scale, Gf.Vec3f)


def set_or_add_scale_orient_translate(xformable: Any, scale: Any, orient: Any, translate: Any) -> list[Any]:
    return [
        set_or_add_translate_op(xformable, translate),
        set_or_add_orient_op(xformable, orient),
        set_or_add_scale_op(xformable, scale),
    ]


def createMeshBox(stage: Any, path: str, size: float = 1.0) -> Any:
    from .meshes import Mesh

    made = Mesh(str(path), primitives="Cube")
    made.set_local_scales([[size] * 3])
    return UsdGeom.Mesh(made.prims[0])


def sdfPathToInt(path: Any) -> int:
    number = abs(hash(str(path)))
    _PATHS[number] = str(path)
    return number


encodeSdfPath = sdfPathToInt  # noqa: N816


def intToSdfPath(number: int) -> Any:
    return Sdf.Path(_PATHS.get(int(number), ""))
