"""The raw kernel beside which `bench_device` measures; a file of its own, for Warp compiles it by its source."""

from typing import Any

from graph.sim.devices import warp

wp: Any = warp()


@wp.kernel
def raw_scan(
    mesh: wp.uint64,
    ways: wp.array(dtype=wp.vec3),
    places: wp.array(dtype=wp.vec3),
    boxes: wp.array2d(dtype=wp.vec3),
    distance: wp.array2d(dtype=wp.float32),
    point: wp.array2d(dtype=wp.vec3),
    normal: wp.array2d(dtype=wp.vec3),
    intensity: wp.array2d(dtype=wp.float32),
    velocity: wp.array2d(dtype=wp.vec3),
    surface: wp.array2d(dtype=wp.int32),
):
    """The nearest of a mesh and boxes of 1 m, by a slab test after a sphere test."""
    world, ray = wp.tid()
    start, way = places[world], ways[ray]
    best = wp.float32(200.0)
    number = wp.int32(-1)
    n = wp.vec3()
    query = wp.mesh_query_ray(mesh, start, way, best)
    if query.result:
        best = query.t
        number = 0
        n = query.normal
    for box in range(boxes.shape[1]):
        away = boxes[world, box] - start
        along = wp.dot(away, way)
        if wp.length_sq(away) - along * along < 0.75 and along > -0.87 and along - 0.87 < best:
            enter, leave = wp.float32(-1e30), wp.float32(1e30)
            side = wp.vec3()
            for axis in range(3):
                each = 1.0 / (way[axis] + 1e-20)
                middle = away[axis] * each
                half = 0.5 * wp.abs(each)
                if middle - half > enter:
                    enter = middle - half
                    side = wp.vec3()
                    side[axis] = -wp.sign(way[axis])
                leave = wp.min(leave, middle + half)
            if enter <= leave and enter > 0.0 and enter < best:
                best = enter
                number = box + 1
                n = side
    if number >= 0:
        distance[world, ray] = best
        point[world, ray] = start + best * way
        normal[world, ray] = n
        intensity[world, ray] = 0.5 * wp.abs(wp.dot(n, way))
        velocity[world, ray] = wp.vec3()
    else:
        distance[world, ray] = 0.0
    surface[world, ray] = number
