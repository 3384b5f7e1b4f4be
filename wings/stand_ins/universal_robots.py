"""Stand-ins for the arms of Universal Robots: six revolute joints, links as boxes without colliders."""

from __future__ import annotations

from typing import Any, NamedTuple

from graph.sim.usd import Gf, Sdf, UsdGeom, UsdPhysics

from .parts import Numbers, add_drive, frame_at, join, make_body


class Model(NamedTuple):
    """What tells the arms apart, of the maker's tables.

    lengths: d1, a2, a3, d4, d5, d6 of their DH parameters [m]. masses: of the six links [kg]. torques: highest ones of
    the two shoulder joints, of the elbow, and of the three joints of the wrist [N m].
    """

    lengths: Numbers
    masses: Numbers
    torques: Numbers


_OF_3 = (2.0, 3.42, 1.26, 0.8, 0.8, 0.35)
_OF_5 = (3.7, 8.39, 2.28, 1.22, 1.22, 0.19)
MODELS = {
    "ur3": Model((0.1519, -0.24365, -0.21325, 0.11235, 0.08535, 0.0819), _OF_3, (56, 28, 12)),
    "ur5": Model((0.08916, -0.425, -0.39225, 0.10915, 0.09465, 0.0823), _OF_5, (150, 150, 28)),
    "ur10": Model(
        (0.1273, -0.612, -0.5723, 0.16394, 0.1157, 0.0922), (7.78, 12.93, 3.87, 1.96, 1.96, 0.2), (330, 150, 56)
    ),
    "ur3e": Model((0.15185, -0.24355, -0.2132, 0.13105, 0.08535, 0.0921), _OF_3, (56, 28, 12)),
    "ur5e": Model((0.1625, -0.425, -0.3922, 0.1333, 0.0997, 0.0996), _OF_5, (150, 150, 28)),
    "ur10e": Model(
        (0.1807, -0.6127, -0.57155, 0.17415, 0.11985, 0.11655), (7.37, 13.05, 3.99, 2.1, 1.98, 0.62), (330, 150, 56)
    ),
    "ur16e": Model(
        (0.1807, -0.4784, -0.36, 0.17415, 0.11985, 0.11655), (7.37, 10.45, 4.32, 2.1, 1.98, 0.62), (330, 150, 56)
    ),
}
LINKS = ("shoulder_link", "upper_arm_link", "forearm_link", "wrist_1_link", "wrist_2_link", "wrist_3_link")
JOINTS = ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3")
STIFFNESS, DAMPING = 1000.0, 100.0
"""Of the drives [N m / deg, N m s / deg]: they hold the arm stretched out within a degree."""


def universal_robot(name: str, stage: Any) -> Any:
    """The arm of a model, stretched out along -x: each joint turns about the z axis of its link."""
    model = MODELS[name]
    d1, a2, a3, d4, d5, d6 = model.lengths
    steps = (
        frame_at((0, 0, d1), (1, 0, 0), 0),
        frame_at((0, 0, 0), (1, 0, 0), 90),
        frame_at((a2, 0, 0), (1, 0, 0), 0),
        frame_at((a3, 0, d4), (1, 0, 0), 0),
        frame_at((0, -d5, 0), (1, 0, 0), 90),
        frame_at((0, d6, 0), (1, 0, 0), -90),
    )
    torques = (model.torques[0], *model.torques[:2], *(model.torques[2],) * 3)
    root = UsdGeom.Xform.Define(stage, f"/{name}").GetPrim()
    UsdPhysics.ArticulationRootAPI.Apply(root)
    root.CreateAttribute("physxArticulation:enabledSelfCollisions", Sdf.ValueTypeNames.Bool).Set(False)
    pose = Gf.Matrix4d(1.0)
    link = _link(stage, f"/{name}/base_link", pose, 4.0)
    UsdPhysics.FixedJoint.Define(stage, f"/{name}/root_joint").CreateBody1Rel().SetTargets([link])
    for child_name, joint_name, step, mass, torque in zip(LINKS, JOINTS, steps, model.masses, torques, strict=True):
        pose = step * pose
        child = _link(stage, f"/{name}/{child_name}", pose, mass)
        joint = UsdPhysics.RevoluteJoint.Define(stage, f"{link}/{joint_name}_joint")
        join(joint, link, child, step)
        joint.CreateAxisAttr("Z")
        limit = 180.0 if joint_name == "elbow" else 360.0
        joint.CreateLowerLimitAttr(-limit)
        joint.CreateUpperLimitAttr(limit)
        add_drive(joint, "angular", STIFFNESS, DAMPING, float(torque))
        link = child
    tool = _link(stage, f"/{name}/ee_link", pose, 0.01)
    join(UsdPhysics.FixedJoint.Define(stage, f"{link}/ee_fixed_joint"), link, tool, Gf.Matrix4d(1.0))
    return root


def _link(stage: Any, path: str, pose: Any, mass: float) -> str:
    prim = UsdGeom.Xform.Define(stage, path)
    prim.AddTransformOp().Set(pose)
    make_body(prim.GetPrim(), mass, [mass * 0.01] * 3)
    shape = UsdGeom.Cube.Define(stage, f"{path}/visuals")
    shape.CreateSizeAttr(0.1)
    return path
