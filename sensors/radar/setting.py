"""What the waves of a radar travel in: the faces that they may meet, in one state of the world."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from graph.sim.geometry.surfaces import Mesh
from sensors.compiled import inlined
from sensors.raycast.rays import NO_SURFACE, Hits, RayBundle
from sensors.raycast.world import CastWorld
from sensors.vectors import Vector, dot, row_of, times

from .antenna import Antenna
from .images import Twists
from .materials import Reflections, Tables
from .planes import WorldPlanes, planes_of


class Faces(NamedTuple):
    """What waves may meet: planes, after them single hits of what deforms, last nothing, which `NO_PLANE` finds.

    normal: (f, 3) float64 and offset: (f,) [m], n . x = offset in the axes of their bodies; table: (f,) int32, their
    first places in the reflection tables; surface: (f,) int32, and curved: (f,) bool, of planes, else `NO_SURFACE` and
    False; body: (f,) int64, whose each is. Of bodies turn: (b, 3, 3) to the sensor's axes, place: (b, 3) [m] of the
    radar in theirs; linear, angular: (b, 3), twists (`Twists`). planes: how many of them are.
    """

    normal: np.ndarray
    offset: np.ndarray
    table: np.ndarray
    surface: np.ndarray
    curved: np.ndarray
    body: np.ndarray
    turn: np.ndarray
    place: np.ndarray
    linear: np.ndarray
    angular: np.ndarray
    planes: int

    def seen(self, face: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Normals (k, 3) of faces, by number, in the sensor's axes, and heights (k,) [m] of the radar under them."""
        normal, body = self.normal[face], self.body[face]
        height = self.offset[face] - np.einsum("ki,ki->k", normal, self.place[body])
        return np.einsum("kij,kj->ki", self.turn[body], normal), height


@inlined
def normal_of(faces: Faces, face: Any) -> Vector:
    """The normal of a face, in the sensor's axes."""
    return times(faces.turn, faces.body[face], row_of(faces.normal, face))


@inlined
def height_of(faces: Faces, face: Any) -> Any:
    """How far a face is from the radar along its normal [m]."""
    return faces.offset[face] - dot(row_of(faces.normal, face), row_of(faces.place, faces.body[face]))


class Scenery:
    """What waves of one length may meet, as far as it does not change: planes, what they reflect, and their curves.

    materials: (n,) encoded ones, of every surface. table: (p + 1,) int32, the first places of planes in the reflection
    tables.
    """

    def __init__(self, world: CastWorld, materials: np.ndarray, wavelength: float) -> None:
        self.planes = planes_of(world)
        self.reflections = Reflections(materials, wavelength)
        self.table = self.reflections.of_surfaces(self.planes.surface)
        self.table[-1] = 0
        self.curves = self.planes.curves(wavelength)


class Space(NamedTuple):
    """What loops over waves look up.

    keys: of planes (`WorldPlanes`). rotation: (3, 3) sensor to world. longest: way [m] on which a face is met; seen:
    farthest [m] that counts. received: power of 4 m^2 at 1 m [W m^2]. wavelength: [m]. scale: field at 1 m of a solid
    angle of 1 sr [sqrt(W) m].
    """

    faces: Faces
    tables: Tables
    keys: np.ndarray
    rotation: np.ndarray
    longest: float
    seen: float
    received: float
    wavelength: float
    scale: float


