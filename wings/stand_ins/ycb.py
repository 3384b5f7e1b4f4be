"""Stand-ins for objects of the YCB set: boxes of their sizes and masses."""

from __future__ import annotations

from typing import Any

from graph.sim.usd import Sdf, UsdGeom, UsdPhysics

from .parts import add_box, make_body

SIZES = {
    # width, depth, height [m]; mass [kg]
    "002": ((0.102, 0.102, 0.139), 0.414),  # master chef can
    "003": ((0.164, 0.213, 0.072), 0.411),  # cracker box
    "004": ((0.049, 0.094, 0.176), 0.514),  # sugar box
    "005": ((0.068, 0.068, 0.102), 0.349),  # tomato soup can
    "006": ((0.058, 0.095, 0.19), 0.603),  # mustard bottle
    "007": ((0.085, 0.085, 0.033), 0.171),  # tuna fish can
    "008": ((0.035, 0.11, 0.089), 0.187),  # pudding box
    "009": ((0.028, 0.085, 0.073), 0.097),  # gelatin box
    "010": ((0.05, 0.097, 0.082), 0.37),  # potted meat can
    "011": ((0.036, 0.19, 0.036), 0.066),  # banana
    "019": ((0.108, 0.149, 0.242), 0.178),  # pitcher base
    "021": ((0.075, 0.06, 0.25), 1.131),  # bleach cleanser
    "024": ((0.159, 0.159, 0.053), 0.147),  # bowl
    "025": ((0.08, 0.117, 0.082), 0.118),  # mug
    "035": ((0.184, 0.187, 0.057), 0.895),  # power drill
    "036": ((0.085, 0.085, 0.2), 0.729),  # wood block
    "037": ((0.087, 0.2, 0.014), 0.082),  # scissors
    "040": ((0.018, 0.121, 0.018), 0.016),  # large marker
    "051": ((0.165, 0.213, 0.037), 0.202),  # large clamp
    "052": ((0.202, 0.213, 0.037), 0.202),  # extra large clamp
    "061": ((0.05, 0.075, 0.05), 0.028),  # foam brick
}
"""By number."""


def ycb(number: str, solid: bool, stage: Any) -> Any:
    """A box around its origin; solid: a body that physics moves."""
    size, mass = SIZES[number]
    root = UsdGeom.Xform.Define(stage, "/Root").GetPrim()
    add_box(stage, "/Root/shape", size, (0, 0, 0))
    if not solid:
        stage.GetPrimAtPath("/Root/shape").RemoveAPI(UsdPhysics.CollisionAPI)
        return root
    make_body(root, mass)
    for name, kind, value in (("disableGravity", "bool", False), ("linearDamping", "float", 0.0)):
        root.CreateAttribute(f"physxRigidBody:{name}", Sdf.ValueTypeNames.Find(kind), custom=False).Set(value)
    root.CreateAttribute("physxRigidBody:angularDamping", Sdf.ValueTypeNames.Float, custom=False).Set(0.05)
    return root
