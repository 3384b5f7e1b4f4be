"""Rays of a radar on their way: the faces they meet, one after the other.

Each ray is a tube that fills a solid angle. Where it goes is worked out in float64 on the planes of the faces: float32
hits are off by more than the phase of a millimetre wave allows. Flat faces reflect tubes as mirrors do; curved and
rough ones end them. After mirrors a ray goes on as if it came from the radar's image in them, so that the length of its
way is that to one plane.
"""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np

from graph.sim.geometry.surfaces import Mesh
from sensors.raycast.rays import NO_SURFACE, Hits, RayBundle
from sensors.raycast.world import CastWorld

from .antenna import Antenna
from .grouping import Groups
from .images import Images, Twists, plane_keys
from .materials import Reflections
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

_OWN = 1 << 40


@dataclass(slots=True)
class Setting:
    """What waves travel in, in one state.

    pose: (4, 4) float64 sensor to world [m]. poses: the state, for the caster (None: now). reach: farthest range [m].
    bounces: most faces on a way. exclude: prims that are not there. twists: of the bodies, world axes.

    Derived for each plane, the last for no plane: heights: (p + 1,) float64 [m] of the radar over it; columns:
    (3, p + 1) of the normals, in the sensor's axes; tables: (p + 1,) int32, its first place in the reflection tables;
    surfaces, patches: (p + 1,); curved: (p + 1,) bool. speeds: the twists in the sensor's axes. deforms: whether any
    surface does; spots: whether hits need theirs. alike: whether all that is seen moves alike; still: not at all.
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
    heights: np.ndarray = field(init=False)
    columns: np.ndarray = field(init=False)
    tables: np.ndarray = field(init=False)
    surfaces: np.ndarray = field(init=False)
    patches: np.ndarray = field(init=False)
    curved: np.ndarray = field(init=False)
    speeds: Twists = field(init=False)
    deforms: bool = field(init=False)
    alike: bool = field(init=False)
    still: bool = field(init=False)
    spots: bool = field(init=False)

    def __post_init__(self) -> None:
        planes = self.planes
        self.heights = np.append(planes.offset - planes.normal @ self.pose[:3, 3], 0.0)
        self.columns = np.concatenate(((planes.normal @ self.rotation).T, np.zeros((3, 1))), axis=1)
        self.tables = np.append(self.reflections.of_surfaces(planes.surface), np.int32(0))
        self.surfaces = np.append(planes.surface, np.int32(NO_SURFACE))
        self.patches = np.append(planes.patch, np.int64(NO_PLANE))
        self.curved = np.append(planes.curved, False)
        self.speeds = self.twists.seen_from(self.rotation)
        self.deforms = bool(self.world.deforming.any())
        seen = planes.bodies_seen(self.exclude)
        self.spots = self.deforms or bool(len(seen))
        self.alike = self.twists.alike(seen)
        self.still = self.alike and not self.twists.linear[-1].any() and not self.twists.angular[-1].any()

    @property
    def seen(self) -> float:
        """Beyond this distance from the radar [m] nothing counts: a way there and back is longer than its range."""
        return self.reach * 1.01

    @property
    def rotation(self) -> np.ndarray:
        """(3, 3) sensor to world."""
        return self.pose[:3, :3]

    def to_world(self, vectors: np.ndarray) -> np.ndarray:
        """Vectors (3, k) of the sensor's axes in the world's, float32."""
        # Unlike a product of matrices this gives a column the same bytes wherever it stands, on any number of threads.
        turned = np.einsum("ij,jk->ik", self.rotation.astype(np.float32), vectors.astype(np.float32, copy=False))
        return np.asarray(turned)


@dataclass(slots=True)
class _Rows:
    """Columns (k,) and vectors (3, k) of k rows; None where a column is absent."""

    def at(self, rows: np.ndarray, taken: dict[int, np.ndarray] | None = None) -> Any:
        """Some of the rows, (m,). An array that serves two columns still does; taken: what was taken of them so far."""
        taken = {} if taken is None else taken
        found: dict[str, Any] = {}
        for each in fields(self):
            one = getattr(self, each.name)
            if isinstance(one, _Rows):
                one = one.at(rows, taken)
            elif isinstance(one, np.ndarray):
                if id(one) not in taken:
                    taken[id(one)] = _taken(one, rows)
                one = taken[id(one)]
            found[each.name] = one
        return type(self)(**found)


@dataclass(slots=True)
class Waves(_Rows):
    """Tubes before a stretch of their way; k of them, vectors (3, k) float64 in the sensor's axes [m].

    row: (k,) of the tube. direction: of the stretch. travelled: [m]. field: what the faces left of it, complex64.
    image: (k,) number of the radar's image that they come from, None before the first face.
    """

    row: np.ndarray
    direction: np.ndarray
    images: Images
    travelled: np.ndarray | None = None
    field: np.ndarray | None = None
    image: np.ndarray | None = None

    def left(self, coherent: np.ndarray) -> np.ndarray:
        """What is left (k,) complex64 of the waves after one more face, by its reflection (k,)."""
        return coherent if self.field is None else self.field * coherent


@dataclass(slots=True)
class Met(_Rows):
    """Faces that waves meet: k of them, vectors (3, k).

    way: [m] in all. back: unit from the radar to it, out: [m] of that. plane: its number, `NO_PLANE` where it is not
    known. normal: of the plane. slope, rise: its components along the wave and along `back`. cosine: (k,) float32 of
    incidence. table: place in the reflection tables. coming, going: rates [m/s] of the ways in and straight back, None
    where nothing moves.
    """

    waves: Waves
    way: np.ndarray
    back: np.ndarray
    out: np.ndarray
    plane: np.ndarray
    normal: np.ndarray
    slope: np.ndarray
    rise: np.ndarray
    cosine: np.ndarray
    table: np.ndarray
    coming: np.ndarray | None = None
    going: np.ndarray | None = None

    def __len__(self) -> int:
        return len(self.way)

    @property
    def range_m(self) -> np.ndarray:
        """Half the way (k,) [m] there and straight back."""
        return self.way if self.out is self.way else np.asarray((self.way + self.out) / 2.0)

    def rate(self) -> np.ndarray:
        """Half the rate (k,) [m/s] of the way in and straight back."""
        again = self.rate_again()
        return again if self.going is None or self.going is again else np.asarray((again + self.going) / 2.0)

    def rate_again(self) -> np.ndarray:
        """The rate (k,) [m/s] of the way in, which is also the way back."""
        return np.broadcast_to(0.0, len(self)) if self.coming is None else self.coming


def cast_first(setting: Setting, bundle: RayBundle) -> Hits:
    """What tubes meet as they leave the radar; the bundle has their rays."""
    return _cast(setting, bundle)


def first_waves(tubes: Tubes, row: np.ndarray) -> Waves:
    """Some tubes as they leave the radar."""
    return Waves(row, _taken(tubes.directions, row), Images.none())


@dataclass(slots=True)
class Sent:
    """Waves that flat faces send on; k of them, vectors (3, k).

    row, direction, travelled, field: as those of `Waves`. mirror: (k,) int64, the number of the last image x planes +
    the plane. start: [m] from the radar.
    """

    row: np.ndarray
    direction: np.ndarray
    travelled: np.ndarray
    field: np.ndarray
    mirror: np.ndarray
    start: np.ndarray


def next_waves(setting: Setting, images: Images, parts: list[Sent]) -> tuple[Waves, Hits, np.ndarray]:
    """Waves after a reflection, what they meet, and the rows (k,) of those that meet anything; images: the last."""
    row, direction, travelled, left, mirror, start = (
        np.concatenate([getattr(part, each.name) for part in parts], axis=-1) for each in fields(Sent)
    )
    planes, groups = setting.planes, Groups(mirror)
    image, plane = np.divmod(groups.keys, len(planes.normal))
    speeds, normal = (setting.speeds, planes.body[plane]), setting.columns[:, plane].T
    images = images.beyond(image, normal, setting.heights[plane], planes.patch[plane], speeds)
    hits = _cast_on(setting, direction, start)
    waves = Waves(row, direction, images, travelled, left, groups.which)
    return waves, hits, np.flatnonzero(hits.distance < 2.0 * setting.reach - travelled)


def in_sight(setting: Setting, out: np.ndarray, back: np.ndarray) -> np.ndarray:
    """Whether the radar sees points (3, k) [m from it] at distances (k,), in unit directions (3, k)."""
    bundle = RayBundle(setting.pose[:3, 3], _table(setting, back), exclude=setting.exclude, reach=setting.seen)
    hits = setting.world.cast(bundle, setting.poses)
    return np.asarray(hits.distance > out * (1 - 1e-6) - SIGHT_M)


def tangential(tubes: Tubes, waves: Waves, vectors: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The components (k,) of vectors (3, k) across and up of tubes, mirrored as the waves were, float32."""
    vectors = vectors.astype(np.float32, copy=False)
    if waves.image is not None:
        unturned = waves.images.unturned.astype(np.float32)
        vectors = np.einsum("jik,jk->ik", np.take(unturned, waves.image, axis=2), vectors)
    return tubes.tangential(waves.row, vectors)


