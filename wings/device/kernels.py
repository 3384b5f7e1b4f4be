"""What a device computes: the nearest hit of each ray, in any number of worlds at once.

Ranges are refined in float64 from the triangle, or follow from the formula of a solid, as on the processor (`raycast`).
Imported only once a device was chosen: its functions are compiled by Warp.
"""

# Warp reads the annotations of kernels, so they are evaluated.

import functools
from typing import Any

from graph.sim.devices import warp

from .items import FEW_ITEMS, MESH
from .solid_kernels import INFINITE, SKIN, meet_solid, solid_normal

wp: Any = warp()

FARTHEST = wp.constant(wp.float64(1e30))
IS_MESH = wp.constant(MESH)
BEFORE = wp.constant(wp.float64(1.01))
NOTHING = wp.constant(-1)
FEW = wp.constant(FEW_ITEMS)


@wp.struct
class Items:
    """Solids and moving meshes, m of them: kinds, sizes and the frames in which their bodies carry them.

    inverse: from the body's axes to those of a solid; centre [m]: of a solid, or of the box of a mesh; box: half of its
    extent about `middle` [m]; radius [m]: of a sphere about the middle of a mesh.
    """

    kind: wp.array(dtype=wp.int32)
    surface: wp.array(dtype=wp.int32)
    body: wp.array(dtype=wp.int32)
    low: wp.array(dtype=wp.float64)
    high: wp.array(dtype=wp.float64)
    inverse: wp.array(dtype=wp.mat33d)
    centre: wp.array(dtype=wp.vec3d)
    middle: wp.array(dtype=wp.vec3d)
    box: wp.array(dtype=wp.vec3d)
    radius: wp.array(dtype=wp.float64)
    mesh: wp.array(dtype=wp.uint64)


@wp.struct
class Placed:
    """The items of all worlds where they are: (w, m), about the anchor of each world's rays.

    ball: a sphere around each, its centre and radius, for `FEW` items; lower, upper, tree: boxes around more.
    """

    turn: wp.array2d(dtype=wp.mat33d)
    centre: wp.array2d(dtype=wp.vec3d)
    ball: wp.array2d(dtype=wp.vec4)
    lower: wp.array(dtype=wp.vec3)
    upper: wp.array(dtype=wp.vec3)
    tree: wp.uint64


@wp.struct
class Ground:
    """What all worlds share: standing triangles, deforming meshes and infinite planes.

    surface: (t,) of the standing triangles. soft, soft_surface: of the deforming meshes. points, normals: (p,) of
    planes, in the axes of their bodies (-1: the world).
    """

    mesh: wp.uint64
    surface: wp.array(dtype=wp.int32)
    soft: wp.array(dtype=wp.uint64)
    soft_surface: wp.array(dtype=wp.int32)
    plane_surface: wp.array(dtype=wp.int32)
    plane_body: wp.array(dtype=wp.int32)
    plane_point: wp.array(dtype=wp.vec3d)
    plane_normal: wp.array(dtype=wp.vec3d)


@wp.struct
class Rough:
    """What a ray meets of the standing triangles, in float32: distance [m] and triangle, -1 for a miss."""

    distance: wp.float32
    face: wp.int32


@wp.struct
class Hit:
    """The nearest hit of a ray: distance [m], surface, -1 for a miss, and unit normal by the winding, world axes.

    item: 1 if it is an item.
    """

    distance: wp.float64
    surface: wp.int32
    item: wp.int32
    normal: wp.vec3d


@wp.func
def _exact(mesh: wp.uint64, face: wp.int32, start: wp.vec3d, ahead: wp.vec3d, rough: wp.float64):
    """Distance to the plane of a triangle, and its unit normal, both in float64; `rough` along the plane."""
    first = wp.vec3d(wp.mesh_get_point(mesh, face * 3))
    one = wp.vec3d(wp.mesh_get_point(mesh, face * 3 + 1)) - first
    two = wp.vec3d(wp.mesh_get_point(mesh, face * 3 + 2)) - first
    normal = wp.normalize(wp.cross(one, two))
    along = wp.dot(ahead, normal)
    found = rough
    if wp.abs(along) > wp.float64(1e-6):
        found = wp.dot(first - start, normal) / along
    return found, normal


