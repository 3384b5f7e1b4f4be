"""`Mesh` of `isaacsim.core.experimental.objects`."""

from __future__ import annotations

from typing import Any

import numpy as np

from graph.isaac.results import Result, array, numbers, result, words
from graph.sim.usd import UsdGeom

from .objects import Colored

__all__ = ["Mesh"]


class Mesh(Colored):
    kind = "Mesh"

    def set_primitives(self, primitives: Any, *, indices: Any = None) -> None:
        chosen = numbers(indices, len(self))
        for one, name in zip(chosen, words(primitives, len(chosen)), strict=True):
            points, counts, faces = _primitive(str(name))
            mesh = UsdGeom.Mesh(self.prims[one])
            mesh.CreatePointsAttr().Set([tuple(map(float, point)) for point in points])
            mesh.CreateFaceVertexCountsAttr().Set(counts)
            mesh.CreateFaceVertexIndicesAttr().Set(faces)
            mesh.CreateSubdivisionSchemeAttr().Set("none")

    @property
    def geoms(self) -> list[Any]:
        return [UsdGeom.Mesh(prim) for prim in self.prims]

    @property
    def num_faces(self) -> list[int]:
        return [len(one.GetFaceVertexCountsAttr().Get() or ()) for one in self.geoms]

    def set_points(self, points: Any, *, indices: Any = None) -> None:
        for one, values in zip(numbers(indices, len(self)), points, strict=True):
            self.geoms[one].CreatePointsAttr().Set([tuple(map(float, point)) for point in array(values)])

    def get_points(self, *, indices: Any = None) -> list[Result]:
        return [result(self.geoms[one].GetPointsAttr().Get()) for one in numbers(indices, len(self))]

    def set_face_specs(
        self, vertex_indices: Any = None, vertex_counts: Any = None, *_: Any, indices: Any = None, **__: Any
    ) -> None:
        for row, one in enumerate(numbers(indices, len(self))):
            if vertex_indices is not None:
                self.geoms[one].CreateFaceVertexIndicesAttr().Set([int(v) for v in array(vertex_indices[row])])
            if vertex_counts is not None:
                self.geoms[one].CreateFaceVertexCountsAttr().Set([int(v) for v in array(vertex_counts[row])])

    def get_face_specs(self, *, indices: Any = None) -> tuple[list[Result], list[Result], list[str]]:
        found = [self.geoms[one] for one in numbers(indices, len(self))]
        return (
            [result(one.GetFaceVertexIndicesAttr().Get() or (), np.int32) for one in found],
            [result(one.GetFaceVertexCountsAttr().Get() or (), np.int32) for one in found],
            [str(one.GetFaceVaryingLinearInterpolationAttr().Get()) for one in found],
        )

    def set_normals(self, normals: Any, *, indices: Any = None) -> None:
        for one, values in zip(numbers(indices, len(self)), normals, strict=True):
            self.geoms[one].CreateNormalsAttr().Set([tuple(map(float, normal)) for normal in array(values)])

    def get_normals(self, *, indices: Any = None) -> list[Result]:
        found = [self.geoms[one].GetNormalsAttr().Get() or () for one in numbers(indices, len(self))]
        return [result(np.reshape(one, (-1, 3))) for one in found]

    def set_subdivision_specs(
        self,
        subdivision_schemes: Any = None,
        interpolate_boundaries: Any = None,
        triangle_subdivision_rules: Any = None,
        *,
        indices: Any = None,
    ) -> None:
        chosen = numbers(indices, len(self))
        given = (subdivision_schemes, interpolate_boundaries, triangle_subdivision_rules)
        for name, values in zip(_SUBDIVISION, given, strict=True):
            for one, value in zip(
                chosen, () if values is None else words(values, len(chosen)), strict=values is not None
            ):
                self.prims[one].GetAttribute(name).Set(value)

    def get_subdivision_specs(self, *, indices: Any = None) -> tuple[list[str], ...]:
        chosen = [self.prims[one] for one in numbers(indices, len(self))]
        return tuple([str(prim.GetAttribute(name).Get()) for prim in chosen] for name in _SUBDIVISION)


_SUBDIVISION = ("subdivisionScheme", "interpolateBoundary", "triangleSubdivisionRule")


def _primitive(name: str) -> tuple[np.ndarray, list[int], list[int]]:
    """Points, counts and indices of a mesh with edge or diameter 1, from the tessellation of rays."""
    if name == "Plane":
        return np.array([(-0.5, -0.5, 0), (0.5, -0.5, 0), (0.5, 0.5, 0), (-0.5, 0.5, 0)]), [4], [0, 1, 2, 3]
    from graph.sim.geometry import tessellation

    makers = {
        "Cube": lambda: tessellation.cube(1.0),
        "Sphere": lambda: tessellation.sphere(0.5, 24),
        "Cylinder": lambda: tessellation.cylinder(0.5, 0.5, 1.0, "Z", 24),
        "Cone": lambda: tessellation.cylinder(0.5, 0.0, 1.0, "Z", 24),
        "Disk": lambda: tessellation.cylinder(0.5, 0.5, 1e-6, "Z", 24),
    }
    if name not in makers:
        raise ValueError(f"there is no mesh of the form {name!r} here; there are Plane, {', '.join(makers)}")
    points, triangles = makers[name]()
    return points, [3] * len(triangles), [int(one) for one in np.asarray(triangles).reshape(-1)]
