"""What a lidar measures, computed on a device: all channels of a beam in one kernel, for any number of worlds.

The formulas are those of `lidar.receiver`, `lidar.returns` and `motion.velocities`; a test holds both to each other.
"""

# Warp reads the annotations of kernels, so they are evaluated.

import functools
from typing import Any

from graph.sim.devices import warp
from sensors.surfaces.optics import RETRO_GAIN

from .kernels import Ground, Items, Placed, Rays, Rough, nearest_of, ray_of

wp: Any = warp()

RETRO = wp.constant(wp.float32(RETRO_GAIN))


@wp.struct
class Gates:
    """The range gates [m] of the firings of a turn, n of each or one for all."""

    near: wp.array(dtype=wp.float32)
    far: wp.array(dtype=wp.float32)


@wp.struct
class Receiver:
    """Reflectances of surfaces and the receiver's rule; see `lidar.receiver.Receiver`. Tables may be empty."""

    reflectance: wp.array(dtype=wp.float32)
    retro: wp.array(dtype=wp.uint8)
    least: wp.float32
    near: wp.float32
    scale: wp.float32
    normalised: wp.int32
    first: wp.array(dtype=wp.float32)
    second: wp.array(dtype=wp.float32)


@wp.struct
class Motion:
    """Velocities [m/s, rad/s] of bodies at their origins, (w, b), and which body carries the sensor; -1: none does."""

    linear: wp.array2d(dtype=wp.vec3d)
    angular: wp.array2d(dtype=wp.vec3d)
    body_of: wp.array(dtype=wp.int32)
    carrier: wp.int32


@wp.struct
class Channels:
    """Results by world and firing, (w, n); arrays without rows are left out.

    distance [m] and intensity 0 to 1: 0 without a return; points and normals (towards the sensor), velocities [m/s]:
    in the sensor's frame; surface: -1 without a return.
    """

    distance: wp.array2d(dtype=wp.float32)
    point: wp.array2d(dtype=wp.vec3)
    normal: wp.array2d(dtype=wp.vec3)
    intensity: wp.array2d(dtype=wp.float32)
    velocity: wp.array2d(dtype=wp.vec3)
    surface: wp.array2d(dtype=wp.int32)


@wp.func
def _mapped(value: wp.float32, table: wp.array(dtype=wp.float32)):
    """Linear between the entries of a table at equal steps from 0 to 1."""
    last = table.shape[0] - 1
    found = value
    if last > 0:
        at = wp.min(wp.max(value, wp.float32(0.0)), wp.float32(1.0)) * wp.float32(last)
        low = wp.min(wp.int32(at), last - 1)
        share = at - wp.float32(low)
        found = table[low] + share * (table[low + 1] - table[low])
    return found


@wp.func
def _speed(motion: Motion, bodies: wp.array2d(dtype=wp.mat44d), world: wp.int32, body: wp.int32, place: wp.vec3d):
    """The velocity of a place that moves with a body."""
    pose = bodies[world, body]
    lever = place - wp.vec3d(pose[0, 3], pose[1, 3], pose[2, 3])
    return motion.linear[world, body] + wp.cross(motion.angular[world, body], lever)


@functools.cache
def scan_of(*kinds: bool) -> Any:
    """The kernel `scan` for worlds of these kinds, see `kernels.nearest_of`."""
    nearest = nearest_of(*kinds)

    @wp.kernel(module="unique")
    def scan(
        ground: Ground,
        items: Items,
        placed: Placed,
        bodies: wp.array2d(dtype=wp.mat44d),
        skip: wp.array(dtype=wp.uint8),
        gates: Gates,
        receiver: Receiver,
        motion: Motion,
        rays: Rays,
        met: wp.array2d(dtype=Rough),
        due: wp.array(dtype=wp.int32),
        out: Channels,
    ):
        """One firing of one of the worlds that are due."""
        row, ray = wp.tid()
        world = due[row]
        pose = rays.frames[world]
        turn = wp.mat33d(
            pose[0, 0],
            pose[0, 1],
            pose[0, 2],
            pose[1, 0],
            pose[1, 1],
            pose[1, 2],
            pose[2, 0],
            pose[2, 1],
            pose[2, 2],
        )
        start, way = ray_of(rays, world, ray)
        ahead = wp.vec3d(way)
        farthest = gates.far[wp.min(ray, gates.far.shape[0] - 1)]
        hit = nearest(ground, items, placed, bodies, skip, world, start, ahead, met[world, ray])
        distance = wp.float32(hit.distance)
        there = distance >= gates.near[wp.min(ray, gates.near.shape[0] - 1)] and distance <= farthest
        light = wp.float32(0.0)
        if there:
            light = wp.abs(wp.float32(wp.dot(ahead, hit.normal))) * receiver.reflectance[hit.surface]
            if receiver.retro[hit.surface] != wp.uint8(0):
                light = RETRO
            there = not light < distance * distance * receiver.least
        point, normal, velocity = wp.vec3(), wp.vec3(), wp.vec3()
        surface = wp.int32(-1)
        scalar = wp.float32(0.0)
        if not there:
            distance = wp.float32(0.0)
        else:
            surface = hit.surface
            point = wp.vec3(rays.ways[ray]) * distance
            if rays.origins.shape[0] > 0:
                point += wp.vec3(rays.origins[ray])
            if out.normal.shape[0] > 0:
                towards = hit.normal
                if wp.dot(ahead, towards) > wp.float64(0.0):
                    towards = -towards
                normal = wp.vec3(wp.transpose(turn) * towards)
            if out.intensity.shape[0] > 0:
                scalar = light
                if receiver.normalised == 0:
                    ratio = receiver.near / wp.max(distance, receiver.near)
                    scalar = light * ratio * ratio
                scalar = _mapped(_mapped(wp.min(scalar, wp.float32(1.0)), receiver.first), receiver.second)
                scalar = scalar * receiver.scale
            if out.velocity.shape[0] > 0:
                place = start + hit.distance * ahead
                speed = wp.vec3d()
                body = motion.body_of[surface]
                if body >= 0:
                    speed = _speed(motion, bodies, world, body, place)
                if motion.carrier >= 0:
                    speed -= _speed(motion, bodies, world, motion.carrier, place)
                velocity = wp.vec3(wp.transpose(turn) * speed)
        if out.distance.shape[0] > 0:
            out.distance[world, ray] = distance
        if out.point.shape[0] > 0:
            out.point[world, ray] = point
        if out.normal.shape[0] > 0:
            out.normal[world, ray] = normal
        if out.intensity.shape[0] > 0:
            out.intensity[world, ray] = scalar
        if out.velocity.shape[0] > 0:
            out.velocity[world, ray] = velocity
        if out.surface.shape[0] > 0:
            out.surface[world, ray] = surface

    return scan


