"""Robots on a base that stays where it is, with driven joints, for nodes that command joints or read them."""


def define_base(stage, root, size=0.2):
    """An articulation `root` with a cube `root`/base of 1 kg that is mounted to the world."""
    from pxr import UsdGeom, UsdPhysics

    UsdPhysics.ArticulationRootAPI.Apply(UsdGeom.Xform.Define(stage, root).GetPrim())
    base = _define_body(stage, f"{root}/base", (0, 0, 0), size)
    UsdPhysics.FixedJoint.Define(stage, f"{root}/mount").GetBody1Rel().SetTargets([base])


def define_joint(stage, root, name, link, place, axis="Y", kind="angular", size=0.2, **drive):
    """A joint `root`/`name` on the base, which carries the cube `root`/`link` of 1 kg at `place`.

    Its drive gives accelerations; `drive` has values of its attributes, such as damping.
    """
    from pxr import UsdPhysics

    schema = UsdPhysics.RevoluteJoint if kind == "angular" else UsdPhysics.PrismaticJoint
    joint = schema.Define(stage, f"{root}/{name}")
    joint.GetAxisAttr().Set(axis)
    joint.GetBody0Rel().SetTargets([f"{root}/base"])
    joint.GetBody1Rel().SetTargets([_define_body(stage, f"{root}/{link}", place, size)])
    joint.GetLocalPos0Attr().Set(place)
    UsdPhysics.DriveAPI.Apply(joint.GetPrim(), kind).GetTypeAttr().Set("acceleration")
    for attribute, value in drive.items():
        joint.GetPrim().GetAttribute(f"drive:{kind}:physics:{attribute}").Set(value)


def define_cart(stage, damping):
    """/World/Cart with the wheels left and right, 1 m from its middle, on left_joint and right_joint.

    Drives of this damping [1/s, of degrees] turn them at the commanded speeds.
    """
    define_base(stage, "/World/Cart")
    for name, y in (("left", 1), ("right", -1)):
        define_joint(stage, "/World/Cart", f"{name}_joint", name, (0, y, 0), damping=damping)


def _define_body(stage, path, place, size):
    from pxr import UsdGeom, UsdPhysics

    cube = UsdGeom.Cube.Define(stage, path)
    cube.GetSizeAttr().Set(size)
    cube.AddTranslateOp().Set(place)
    UsdPhysics.RigidBodyAPI.Apply(cube.GetPrim())
    UsdPhysics.MassAPI.Apply(cube.GetPrim()).GetMassAttr().Set(1.0)
    return path
