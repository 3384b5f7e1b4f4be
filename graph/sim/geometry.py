"""What rays can hit: the stage's visible surfaces as triangles, static ones apart from those that move."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from . import transforms
from .scan import Scan, scan_stage
from .shapes import Shape, shape_of
from .stage import Warn, ignore_warning
from .tessellation import Triangles, axis_vector
from .transforms import Floats
from .usd import EARLIEST, Usd, UsdGeom, UsdShade

GRID = 1e-9
"""Vertices of moving meshes lie on this grid [m], so that copies of one mesh are equal to the last bit."""


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles of one prim (or of one instance of it).

    vertices: (n, 3) float64 [m]; in the world if `body` is None, else in the rigid frame of that body (its pose without
    scale: `Fabric.rigid_matrices`). triangles: (m, 3) uint32, normals facing out. material: path of the bound one.
    """

    path: str
    body: str | None
    vertices: Floats
    triangles: Triangles
    material: str | None = None

    @cached_property
    def unique_key(self) -> bytes:
        """Equal for meshes with equal vertices and triangles: one ray-casting scene serves them all."""
        digest = hashlib.blake2b(self.vertices.tobytes(), digest_size=16)
        digest.update(self.triangles.tobytes())
        return digest.digest()


@dataclass(frozen=True, eq=False)
class Plane:
    """An endless plane: a point on it [m] and its unit normal, in the world or the rigid frame of `body`."""

    path: str
    body: str | None
    origin: Floats
    normal: Floats
    material: str | None = None


@dataclass
class _Collector:
    scan: Scan
    tolerance: float
    warn: Warn
    shapes: dict[tuple[str, float], Shape | None] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.body_inverse: dict[str, Floats] = {}

    def to_frame(self, world: Floats, body: str | None) -> Floats:
        """Prim to world in stage units, to: prim to its body's rigid frame (or the world) in metres."""
        out = world.copy()
        out[:3] *= self.scan.meters_per_unit
        if body is None:
            return out
        if body not in self.body_inverse:
            self.body_inverse[body] = transforms.inverse_rigid(self.scan.body_pose(body))
        local: Floats = np.round(self.body_inverse[body] @ out, 12)
        return local

    def collect(self, prim: Any, path: str, body: str | None, world: Floats) -> Mesh | Plane | None:
        if not transforms.usable(world):
            self.warn("bad-transform", path, "its transform is flat or not finite; rays do not see it.")
            return None
        frame = self.to_frame(world, body)
        if prim.IsA(UsdGeom.Plane) and endless(prim):
            axis = axis_vector(str(UsdGeom.Plane(prim).GetAxisAttr().Get(EARLIEST)))
            normal = np.linalg.inv(frame[:3, :3]).T @ axis
            return Plane(path, body, frame[:3, 3].copy(), normal / np.linalg.norm(normal))
        shape = self._shape(prim, path, float(np.linalg.norm(frame[:3, :3], ord=2)))
        if shape is None:
            return None
        vertices, triangles = shape
        if np.linalg.det(frame[:3, :3]) < 0:
            triangles = np.ascontiguousarray(triangles[:, ::-1])
        vertices = transforms.transformed(frame, vertices)
        if body is not None:
            vertices = np.round(vertices / GRID) * GRID + 0.0  # which also makes -0.0 and 0.0 equal in their bytes
        return Mesh(path, body, vertices, triangles)

    def _shape(self, prim: Any, path: str, scale: float) -> Shape | None:
        """The prim's own triangles; instances of one prototype share them."""
        source = prim.GetPrimInPrototype() if prim.IsInstanceProxy() else prim
        key = (str(source.GetPath()), 0.0 if prim.IsA(UsdGeom.Mesh) else scale)
        if key not in self.shapes:
            self.shapes[key] = shape_of(
                prim, self.tolerance / scale, lambda message: self.warn("bad-geometry", path, message)
            )
        return self.shapes[key]


def collect_geometry(
    stage: Any, tolerance: float, warn: Warn = ignore_warning, scan: Scan | None = None
) -> tuple[Mesh | Plane, ...]:
    """Every visible surface of the stage, in stage order.

    tolerance: how far the triangles of curved solids may lie inside them [m], `mesh.tolerance`. Invisible prims and
    those for guides and proxies are left out. `warn` gets `bad-geometry` and `bad-transform` for what cannot be cast.
    """
    scan = scan or scan_stage(stage)
    collector = _Collector(scan, tolerance, warn)
    found = []
    for prim, path, body, world in _visible(scan, warn):
        part = collector.collect(prim, path, body, world)
        if part is not None:
            found.append((part, prim))
    return _with_materials(found)