@wp.kernel
def mount(
    bodies: wp.array2d(dtype=wp.mat44d),
    carrier: wp.int32,
    local: wp.array(dtype=wp.mat44d),
    sensors: wp.array(dtype=wp.mat44d),
):
    """Sensors where their carriers are, (w,); local: (1 or w,) to the carrier, to the anchor without a carrier."""
    world = wp.tid()
    pose = local[world % local.shape[0]]
    if carrier >= 0:
        pose = bodies[world, carrier] * pose
    sensors[world] = pose


@wp.kernel
def mark(distance: wp.array2d(dtype=wp.float32), found: wp.array(dtype=wp.int32)):
    """1 for each firing of world 0 with a return."""
    ray = wp.tid()
    found[ray] = wp.where(distance[0, ray] > wp.float32(0.0), 1, 0)


@wp.kernel
def number(found: wp.array(dtype=wp.int32), before: wp.array(dtype=wp.int32), rows: wp.array(dtype=wp.int32)):
    """The firings with a return, in order; before: how many there are up to each."""
    ray = wp.tid()
    if found[ray] == 1:
        rows[before[ray] - 1] = ray


FIRING, SURFACE = wp.constant(0), wp.constant(1)
"""Where a field of a frame comes from: a table of the firings, or of the surfaces; from 2 on, a measured channel."""


@wp.func
def _measured(channels: Channels, field: wp.int32, ray: wp.int32, number: wp.int32):
    """One number of a measured channel of world 0, in the order of `frames.MEASURED`."""
    value = wp.float32(0.0)
    if field == 2:
        value = channels.distance[0, ray]
    elif field == 3:
        value = channels.point[0, ray][number]
    elif field == 4:
        value = channels.normal[0, ray][number]
    elif field == 5:
        value = channels.intensity[0, ray]
    else:
        value = channels.velocity[0, ray][number]
    return value


@wp.kernel
def gather(
    before: wp.array(dtype=wp.int32),
    rows: wp.array(dtype=wp.int32),
    channels: Channels,
    firings: wp.array2d(dtype=wp.uint8),
    surfaces: wp.array2d(dtype=wp.uint8),
    field: wp.array(dtype=wp.int32),
    column: wp.array(dtype=wp.int32),
    width: wp.array(dtype=wp.int32),
    slot: wp.array(dtype=wp.int32),
    slots: wp.array(dtype=wp.int32),
    first: wp.int32,
    block: wp.array(dtype=wp.uint8),
):
    """Writes the fields of the firings `rows` into a block of bytes: field f of row r from its begin + r width on.

    before: how many rows there are up to each firing. The arrays of the block have `slots` bytes a row and begin at
    multiples of 8, from `first` on; slot: the number of each field's array.
    """
    row, number = wp.tid()
    count = before[before.shape[0] - 1]
    if row >= count:
        return
    ray, source, size = rows[row], field[number], width[number]
    begin = first
    for array in range(slot[number]):
        begin += (slots[array] * count + 7) // 8 * 8
    begin += row * size
    if source == FIRING:
        for byte in range(size):
            block[begin + byte] = firings[ray, column[number] + byte]
    elif source == SURFACE:
        for byte in range(size):
            block[begin + byte] = surfaces[channels.surface[0, ray], column[number] + byte]
    else:
        for word in range(size // 4):
            bits = wp.cast(_measured(channels, source, ray, word), wp.uint32)
            for byte in range(4):
                block[begin + 4 * word + byte] = wp.uint8(bits >> wp.uint32(8 * byte))
