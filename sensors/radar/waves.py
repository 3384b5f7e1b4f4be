"""Rays of a radar on their way: the faces they meet, one after the other.

Each ray is a tube that fills a solid angle. Where it goes is worked out in float64 on the planes of the faces: float32
hits are off by more than the phase of a millimetre wave allows. Flat faces reflect tubes as mirrors do; curved and
rough ones end them. After mirrors a ray goes on as if it came from the radar's image in them, so that the length of its
way is that to one plane.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np

from graph.sim.geometry.surfaces import Mesh
from sensors.compiled import compiled
from sensors.raycast.rays import NO_SURFACE, NOTHING, Hits, RayBundle
from sensors.raycast.world import CastWorld

from .antenna import Antenna
from .grouping import Groups
from .images import Images, Twists, plane_keys
from .materials import STEPS, Reflections
from .planes import NO_PLANE, WorldPlanes
from .rays import Tubes

GRAZING = 1e-6
"""Cosine of incidence below which a face is not met."""

FAINTEST = 0.02
"""Amplitude, of what was sent, below which a wave is not followed."""

LIFT_M = 2e-4
"""Reflected rays start so high above the face that they leave."""

SIGHT_M = 5e-3
"""A point is in sight if a ray to it comes so near."""


class Faces(NamedTuple):
    """What waves may meet: planes, after them single hits of what deforms, last nothing, which `NO_PLANE` finds.

    normal: (f, 3) float64, in the sensor's axes; height: (f,) float64 [m] of the radar over them; table: (f,) int32,
    their first places in the reflection tables; surface: (f,) int32, and curved: (f,) bool, of planes, else
    `NO_SURFACE` and False; linear, angular: (b, 3) float64, twists of bodies (`Twists`), and body: (f,) int64, whose
    each has. planes: how many of them are.
    """

    normal: np.ndarray
    height: np.ndarray
    table: np.ndarray
    surface: np.ndarray
    curved: np.ndarray
    body: np.ndarray
    linear: np.ndarray
    angular: np.ndarray
    planes: int


@dataclass(slots=True)
class Setting:
    """What waves travel in, in one state.

    pose: (4, 4) float64 sensor to world [m]. poses: the state, for the caster (None: now). reach: farthest range [m].
    bounces: most faces on a way. exclude: prims that are not there. twists: of the bodies, world axes.

    Derived: faces; keys: (p + 1,) of the planes' patches (`plane_keys`), the last for no plane; speeds: the twists in
    the sensor's axes; deforms: whether any surface does; spots: whether hits need theirs.
    """

    world: CastWorld
    planes: WorldPlanes
    reflections: Reflections
    twists: Twists
    antenna: Antenna
    reach: float
    bounces: int
    pose: np.ndarray
    poses: Any = None
    exclude: frozenset[str] = frozenset()
    faces: Faces = field(init=False)
    keys: np.ndarray = field(init=False)
    speeds: Twists = field(init=False)
    deforms: bool = field(init=False)
    spots: bool = field(init=False)

    def __post_init__(self) -> None:
        planes = self.planes
        self.speeds = self.twists.seen_from(self.rotation)
        self.faces = Faces(
            np.concatenate((planes.normal @ self.rotation, np.zeros((1, 3)))),
            np.append(planes.offset - planes.normal @ self.pose[:3, 3], 0.0),
            np.append(self.reflections.of_surfaces(planes.surface), np.int32(0)),
            np.append(planes.surface, np.int32(NO_SURFACE)),
            np.append(planes.curved, False),
            planes.body,
            self.speeds.linear,
            self.speeds.angular,
            len(planes.normal),
        )
        self.keys = np.append(plane_keys(planes.patch), np.uint64(0))
        self.deforms = bool(self.world.deforming.any())
        self.spots = self.deforms or bool(len(planes.bodies_seen(self.exclude)))

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


WAVE = np.dtype(
    [
        ("row", np.int64),
        ("direction", np.float64, 3),
        ("travelled", np.float64),
        ("field", np.complex64),
        ("wide", np.float32),
    ],
    align=True,
)
"""A tube before a stretch of its way. row: its number. direction: of the stretch, in the sensor's axes. travelled: [m].
field: what the faces left of it. wide: how many tubes across, and up, it stands for.
"""

MET = np.dtype(
    [
        ("wave", np.int64),
        ("face", np.int64),
        ("back", np.float64, 3),
        *((name, np.float64) for name in ("way", "out", "slope", "rise", "coming", "going")),
        ("cosine", np.float32),
        ("table", np.int32),
    ],
    align=True,
)
"""A face that a wave meets. wave, face: their numbers. back: unit from the radar to it, out: [m] of that. way: [m] in
all. slope, rise: components of the face's normal along the wave and along `back`. coming, going: rates [m/s] of the
ways in and straight back. cosine: of incidence. table: place in the reflection tables.
"""


@dataclass(slots=True)
class Waves:
    """Waves (k,) of `WAVE` before the face of that number, from 1 on.

    image: (k,) int32, number of the radar's image among `images` that each comes from.
    """

    bounce: int
    images: Images
    image: np.ndarray
    each: np.ndarray


@dataclass(slots=True)
class Met:
    """What some waves meet: (k,) of `MET`, of these waves and faces."""

    waves: Waves
    faces: Faces
    each: np.ndarray

    def __len__(self) -> int:
        return len(self.each)

    def at(self, rows: np.ndarray) -> Met:
        """Some of them."""
        return replace(self, each=self.each.take(rows))

    @property
    def wave(self) -> np.ndarray:
        """Their waves, (k,) of `WAVE`."""
        return self.waves.each.take(self.each["wave"])

    @property
    def plane(self) -> np.ndarray:
        """The planes (k,) that they meet, `NO_PLANE` for single hits."""
        face = self.each["face"]
        return np.where(face < self.faces.planes, face, NO_PLANE)


@dataclass(slots=True)
class Sent:
    """Waves that flat faces send on, (k,) of `WAVE`.

    mirror: (k,) int64, the number of the last image x planes + the plane; rays: (k, 6), offsets: (k, 3) float32, as
    those of a `RayBundle`.
    """

    waves: np.ndarray
    mirror: np.ndarray
    rays: np.ndarray
    offsets: np.ndarray


def next_waves(setting: Setting, before: Waves, parts: list[Sent]) -> tuple[Waves, Hits, np.ndarray]:
    """Waves after a reflection, what they meet, and the rows (k,) of those that meet anything; before: any of the last,
    with their images.
    """
    each = np.concatenate([sent.waves.view(np.uint8) for sent in parts]).view(WAVE)  # as bytes: records take long
    mirror, rays, offsets = (
        np.concatenate([getattr(sent, name) for sent in parts]) for name in ("mirror", "rays", "offsets")
    )
    hits = setting.cast(RayBundle(setting.pose[:3, 3], rays, offsets, setting.exclude, setting.seen))
    planes, faces, groups = setting.planes, setting.faces, Groups(mirror)
    image, plane = np.divmod(groups.keys, faces.planes)
    speeds = setting.speeds, planes.body[plane]
    images = before.images.beyond(image, faces.normal[plane], faces.height[plane], planes.patch[plane], speeds)
    rows = np.flatnonzero(hits.distance < 2.0 * setting.reach - each["travelled"])
    return Waves(before.bounce + 1, images, groups.which, each), hits, rows


def in_sight(setting: Setting, out: np.ndarray, rays: np.ndarray) -> np.ndarray:
    """Whether the radar sees points at distances (k,) [m] along rays (k, 6) from it."""
    bundle = RayBundle(setting.pose[:3, 3], rays, exclude=setting.exclude, reach=setting.seen)
    hits = setting.world.cast(bundle, setting.poses)
    return np.asarray(hits.distance > out * (1 - 1e-6) - SIGHT_M)


def meet(setting: Setting, waves: Waves, rows: np.ndarray, hits: Hits, hit: np.ndarray, plane: np.ndarray) -> Met:
    """The faces that the waves `rows` (k,) meet; hit: (k,) their hits, plane: (k,) of these."""
    faces, images, face = setting.faces, waves.images, plane
    if setting.deforms:
        single = np.flatnonzero((plane == NO_PLANE) & (hits.number[hit] != NOTHING))
        some = waves.each[rows[single]]
        length = hits.distance[hit[single]] + some["travelled"]
        point = images.place[waves.image[rows[single]]] + some["direction"] * length[:, None]
        face, faces = with_hits(setting, plane, hits, hit[single], single, point)
    met = np.empty(len(rows), MET)
    count = _meet(
        faces, images.place, images.rate, waves.image, waves.each, rows, face, STEPS, 2.0 * setting.reach, met
    )
    return Met(waves, faces, met[:count])


def with_hits(
    setting: Setting, plane: np.ndarray, hits: Hits, row: np.ndarray, single: np.ndarray, point: np.ndarray
) -> tuple[np.ndarray, Faces]:
    """The faces (k,) that are met, of planes (k,), where the rows `single` (m,) are faces of their own: the hits `row`
    (m,), at places (m, 3) [m] from the radar.
    """
    assert hits.normals is not None
    faces = setting.faces
    normal = hits.normals[row] @ setting.rotation
    surface = hits.surfaces(row)
    within = speeds_within(setting, surface, hits, row) @ setting.rotation
    order, plane = np.arange(len(row)), plane.copy()
    plane[single] = faces.planes + order
    return plane, Faces(
        _before_last(faces.normal, normal),
        _before_last(faces.height, (normal * point).sum(axis=1)),
        _before_last(faces.table, setting.reflections.of_surfaces(surface)),
        _before_last(faces.surface, np.full(len(row), NO_SURFACE)),
        _before_last(faces.curved, np.zeros(len(row))),
        _before_last(faces.body, len(faces.linear) - 1 + order),
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


def reflected(setting: Setting, tubes: Tubes, met: Met, rows: np.ndarray) -> Sent:
    """What flat faces send on, as far as it is not too faint; rows: (m,) of those that may."""
    count, waves = len(rows), met.waves
    sent, mirror = np.empty(count, WAVE), np.empty(count, np.int64)
    rays, offsets = np.empty((count, 6), np.float32), np.empty((count, 3), np.float32)
    tables = tubes.wide, setting.reflections.tables.amplitude, setting.faces.curved, setting.rotation
    count = _reflect(met.faces, waves.image, waves.each, met.each, rows, *tables, sent, mirror, rays, offsets)
    return Sent(sent[:count], mirror[:count], rays[:count], offsets[:count])


@compiled
def _row(table: Any, number: Any) -> Any:
    """A vector of a table (n, 3); a part of the array would be counted as a reference."""
    return table[number, 0], table[number, 1], table[number, 2]


@compiled
def _dot(one: Any, two: Any) -> Any:
    return one[0] * two[0] + one[1] * two[1] + one[2] * two[2]


@compiled
def _meet(
    faces: Faces,
    place: np.ndarray,
    rate: np.ndarray,
    images: np.ndarray,
    waves: np.ndarray,
    rows: np.ndarray,
    face: np.ndarray,
    steps: int,
    longest: float,
    met: np.ndarray,
) -> int:
    """Writes `MET`, and counts them, of waves `rows` (k,) that meet faces (k,).

    place, rate: of images, and images: (n,) of the waves; steps: places of a surface in the reflection tables; longest:
    way [m].
    """
    count = 0
    for at in range(len(rows)):
        wave, image, number = waves[rows[at]], images[rows[at]], face[at]
        towards = wave.direction[0], wave.direction[1], wave.direction[2]
        normal, start = _row(faces.normal, number), _row(place, image)
        slope = _dot(normal, towards)
        cosine = np.float32(min(abs(slope), 1.0))
        if cosine <= GRAZING:
            continue
        way = (faces.height[number] - _dot(normal, start)) / slope
        if way <= wave.travelled or way >= longest:
            continue
        back = start[0] + way * towards[0], start[1] + way * towards[1], start[2] + way * towards[2]
        out = max(math.sqrt(_dot(back, back)), 1e-9)
        inverse = 1.0 / out
        back = back[0] * inverse, back[1] * inverse, back[2] * inverse
        body = faces.body[number]
        speed, spin, known = _row(faces.linear, body), _row(faces.angular, body), _row(rate, image)
        there = (
            known[0] + speed[0] + spin[1] * start[2] - spin[2] * start[1],
            known[1] + speed[1] + spin[2] * start[0] - spin[0] * start[2],
            known[2] + speed[2] + spin[0] * start[1] - spin[1] * start[0],
        )
        one = met[count]
        count += 1
        one.wave, one.face, one.way, one.slope, one.cosine = rows[at], number, way, slope, cosine
        one.table = faces.table[number] + min(int(cosine * steps), steps - 1)
        one.out, one.back[0], one.back[1], one.back[2] = out, back[0], back[1], back[2]
        one.rise, one.coming, one.going = _dot(normal, back), _dot(there, towards), _dot(speed, back)
    return count


@compiled
def _reflect(
    faces: Faces,
    images: np.ndarray,
    waves: np.ndarray,
    met: np.ndarray,
    rows: np.ndarray,
    wide: np.ndarray,
    amplitude: np.ndarray,
    curved: np.ndarray,
    rotation: np.ndarray,
    sent: np.ndarray,
    mirror: np.ndarray,
    rays: np.ndarray,
    offsets: np.ndarray,
) -> int:
    """Writes the arrays of `Sent`, and counts them, of some rows (m,) of `MET`."""
    count = 0
    for row in rows:
        one = met[row]
        wave = waves[one.wave]
        left = amplitude[one.table] * wave.field
        if left.real**2 + left.imag**2 <= FAINTEST**2 or one.face >= faces.planes or curved[one.face]:
            continue
        on = sent[count]
        on.row, on.travelled, on.field, on.wide = wave.row, one.way, left, wide[wave.row]
        mirror[count] = images[one.wave] * faces.planes + one.face
        for axis in range(3):
            on.direction[axis] = wave.direction[axis] - 2.0 * one.slope * faces.normal[one.face, axis]
        for axis in range(3):
            turned = _dot(_row(rotation, axis), on.direction)
            rays[count, 3 + axis] = turned
            offsets[count, axis] = _dot(_row(rotation, axis), one.back) * one.out + LIFT_M * turned
        count += 1
    return count