def endless(plane: Any) -> bool:
    """Whether a Plane has no authored width or length: it then has no edge."""
    schema = UsdGeom.Plane(plane)
    return not (schema.GetWidthAttr().HasAuthoredValue() or schema.GetLengthAttr().HasAuthoredValue())


def _visible(scan: Scan, warn: Warn) -> Iterator[tuple[Any, str, str | None, Floats]]:
    """Each visible gprim with its path, moving body and world matrix; prims of point instancers once per point."""
    walk = iter(Usd.PrimRange.Stage(scan.stage, Usd.TraverseInstanceProxies()))
    for prim in walk:
        if _hidden(prim):
            walk.PruneChildren()
            continue
        path = str(prim.GetPath())
        if prim.IsA(UsdGeom.PointInstancer):
            walk.PruneChildren()
            yield from _instances(scan, prim, path, warn)
        elif _castable(prim):
            yield prim, path, scan.moving_body_of(path), scan.world_matrix(prim)


def _hidden(prim: Any) -> bool:
    if not prim.IsA(UsdGeom.Imageable):
        return False
    visibility = UsdGeom.Imageable(prim).GetVisibilityAttr()
    return bool(visibility.HasAuthoredValue() and visibility.Get(EARLIEST) == UsdGeom.Tokens.invisible)


def _castable(prim: Any) -> bool:
    if not prim.IsA(UsdGeom.Gprim):
        return False
    return UsdGeom.Imageable(prim).ComputePurpose() in (UsdGeom.Tokens.default_, UsdGeom.Tokens.render)


def _instances(scan: Scan, prim: Any, path: str, warn: Warn) -> Iterator[tuple[Any, str, str | None, Floats]]:
    instancer = UsdGeom.PointInstancer(prim)
    prototypes = instancer.GetPrototypesRel().GetForwardedTargets()
    which = np.asarray(instancer.GetProtoIndicesAttr().Get(EARLIEST) or (), dtype=np.int64)
    options = UsdGeom.PointInstancer.IncludeProtoXform, UsdGeom.PointInstancer.IgnoreMask
    matrices = instancer.ComputeInstanceTransformsAtTime(EARLIEST, EARLIEST, *options)
    mask = np.asarray(instancer.ComputeMaskAtTime(EARLIEST) or (), dtype=bool)
    if len(matrices) != len(which) or (which < 0).any() or (which >= len(prototypes)).any():
        warn("bad-geometry", path, "its prototypes, indices and positions do not fit together; rays do not see it.")
        return
    parts = [list(_parts(scan, target)) for target in prototypes]
    base, body = scan.world_matrix(prim), scan.moving_body_of(path)
    for number, (prototype, matrix) in enumerate(zip(which, matrices, strict=True)):
        if len(mask) and not mask[number]:
            continue
        placed = base @ transforms.from_usd(matrix)
        for part, local in parts[prototype]:
            yield part, f"{path}[{number}]", body, placed @ local


def _parts(scan: Scan, root: Any) -> Iterator[tuple[Any, Floats]]:
    """The gprims of a prototype, each with its matrix to the prototype's root."""
    prim = scan.stage.GetPrimAtPath(root)
    if not prim:
        return
    inverse = np.linalg.inv(scan.world_matrix(prim))
    walk = iter(Usd.PrimRange(prim, Usd.TraverseInstanceProxies()))
    for part in walk:
        if _hidden(part):
            walk.PruneChildren()
        elif _castable(part):
            yield part, inverse @ scan.world_matrix(part)


def _with_materials(found: list[tuple[Mesh | Plane, Any]]) -> tuple[Mesh | Plane, ...]:
    """Note the material bound to each part."""
    if not found:
        return ()
    bound, _ = UsdShade.MaterialBindingAPI.ComputeBoundMaterials([prim for _, prim in found])
    return tuple(
        replace(part, material=str(material.GetPath())) if material else part
        for (part, _), material in zip(found, bound, strict=True)
    )