@dataclass(slots=True)
class Setting:
    """What waves travel in, in one state.

    bodies: (b, 4, 4) float64, poses of the bodies [m]. pose: (4, 4) float64 sensor to world [m]. poses: the state, for
    the caster (None: now). reach: farthest range [m]. bounces: most faces on a way. exclude: prims that are not there.
    twists: of the bodies, world axes.

    Derived: faces; speeds: the twists in the sensor's axes; deforms: whether any surface does; spots: whether hits need
    theirs.
    """

    world: CastWorld
    scenery: Scenery
    bodies: np.ndarray
    twists: Twists
    antenna: Antenna
    reach: float
    bounces: int
    pose: np.ndarray
    poses: Any = None
    exclude: frozenset[str] = frozenset()
    faces: Faces = field(init=False)
    speeds: Twists = field(init=False)
    deforms: bool = field(init=False)
    spots: bool = field(init=False)

    def __post_init__(self) -> None:
        planes = self.planes
        self.speeds = self.twists.seen_from(self.rotation)
        all_of_them = np.concatenate((self.bodies, np.eye(4)[None]))  # the last for what stands still
        rotation = all_of_them[:, :3, :3]
        self.faces = Faces(
            *(planes.normal, planes.offset, self.scenery.table, planes.surface, planes.curved, planes.body),
            np.einsum("ji,bjk->bik", self.rotation, rotation),
            np.einsum("bji,bj->bi", rotation, self.pose[:3, 3] - all_of_them[:, :3, 3]),
            *(self.speeds.linear, self.speeds.angular, len(planes.patch)),
        )
        self.deforms = bool(self.world.deforming.any())
        self.spots = self.deforms or bool(len(planes.bodies_seen(self.exclude)))

    @property
    def planes(self) -> WorldPlanes:
        """The planes of the world."""
        return self.scenery.planes

    @property
    def seen(self) -> float:
        """Beyond this distance from the radar [m] nothing counts: a way there and back is longer than its range."""
        return self.reach * 1.01

    @property
    def rotation(self) -> np.ndarray:
        """(3, 3) sensor to world."""
        return np.ascontiguousarray(self.pose[:3, :3])

    def cast(self, bundle: RayBundle) -> Hits:
        """What rays meet."""
        return self.world.cast(bundle, self.poses, normals=self.deforms, spots=self.spots)

    def space(self, faces: Faces) -> Space:
        """What loops over waves that may meet these faces look up."""
        antenna = self.antenna
        return Space(
            *(faces, self.scenery.reflections.tables, self.planes.key, self.rotation, 2.0 * self.reach, self.seen),
            *(4.0 * antenna.receives, antenna.wavelength, math.sqrt(antenna.power) / (4.0 * math.pi)),
        )


def with_hits(
    setting: Setting, plane: np.ndarray, hits: Hits, row: np.ndarray, single: np.ndarray, point: np.ndarray
) -> tuple[np.ndarray, Faces]:
    """The faces (k,) that are met, of planes (k,), where the rows `single` (m,) are faces of their own: the hits `row`
    (m,), at places (m, 3) [m] from the radar.
    """
    assert hits.normals is not None
    faces = setting.faces
    normal = np.einsum("ki,ij->kj", hits.normals[row], setting.rotation)
    surface = hits.surfaces(row)
    within = np.einsum("ki,ij->kj", speeds_within(setting, surface, hits, row), setting.rotation)
    order, plane = np.arange(len(row)), plane.copy()
    plane[single] = faces.planes + order
    return plane, Faces(
        _before_last(faces.normal, normal),
        _before_last(faces.offset, (normal * point).sum(axis=1)),
        _before_last(faces.table, setting.scenery.reflections.of_surfaces(surface)),
        _before_last(faces.surface, np.full(len(row), NO_SURFACE)),
        _before_last(faces.curved, np.zeros(len(row))),
        _before_last(faces.body, len(faces.linear) - 1 + order),
        _before_last(faces.turn, np.tile(np.eye(3), (len(row), 1, 1))),
        _before_last(faces.place, np.zeros((len(row), 3))),
        _before_last(faces.linear, faces.linear[-1] + within),
        _before_last(faces.angular, np.tile(faces.angular[-1], (len(row), 1))),
        faces.planes,
    )


def _before_last(array: np.ndarray, more: np.ndarray) -> np.ndarray:
    return np.concatenate((array[:-1], more.astype(array.dtype), array[-1:]))


def speeds_within(setting: Setting, surface: np.ndarray, hits: Hits, row: np.ndarray) -> np.ndarray:
    """Velocities (k, 3) of points on meshes that deform, from those of the triangles' corners; in the world's axes."""
    assert hits.spots is not None
    found = np.zeros((len(row), 3))
    for number in np.unique(surface).tolist():
        some = np.flatnonzero(surface == number)
        mesh, spot = setting.world.surfaces[number], hits.spots
        assert isinstance(mesh, Mesh)
        corners = np.asarray(mesh.triangles)[spot.triangle[row[some]]]
        second, third = spot.uv[row[some]].T.astype(np.float64)
        velocities = setting.world.vertex_velocities(number, setting.poses)[corners]
        shares = np.stack((1.0 - second - third, second, third), 1)
        found[some] = np.einsum("kc,kcj->kj", shares, velocities)
    return found
