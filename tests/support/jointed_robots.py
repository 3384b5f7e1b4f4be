"""Robots of two links with the root of their articulation at each place that files use, and MJCF models of them."""

from __future__ import annotations

TWO_ROBOTS = """<mujoco>
  <worldbody>
    <geom name="floor" type="plane" size="0 0 1"/>
    <body name="torso" pos="0 0 1">
      <freejoint/>
      <geom name="trunk" size=".1"/>
      <body name="leg" pos="0 1 0">
        <joint name="hip-yaw.l" axis="0 0 1" range="-1 1"/>
        <geom name="shin" size=".1"/>
        <body name="foot" pos="0 1 0"><geom name="sole" size=".1"/></body>
      </body>
    </body>
    <body name="stand" pos="5 0 1">
      <geom name="post" size=".1"/>
      <body name="arm" pos="0 1 0">
        <joint name="elbow" axis="0 0 1"/>
        <geom name="rod" size=".1"/>
      </body>
    </body>
    <body name="ball" pos="0 0 3"><freejoint/><geom name="round" size=".1"/></body>
  </worldbody>
</mujoco>
"""
"""A walker with a free base and a foot welded to its leg, an arm on a stand that stays, and a free ball."""

ROOTS = ("link", "joint", "above", "static base")


def define_robot(stage, root, place, at=(0.0, 0.0, 0.0), *, free=False):
    """Links `root`/base and `root`/arm on the hinge `root`/hinge (z), 1 m apart along y; the base is fixed or free.

    place: where the root API is, one of `ROOTS`: on the base, on the joint that fixes it, on `root`, or on a base
    without a rigid body.
    """
    from pxr import UsdGeom, UsdPhysics

    UsdGeom.Xform.Define(stage, root)
    for name, shift in (("base", 0.0), ("arm", 1.0)):
        cube = UsdGeom.Cube.Define(stage, f"{root}/{name}")
        cube.GetSizeAttr().Set(0.2)
        cube.AddTranslateOp().Set((at[0], at[1] + shift, at[2]))
        UsdPhysics.CollisionAPI.Apply(cube.GetPrim())
        if place != "static base" or name == "arm":
            UsdPhysics.RigidBodyAPI.Apply(cube.GetPrim())
    hinge = UsdPhysics.RevoluteJoint.Define(stage, f"{root}/hinge")
    hinge.GetAxisAttr().Set("Z")
    hinge.GetBody0Rel().SetTargets([f"{root}/base"])
    hinge.GetBody1Rel().SetTargets([f"{root}/arm"])
    hinge.GetLocalPos0Attr().Set((0, 1, 0))
    if place != "static base" and not free:
        mount = UsdPhysics.FixedJoint.Define(stage, f"{root}/mount")
        mount.GetBody1Rel().SetTargets([f"{root}/base"])
        mount.GetLocalPos0Attr().Set(at)
    where = {"link": f"{root}/base", "joint": f"{root}/mount", "above": root, "static base": f"{root}/base"}[place]
    UsdPhysics.ArticulationRootAPI.Apply(stage.GetPrimAtPath(where))
    return where


def define_ball(stage, path, at=(0.0, 0.0, 5.0)):
    """A free ball."""
    from pxr import UsdGeom, UsdPhysics

    ball = UsdGeom.Sphere.Define(stage, path)
    ball.GetRadiusAttr().Set(0.1)
    ball.AddTranslateOp().Set(at)
    UsdPhysics.RigidBodyAPI.Apply(ball.GetPrim())
