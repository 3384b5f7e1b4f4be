"""Solids in closed form: rays against the implicit functions of the solids, and against their triangles."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from graph.sim.geometry.closed_forms import closed_form
from graph.sim.geometry.shapes import solid
from graph.sim.geometry.surfaces import Mesh, Plane, Solid
from sensors.raycast.alone import cast_alone
from sensors.raycast.rays import RayBundle
from sensors.raycast.windows import RayGrid
from sensors.raycast.world import CastWorld

KINDS = ["Sphere", "Cube", "Cylinder", "Cone", "Capsule", "Cylinder_1"]
TOLERANCE = 1e-3


def sizes_of(kind, radius, height):
    if kind == "Cube":
        return {"size": 2 * radius}
    if kind == "Cylinder_1":
        return {"radiusBottom": radius, "radiusTop": 0.4 * radius, "height": height}
    return {"radius": radius} if kind == "Sphere" else {"radius": radius, "height": height}


def inside(kind, sizes, axis, points):
    """Whether points (n, 3) in the prim's own space lie in the solid, as UsdGeom defines it."""
    order = {"X": [1, 2, 0], "Y": [2, 0, 1], "Z": [0, 1, 2]}[axis]
    x, y, z = points[:, order].T
    if kind == "Cube":
        return np.abs(points).max(axis=1) <= sizes["size"] / 2
    if kind == "Sphere":
        return np.linalg.norm(points, axis=1) <= sizes["radius"]
    half, level = sizes["height"] / 2, np.hypot(x, y)
    if kind == "Capsule":
        return np.hypot(level, np.maximum(np.abs(z) - half, 0)) <= sizes["radius"]
    bottom = sizes.get("radiusBottom", sizes.get("radius"))
    top = sizes.get("radiusTop", 0.0 if kind == "Cone" else bottom)
    return (np.abs(z) <= half) & (level <= bottom + (top - bottom) * (z + half) / (2 * half))


def turned(angles):
    (a, b, c), matrix = angles, np.eye(3)
    for axis, angle in ((0, a), (1, b), (2, c)):
        turn, (i, j) = np.eye(3), [k for k in range(3) if k != axis]
        turn[i, i] = turn[j, j] = math.cos(angle)
        turn[i, j], turn[j, i] = -math.sin(angle), math.sin(angle)
        matrix = matrix @ turn
    return matrix


def affine(angles, scales, shear, place):
    matrix = np.eye(4)
    matrix[:3, :3] = turned(angles) @ np.array([[1, shear, 0], [0, 1, 0], [0, 0, 1]]) @ np.diag(scales)
    matrix[:3, 3] = place
    return matrix


def made(kind, sizes, axis, matrix, body=None, path="/World/S"):
    """A Solid with triangles of the tolerance in its own space."""
    vertices, triangles = solid(kind, sizes, axis, TOLERANCE, lambda message: None)
    if np.linalg.det(matrix[:3, :3]) < 0:
        triangles = triangles[:, ::-1]
    form = closed_form(kind, sizes, axis).placed(matrix)
    return Solid(path, body, form, lambda: (vertices @ matrix[:3, :3].T + matrix[:3, 3], triangles))


def bundle(origin, directions, offsets=None, grid=False):
    table = np.zeros((len(directions), 6), np.float32)
    table[:, 3:6] = directions / np.linalg.norm(directions, axis=1)[:, None]
    found = RayGrid(table[:, 3:6].copy()) if grid else None
    return RayBundle(np.asarray(origin, np.float64), table, offsets, grid=found)


def world_of(one, *others):
    return CastWorld([one, *others], lambda _: np.eye(4)[None])


def ball(radius=0.5, place=(0.0, 0.0, 0.0), body=None, path="/World/S"):
    return made("Sphere", {"radius": radius}, "Z", affine((0, 0, 0), (1, 1, 1), 0, place), body, path)


