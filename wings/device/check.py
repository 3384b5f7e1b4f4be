"""Whether a device measures what the processor measures: the same rays, cast by both at solids, meshes and a plane."""

from __future__ import annotations

import numpy as np

from graph.base.records import dataclass
from graph.sim.app import App
from sensors.raycast.rays import Hits, RayBundle
from sensors.raycast.shared import cast_world

RAYS = 20_000
"""Rays of the comparison, evenly over the sphere (a Fibonacci lattice)."""

SAME_M = 1e-5
"""Ranges differ by less, but for rays that graze a triangle, where the processor's float32 is off by more."""

EDGES = 1e-3
"""Share of the rays that may meet another surface, or graze one: edges are decided by the last bit."""


@dataclass(frozen=True)
class Comparison:
    """Of `rays` rays, the largest difference in range [m], and how many met other surfaces.

    Without the share `EDGES` of the rays, and less the spacing of float32 at the range.
    """

    rays: int
    worst_m: float
    others: int

    @property
    def same(self) -> bool:
        """Whether the device agrees with the processor."""
        return self.worst_m < SAME_M and self.others <= EDGES * self.rays


def compare(device: str) -> Comparison:
    """Casts on a device (a value of the knob `device`) and on the processor. Raises UserError without the device."""
    ours, theirs = _cast(device), _cast("cpu")
    both = np.isfinite(ours.distance) & np.isfinite(theirs.distance)
    others = int((ours.surfaces() != theirs.surfaces()).sum())
    apart = np.abs(ours.distance[both] - theirs.distance[both]) - np.spacing(theirs.distance[both])
    apart.sort()
    return Comparison(RAYS, float(apart[: len(apart) - int(EDGES * RAYS)].max(initial=0.0)), others)


def _cast(device: str) -> Hits:
    with App(device=device) as app:
        _fill(app.stage)
        app.play()
        table = np.zeros((RAYS, 6), np.float32)
        number = np.arange(RAYS) + 0.5
        height, turn = 1 - 2 * number / RAYS, np.pi * (1 + np.sqrt(5)) * number
        level = np.sqrt(1 - height * height)
        table[:, 3:] = np.stack([level * np.cos(turn), level * np.sin(turn), height], 1)
        return cast_world(app.world).cast(RayBundle(np.array([0.1, 0.2, 0.3]), table), normals=True)


def _fill(stage: object) -> None:
    """A plane, each kind of solid, standing and on a body, and a mesh on a body."""
    from graph.sim.usd import Gf, UsdGeom, UsdPhysics

    UsdGeom.Plane.Define(stage, "/World/Plane").AddTranslateOp().Set(Gf.Vec3d(0, 0, -3))
    kinds = UsdGeom.Cube, UsdGeom.Sphere, UsdGeom.Cylinder, UsdGeom.Cone, UsdGeom.Capsule
    for number, kind in enumerate(kinds):
        for ring, body in ((4.0, False), (7.0, True)):
            angle = 2 * np.pi * (number + 0.3 * ring) / len(kinds)
            shape = kind.Define(stage, f"/World/{kind.__name__}{int(ring)}")
            shape.AddTranslateOp().Set(Gf.Vec3d(ring * np.cos(angle), ring * np.sin(angle), number - 2.0))
            shape.AddRotateXYZOp().Set(Gf.Vec3f(20 * number, 35, 10))
            shape.AddScaleOp().Set(Gf.Vec3f(0.6, 0.6, 0.8))
            if body:
                UsdPhysics.RigidBodyAPI.Apply(shape.GetPrim()).GetKinematicEnabledAttr().Set(True)
    mesh = UsdGeom.Mesh.Define(stage, "/World/Tent")
    mesh.GetPointsAttr().Set([(2, -1, -1), (3, 1, -1), (2, 0, 1), (4, 0, -1)])
    mesh.GetFaceVertexCountsAttr().Set([3, 3, 3, 3])
    mesh.GetFaceVertexIndicesAttr().Set([0, 2, 1, 0, 3, 2, 1, 2, 3, 0, 1, 3])
    UsdPhysics.RigidBodyAPI.Apply(mesh.GetPrim()).GetKinematicEnabledAttr().Set(True)
