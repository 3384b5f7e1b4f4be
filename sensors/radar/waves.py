"""Rays of a radar on their way: the faces they meet, one after the other.

Each ray is a tube that fills a solid angle. Where it goes is worked out in float64 on the planes of the faces: float32
hits are off by more than the phase of a millimetre wave allows. Flat faces reflect tubes as mirrors do; curved and
rough ones end them. After mirrors a ray goes on as if it came from the radar's image in them, so that the length of its
way is that to one plane.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from sensors.compiled import inlined
from sensors.raycast.rays import Hits, RayBundle
from sensors.vectors import Vector, dot, row_of, times

from .grouping import Groups
from .images import Images
from .rays import Tubes
from .setting import Faces, Setting, Space, height_of, normal_of

GRAZING = 1e-6
"""Cosine of incidence below which a face is not met."""

FAINTEST = 0.02
"""Amplitude, of what was sent, below which a wave is not followed."""

LIFT_M = 2e-4
"""Reflected rays start so high above the face that they leave."""

WAVE = np.dtype([("travelled", np.float64), ("field", np.complex64), ("row", np.int64)])
"""A tube before a stretch of its way. travelled: [m]. field: what the faces left of it. row: its number."""

MET = np.dtype(
    [
        *((name, np.int32) for name in ("row", "image", "face", "table")),
        *((name, np.float64) for name in ("way", "out", "slope", "coming", "going")),
        *((name, np.float64, 3) for name in ("direction", "back")),
        ("field", np.complex64),
        *((name, np.float32) for name in ("cosine", "wide")),
    ],
    align=True,
)
"""A curved face that a wave meets, as `Wave`, `Touch` and `Echo` have them."""


class Wave(NamedTuple):
    """A wave on a stretch of its way, for loops.

    direction: of the stretch, in the sensor's axes. wide: how many tubes across, and up, it stands for. image: number
    of the radar's image that it comes from. row, travelled, field: as in `WAVE`.
    """

    row: Any
    direction: Vector
    wide: Any
    travelled: Any
    field: Any
    image: Any


class Touch(NamedTuple):
    """How a wave meets a face, for loops.

    face: its number; normal: of it, in the sensor's axes. way: [m] in all, 0 if it does not meet it. there: from the
    radar [m]. slope: component of the normal along the wave. cosine: of incidence. table: place in the reflection
    tables.
    """

    face: Any
    normal: Vector
    way: float
    there: Vector
    slope: float
    cosine: Any
    table: Any


class Echo(NamedTuple):
    """The way straight back from where a wave meets a face, for loops.

    back: unit from the radar to the place, out: [m] of that. rise: component of the face's normal along `back`. coming,
    going: rates [m/s] of the ways in and back.
    """

    back: Vector
    out: float
    rise: float
    coming: float
    going: float


class Waves(NamedTuple):
    """Waves (k,) of `WAVE` before the face of that number, from 1 on, and of which images (k,) each comes from."""

    bounce: int
    images: Images
    image: np.ndarray
    each: np.ndarray

    @classmethod
    def none(cls) -> Waves:
        """No waves, from the radar itself."""
        return cls(1, Images.none(), np.empty(0, np.int32), np.empty(0, WAVE))

    def some(self, rows: slice) -> Waves:
        """Some of them."""
        return self._replace(image=self.image[rows], each=self.each[rows])


@dataclass(slots=True)
class Met:
    """Curved faces that some waves meet: (k,) of `MET`, of these planes and images, the faces of that number."""

    bounce: int
    images: Images
    faces: Faces
    each: np.ndarray

    def __len__(self) -> int:
        return len(self.each)

    def at(self, rows: np.ndarray) -> Met:
        """Some of them."""
        return replace(self, each=self.each.take(rows))

    @staticmethod
    def together(parts: Sequence[Met]) -> Met:
        """Those of several blocks of waves."""
        return replace(parts[0], each=_joined([part.each for part in parts]))


class Sent(NamedTuple):
    """Waves that flat faces send on, (k,) of `WAVE`; room for more of them.

    mirror: (k,) int64, the number of the last image x planes + the plane; rays: (k, 6), offsets: (k, 3) float32, as
    those of a `RayBundle`.
    """

    waves: np.ndarray
    mirror: np.ndarray
    rays: np.ndarray
    offsets: np.ndarray

    def cast(self, setting: Setting, looks: np.ndarray) -> tuple[Hits, np.ndarray]:
        """What they meet, and the distances (r,) [m] to what the rays `looks` (r, 6) meet, which begin at the radar."""
        rays, offsets, count = looks, None, len(self.rays)
        if count:
            rays = np.concatenate((self.rays, looks))
            offsets = np.zeros((len(rays), 3), np.float32)
            offsets[:count] = self.offsets
        hits = setting.cast(RayBundle(setting.pose[:3, 3], rays, offsets, setting.exclude, setting.seen))
        return hits.some(slice(0, count)), hits.distance[count:]

    @classmethod
    def room(cls, count: int) -> Sent:
        """For so many waves."""
        rays, offsets = np.empty((count, 6), np.float32), np.empty((count, 3), np.float32)
        return cls(np.empty(count, WAVE), np.empty(count, np.int64), rays, offsets)

    def first(self, count: int) -> Sent:
        """So many of them."""
        return Sent(*(each[:count] for each in self))

    @classmethod
    def together(cls, parts: list[Sent]) -> Sent:
        """Several as one."""
        waves, *columns = zip(*parts, strict=True)
        return cls(_joined(waves), *(np.concatenate(each) for each in columns))


def _joined(parts: Sequence[np.ndarray]) -> np.ndarray:
    """Records as one array; by their bytes, as themselves they take long."""
    return np.concatenate([part.view(np.uint8) for part in parts]).view(parts[0].dtype)


def next_waves(setting: Setting, before: Waves, sent: Sent) -> Waves:
    """Waves after a reflection; before: the last, with their images."""
    planes, faces, groups = setting.planes, setting.faces, Groups(sent.mirror)
    image, plane = np.divmod(groups.keys, faces.planes)
    speeds = setting.speeds, planes.body[plane]
    images = before.images.beyond(image, *faces.seen(plane), planes.patch[plane], speeds)
    return Waves(before.bounce + 1, images, groups.which, sent.waves)


@inlined
def strength(field: Any) -> Any:
    """The power of a field."""
    return field.real**2 + field.imag**2


@inlined
def wave_of(waves: Waves, at: Any, tubes: Tubes) -> Wave:
    """The wave number `at`: its direction is that of its tube, as mirrors have turned it."""
    one, image = waves.each[at], np.int64(waves.image[at])
    ahead = tubes.directions[0, one.row], tubes.directions[1, one.row], tubes.directions[2, one.row]
    direction = times(waves.images.turn, image, ahead)
    return Wave(one.row, direction, tubes.wide[one.row], one.travelled, one.field, image)


@inlined
def meets(space: Space, images: Images, wave: Wave, face: Any) -> Touch:
    """How a wave meets a face."""
    faces, towards = space.faces, wave.direction
    normal, start = normal_of(faces, face), row_of(images.place, wave.image)
    slope = dot(normal, towards)
    cosine = np.float32(min(abs(slope), 1.0))
    way = (height_of(faces, face) - dot(normal, start)) / slope
    if not (cosine > GRAZING and wave.travelled < way < space.longest):
        way = 0.0
    there = start[0] + way * towards[0], start[1] + way * towards[1], start[2] + way * towards[2]
    table = faces.table[face] + min(int(cosine * space.tables.steps), space.tables.steps - 1)
    return Touch(face, normal, way, there, slope, cosine, table)


@inlined
def echo_of(space: Space, images: Images, wave: Wave, touch: Touch) -> Echo:
    """The way straight back."""
    faces, there, start = space.faces, touch.there, row_of(images.place, wave.image)
    out = max(math.sqrt(dot(there, there)), 1e-9)
    inverse = 1.0 / out
    back = there[0] * inverse, there[1] * inverse, there[2] * inverse
    body = faces.body[touch.face]
    speed, spin, known = row_of(faces.linear, body), row_of(faces.angular, body), row_of(images.rate, wave.image)
    rate = (
        known[0] + speed[0] + spin[1] * start[2] - spin[2] * start[1],
        known[1] + speed[1] + spin[2] * start[0] - spin[0] * start[2],
        known[2] + speed[2] + spin[0] * start[1] - spin[1] * start[0],
    )
    return Echo(back, out, dot(touch.normal, back), dot(rate, wave.direction), dot(speed, back))


@inlined
def send_on(space: Space, wave: Wave, touch: Touch, sent: Sent, at: Any) -> bool:
    """Writes the wave that a face sends on, if it is flat and what is left is not too faint; whether it is."""
    faces = space.faces
    left = space.tables.amplitude[touch.table] * wave.field
    if strength(left) <= FAINTEST**2 or touch.face >= faces.planes or faces.curved[touch.face]:
        return False
    on, normal, twice = sent.waves[at], touch.normal, 2.0 * touch.slope
    on.row, on.travelled, on.field = wave.row, touch.way, left
    sent.mirror[at] = wave.image * faces.planes + touch.face
    towards = (
        wave.direction[0] - twice * normal[0],
        wave.direction[1] - twice * normal[1],
        wave.direction[2] - twice * normal[2],
    )
    for axis in range(3):
        turned = dot(row_of(space.rotation, axis), towards)
        sent.rays[at, 3 + axis] = turned
        sent.offsets[at, axis] = dot(row_of(space.rotation, axis), touch.there) + LIFT_M * turned
    return True


@inlined
def write(met: np.ndarray, at: Any, wave: Wave, touch: Touch, echo: Echo) -> None:
    """Writes into one of `MET`."""
    one = met[at]
    one.row, one.image, one.field, one.wide = wave.row, wave.image, wave.field, wave.wide
    one.face, one.table, one.cosine = touch.face, touch.table, touch.cosine
    one.way, one.out, one.slope, one.coming, one.going = touch.way, echo.out, touch.slope, echo.coming, echo.going
    for axis in range(3):
        one.direction[axis], one.back[axis] = wave.direction[axis], echo.back[axis]