ANGLES = st.tuples(*[st.floats(-3, 3)] * 3)
SCALES = st.tuples(*[st.sampled_from([-2.0, -0.3, 0.2, 0.7, 1.0, 3.0])] * 3)
CASES = {
    "kind": st.sampled_from(KINDS),
    "axis": st.sampled_from("XYZ"),
    "radius": st.floats(0.05, 2),
    "height": st.floats(0.1, 3),
    "angles": ANGLES,
    "scales": SCALES,
    "shear": st.sampled_from([0.0, 0.0, 0.6]),
    "moving": st.booleans(),
    "seed": st.integers(0, 1000),
}


def aimed(matrix, away, seed, count=400):
    """Rays from a place `away` [m] from a solid, at points in and around it: origin (3,), directions (n, 3)."""
    generator = np.random.default_rng(seed)
    way = generator.normal(size=3)
    origin = matrix[:3, 3] + away * way / np.linalg.norm(way)
    targets = generator.uniform(-1.6, 1.6, (count, 3)) @ matrix[:3, :3].T + matrix[:3, 3]
    return origin, targets - origin


@given(**CASES, away=st.floats(0, 60), offset=st.sampled_from([0.0, 1e3, 1e6]), spread=st.booleans())
@settings(max_examples=120, deadline=None)
def test_a_range_ends_on_the_solid_to_a_millionth(
    kind, axis, radius, height, angles, scales, shear, moving, seed, away, offset, spread
):
    sizes = sizes_of(kind, radius, height)
    matrix = affine(angles, scales, shear, (offset, -offset, 0.0))
    origin, directions = aimed(matrix, away, seed)
    offsets = np.random.default_rng(seed).normal(size=directions.shape).astype(np.float32) if spread else None
    rays = bundle(origin, directions, offsets, grid=not spread)
    inverse = np.linalg.inv(matrix[:3, :3])

    def within(length):
        points = (rays.origin - matrix[:3, 3]) + length[:, None] * rays.table[:, 3:6].astype(np.float64)
        points = points + offsets if spread else points
        return inside(kind, sizes, axis, points @ inverse.T)

    hits = world_of(made(kind, sizes, axis, matrix, "/World/S" if moving else None)).cast(rays, normals=True)
    hit = np.isfinite(hits.distance)
    distance = np.where(hit, hits.distance, 3 * (away + 10)).astype(np.float64)
    began = within(np.zeros(len(hit)))
    far = (distance > 1e-2) & (within(np.full(len(hit), 2e-4)) == began)  # but for rays that start on a surface
    for step in np.linspace(0, 1, 100)[1:-1]:  # the hit is the first place where the ray changes sides
        assert (within(step * distance) == began)[far].all()
    normal = hits.normals.astype(np.float64)
    cosine = np.abs((normal * rays.table[:, 3:6]).sum(axis=1))
    clear = hit & (cosine > 0.1)
    before, after = within(distance * (1 - 1e-6) - 1e-9), within(distance * (1 + 1e-6) + 1e-9)
    through = before[clear] != after[clear]
    assert (~through).sum() <= max(1, 0.01 * through.size)  # corners of less than a millionth are left
    assert np.allclose(np.linalg.norm(normal[hit], axis=1), 1.0, atol=1e-6)
    out = (normal * rays.table[:, 3:6]).sum(axis=1)
    assert (np.sign(out[clear]) == np.where(began[clear], 1, -1)).all()  # outwards, also of a mirrored solid


