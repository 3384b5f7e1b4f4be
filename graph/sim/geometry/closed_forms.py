"""Solids whose surface follows from a formula: what a ray meets needs no triangles."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np

from graph.base.records import dataclass
from graph.sim.transforms import Floats

Kind = Literal["ball", "box", "frustum", "capsule"]

SOLIDS: dict[str, tuple[str, ...]] = {
    "Cube": ("size",),
    "Sphere": ("radius",),
    "Plane": ("width", "length"),
    **dict.fromkeys(("Capsule", "Cylinder", "Cone"), ("radius", "height")),
    **dict.fromkeys(("Capsule_1", "Cylinder_1"), ("radiusBottom", "radiusTop", "height")),
}
"""The UsdGeom types whose surface follows from a few numbers, and the attributes that hold these."""

_TO_AXIS = {"X": (2, 0, 1), "Y": (1, 2, 0), "Z": (0, 1, 2)}

FLATTEST = 1e-6
"""Ratio of the smallest to the largest scale below which a solid is left to its triangles."""


@dataclass(frozen=True, eq=False)
class ClosedForm:
    """A convex solid in a frame of its own, which may be scaled, sheared and mirrored.

    ball: |p| <= 1. box: |x|, |y|, |z| <= 1. frustum (cylinder, cone): |z| <= 1 and a radius that goes from `low` at
    z = -1 to `high` at z = 1, the larger being 1. capsule: all that is within 1 of the axis from (0, 0, low) to
    (0, 0, high). frame: (4, 4) float64, from the solid's frame to that of its surface [m].
    """

    kind: Kind
    frame: Floats
    low: float = 0.0
    high: float = 0.0

    def placed(self, matrix: Floats) -> ClosedForm:
        """The solid after a transform (4, 4)."""
        return replace(self, frame=matrix @ self.frame)

    @property
    def usable(self) -> bool:
        """Whether the frame has an inverse that can be computed well."""
        with np.errstate(all="ignore"):
            scales = np.linalg.svd(self.frame[:3, :3], compute_uv=False) if np.isfinite(self.frame).all() else [0.0]
        return bool(scales[-1] > FLATTEST * scales[0])

    def bounds(self) -> tuple[Floats, Floats]:
        """The least and greatest coordinates (3,) [m] of the solid, in the frame of its surface."""
        sides, centre = self.frame[:3, :3], self.frame[:3, 3]
        return centre - self.support(-sides.T), centre + self.support(sides.T)

    def support(self, ways: Floats) -> Floats:
        """How far the solid reaches along ways (3, k), in its own frame: the largest p . way, (k,)."""
        x, y, z = ways
        if self.kind == "ball":
            return np.asarray(np.sqrt(x * x + y * y + z * z))
        if self.kind == "box":
            return np.asarray(np.abs(x) + np.abs(y) + np.abs(z))
        if self.kind == "capsule":
            return np.asarray(np.sqrt(x * x + y * y + z * z) + np.maximum(self.low * z, self.high * z))
        level = np.hypot(x, y)
        return np.asarray(np.maximum(self.low * level - z, self.high * level + z))


def closed_form(kind: str, sizes: dict[str, float], axis: str) -> ClosedForm | None:
    """The form of a prim of `SOLIDS` in the prim's own space, from its sizes (named as in UsdGeom).

    None without one: a Plane, which is flat; a capsule of two radii, which is not convex; a size of 0.
    """
    if kind == "Cube":
        return _scaled("box", (sizes["size"] / 2,) * 3)
    if kind == "Sphere":
        return _scaled("ball", (sizes["radius"],) * 3)
    if kind == "Plane":
        return None
    bottom = sizes.get("radiusBottom", sizes.get("radius", 0.0))
    top = sizes.get("radiusTop", 0.0 if kind == "Cone" else bottom)
    radius, half = max(bottom, top), sizes["height"] / 2
    if radius == 0:
        return None
    if kind.startswith("Capsule"):
        long = half / radius
        return _scaled("capsule", (radius,) * 3, axis, -long, long) if bottom == top else None
    return _scaled("frustum", (radius, radius, half), axis, bottom / radius, top / radius)


def _scaled(
    kind: Kind, scale: tuple[float, float, float], axis: str = "Z", low: float = 0.0, high: float = 0.0
) -> ClosedForm | None:
    frame = np.zeros((4, 4))
    for row, column in enumerate(_TO_AXIS[axis]):
        frame[row, column] = scale[column]
    frame[3, 3] = 1.0
    form = ClosedForm(kind, frame, low, high)
    return form if form.usable else None