def face_keys(setting: Setting, met: Met) -> np.ndarray:
    """(k,) uint64 of the flat patches on the way, whatever their order; unknown faces are like no other."""
    key = plane_keys(np.where(met.plane != NO_PLANE, np.take(setting.patches, met.plane), met.waves.row + _OWN))
    waves = met.waves
    return key if waves.image is None else np.asarray(key + np.take(waves.images.key, waves.image))


def meet(setting: Setting, waves: Waves, hits: Hits, row: np.ndarray, plane: np.ndarray) -> Met:
    """The faces that waves meet; row: (k,) the hits of the waves, plane: (k,) of those."""
    image = waves.image
    place = None if image is None else np.stack([np.take(c, image) for c in waves.images.place.T])
    normal = _taken(setting.columns, plane)  # the last is that of no plane
    height = np.take(setting.heights, plane)
    unknown = np.flatnonzero(plane == NO_PLANE) if setting.deforms else np.zeros(0, np.intp)
    if len(unknown):
        assert hits.normals is not None
        normal[:, unknown] = setting.rotation.T @ hits.normals[row[unknown]].T
        length = hits.distance[row[unknown]].astype(np.float64)
        if waves.travelled is not None:
            length += waves.travelled[unknown]
        point = waves.direction[:, unknown] * length
        height[unknown] = dot(normal[:, unknown], point if place is None else point + place[:, unknown])
    slope = dot(normal, waves.direction)
    if place is not None:
        height -= dot(normal, place)
    with np.errstate(divide="ignore", invalid="ignore"):
        way = height / slope
    cosine = np.abs(slope).astype(np.float32)
    before = 0.0 if waves.travelled is None else waves.travelled
    kept = (cosine > GRAZING) & (way > before) & (way < 2 * setting.reach)
    out, back, rise = way, waves.direction, slope
    if place is not None:
        back = waves.direction * way
        back += place
        out = np.sqrt(dot(back, back))
        back /= np.maximum(out, 1e-9)
        rise = dot(normal, back)
    table = np.take(setting.tables, plane) + setting.reflections.steps(cosine)
    if len(unknown):
        first = setting.reflections.of_surfaces(hits.surfaces(row[unknown]))
        table[unknown] += first - setting.tables[NO_PLANE]
    met = Met(waves, way, back, out, plane, normal, slope, rise, cosine, table)
    if not setting.still:
        met.coming, met.going = _rates(setting, waves, plane, back)
    if len(unknown):
        _add_within(setting, met, unknown, hits, row[unknown])
    return met if kept.all() else met.at(np.flatnonzero(kept))