@given(**CASES, away=st.floats(4, 60))
@settings(max_examples=60, deadline=None)
def test_formulas_and_triangles_agree_within_the_tolerance(
    kind, axis, radius, height, angles, scales, shear, moving, seed, away
):
    matrix = affine(angles, scales, shear, (3.0, 2.0, 1.0))
    origin, directions = aimed(matrix, away * 3, seed)
    world = world_of(made(kind, sizes_of(kind, radius, height), axis, matrix, "/World/S" if moving else None))
    exact = world.cast(bundle(origin, directions), normals=True)
    facets = world.facets.cast(bundle(origin, directions), normals=True)
    both = np.isfinite(exact.distance) & np.isfinite(facets.distance)
    assume(both.any())
    # Triangles lie inside, nearer to the surface than the tolerance times the largest scale.
    further = (facets.distance[both] - exact.distance[both]).astype(np.float64)
    cosine = np.abs((exact.normals * bundle(origin, directions).table[:, 3:6]).sum(axis=1))[both]
    assert (further * cosine).min() > -1e-4
    most = TOLERANCE * np.linalg.norm(matrix[:3, :3], 2)
    same = (exact.normals * facets.normals).sum(axis=1)[both] > 0.9  # not past a rim, where a ray meets another face
    assert (further * cosine)[same & (cosine > 0.3)].max(initial=0.0) < 1.5 * most + 2e-4
    assert (np.isfinite(facets.distance) & ~np.isfinite(exact.distance)).sum() <= 1  # by rounding, at a silhouette


@pytest.mark.parametrize("body", [None, "/World/S"])
def test_a_ray_past_the_silhouette_goes_on(body):
    # From 5 m away at a sphere of 0.5 m: a ray whose line passes 1 µm outside meets the wall at x = 3; 1 µm inside, the
    # sphere, at sqrt(25 - 0.25) less half the chord, which is about 1 mm. The inscribed triangles of 1 mm miss both.
    wall = Plane("/World/Wall", None, np.array([3.0, 0.0, 0.0]), np.array([-1.0, 0.0, 0.0]))
    world = world_of(ball(body=body), wall)
    for tilt in np.linspace(0, 2 * np.pi, 16, endpoint=False):
        for off, expected in ((1e-6, None), (-1e-6, math.sqrt(24.75))):
            sine = (0.5 + off) / 5.0
            level = math.sqrt(1 - sine**2)
            way = np.array([[level, sine * math.cos(tilt), sine * math.sin(tilt)]])
            hits = world.cast(bundle((-5.0, 0.0, 0.0), way))
            distance = float(hits.distance[0])
            if expected is None:
                assert distance == pytest.approx(8 / level, rel=1e-6)
                assert hits.surfaces().tolist() == [1]
            else:
                assert distance == pytest.approx(expected, abs=2e-3)
                assert hits.surfaces().tolist() == [0]


@pytest.mark.parametrize("body", [None, "/World/S"])
def test_a_sensor_within_sees_the_far_side(body):
    directions = np.random.default_rng(0).normal(size=(500, 3))
    hits = world_of(ball(2.0, (7.0, 0.0, 0.0), body)).cast(bundle((7.0, 0.0, 0.0), directions), normals=True)
    assert np.abs(hits.distance - 2.0).max() < 1e-6
    assert ((hits.normals * directions).sum(axis=1) > 0).all()


@pytest.mark.parametrize("body", [None, "/World/S"])
@pytest.mark.parametrize("height", [0.0, 1e-4, -1e-4])
def test_a_ray_that_starts_on_a_solid_and_leaves_it_goes_on(body, height):
    # Within SKIN (0.2 mm) of the surface: the ray outwards sees the wall at z = 10; the one inwards sees the surface,
    # or from below it the far side of the ball.
    wall = Plane("/World/Wall", None, np.array([0.0, 0.0, 10.0]), np.array([0.0, 0.0, -1.0]))
    world = world_of(ball(body=body), wall)
    hits = world.cast(bundle((0.0, 0.0, 0.5 + height), np.array([[0.1, 0.0, 1.0], [0.0, 0.0, -1.0]])))
    assert hits.distance[0] == pytest.approx((9.5 - height) * math.sqrt(1.01), rel=1e-5)
    assert hits.distance[1] == pytest.approx(height if height >= 0 else 1.0, abs=2e-4)


