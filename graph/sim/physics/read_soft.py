"""Deformable prims: cloth, soft bodies and particles, by the schemas of PhysX and the proposed one of UsdPhysics."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graph.sim import transforms
from graph.sim.attributes import applied_schemas, array_of, first_target, kilograms_per_unit, value_of, vector
from graph.sim.geometry.polygons import usable_faces
from graph.sim.scene.scan import SOFT_ATTACHMENTS, Scan
from graph.sim.scene.stage import Warn
from graph.sim.transforms import Floats
from graph.sim.usd import UsdGeom, UsdShade

from .contact_materials import PLAIN, Material
from .world_model import DEFAULT_DENSITY, Soft

CLOTH = frozenset({"PhysxDeformableSurfaceAPI", "PhysxParticleClothAPI", "OmniPhysicsSurfaceDeformableSimAPI"})
SOLID = frozenset({"PhysxDeformableBodyAPI", "OmniPhysicsVolumeDeformableSimAPI"})
PARTICLES = frozenset({"PhysxParticleSetAPI"})

MOST_POINTS = 10_000
"""A prim with more points is left out: a step of it would take seconds."""

_SURFACE, _BODY, _OMNI = "physxDeformableSurfaceMaterial", "physxDeformableBodyMaterial", "omniphysics"


def read_softs(scan: Scan, warn: Warn) -> tuple[Soft, ...]:
    """Every enabled deformable prim that can be simulated."""
    held = _attachments(scan, warn) if scan.soft else {}
    return tuple(soft for prim in scan.soft if (soft := _soft(scan, prim, held.get(str(prim.GetPath()), []), warn)))


def _soft(scan: Scan, prim: Any, held: list[tuple[Any, ...]], warn: Warn) -> Soft | None:
    path = str(prim.GetPath())
    schemas = frozenset(applied_schemas(prim))
    for name in (
        "physxDeformable:deformableEnabled",
        "omniphysics:deformableBodyEnabled",
        "physxParticle:particleEnabled",
    ):
        if value_of(prim, name) is False:
            return None
    if schemas & PARTICLES and value_of(prim, "physxParticle:fluid"):
        warn("fluid-not-simulated", path, "fluids are not simulated; its particles stay where they are")
        return None
    points = array_of(UsdGeom.PointBased(prim).GetPointsAttr(), np.float64, 3)
    frame = scan.world_matrix(prim)
    frame[:3] *= scan.meters_per_unit
    if not len(points) or not np.isfinite(points).all() or not np.isfinite(frame).all():
        warn("bad-deformable", path, "it has no points, or they are not finite; it does not move")
        return None
    places = transforms.transformed(frame, points)
    if schemas & PARTICLES:
        return _particles(scan, prim, places, warn)
    triangles = _triangles(prim, points, warn) if schemas & CLOTH else None
    if triangles is not None:
        return _cloth(scan, prim, places, triangles, held, warn)
    return _solid(scan, prim, places, frame, held, warn)


def _triangles(prim: Any, points: Floats, warn: Warn) -> NDArray[np.intp]:
    mesh = UsdGeom.Mesh(prim)
    counts = array_of(mesh.GetFaceVertexCountsAttr(), np.int64)
    indices = array_of(mesh.GetFaceVertexIndicesAttr(), np.int64)
    complaints: list[str] = []
    faces = usable_faces(points, counts, indices, complaints.append)
    if len(faces.counts):  # without a remaining face the caller gives the one warning
        for said in complaints:
            warn("bad-deformable", str(prim.GetPath()), said)
    corners, out, first = faces.corners, [], 0
    for count in faces.counts.tolist():
        out += [[corners[first], corners[first + k], corners[first + k + 1]] for k in range(1, count - 1)]
        first += count
    return np.array(out, dtype=np.intp).reshape(-1, 3)


def _cloth(
    scan: Scan, prim: Any, places: Floats, triangles: NDArray[np.intp], held: list[tuple[Any, ...]], warn: Warn
) -> Soft | None:
    path = str(prim.GetPath())
    if len(triangles) == 0 or triangles.max() >= len(places) or triangles.min() < 0:
        warn("bad-deformable", path, "its faces do not fit its points; it does not move")
        return None
    unique, number = np.unique(places, axis=0, return_inverse=True)
    number = number.reshape(-1)
    elements = number[triangles]
    a, b, c = (unique[elements[:, k]] for k in range(3))
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
    elements, areas = elements[areas > 0], areas[areas > 0]
    said = _Said(scan, prim, warn)
    thickness = said.length((f"{_SURFACE}:thickness", f"{_OMNI}:surfaceThickness"), 0.001)
    density = said.density((f"{_SURFACE}:density", f"{_OMNI}:density", "physxPBDMaterial:density"))
    return _soft_of(
        said, unique, elements, areas * thickness * density, held, number[:, None], np.ones((len(places), 1)), thickness
    )


def _solid(
    scan: Scan, prim: Any, places: Floats, frame: Floats, held: list[tuple[Any, ...]], warn: Warn
) -> Soft | None:
    path = str(prim.GetPath())
    said = _Said(scan, prim, warn)
    if prim.GetTypeName() == "TetMesh":
        corners, tets = places, array_of(prim.GetAttribute("tetVertexIndices"), np.int64, 4)
    else:
        rest = array_of(prim.GetAttribute("physxDeformable:simulationRestPoints"), np.float64, 3)
        corners = transforms.transformed(frame, rest) if len(rest) else rest
        tets = array_of(prim.GetAttribute("physxDeformable:simulationIndices"), np.int64)
        tets = tets[: len(tets) // 4 * 4].reshape(-1, 4)
    if not len(tets) or not len(corners) or tets.max() >= len(corners) or tets.min() < 0:
        warn(
            "bad-deformable",
            path,
            "a soft body needs tetrahedra: a TetMesh, or physxDeformable:simulationRestPoints and :simulationIndices; "
            "it does not move",
        )
        return None
    used, tets = np.unique(tets, return_inverse=True)
    corners, tets = corners[used], tets.reshape(-1, 4)
    volumes = _volumes(corners, tets)
    tets[volumes < 0] = tets[volumes < 0][:, [0, 1, 3, 2]]
    volumes = np.abs(volumes)
    tets, volumes = tets[volumes > 0], volumes[volumes > 0]
    if not len(tets):
        warn("bad-deformable", path, "all its tetrahedra are flat; it does not move")
        return None
    density = said.density((f"{_BODY}:density", f"{_OMNI}:density"))
    inside, weights = _embedded(places, corners, tets)
    return _soft_of(said, corners, tets, volumes * density, held, inside, weights, 0.0)


def _volumes(corners: Floats, tets: NDArray[Any]) -> Floats:
    out: Floats = np.linalg.det(corners[tets[:, 1:]] - corners[tets[:, :1]]) / 6
    return out


def _embedded(points: Floats, corners: Floats, tets: NDArray[Any]) -> tuple[NDArray[np.intp], Floats]:
    """For each point, the tetrahedron that contains it or is closest to it, and the barycentric weights."""
    edges = np.linalg.inv(np.swapaxes(corners[tets[:, 1:]] - corners[tets[:, :1]], 1, 2))
    inside, weights = np.empty((len(points), 4), dtype=np.intp), np.empty((len(points), 4))
    for number, point in enumerate(points):
        local = np.einsum("tij,tj->ti", edges, point - corners[tets[:, 0]])
        all_four = np.concatenate([1 - local.sum(axis=1, keepdims=True), local], axis=1)
        best = int(np.argmax(all_four.min(axis=1)))
        inside[number], weights[number] = tets[best], all_four[best]
    return inside, weights


def _particles(scan: Scan, prim: Any, places: Floats, warn: Warn) -> Soft | None:
    said = _Said(scan, prim, warn)
    widths = array_of(prim.GetAttribute("widths"), np.float64)
    radius = float(np.median(widths)) / 2 * scan.meters_per_unit if len(widths) else 0.05
    if not radius > 0:
        warn("bad-deformable", said.path, "its particles have no size; they do not move")
        return None
    density = said.density(("physxPBDMaterial:density",))
    mass = density * 4 / 3 * math.pi * radius**3
    count = len(places)
    if count > MOST_POINTS:
        said.too_many(count)
        return None
    total = said.mass()
    masses = np.full(count, mass if total is None else total / count)
    return Soft(
        said.path,
        places,
        masses,
        None,
        radius,
        material=said.surface(),
        corners=np.arange(count)[:, None],
        weights=np.ones((count, 1)),
    )


def _soft_of(
    said: _Said,
    places: Floats,
    elements: NDArray[np.intp],
    masses: Floats,
    held: list[tuple[Any, ...]],
    corners: NDArray[np.intp],
    weights: Floats,
    thickness: float,
) -> Soft | None:
    """masses: (m,) of the elements, distributed equally to their points."""
    if len(places) > MOST_POINTS:
        said.too_many(len(places))
        return None
    width = elements.shape[1]
    shares: Floats = np.zeros(len(places))
    np.add.at(shares, elements.ravel(), np.repeat(masses / width, width))
    total = said.mass()
    if total is not None:
        shares *= total / shares.sum()
    pinned = _pinned(places, corners, held)
    loose = np.flatnonzero(shares == 0)
    pinned.update({int(number): (None, places[number]) for number in loose if int(number) not in pinned})
    edges = np.concatenate([elements[:, (k, (k + 1) % width)] for k in range(width)])
    length = float(np.linalg.norm(places[edges[:, 0]] - places[edges[:, 1]], axis=1).mean())
    kind = _SURFACE if width == 3 else _BODY
    return Soft(
        said.path,
        places,
        shares,
        elements,
        radius=max(thickness / 2, 0.05 * length),
        young=said.pressure((f"{kind}:youngsModulus", f"{_OMNI}:youngsModulus"), 5e5),
        poisson=min(
            said.number((f"{kind}:poissonsRatio", f"{_OMNI}:poissonsRatio"), 0.45 if width == 4 else 0.3), 0.49
        ),
        damping=said.number((f"{kind}:elasticityDamping", f"{_OMNI}:elasticityDamping"), 0.005),
        thickness=thickness,
        self_collides=bool(
            value_of(said.prim, "physxDeformable:selfCollision") or value_of(said.prim, "physxParticle:selfCollision")
        ),
        material=said.surface(),
        velocity=said.velocity(),
        held=pinned,
        corners=corners.astype(np.intp),
        weights=weights,
    )


def _pinned(
    places: Floats, corners: NDArray[np.intp], held: list[tuple[Any, ...]]
) -> dict[int, tuple[str | None, Floats]]:
    out: dict[int, tuple[str | None, Floats]] = {}
    for numbers, spots, body, back in held:
        points = [int(corners[number, 0]) for number in numbers if 0 <= number < len(corners)]
        points += [int(np.argmin(((places - spot) ** 2).sum(axis=1))) for spot in spots]
        for point in points:
            out[point] = body, transforms.transformed(back, places[point][None])[0]
    return out


def _attachments(scan: Scan, warn: Warn) -> dict[str, list[tuple[Any, ...]]]:
    """The attachments of each deformable prim: numbers of its points, positions in the world, the body, and the
    transform into it.
    """
    out: dict[str, list[tuple[Any, ...]]] = {}
    for prim in scan.stage.Traverse():
        if prim.GetTypeName() not in SOFT_ATTACHMENTS:
            continue
        path = str(prim.GetPath())
        names = (
            ("actor0", "actor1")
            if prim.GetTypeName() == SOFT_ATTACHMENTS[0]
            else ("omniphysics:src0", "omniphysics:src1")
        )
        ends = [first_target(prim.GetRelationship(name)) for name in names]
        soft = scan.stage.GetPrimAtPath(ends[0]) if ends[0] else None
        if not soft:
            warn("bad-attachment", path, f"{names[0]} names no prim; it holds nothing")
            continue
        body = scan.moving_body_of(ends[1]) if ends[1] else None
        back = np.eye(4) if body is None else transforms.inverse_rigid(scan.body_pose(body))
        numbers = array_of(prim.GetAttribute("omniphysics:vtxIndicesSrc0"), np.int64).tolist()
        local = array_of(prim.GetAttribute("points0"), np.float64, 3)
        frame = scan.world_matrix(soft)
        frame[:3] *= scan.meters_per_unit
        spots = list(transforms.transformed(frame, local)) if len(local) else []
        if not numbers and not spots:
            warn("bad-attachment", path, "it names no points (points0 or omniphysics:vtxIndicesSrc0); it holds nothing")
            continue
        out.setdefault(ends[0], []).append((numbers, spots, body, back))
    return out


class _Said:
    """The authored data of a deformable prim and its physics material, in SI units."""

    def __init__(self, scan: Scan, prim: Any, warn: Warn) -> None:
        self.prim, self.path, self._warn = prim, str(prim.GetPath()), warn
        self._unit, self._mass = scan.meters_per_unit, kilograms_per_unit(scan.stage)
        material, _ = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial("physics")
        self._prims = [prim, *([material.GetPrim()] if material else [])]

    def too_many(self, count: int) -> None:
        """Warns that the prim is too large."""
        self._warn("bad-deformable", self.path, f"{count} points are more than {MOST_POINTS}; it does not move")

    def number(self, names: tuple[str, ...], default: float) -> float:
        """The first authored number above 0, or 0."""
        for prim in self._prims:
            for name in names:
                if (value := self._number(prim, name)) is not None:
                    return value
        return default

    def _number(self, prim: Any, name: str) -> float | None:
        value = value_of(prim, name)
        if value is None or (math.isfinite(value) and value >= 0):
            return None if value is None else float(value)
        self._warn("bad-deformable", self.path, f"{name} is {value:g}, not a number from 0; it counts as not written")
        return None

    def length(self, names: tuple[str, ...], default: float) -> float:
        value = self.number(names, 0.0)
        return value * self._unit if value > 0 else default

    def pressure(self, names: tuple[str, ...], default: float) -> float:
        value = self.number(names, 0.0)
        return value * self._mass / self._unit if value > 0 else default

    def density(self, names: tuple[str, ...]) -> float:
        value = self._number(self.prim, "physics:density") or self.number(names, 0.0)
        return value * self._mass / self._unit**3 if value > 0 else DEFAULT_DENSITY

    def mass(self) -> float | None:
        value = self._number(self.prim, "physics:mass") or None
        if value is None:
            value = self.number((f"{_OMNI}:mass",), 0.0) or None
        return None if value is None else value * self._mass

    def velocity(self) -> Floats:
        found = vector(self.prim.GetAttribute("physics:velocity"))
        return np.zeros(3) if found is None else found * self._unit

    def surface(self) -> Material:
        names = [f"{kind}:dynamicFriction" for kind in (_SURFACE, _BODY, _OMNI)]
        names += ["physxPBDMaterial:friction", "physics:dynamicFriction"]
        friction = self.number(tuple(names), PLAIN.sliding)
        return Material(static=friction, sliding=friction)