def _rates(setting: Setting, waves: Waves, plane: np.ndarray, back: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """`coming` and `going` (k,) of waves that meet planes of rigid bodies."""
    speeds, images, image = setting.speeds, waves.images, waves.image
    if setting.alike:
        going = np.einsum("i,ik->k", speeds.linear[-1], back)
        if image is None:
            return going, going
        return dot(_taken((images.rate + speeds.at(-1, images.place)).T, image), waves.direction), going
    body = np.take(setting.planes.body, plane)
    going = dot(_taken(speeds.linear.T, body), back)
    if image is None:
        return going, going
    rate = _taken(images.rate.T, image) + speeds.at(body, np.take(images.place, image, axis=0)).T
    return dot(rate, waves.direction), going


def _add_within(setting: Setting, met: Met, some: np.ndarray, hits: Hits, row: np.ndarray) -> None:
    """Adds how points on meshes that deform move within these: some (m,) of the waves, the hits `row` (m,)."""
    within = setting.rotation.T @ speeds_within(setting, hits.surfaces(row), hits, row)
    rates = np.zeros((2, len(met)))
    if met.coming is not None and met.going is not None:
        rates += met.coming, met.going
    rates[0, some] += dot(within, met.waves.direction[:, some])
    rates[1, some] += dot(within, met.back[:, some])
    met.coming, met.going = rates


def speeds_within(setting: Setting, surface: np.ndarray, hits: Hits, row: np.ndarray) -> np.ndarray:
    """Velocities (3, k) of points on meshes that deform, from those of the triangles' corners; in the world's axes."""
    assert hits.spots is not None
    found = np.zeros((3, len(row)))
    for number in np.unique(surface).tolist():
        some = np.flatnonzero(surface == number)
        mesh, spot = setting.world.surfaces[number], hits.spots
        assert isinstance(mesh, Mesh)
        corners = np.asarray(mesh.triangles)[spot.triangle[row[some]]]
        second, third = spot.uv[row[some]].T.astype(np.float64)
        velocities = setting.world.vertex_velocities(number, setting.poses)[corners]
        shares = np.stack((1.0 - second - third, second, third), 1)
        found[:, some] = np.einsum("kc,kcj->jk", shares, velocities)
    return found


def reflected(setting: Setting, met: Met) -> Sent:
    """What flat faces send on, as far as it is not too faint."""
    planes, before = setting.planes, met.waves.field
    left = setting.reflections.coherent(met.table)
    if before is not None:
        left = left * before
    flat = left.real**2 + left.imag**2 > FAINTEST**2
    if planes.any_curved:
        flat &= ~np.take(setting.curved, met.plane)
    if setting.deforms:
        flat &= met.plane != NO_PLANE
    rows = np.flatnonzero(flat)

    def some(one: np.ndarray) -> np.ndarray:
        return one if len(rows) == len(flat) else _taken(one, rows)

    waves, mirror = met.waves, some(met.plane)
    if waves.image is not None:
        mirror = mirror + some(waves.image) * len(planes.normal)
    direction = some(met.normal) * (-2.0 * some(met.slope))
    direction += some(waves.direction)
    start = some(met.back) * some(met.out)
    return Sent(some(waves.row), direction, some(met.way), some(left), mirror, start)


def _cast_on(setting: Setting, direction: np.ndarray, start: np.ndarray) -> Hits:
    """What waves meet next."""
    offsets = np.ascontiguousarray(setting.to_world(start + LIFT_M * direction).T)
    bundle = RayBundle(setting.pose[:3, 3], _table(setting, direction), offsets, setting.exclude, setting.seen)
    return _cast(setting, bundle)


def _cast(setting: Setting, bundle: RayBundle) -> Hits:
    return setting.world.cast(bundle, setting.poses, normals=setting.deforms, spots=setting.spots)


def _table(setting: Setting, direction: np.ndarray) -> np.ndarray:
    """The table of rays in these directions (3, k)."""
    table = np.empty((direction.shape[1], 6), np.float32)
    table[:, 3:] = setting.to_world(direction).T
    return table


def _taken(array: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Some rows, from -n to n - 1, of (n,) or of vectors (3, n)."""
    if array.strides[-1] == 0:  # one for all
        return array[..., : len(rows)]
    if array.ndim == 1:
        return np.take(array, rows)
    found = np.empty((len(array), len(rows)), array.dtype)
    for column, out in zip(array, found, strict=True):
        np.take(column, rows, out=out, mode="wrap")  # other modes copy `out`, or the whole of `array`
    return found


def dot(one: np.ndarray, two: np.ndarray) -> np.ndarray:
    """Dot products (k,) of vectors (3, k)."""
    return np.asarray(np.einsum("ik,ik->k", one, two))