def test_standing_and_moving_solids_are_met_alike():
    directions = np.random.default_rng(3).normal(size=(5000, 3))
    for kind in KINDS:
        matrix = affine((0.3, 1.0, -0.4), (1.0, 0.7, -1.3), 0.2, (4.0, 1.0, 2.0))
        hits = [
            world_of(made(kind, sizes_of(kind, 0.8, 1.5), "Y", matrix, body)).cast(
                bundle((1.0, 0.0, 0.5), directions), normals=True
            )
            for body in (None, "/World/S")
        ]
        assert hits[0].distance.tobytes() == hits[1].distance.tobytes()
        assert np.abs(hits[0].normals - hits[1].normals).max() < 1e-6


def test_rays_pass_many_standing_solids_that_they_miss():
    # The line x, y = 0.5 m + 0.1 mm passes 30 balls of 0.5 m closely, through the triangles around each.
    balls = [ball(0.5, (0.0, 0.0, 1.2 * number), path=f"/World/S{number}") for number in range(30)]
    end = Plane("/World/End", None, np.array([0.0, 0.0, 50.0]), np.array([0.0, 0.0, -1.0]))
    hits = CastWorld([*balls, end]).cast(bundle((0.5 + 1e-4, 0.0, -2.0), np.array([[0.0, 0.0, 1.0]])))
    assert hits.distance.tolist() == [52.0]


def test_bytes_do_not_depend_on_threads_nor_on_the_selection_of_rays():
    generator = np.random.default_rng(5)
    solids = [
        made(
            KINDS[number % len(KINDS)],
            sizes_of(KINDS[number % len(KINDS)], 0.4, 0.8),
            "X",
            affine(generator.uniform(-3, 3, 3), (1, 1, 1), 0, generator.uniform(-9, 9, 3)),
            f"/World/B{number}" if number % 2 else None,
            f"/World/B{number}",
        )
        for number in range(60)
    ]
    directions = generator.normal(size=(20_000, 3))

    def cast(threads, rows, grid):
        world = CastWorld(solids, lambda _: np.tile(np.eye(4), (30, 1, 1)), lambda: threads)
        hits = world.cast(bundle((0.1, 0.2, 0.3), directions[rows], grid=grid), normals=True)
        return hits.distance.tobytes(), hits.normals.tobytes(), hits.surfaces().tobytes()

    every = slice(None)
    assert cast(1, every, True) == cast(2, every, True) == cast(0, every, False)
    few = slice(100, 200)
    assert cast(1, few, False)[0] == np.frombuffer(cast(1, every, True)[0], np.float32)[few].tobytes()


def test_facets_stand_for_the_same_solids_with_the_same_numbers():
    world = CastWorld([ball(path="/World/A"), ball(place=(3.0, 0.0, 0.0), body="/World/B", path="/World/B")], one_pose)
    assert world.facets.facets is world.facets
    assert [surface.path for surface in world.facets.surfaces] == ["/World/A", "/World/B"]
    ways = np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]])
    seen = [one.cast(bundle((1.5, 0.0, 0.0), ways)) for one in (world, world.facets)]
    assert seen[0].surfaces().tolist() == seen[1].surfaces().tolist() == [1, 0]
    assert (seen[1].distance - seen[0].distance).min() > -1e-6


def one_pose(_):
    return np.eye(4)[None]


def test_a_world_without_solids_is_its_own_facets():
    world = CastWorld([Mesh("/World/M", None, np.eye(3), np.array([[0, 1, 2]], np.uint32))])
    assert world.facets is world


def test_an_outline_is_that_of_the_formula():
    # A ball seen from 5 m has its silhouette at asin(0.1): rays 1e-5 rad within meet it.
    world = world_of(ball(body="/World/S"))
    edge = math.asin(0.1)
    ways = np.array([[math.cos(a), math.sin(a), 0.0] for a in (edge - 1e-5, edge + 1e-5, -edge + 1e-5, -edge - 1e-5)])
    distance = cast_alone(world, [0], bundle((-5.0, 0.0, 0.0), ways), None)
    assert np.isfinite(distance).tolist() == [True, False, True, False]
