"""The colours of a camera on a device: what its rays met, the light that falls there, and the picture, in one kernel.

The formulas are those of `camera.shading`, `camera.lights` and `camera.view`; a test holds both to each other.
"""

# Warp reads the annotations of kernels, so they are evaluated.

import functools
from typing import Any

from graph.sim.devices import warp
from sensors.camera.shading import BEYOND_WHITE
from sensors.raycast.shadows import REACH

from .kernels import Ground, Items, Placed, Rays, Rough, nearest_of, ray_of
from .lamps import CARRIED, FAR, FLAT, HEADER, LONG, SHADOWS, SPOT

wp: Any = warp()

IS_FAR, IS_CARRIED, IS_FLAT = wp.constant(FAR), wp.constant(CARRIED), wp.constant(FLAT)
IS_LONG, IS_SPOT, HAS_SHADOWS = wp.constant(LONG), wp.constant(SPOT), wp.constant(SHADOWS)
PIXELS = wp.constant(HEADER)
WHITE = wp.constant(wp.float32(BEYOND_WHITE))
PART_OF_WAY = wp.constant(wp.float32(REACH))
NONE = wp.constant(wp.float32(0.0))
ONE = wp.constant(wp.float32(1.0))
ENDLESS = wp.constant(wp.float32(1e30))


@wp.struct
class Lamps:
    """Lights as of `camera.lights.Light`; `lamps` has the bits of `kind`.

    patches: of all, those of a light from `first` on. cone: cosines of the edge and of the inner edge, and the focus.
    """

    color: wp.array(dtype=wp.vec3)
    place: wp.array(dtype=wp.vec3)
    axis: wp.array(dtype=wp.vec3)
    cone: wp.array(dtype=wp.vec3)
    kind: wp.array(dtype=wp.int32)
    first: wp.array(dtype=wp.int32)
    patches: wp.array(dtype=wp.vec3)
    sky: wp.array(dtype=wp.vec3)


@wp.struct
class Looks:
    """Linear colours (s,) of the surfaces, and the light [nit] that they give."""

    base: wp.array(dtype=wp.vec3)
    emitted: wp.array(dtype=wp.vec3)


@wp.struct
class Film:
    """What becomes of light. along: (n,) as of `CameraRays`, or none. table: sRGB of light from 0 to 1.

    near, far [m]: what is shown, from the image plane; aces: whether light is bent by `aces_curve`.
    """

    along: wp.array(dtype=wp.float32)
    table: wp.array(dtype=wp.uint8)
    near: wp.float32
    far: wp.float32
    exposure: wp.float32
    aces: wp.int32


@wp.func
def _spot(axis: wp.vec3, cone: wp.vec3, away: wp.vec3):
    """How much of a spot's light goes a way from it; see `lights._cone`."""
    cosine = wp.dot(axis, away) / wp.max(wp.sqrt(wp.dot(away, away)), wp.float32(1e-6))
    share = wp.clamp((cosine - cone[0]) / wp.max(cone[1] - cone[0], wp.float32(1e-6)), NONE, ONE)
    share = share * share * (wp.float32(3.0) - wp.float32(2.0) * share)
    if cone[2] > NONE:
        share *= wp.pow(wp.max(cosine, NONE), cone[2])
    return share


@wp.func
def _fallen(lamps: Lamps, light: wp.int32, point: wp.vec3, normal: wp.vec3):
    """What a light brings to a place, times its colour, and where it comes from; see `lights.irradiance`."""
    kind, place = lamps.kind[light], wp.vec3(lamps.place[light])
    total = wp.float32(0.0)
    if (kind & IS_FAR) != 0:
        total = wp.max(wp.dot(place, normal), NONE)
    elif (kind & IS_CARRIED) != 0:
        away = wp.max(wp.sqrt(wp.dot(point, point)), wp.float32(1e-6))
        total = wp.max(-wp.dot(point, normal) / away, NONE)
    else:
        axis = wp.vec3(lamps.axis[light])
        mean = wp.vec3()
        begin, end = lamps.first[light], lamps.first[light + 1]
        for number in range(begin, end):
            patch = wp.vec3(lamps.patches[number])
            way = patch - point
            squared = wp.max(wp.dot(way, way), wp.float32(1e-12))
            share = wp.max(wp.dot(way, normal), NONE)
            if (kind & IS_FLAT) != 0:
                share = share * wp.max(-wp.dot(axis, way), NONE) / (squared * squared)
            else:
                share = share / (squared * wp.sqrt(squared))
                if (kind & IS_LONG) != 0:
                    along = wp.dot(axis, way)
                    share *= wp.sqrt(wp.max(ONE - along * along / squared, NONE))
            total += share
            mean += share * patch
        if end - begin > 1:
            place = mean / wp.max(total, wp.float32(1e-30))
        if (kind & IS_SPOT) != 0:
            total *= _spot(axis, lamps.cone[light], point - lamps.place[light])
    return total, place


