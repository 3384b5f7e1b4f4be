"""`isaacsim.core.experimental.objects`: shapes, ground planes, lights."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np

from graph.isaac.outcomes import inert
from graph.isaac.parameters import renamed
from graph.isaac.results import Result, numbers, result, rows, words
from graph.sim.usd import Sdf, UsdGeom, UsdPhysics

from .prim_base import XformPrim
from .prims import GeomPrim
from .stage import get_current_stage

__all__ = [
    "Camera",
    "Capsule",
    "Cone",
    "Cube",
    "Cylinder",
    "CylinderLight",
    "DiskLight",
    "DistantLight",
    "DomeLight",
    "GroundPlane",
    "Light",
    "Mesh",
    "Plane",
    "RectLight",
    "Shape",
    "Sphere",
    "SphereLight",
]
_COLORS = {
    "red": (1, 0, 0),
    "green": (0, 1, 0),
    "blue": (0, 0, 1),
    "white": (1, 1, 1),
    "black": (0, 0, 0),
    "gray": (0.5,) * 3,
}


def define(paths: Any, kind: str) -> list[str]:
    """Defines missing prims of a type. Raises AssertionError for an existing prim of another."""
    stage = get_current_stage()
    found, _ = XformPrim.resolve_paths([paths] if isinstance(paths, str) else list(paths))
    for path in found:
        prim = stage.GetPrimAtPath(path)
        if prim and prim.GetTypeName() != kind and prim.GetTypeName():
            raise AssertionError(f"{path} is a {prim.GetTypeName()}, not a {kind}")
        if not prim or not prim.GetTypeName():
            stage.DefinePrim(path, kind)
    return found


class _Typed(XformPrim):
    kind: ClassVar[str]

    def __init__(self, paths: Any, *, reset_xform_op_properties: bool = True, **options: Any) -> None:
        pose = {key: options.pop(key, None) for key in ("positions", "translations", "orientations", "scales")}
        super().__init__(
            define(paths, self.kind), resolve_paths=False, reset_xform_op_properties=reset_xform_op_properties, **pose
        )
        for name, value in options.items():
            if value is not None:
                getattr(self, f"set_{name}")(value)

    @classmethod
    def are_of_type(cls, paths: Any) -> Result:
        stage = get_current_stage()
        listed = paths if isinstance(paths, (list, tuple)) else [paths]
        prims = [stage.GetPrimAtPath(one) if isinstance(one, str) else one for one in listed]
        return result([prim.GetTypeName() == cls.kind for prim in prims], bool)

    @classmethod
    def fetch_instances(cls, paths: Any) -> list[Any]:
        listed = paths if isinstance(paths, (list, tuple)) else [paths]
        texts = [one if isinstance(one, str) else str(one.GetPath()) for one in listed]
        return [cls(path) if bool(cls.are_of_type(path)[0]) else None for path in texts]

    def _write(self, name: str, kind: str, values: Any, indices: Any, make: Any = float) -> None:
        chosen = numbers(indices, len(self))
        given = rows(values, len(chosen), None, name)
        for one, value in zip(chosen, () if given is None else given, strict=True):
            prim = self.prims[one]
            prim.CreateAttribute(name, Sdf.ValueTypeNames.Find(kind), custom=False).Set(make(value))
            boundable = UsdGeom.Boundable(prim)
            if boundable and (extent := UsdGeom.Boundable.ComputeExtentFromPlugins(boundable, 0)):
                boundable.CreateExtentAttr().Set(extent)

    def _numbers(self, name: str, indices: Any) -> Result:
        return result([[self.prims[one].GetAttribute(name).Get()] for one in numbers(indices, len(self))])


def _number(name: str, plural: str, kind: str = "double") -> tuple[Any, Any]:
    def setter(self: Any, values: Any, *, indices: Any = None) -> None:
        self._write(name, kind, values, indices)

    def getter(self: Any, *, indices: Any = None) -> Result:
        return self._numbers(name, indices)  # type: ignore[no-any-return]

    return renamed(setter, f"set_{plural}", plural, indices=True), renamed(getter, f"get_{plural}", indices=True)


class Shape(_Typed, GeomPrim):
    set_sizes, get_sizes = _number("size", "sizes")
    set_radii, get_radii = _number("radius", "radii")
    set_heights, get_heights = _number("height", "heights")
    set_widths, get_widths = _number("width", "widths")
    set_lengths, get_lengths = _number("length", "lengths")

    def set_axes(self, axes: Any, *, indices: Any = None) -> None:
        chosen = numbers(indices, len(self))
        for one, axis in zip(chosen, words(axes, len(chosen)), strict=True):
            self.prims[one].GetAttribute("axis").Set(axis)

    def get_axes(self, *, indices: Any = None) -> list[str]:
        return [str(self.prims[one].GetAttribute("axis").Get()) for one in numbers(indices, len(self))]

    def set_display_colors(self, colors: Any, *, indices: Any = None) -> None:
        chosen = numbers(indices, len(self))
        if isinstance(colors, str):
            colors = _COLORS.get(colors) or [int(colors.lstrip("#")[n : n + 2], 16) / 255 for n in (0, 2, 4)]
        elif isinstance(colors, (list, tuple)) and colors and isinstance(colors[0], str):
            colors = [_COLORS[one] for one in colors]
        given = rows(colors, len(chosen), 3, "colors")
        for row, one in enumerate(chosen):
            if given is not None:
                UsdGeom.Gprim(self.prims[one]).CreateDisplayColorAttr().Set([tuple(map(float, given[row]))])

    set_colors = set_display_colors

    def get_display_colors(self, *, indices: Any = None) -> Result:
        found = [UsdGeom.Gprim(self.prims[one]).GetDisplayColorAttr().Get() for one in numbers(indices, len(self))]
        return result([(value or [(0.5, 0.5, 0.5)])[0] for value in found])

    @staticmethod
    def update_extents(geoms: list[Any]) -> None:
        for geom in geoms:
            geom.CreateExtentAttr().Set(UsdGeom.Boundable.ComputeExtentFromPlugins(geom, 0))


def _shape(kind: str) -> Any:
    return type(kind, (Shape,), {"kind": kind, "__module__": "isaacsim.core.experimental.objects"})


Cube, Sphere, Cylinder, Cone, Capsule = map(_shape, ("Cube", "Sphere", "Cylinder", "Cone", "Capsule"))
Plane = _shape("Plane")


class Mesh(Shape):
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
            self.geoms[one].CreatePointsAttr().Set([tuple(map(float, point)) for point in np.asarray(values)])

    def get_points(self, *, indices: Any = None) -> list[Result]:
        return [result(self.geoms[one].GetPointsAttr().Get()) for one in numbers(indices, len(self))]

    def set_face_specs(
        self, vertex_indices: Any = None, vertex_counts: Any = None, *_: Any, indices: Any = None, **__: Any
    ) -> None:
        for row, one in enumerate(numbers(indices, len(self))):
            if vertex_indices is not None:
                self.geoms[one].CreateFaceVertexIndicesAttr().Set([int(v) for v in np.asarray(vertex_indices[row])])
            if vertex_counts is not None:
                self.geoms[one].CreateFaceVertexCountsAttr().Set([int(v) for v in np.asarray(vertex_counts[row])])

    def get_face_specs(self, *, indices: Any = None) -> tuple[list[Result], list[Result], list[str]]:
        found = [self.geoms[one] for one in numbers(indices, len(self))]
        return (
            [result(one.GetFaceVertexIndicesAttr().Get() or (), np.int32) for one in found],
            [result(one.GetFaceVertexCountsAttr().Get() or (), np.int32) for one in found],
            [str(one.GetFaceVaryingLinearInterpolationAttr().Get()) for one in found],
        )

    def set_normals(self, normals: Any, *, indices: Any = None) -> None:
        for one, values in zip(numbers(indices, len(self)), normals, strict=True):
            self.geoms[one].CreateNormalsAttr().Set([tuple(map(float, normal)) for normal in np.asarray(values)])

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
        stage = get_current_stage()
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
        self.planes = GeomPrim([f"{path}/collisionPlane" for path in roots], resolve_paths=False)
        self.meshes = Mesh([f"{path}/geom" for path in roots])
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


class Camera(_Typed):
    kind = "Camera"


class Light(_Typed):
    set_intensities, get_intensities = _number("inputs:intensity", "intensities", "float")
    set_radii, get_radii = _number("inputs:radius", "radii", "float")
    set_lengths, get_lengths = _number("inputs:length", "lengths", "float")
    set_widths, get_widths = _number("inputs:width", "widths", "float")
    set_heights, get_heights = _number("inputs:height", "heights", "float")
    set_angles, get_angles = _number("inputs:angle", "angles", "float")
    set_exposures, get_exposures = _number("inputs:exposure", "exposures", "float")
    set_color_temperatures, get_color_temperatures = _number("inputs:colorTemperature", "color_temperatures", "float")

    def set_colors(self, colors: Any, *, indices: Any = None) -> None:
        chosen = numbers(indices, len(self))
        given = rows(colors, len(chosen), 3, "colors")
        for row, one in enumerate(chosen):
            if given is not None:
                self.prims[one].CreateAttribute("inputs:color", Sdf.ValueTypeNames.Color3f, custom=False).Set(
                    tuple(map(float, given[row]))
                )

    def _text(self, name: str, kind: str, values: Any, indices: Any) -> None:
        chosen = numbers(indices, len(self))
        for one, value in zip(chosen, words(values, len(chosen)), strict=True):
            self.prims[one].CreateAttribute(name, Sdf.ValueTypeNames.Find(kind), custom=False).Set(value)

    def set_texture_files(self, texture_files: Any, *, indices: Any = None) -> None:
        self._text("inputs:texture:file", "asset", texture_files, indices)

    def set_texture_formats(self, texture_formats: Any, *, indices: Any = None) -> None:
        self._text("inputs:texture:format", "token", texture_formats, indices)

    def set_enabled_color_temperatures(self, enabled: Any, *, indices: Any = None) -> None:
        self._text("inputs:enableColorTemperature", "bool", enabled, indices)


def _light(kind: str) -> Any:
    return type(kind, (Light,), {"kind": kind, "__module__": "isaacsim.core.experimental.objects"})


CylinderLight, DiskLight, DistantLight = map(_light, ("CylinderLight", "DiskLight", "DistantLight"))
DomeLight, RectLight, SphereLight = map(_light, ("DomeLight", "RectLight", "SphereLight"))
