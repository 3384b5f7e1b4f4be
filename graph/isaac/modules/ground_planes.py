"""`GroundPlane` of `isaacsim.core.experimental.objects`."""

from __future__ import annotations

from typing import Any

from graph.isaac.outcomes import inert
from graph.isaac.results import Result, rows
from graph.sim.usd import UsdGeom, UsdPhysics

from .meshes import Mesh
from .objects import Plane
from .prim_base import define
from .prims import GeomPrim
from .stage import usd_stage

__all__ = ["GroundPlane"]


class GroundPlane(GeomPrim):
    def __init__(
        self,
        paths: Any,
        *,
        sizes: Any = 100.0,
        colors: Any = None,
        templates: Any = "wireframe-blue",
        positions: Any = None,
        translations: Any = None,
        orientations: Any = None,
        scales: Any = None,
        reset_xform_op_properties: bool = True,
    ) -> None:
        stage = usd_stage()
        roots = define(paths, "Xform")
        half = rows(sizes, len(roots), None, "sizes")
        for row, path in enumerate(roots):
            if not stage.GetPrimAtPath(f"{path}/collisionPlane"):
                plane = UsdGeom.Plane.Define(stage, f"{path}/collisionPlane")
                plane.CreateAxisAttr("Z")
                plane.CreatePurposeAttr(UsdGeom.Tokens.guide)
                UsdPhysics.CollisionAPI.Apply(plane.GetPrim())
                side = float(half[row]) / 2 if half is not None else 50.0
                mesh = UsdGeom.Mesh.Define(stage, f"{path}/geom")
                mesh.CreatePointsAttr([(-side, -side, 0), (side, -side, 0), (side, side, 0), (-side, side, 0)])
                mesh.CreateFaceVertexCountsAttr([4])
                mesh.CreateFaceVertexIndicesAttr([0, 1, 2, 3])
                mesh.CreateSubdivisionSchemeAttr("none")
        super().__init__(
            roots,
            resolve_paths=False,
            positions=positions,
            translations=translations,
            orientations=orientations,
            scales=scales,
            reset_xform_op_properties=reset_xform_op_properties,
        )
        self.planes: GeomPrim = Plane([f"{path}/collisionPlane" for path in roots], reset_xform_op_properties=False)
        self.meshes = Mesh([f"{path}/geom" for path in roots], reset_xform_op_properties=False)
        if colors is not None:
            self.meshes.set_display_colors(colors)

    def apply_physics_materials(
        self, materials: Any, *, weaker_than_descendants: Any = None, indices: Any = None
    ) -> None:
        self.planes.apply_physics_materials(materials, indices=indices)

    def set_enabled_collisions(self, enabled: Any, *, indices: Any = None) -> None:
        self.planes.set_enabled_collisions(enabled, indices=indices)

    def get_enabled_collisions(self, *, indices: Any = None) -> Result:
        return self.planes.get_enabled_collisions(indices=indices)

    def get_applied_physics_materials(self, *, indices: Any = None) -> list[Any]:
        return self.planes.get_applied_physics_materials(indices=indices)

    def set_offsets(self, contact_offsets: Any = None, rest_offsets: Any = None, *, indices: Any = None) -> None:
        self.planes.set_offsets(contact_offsets, rest_offsets, indices=indices)

    def get_offsets(self, *, indices: Any = None) -> tuple[Result, Result]:
        return self.planes.get_offsets(indices=indices)

    @inert("isaacsim.core.experimental.objects")
    def apply_visual_templates(self, templates: Any, *, indices: Any = None) -> None:
        return None
