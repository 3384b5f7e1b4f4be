"""UsdPhysics colliders as convex shapes; concave ones are cut into convex parts or, with a warning, replaced by a
hull.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from graph.sim import transforms
from graph.sim.attributes import applied_schemas, authored, kilograms_per_unit, number_of
from graph.sim.geometry.closed_forms import SOLIDS
from graph.sim.geometry.collect import endless
from graph.sim.geometry.shapes import shape_of
from graph.sim.geometry.tessellation import Triangles, axis_vector
from graph.sim.scene.scan import Scan
from graph.sim.scene.stage import Warn
from graph.sim.transforms import Floats
from graph.sim.usd import EARLIEST, UsdGeom, UsdPhysics

from .contact_materials import bound_material, read_material
from .convex_decomposition import MOST_PIECES, convex_pieces, enclosed, with_depth
from .filters import Filters
from .mass_properties import read_mass
from .world_model import Collider, Volume

HULL_TOLERANCE = 1e-3
"""How far the hull of a stretched curved solid may lie inside it, as a fraction of its size."""

PLATE_THICKNESS = 0.05
"""A Plane with edges collides as a plate with this fraction of its shorter side as thickness; its upper face is the
plane.
"""

_TO_Z = {"X": [[0, 0, 1], [1, 0, 0], [0, 1, 0]], "Y": [[0, 1, 0], [0, 0, 1], [1, 0, 0]], "Z": np.eye(3)}
"""Rotations whose third column is the axis: they turn shapes along Z to lie along X or Y."""


def read_colliders(
    scan: Scan, filters: Filters, warn: Warn, known: Mapping[str, Sequence[Collider]]
) -> tuple[Collider, ...]:
    """All enabled colliders, each in the frame of its body if that can move, else in the world.

    filters: what keeps them apart. known: colliders of moving bodies with unchanged shapes and masses.
    """
    found: list[Collider] = []
    for path, prim in scan.colliders.items():
        if path not in known:
            found.extend(_Reader(scan, path, prim, filters, warn).read())
        elif known[path]:
            surface = {**_surface(scan, prim, warn), "mask": filters.masks.get(path, 0)}
            found.extend(replace(collider, **surface) for collider in known[path])
    return tuple(found)


class _Reader:
    """One collider prim with its frame: `frame` converts its own units to metres in its body's frame."""

    def __init__(self, scan: Scan, path: str, prim: Any, filters: Filters, warn: Warn) -> None:
        self.prim, self.path = prim, path
        self.body = scan.moving_body_of(path)
        self.falls = self.body is not None and not scan.bodies[self.body].kinematic
        self.warn = warn
        frame = scan.world_matrix(prim)
        frame[:3] *= scan.meters_per_unit
        if self.body is not None:
            frame = transforms.inverse_rigid(scan.body_pose(self.body)) @ frame
        self.frame = frame
        self.pose = transforms.rigid_part(frame) if np.isfinite(frame).all() else frame  # `read` reports what is wrong
        rest = (transforms.inverse_rigid(self.pose) @ frame)[:3, :3]
        self.scale = np.abs(np.diag(rest))
        self.sheared = bool(np.abs(rest - np.diag(np.diag(rest))).max() > 1e-9 * self.scale.max())
        self.common = {**_surface(scan, prim, warn), **self._mass(scan)}
        self.common["mask"] = filters.masks.get(self.path, 0)
        self.common["trigger"] = "PhysxTriggerAPI" in applied_schemas(prim)
        if self.body is None and filters.stills:
            self.common["still"] = _nearest(self.path, filters.stills)

    def read(self) -> list[Collider]:
        if not transforms.usable(self.frame):
            self.warn("bad-transform", self.path, "the collider's transform is flat or not finite; nothing hits it")
            return []
        kind = str(self.prim.GetTypeName())
        if self.prim.IsA(UsdGeom.Mesh):
            return self._mesh()
        if kind not in SOLIDS:
            self.warn(
                "bad-collider", self.path, f"a {kind or 'prim without type'} cannot be a collider; nothing hits it"
            )
            return []
        if any(not math.isfinite(self._number(name)) for name in SOLIDS[kind]):
            self._complain("its sizes are not all finite numbers; nothing hits it")
            return []
        return self._plane() if kind == "Plane" else self._solid(kind)

    def _mass(self, scan: Scan) -> dict[str, Any]:
        """The MassAPI of a collider that is not the body itself (a body reads its own)."""
        if not self.prim.HasAPI(UsdPhysics.MassAPI) or self.prim.HasAPI(UsdPhysics.RigidBodyAPI):
            return {}
        said = read_mass(self.prim, self.warn)
        unit, mass_unit = scan.meters_per_unit, kilograms_per_unit(scan.stage)
        out: dict[str, Any] = {}
        if said.density is not None:
            out["density"] = said.density * mass_unit / unit**3
        if said.mass is not None:
            out["mass"] = said.mass * mass_unit
        if said.center is not None:
            out["center"] = transforms.transformed(self.frame, said.center[None])[0]
        if said.inertia is not None:
            turn = self.pose[:3, :3]
            if said.axes is not None:
                turn = turn @ transforms.rotation_matrices(said.axes)
            out["tensor"] = turn @ np.diag(said.inertia * mass_unit * unit**2) @ turn.T
        return out

    def _make(self, kind: Any, pose: Floats, size: tuple[float, ...] = (), **more: Any) -> Collider:
        return Collider(self.path, self.body, kind, pose, size, **more, **self.common)

    def _number(self, name: str) -> float:
        return number_of(self.prim.GetAttribute(name))

    def _axis(self) -> str:
        return "XYZ"[int(axis_vector(str(self.prim.GetAttribute("axis").Get(EARLIEST))).argmax())]

    def _solid(self, kind: str) -> list[Collider]:
        sx, sy, sz = map(float, self.scale)
        if kind == "Cube" and not self.sheared:
            half = self._number("size") / 2
            return [self._make("box", self.pose, (half * sx, half * sy, half * sz))]
        if kind == "Sphere" and not self.sheared:
            radius = self._number("radius")
            if np.allclose(self.scale, sx, rtol=1e-6):
                return [self._make("sphere", self.pose, (radius * sx,))]
            return [self._make("ellipsoid", self.pose, (radius * sx, radius * sy, radius * sz))]
        if kind in ("Capsule", "Cylinder") and not self.sheared:
            axis = self._axis()
            along = float(self.scale["XYZ".index(axis)])
            across = np.delete(self.scale, "XYZ".index(axis))
            even = np.allclose(across, across[0], rtol=1e-6)
            if even and (kind == "Cylinder" or math.isclose(along, across[0], rel_tol=1e-6)):
                pose = self.pose.copy()
                pose[:3, :3] = pose[:3, :3] @ np.array(_TO_Z[axis], dtype=np.float64)
                size = (self._number("radius") * float(across[0]), self._number("height") / 2 * along)
                return [self._make(kind.lower(), pose, size)]
        shape = shape_of(self.prim, self._hull_tolerance(), self._complain)
        return [] if shape is None else [self._hull(*shape)]

    def _hull_tolerance(self) -> float:
        names = ("radius", "radiusBottom", "radiusTop", "size")
        return HULL_TOLERANCE * max(self._number(name) for name in names if self.prim.GetAttribute(name))

    def _plane(self) -> list[Collider]:
        axis = str(self.prim.GetAttribute("axis").Get(EARLIEST))
        normal = np.linalg.inv(self.frame[:3, :3]).T @ axis_vector(axis)
        pose = _facing(normal / np.linalg.norm(normal), self.frame[:3, 3])
        if endless(self.prim):
            if self.falls:
                self.warn("bad-collider", self.path, "an endless Plane cannot fall with a body; give it a width")
                return []
            return [self._make("plane", pose)]
        shape = shape_of(self.prim, 1.0, self._complain)
        if shape is None:
            return []
        corners = transforms.transformed(self.frame, shape[0])
        shorter = min(np.linalg.norm(corners[1] - corners[0]), np.linalg.norm(corners[3] - corners[0]))
        below = corners - pose[:3, 2] * shorter * PLATE_THICKNESS
        return [self._make("mesh", np.eye(4), vertices=np.concatenate([corners, below]))]

    def _mesh(self) -> list[Collider]:
        shape = shape_of(self.prim, 1.0, self._complain)
        if shape is None:
            return []
        approximation = "none"
        if self.prim.HasAPI(UsdPhysics.MeshCollisionAPI):
            approximation = str(UsdPhysics.MeshCollisionAPI(self.prim).GetApproximationAttr().Get(EARLIEST))
        vertices, triangles = shape
        used = vertices[np.unique(triangles)]
        if approximation == "boundingCube":
            return [self._bounding_box(used)]
        if approximation == "boundingSphere":
            points = transforms.transformed(self.frame, used)
            center = (points.min(axis=0) + points.max(axis=0)) / 2
            pose = transforms.rigid(np.eye(3), center)
            return [self._make("sphere", pose, (float(np.linalg.norm(points - center, axis=1).max()),))]
        moving = self.body is not None
        if approximation == "convexHull" or (moving and approximation in ("none", "meshSimplification")):
            return [self._hull(vertices, triangles)]
        return self._parts(vertices, triangles)

    def _bounding_box(self, points: Floats) -> Collider:
        low, high = points.min(axis=0), points.max(axis=0)
        corners = np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])])
        return self._make("mesh", np.eye(4), vertices=transforms.transformed(self.frame, corners))

    def _hull(self, vertices: Floats, triangles: Triangles) -> Collider:
        points = transforms.transformed(self.frame, vertices)
        used = with_depth(points[np.unique(triangles)], points, triangles)
        return self._make("mesh", np.eye(4), vertices=used)

    def _parts(self, vertices: Floats, triangles: Triangles) -> list[Collider]:
        """Each convex connected part; the faces of concave parts, or their hulls if there are too many.

        The mesh's mass follows from the volume it encloses, not from its pieces.
        """
        points = transforms.transformed(self.frame, vertices)
        if np.linalg.det(self.frame[:3, :3]) < 0:  # a mirrored transform turns faces inside out
            triangles = triangles[:, ::-1]
        shapes, hulls = convex_pieces(points, triangles)
        if hulls:
            self.warn(
                "concave-collider",
                self.path,
                f"{hulls} of its connected parts are not convex and take more than {MOST_PIECES} convex pieces; bodies "
                "hit their convex hulls, while rays see the true surface. Use a coarser mesh for collisions",
            )
        if len(shapes) == 1:
            return [self._make("mesh", np.eye(4), vertices=shapes[0])]
        weightless = Volume(0.0, np.zeros(3), np.zeros((3, 3)))
        whole = weightless if self.body is None else enclosed(points, triangles)
        if whole is None:
            common = dict(self.common)
            if common.get("mass") is not None:
                common["mass"] /= len(shapes)
            return [Collider(self.path, self.body, "mesh", np.eye(4), vertices=shape, **common) for shape in shapes]
        rest = {**self.common, "mass": None, "volume": weightless}
        heavy = {**self.common, "volume": whole}
        return [
            Collider(self.path, self.body, "mesh", np.eye(4), vertices=shape, **(rest if number else heavy))
            for number, shape in enumerate(shapes)
        ]

    def _complain(self, message: str) -> None:
        self.warn("bad-collider", self.path, message)