@wp.func
def _tone(light: wp.float32):
    """See `shading.aces_curve`."""
    x = wp.clamp(light, NONE, WHITE)
    bent = x * (wp.float32(2.51) * x + wp.float32(0.03))
    return bent / (x * (wp.float32(2.43) * x + wp.float32(0.59)) + wp.float32(0.14))


@functools.cache
def shade_of(*kinds: bool) -> Any:
    """The kernel `shade` for worlds that throw shadows of these kinds, see `kernels.nearest_of`."""
    nearest = nearest_of(*kinds)

    @wp.func
    def dark(
        ground: Ground,
        items: Items,
        placed: Placed,
        bodies: wp.array2d(dtype=wp.mat44d),
        skip: wp.array(dtype=wp.uint8),
        start: wp.vec3d,
        way: wp.vec3,
        far: wp.bool,
    ):
        """Whether anything lies on the way (of any length) to a light."""
        length = wp.sqrt(wp.dot(way, way))
        ahead = way / length
        reach = wp.where(far, ENDLESS, PART_OF_WAY * length)
        if ground.mesh != wp.uint64(0):
            if wp.mesh_query_ray_anyhit(ground.mesh, wp.vec3(start), ahead, reach):
                return True
        none = Rough()
        none.face = -1
        hit = nearest(ground, items, placed, bodies, skip, 0, start, wp.vec3d(ahead), none)
        return hit.surface >= 0 and wp.float32(hit.distance) < reach

    @wp.kernel(module="unique")
    def shade(
        ground: Ground,
        items: Items,
        placed: Placed,
        bodies: wp.array2d(dtype=wp.mat44d),
        skip: wp.array(dtype=wp.uint8),
        rays: Rays,
        distances: wp.array(dtype=wp.float32),
        surfaces: wp.array(dtype=wp.int32),
        normals: wp.array(dtype=wp.vec3),
        looks: Looks,
        lamps: Lamps,
        film: Film,
        light: wp.array(dtype=wp.vec3),
        picture: wp.array(dtype=wp.uint8),
    ):
        """One pixel. Its light [nit] goes into `light`; where that is empty, its sRGB into `picture` from `PIXELS`
        on. Byte 0 of `picture` becomes 1 if something is nearer than the near distance.
        """
        ray = wp.tid()
        start, way = ray_of(rays, 0, ray)
        distance = wp.float32(distances[ray])
        reach = wp.float32(distance)
        if film.along.shape[0] > 0:
            reach = distance * film.along[ray]
        found = wp.vec3(lamps.sky[0])
        if distance < ENDLESS and reach < film.near:
            picture[0] = wp.uint8(1)
        elif distance < ENDLESS and reach <= film.far:
            normal = wp.vec3(normals[ray])
            if wp.dot(way, normal) > NONE:
                normal = -normal
            from_camera = way * distance
            pose = wp.mat44d(rays.frames[0])
            camera = wp.vec3d(pose[0, 3], pose[1, 3], pose[2, 3])
            if rays.origins.shape[0] > 0:
                from_camera += wp.vec3(start - camera)
            above = from_camera + normal * (wp.float32(2e-4) + wp.float32(2e-6) * distance)
            begin = camera + wp.vec3d(above)
            lit = lamps.sky[0] * wp.float32(wp.pi)
            for number in range(lamps.kind.shape[0]):
                share, place = _fallen(lamps, number, from_camera, normal)
                if share > NONE and (lamps.kind[number] & HAS_SHADOWS) != 0:
                    far = (lamps.kind[number] & IS_FAR) != 0
                    ahead = wp.where(far, place, place - above)
                    if dark(ground, items, placed, bodies, skip, begin, ahead, far):
                        share = NONE
                lit += lamps.color[number] * share
            surface = surfaces[ray]
            found = wp.cw_mul(looks.base[surface], lit * wp.float32(1.0 / wp.pi)) + looks.emitted[surface]
        if light.shape[0] > 0:
            light[ray] = found
        else:
            for axis in range(3):
                value = found[axis] * film.exposure
                if film.aces != 0:
                    value = _tone(value)
                level = wp.clamp(value, NONE, ONE) * wp.float32(film.table.shape[0] - 1) + wp.float32(0.5)
                picture[PIXELS + 3 * ray + axis] = film.table[wp.int32(level)]

    return shade
