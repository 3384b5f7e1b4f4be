"""`Mesh` of `isaacsim.core.experimental.objects`."""

from __future__ import annotations

from collections.abc import Callable
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
            author_mesh(UsdGeom.Mesh(self.prims[one]), str(name))

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
        self,
        vertex_indices: Any = None,
        vertex_counts: Any = None,
        varying_linear_interpolations: Any = None,
        hole_indices: Any = None,
        *,
        indices: Any = None,
    ) -> None:
        given = (vertex_indices, vertex_counts, varying_linear_interpolations, hole_indices)
        if all(one is None for one in given):
            raise AssertionError("give vertex indices, counts, interpolations or hole indices of faces")
        self._set_lists("faceVertexIndices", vertex_indices, indices)
        self._set_lists("faceVertexCounts", vertex_counts, indices)
        self._set_lists("holeIndices", hole_indices, indices)
        if varying_linear_interpolations is not None:
            chosen = numbers(indices, len(self))
            for one, word in zip(chosen, words(varying_linear_interpolations, len(chosen)), strict=True):
                self.geoms[one].CreateFaceVaryingLinearInterpolationAttr().Set(word)

    def get_face_specs(self, *, indices: Any = None) -> tuple[list[Result], list[Result], list[str], list[Result]]:
        chosen = numbers(indices, len(self))
        rules = [str(self.geoms[one].GetFaceVaryingLinearInterpolationAttr().Get()) for one in chosen]
        corners, counts = self._lists("faceVertexIndices", indices), self._lists("faceVertexCounts", indices)
        return corners, counts, rules, self._lists("holeIndices", indices)

    def set_crease_specs(
        self, crease_indices: Any, crease_lengths: Any, crease_sharpnesses: Any, *, indices: Any = None
    ) -> None:
        rows = zip(crease_indices, crease_lengths, crease_sharpnesses, strict=True)
        for corners, lengths, sharpnesses in (map(_flat, row) for row in rows):
            if lengths.sum() != corners.size:
                raise AssertionError(f"the lengths of creases add up to {lengths.sum()}, not {corners.size} indices")
            if sharpnesses.size not in (lengths.size, (lengths - 1).sum()):
                raise AssertionError(f"{sharpnesses.size} values of sharpness are not one a crease or one an edge")
        self._set_lists("creaseIndices", crease_indices, indices)
        self._set_lists("creaseLengths", crease_lengths, indices)
        self._set_lists("creaseSharpnesses", crease_sharpnesses, indices, np.float32)

    def get_crease_specs(self, *, indices: Any = None) -> tuple[list[Result], list[Result], list[Result]]:
        corners, lengths = self._lists("creaseIndices", indices), self._lists("creaseLengths", indices)
        return corners, lengths, self._lists("creaseSharpnesses", indices, np.float32)

    def set_corner_specs(self, corner_indices: Any, corner_sharpnesses: Any, *, indices: Any = None) -> None:
        for corners, sharpnesses in zip(corner_indices, corner_sharpnesses, strict=True):
            if _flat(corners).size != _flat(sharpnesses).size:
                raise AssertionError("each corner needs one value of sharpness")
        self._set_lists("cornerIndices", corner_indices, indices)
        self._set_lists("cornerSharpnesses", corner_sharpnesses, indices, np.float32)

    def get_corner_specs(self, *, indices: Any = None) -> tuple[list[Result], list[Result]]:
        return self._lists("cornerIndices", indices), self._lists("cornerSharpnesses", indices, np.float32)

    def _set_lists(self, name: str, values: Any, indices: Any, kind: Any = np.int32) -> None:
        """Writes an array attribute of each mesh; one row counts for all."""
        chosen = numbers(indices, len(self))
        for row, one in enumerate(() if values is None else chosen):
            self.prims[one].GetAttribute(name).Set(_flat(values[0 if len(values) == 1 else row]).astype(kind).tolist())

    def _lists(self, name: str, indices: Any, kind: Any = np.int32) -> list[Result]:
        chosen = numbers(indices, len(self))
        return [result(self.prims[one].GetAttribute(name).Get() or (), kind) for one in chosen]

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


def _flat(values: Any) -> np.ndarray:
    return np.asarray(array(values)).reshape(-1)


def author_mesh(mesh: Any, name: str, size: float = 1.0) -> None:
    """Authors a form, "Cube" or another, whose edge or diameter is `size` [stage units]."""
    points, counts, faces = _primitive(name)
    mesh.CreatePointsAttr().Set([tuple(map(float, point)) for point in points * size])
    mesh.CreateFaceVertexCountsAttr().Set(counts)
    mesh.CreateFaceVertexIndicesAttr().Set(faces)
    mesh.CreateSubdivisionSchemeAttr().Set("none")


def _torus(ring: float, tube: float, count: int) -> tuple[np.ndarray, np.ndarray]:
    """A ring about z: its points (count * count, 3), and two triangles for each of its cells, facing outwards."""
    along, around = np.meshgrid(*[np.arange(count) * (2 * np.pi / count)] * 2, indexing="ij")
    reach = ring + tube * np.cos(around)
    points = np.stack([reach * np.cos(along), reach * np.sin(along), tube * np.sin(around)], axis=-1)
    number = np.arange(count * count).reshape(count, count)
    ahead, above = np.roll(number, -1, 0), np.roll(number, -1, 1)
    both = np.roll(ahead, -1, 1)
    cells = np.stack([number, ahead, both, number, both, above], axis=-1)
    return points.reshape(-1, 3), cells.reshape(-1, 3)


def _primitive(name: str) -> tuple[np.ndarray, list[int], list[int]]:
    """Points, counts and indices of a mesh with edge or diameter 1, from the tessellation of rays."""
    if name == "Plane":
        return np.array([(-0.5, -0.5, 0), (0.5, -0.5, 0), (0.5, 0.5, 0), (-0.5, 0.5, 0)]), [4], [0, 1, 2, 3]
    from graph.sim.geometry import tessellation

    makers: dict[str, Callable[[], Any]] = {
        "Cube": lambda: tessellation.cube(1.0),
        "Sphere": lambda: tessellation.sphere(0.5, 24),
        "Cylinder": lambda: tessellation.cylinder(0.5, 0.5, 1.0, "Z", 24),
        "Cone": lambda: tessellation.cylinder(0.5, 0.0, 1.0, "Z", 24),
        "Torus": lambda: _torus(0.375, 0.125, 24),
        "Disk": lambda: tessellation.cylinder(0.5, 0.5, 1e-6, "Z", 24),
    }
    if name not in makers:
        raise ValueError(f"there is no mesh of the form {name!r} here; there are Plane, {', '.join(makers)}")
    points, triangles = makers[name]()
    return points, [3] * len(triangles), [int(one) for one in np.asarray(triangles).reshape(-1)]