def _nearest(path: str, among: frozenset[str]) -> str:
    """The one of some prims that a path is, or is below; "" if none."""
    while path and path not in among:
        path = path.rpartition("/")[0]
    return path


def _facing(normal: Floats, origin: Floats) -> Floats:
    """A frame at `origin` whose Z is `normal`."""
    side = np.eye(3)[int(np.argmin(np.abs(normal)))]
    x = side - normal * (side @ normal)
    x /= np.linalg.norm(x)
    return transforms.rigid(np.stack([x, np.cross(normal, x), normal], axis=1), origin)


def _surface(scan: Scan, prim: Any, warn: Warn) -> dict[str, Any]:
    """The material of the bound physics material."""
    api = bound_material(prim)
    density = None if api is None else _density(scan, api.GetDensityAttr(), warn)
    return {"material": read_material(api, warn), "material_density": density}


def _density(scan: Scan, attribute: Any, warn: Warn) -> float | None:
    """The density of a material [kg/m3]; None without an authored one."""
    said, value = attribute.Get(EARLIEST) if attribute else None, authored(attribute)
    if said is not None and not 0 <= said < math.inf:
        name = attribute.GetName()
        warn("bad-material", str(attribute.GetPrimPath()), f"{name} is {said:g}, not a number from 0; it is not used")
    return None if value is None else value * kilograms_per_unit(scan.stage) / scan.meters_per_unit**3