@wp.func
def _mesh_hit(mesh: wp.uint64, start: wp.vec3d, ahead: wp.vec3d, most: wp.float64):
    """The nearest hit with a mesh: distance [m], its triangle, -1 for a miss, and its normal.

    A triangle that the ray leaves within `SKIN` of its start, by its winding, is where it started: it goes on behind.
    """
    far = wp.float64(INFINITE)
    face = wp.int32(NOTHING)
    normal = wp.vec3d()
    reach = wp.float32(wp.min(most, FARTHEST))
    begin = wp.float64(0.0)
    casts = wp.int32(1)
    while casts > 0:
        here = start + begin * ahead
        query = wp.mesh_query_ray(mesh, wp.vec3(here), wp.vec3(ahead), reach)
        casts -= 1
        if query.result:
            found, upwards = _exact(mesh, query.face, here, ahead, wp.float64(query.t))
            if begin == wp.float64(0.0) and found < SKIN and wp.dot(upwards, ahead) > wp.float64(0.0):
                begin = SKIN
                casts = wp.int32(1)
            else:
                far = found + begin
                face = query.face
                normal = upwards
    return far, face, normal


@wp.kernel
def place_items(items: Items, bodies: wp.array2d(dtype=wp.mat44d), placed: Placed):
    """Places every item of every world, (w, m): its frame, and a box around it [m] about the anchor."""
    world, item = wp.tid()
    turn = wp.mat33d(items.inverse[item])
    centre = wp.vec3d(items.centre[item])
    middle = wp.vec3d(items.middle[item])
    half = wp.vec3d(items.box[item])
    body = items.body[item]
    if body >= 0:
        pose = bodies[world, body]
        rotation = wp.mat33d(
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
        turn = turn * wp.transpose(rotation)
        centre = wp.transform_point(pose, centre)
        middle = wp.transform_point(pose, middle)
        around = wp.vec3d()
        for row in range(3):
            around[row] = (
                wp.abs(rotation[row, 0]) * half[0]
                + wp.abs(rotation[row, 1]) * half[1]
                + wp.abs(rotation[row, 2]) * half[2]
            )
        half = around
    # Float32 at 500 m from the anchor is exact to 3e-5 m.
    margin = wp.vec3d(wp.float64(1e-4), wp.float64(1e-4), wp.float64(1e-4))
    placed.turn[world, item] = turn
    placed.centre[world, item] = centre
    count = items.kind.shape[0]
    if count <= FEW:
        radius = wp.float32(wp.length(wp.vec3d(items.box[item]) + margin)) * wp.float32(1.0001)
        placed.ball[world, item] = wp.vec4(wp.float32(middle[0]), wp.float32(middle[1]), wp.float32(middle[2]), radius)
    else:
        placed.lower[world * count + item] = wp.vec3(middle - half - margin)
        placed.upper[world * count + item] = wp.vec3(middle + half + margin)


@wp.struct
class Rays:
    """Rays of one frame in many worlds: unit ways (n,) and origins (n,), or none, in frames (w,) to the anchor [m]."""

    ways: wp.array(dtype=wp.vec3)
    origins: wp.array(dtype=wp.vec3)
    frames: wp.array(dtype=wp.mat44d)


@wp.func
def ray_of(rays: Rays, world: wp.int32, ray: wp.int32):
    """Start, about the anchor, and unit way of a ray in a world; ways are turned in float32, as on the processor."""
    pose = rays.frames[world]
    turn = wp.mat33(
        wp.float32(pose[0, 0]),
        wp.float32(pose[0, 1]),
        wp.float32(pose[0, 2]),
        wp.float32(pose[1, 0]),
        wp.float32(pose[1, 1]),
        wp.float32(pose[1, 2]),
        wp.float32(pose[2, 0]),
        wp.float32(pose[2, 1]),
        wp.float32(pose[2, 2]),
    )
    start = wp.vec3d(pose[0, 3], pose[1, 3], pose[2, 3])
    if rays.origins.shape[0] > 0:
        start += wp.vec3d(turn * wp.vec3(rays.origins[ray]))
    return start, turn * wp.vec3(rays.ways[ray])


@wp.kernel
def trace(mesh: wp.uint64, rays: Rays, due: wp.array(dtype=wp.int32), most: wp.float32, met: wp.array2d(dtype=Rough)):
    """What rays of the worlds `due` meet of the standing triangles within `most` [m].

    A kernel of its own: with so few registers, twice as many rays run at once as in one that also does the rest.
    """
    row, ray = wp.tid()
    world = due[row]
    start, way = ray_of(rays, world, ray)
    query = wp.mesh_query_ray(mesh, wp.vec3(start), way, most)
    found = Rough()
    found.face = NOTHING
    if query.result:
        found.distance = query.t
        found.face = query.face
    met[world, ray] = found


@wp.kernel
def miss(met: wp.array2d(dtype=Rough)):
    """There are no standing triangles."""
    row, ray = wp.tid()
    found = Rough()
    found.face = NOTHING
    met[row, ray] = found


@functools.cache
def nearest_of(solids: bool, meshes: bool, soft: bool, few: bool) -> Any:
    """The function `nearest` for worlds with, or without, solids, moving meshes and deforming ones; few: items by
    spheres. Fewer branches take fewer registers, and so more rays run at once.
    """

    @wp.func
    def meet_item(
        items: Items, placed: Placed, world: wp.int32, item: wp.int32, start: wp.vec3d, ahead: wp.vec3d, hit: Hit
    ) -> Hit:
        """The nearer of a hit and what a ray meets of one item."""
        turn = placed.turn[world, item]
        kind = items.kind[item]
        local = turn * (start - placed.centre[world, item])
        way = turn * ahead
        far, normal = INFINITE, wp.vec3d()
        if wp.static(meshes):
            if kind == IS_MESH:
                # From just before the sphere about the mesh, so that float32 is exact in its box.
                before = wp.max(-wp.dot(local, way) - BEFORE * items.radius[item], wp.float64(0.0))
                if before < hit.distance:
                    far, face, normal = _mesh_hit(items.mesh[item], local + before * way, way, hit.distance - before)
                    if face != NOTHING:
                        far += before
                        normal = wp.transpose(turn) * normal
        if wp.static(solids):
            if kind != IS_MESH:
                far = meet_solid(kind, items.low[item], items.high[item], local, way)
                if far <= hit.distance and far < INFINITE:
                    inside = solid_normal(kind, items.low[item], items.high[item], local + far * way)
                    normal = wp.normalize(wp.transpose(turn) * inside)
        surface = items.surface[item]
        # Of equal hits the lower surface counts, in whatever order the tree gives them.
        if far < hit.distance or (far == hit.distance and hit.item == 1 and surface < hit.surface):
            hit.distance = far
            hit.surface = surface
            hit.item = 1
            hit.normal = normal
        return hit

    @wp.func
    def nearest(
        ground: Ground,
        items: Items,
        placed: Placed,
        bodies: wp.array2d(dtype=wp.mat44d),
        skip: wp.array(dtype=wp.uint8),
        world: wp.int32,
        start: wp.vec3d,
        ahead: wp.vec3d,
        rough: Rough,
    ) -> Hit:
        """The nearest hit of a ray in a world. start: [m], about the anchor; ahead: unit, world axes.

        bodies: (w, b) to the anchor [m]; skip: (s,) 1 for surfaces that are left out; rough: the ray's hit with the
        standing triangles (`trace`).
        """
        hit = Hit()
        hit.distance = INFINITE
        hit.surface = NOTHING
        if rough.face != NOTHING:
            far, normal = _exact(ground.mesh, rough.face, start, ahead, wp.float64(rough.distance))
            face = wp.int32(rough.face)
            if far < SKIN and wp.dot(normal, ahead) > wp.float64(0.0):
                far, face, normal = _mesh_hit(ground.mesh, start + SKIN * ahead, ahead, FARTHEST)
                far += SKIN
            if face != NOTHING:
                hit.distance = far
                hit.surface = ground.surface[face]
                hit.normal = normal
        for number in range(ground.plane_surface.shape[0]):
            surface = ground.plane_surface[number]
            if skip[surface] == wp.uint8(0):
                point = wp.vec3d(ground.plane_point[number])
                upwards = wp.vec3d(ground.plane_normal[number])
                body = ground.plane_body[number]
                if body >= 0:
                    pose = bodies[world, body]
                    point = wp.transform_point(pose, point)
                    upwards = wp.transform_vector(pose, upwards)
                height = wp.dot(point - start, upwards) / wp.dot(ahead, upwards)
                if height > wp.float64(0.0) and height < hit.distance:
                    hit.distance = height
                    hit.surface = surface
                    hit.normal = upwards
        if wp.static(soft):
            for number in range(ground.soft.shape[0]):
                if skip[ground.soft_surface[number]] == wp.uint8(0):
                    far, face, normal = _mesh_hit(ground.soft[number], start, ahead, hit.distance)
                    if face != NOTHING and far < hit.distance:
                        hit.distance = far
                        hit.surface = ground.soft_surface[number]
                        hit.normal = normal
        count = items.kind.shape[0]
        if wp.static((solids or meshes) and few):
            way, here = wp.vec3(ahead), wp.vec3(start)
            for item in range(count):
                ball = wp.vec4(placed.ball[world, item])
                away = wp.vec3(ball[0], ball[1], ball[2]) - here
                along = wp.dot(away, way)
                if (
                    wp.length_sq(away - along * way) <= ball[3] * ball[3]
                    and along >= -ball[3]
                    and along - ball[3] <= wp.float32(hit.distance)
                    and skip[items.surface[item]] == wp.uint8(0)
                ):
                    hit = meet_item(items, placed, world, item, start, ahead, hit)
        if wp.static((solids or meshes) and not few):
            query = wp.bvh_query_ray(
                placed.tree, wp.vec3(start), wp.vec3(ahead), wp.bvh_get_group_root(placed.tree, world)
            )
            box = wp.int32(0)
            while wp.bvh_query_next(query, box, wp.float32(wp.min(hit.distance, FARTHEST))):
                item = box - world * count
                if skip[items.surface[item]] == wp.uint8(0):
                    hit = meet_item(items, placed, world, item, start, ahead, hit)
        return hit

    return nearest


@functools.cache
def cast_of(*kinds: bool) -> Any:
    """The kernel `cast` for worlds of these kinds, see `nearest_of`."""
    nearest = nearest_of(*kinds)

    @wp.kernel(module="unique")
    def cast(
        ground: Ground,
        items: Items,
        placed: Placed,
        bodies: wp.array2d(dtype=wp.mat44d),
        skip: wp.array(dtype=wp.uint8),
        rays: Rays,
        met: wp.array2d(dtype=Rough),
        distances: wp.array(dtype=wp.float32),
        surfaces: wp.array(dtype=wp.int32),
        normals: wp.array(dtype=wp.vec3),
    ):
        """Nearest hits of rays in world 0, whose standing triangles `trace` has met."""
        ray = wp.tid()
        start, way = ray_of(rays, 0, ray)
        hit = nearest(ground, items, placed, bodies, skip, 0, start, wp.vec3d(way), met[0, ray])
        distances[ray] = wp.float32(hit.distance)
        surfaces[ray] = hit.surface
        if normals.shape[0] > 0:
            normals[ray] = wp.vec3(hit.normal)

    return cast
