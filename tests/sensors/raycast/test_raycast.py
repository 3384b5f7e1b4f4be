"""Rays against closed-form geometry, near and far from the origin, standing and moving."""

import gc
import itertools
import math

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from graph.base.errors import RunError
from graph.sim.geometry.closed_forms import closed_form
from graph.sim.geometry.surfaces import Mesh, Plane, Solid
from sensors.raycast import triangles
from sensors.raycast.bodies import FEW_RAYS
from sensors.raycast.rays import RayBundle, RayMemory
from sensors.raycast.windows import RayGrid
from sensors.raycast.world import CastWorld

OFFSETS = [0.0, 1e3, 1e4, 1e5, 1e6]
FACES = np.array(
    [
        *([0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1]),
        *([2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]),
    ],
    np.uint32,
)


def box(half, centre=(0.0, 0.0, 0.0)):
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], np.float64)
    return corners * half + centre, FACES


def sphere(radius, rings=40):
    """A sphere of 2 * rings segments round: inscribed, so its facets lie inside."""
    theta = np.linspace(0, np.pi, rings + 1)
    phi = np.linspace(0, 2 * np.pi, 2 * rings, endpoint=False)
    points = np.stack(
        [
            np.outer(np.sin(theta), np.cos(phi)),
            np.outer(np.sin(theta), np.sin(phi)),
            np.outer(np.cos(theta), np.ones_like(phi)),
        ],
        axis=-1,
    ).reshape(-1, 3)
    index = np.arange(len(points)).reshape(rings + 1, 2 * rings)
    a, b = index[:-1], index[1:]
    c, d = np.roll(b, -1, axis=1), np.roll(a, -1, axis=1)
    faces = np.concatenate([np.stack([a, b, c], -1).reshape(-1, 3), np.stack([a, c, d], -1).reshape(-1, 3)])
    return points * radius, faces.astype(np.uint32)


def mesh(shape, path="/World/M", body=None):
    return Mesh(path, body, *shape)


def bundle(origin, directions, exclude=frozenset(), offsets=None, ordered=False):
    directions = np.asarray(directions, np.float64)
    table = np.zeros((len(directions), 6), np.float32)
    table[:, 3:6] = directions / np.linalg.norm(directions, axis=1, keepdims=True)
    grid = RayGrid(table[:, 3:6].copy()) if ordered else None
    return RayBundle(np.asarray(origin, np.float64), table, offsets, exclude, grid=grid)


def fan(count=4000, seed=1):
    return np.random.default_rng(seed).normal(size=(count, 3))


def pose_at(x, y, z, turn=0.0):
    pose = np.eye(4)
    pose[:2, :2] = [[math.cos(turn), -math.sin(turn)], [math.sin(turn), math.cos(turn)]]
    pose[:3, 3] = x, y, z
    return pose


def room_distance(directions, half):
    """Distance from the middle of a box to its walls: min over axes of half / |d|."""
    unit = directions / np.linalg.norm(directions, axis=1, keepdims=True)
    return (half / np.abs(unit)).min(axis=1)


@pytest.mark.parametrize("offset", OFFSETS)
def test_a_box_is_as_far_as_its_walls_wherever_it_stands(offset):
    place = np.array([offset, -offset, offset])
    world = CastWorld([mesh(box((20.0, 30.0, 5.0), place))])
    directions = fan()

    hits = world.cast(bundle(place, directions), normals=True)

    np.testing.assert_allclose(hits.distance, room_distance(directions, np.array([20.0, 30.0, 5.0])), atol=1e-4)
    assert np.all(hits.surfaces() == 0)
    assert np.allclose(np.abs(hits.normals).max(axis=1), 1.0)


def test_ranges_at_any_offset_are_those_at_the_origin_to_the_last_bit():
    directions = fan()

    def ranges(offset):
        place = np.array([offset, offset, 0.0])
        return CastWorld([mesh(box((20.0, 30.0, 5.0), place))]).cast(bundle(place + 0.25, directions)).distance

    for offset in OFFSETS[1:]:
        np.testing.assert_array_equal(ranges(offset), ranges(0.0))


@pytest.mark.parametrize("offset", OFFSETS)
def test_a_sphere_is_hit_within_its_tessellation_bound(offset):
    rings, radius = 40, 2.0
    points, faces = sphere(radius, rings)
    place = np.array([offset, 10.0, 0.0])
    world = CastWorld([mesh((points + place, faces))])
    directions = fan()

    distance = world.cast(bundle(place, directions)).distance

    # A facet spans at most pi / rings both ways; its middle lies at r cos(half the angle to its corners).
    bound = radius * (1 - math.cos(math.hypot(math.pi / rings, math.pi / rings) / 2))
    assert np.all(distance <= radius + 1e-5)
    assert np.all(distance >= radius - bound - 1e-5)


@pytest.mark.parametrize("offset", OFFSETS)
@pytest.mark.parametrize("normal", [(0.0, 0.0, 1.0), (0.0, 1.0, 0.0), (0.6, 0.0, 0.8)])
def test_an_infinite_plane_is_hit_by_formula_from_both_sides(offset, normal):
    place = np.array([offset, offset, offset])
    normal = np.array(normal)
    world = CastWorld([Plane("/World/Ground", None, place - 1.5 * normal, normal)])
    directions = fan()
    unit = directions / np.linalg.norm(directions, axis=1, keepdims=True)
    approach = unit @ normal

    above = world.cast(bundle(place, directions), normals=True)
    below = world.cast(bundle(place - 3.0 * normal, directions))

    down, up = approach < -1e-3, approach > 1e-3
    # Directions are float32: their component along the normal is off by up to 2e-7, more of it the more it grazes.
    exact = 1.5 / np.abs(approach)
    error = exact * 2e-7 / np.abs(approach) + 1e-5
    assert np.all(np.abs(above.distance - exact)[down] <= error[down])
    assert np.all(np.isinf(above.distance[approach > 0]))
    np.testing.assert_allclose(above.normals[down], np.broadcast_to(normal, (down.sum(), 3)), atol=1e-6)
    assert np.all(np.abs(below.distance - exact)[up] <= error[up])


@pytest.mark.parametrize("offset", OFFSETS)
@pytest.mark.parametrize("ordered", [False, True])
@pytest.mark.parametrize("shape", ["box", "sphere"])
def test_moving_meshes_are_hit_where_they_are_now(offset, ordered, shape):
    points, faces = box((0.5, 0.5, 0.5)) if shape == "box" else sphere(0.5, 30)
    places = {"now": pose_at(offset + 8.0, 0.0, 0.0)}
    world = CastWorld([mesh((points, faces), "/World/B/m", "/World/B")], lambda _: places["now"][None])
    towards = bundle((offset, 0.0, 0.0), [[1, 0, 0.01], [0, 1, 0.01], [-1, 0, 0.01]], ordered=ordered)

    first = world.cast(towards, normals=True)
    places["now"] = pose_at(offset, 5.0, 0.0)
    second = world.cast(towards)

    np.testing.assert_allclose(first.distance, [7.5, np.inf, np.inf], atol=1e-2)
    np.testing.assert_allclose(first.normals[0], [-1, 0, 0], atol=0.2)
    assert first.surfaces().tolist() == [0, -1, -1]
    np.testing.assert_allclose(second.distance, [np.inf, 4.5, np.inf], atol=1e-2)


def test_moving_meshes_share_one_scene_and_are_distinguished():
    shapes = [sphere(0.5, 30), sphere(0.5, 20)]
    meshes = [mesh(shapes[i % 2], f"/World/B{i}/m", f"/World/B{i}") for i in range(6)]
    poses = np.stack([pose_at(5 * math.cos(i), 5 * math.sin(i), 0.0, turn=i) for i in range(6)])
    before = triangles.alive()
    world = CastWorld(meshes, lambda _: poses)

    hits = world.cast(bundle((0, 0, 0), poses[:, :3, 3] + [0, 0, 0.01], ordered=True))

    assert triangles.alive() - before == 1
    assert hits.surfaces().tolist() == list(range(6))
    np.testing.assert_allclose(hits.distance, 4.5, atol=3e-3)


def test_a_sensor_inside_a_moving_body_sees_it_all_around():
    world = CastWorld([mesh(sphere(3.0, 30), "/World/B/m", "/World/B")], lambda _: pose_at(0.1, 0, 0)[None])

    distance = world.cast(bundle((0.0, 0.0, 0.0), fan(), ordered=True)).distance

    assert np.all((distance > 2.85) & (distance < 3.15))


@pytest.mark.parametrize("rings", [4, 30])
def test_windows_miss_nothing_that_casting_all_rays_hits(rings):
    points, faces = sphere(1.0, rings)
    generator = np.random.default_rng(5)
    poses = np.stack([pose_at(*generator.uniform(-12, 12, 3), turn=i) for i in range(40)])
    bodies = [mesh((points, faces), f"/World/B{i}/m", f"/World/B{i}") for i in range(40)]
    standing = [mesh((points @ pose[:3, :3].T + pose[:3, 3], faces), f"/World/B{i}/m") for i, pose in enumerate(poses)]
    directions = fan(20000)

    moving = CastWorld(bodies, lambda _: poses).cast(bundle((0, 0, 0), directions, ordered=True))
    fixed = CastWorld(standing).cast(bundle((0, 0, 0), directions))

    np.testing.assert_array_equal(np.isfinite(moving.distance), np.isfinite(fixed.distance))
    np.testing.assert_allclose(moving.distance, fixed.distance, atol=1e-4)
    assert np.mean(moving.surfaces() == fixed.surfaces()) > 0.999  # overlapping spheres may tie


@pytest.mark.parametrize("reach", [(0.3, 0.8), (0.6, 2.5)])
def test_small_bodies_around_a_sensor_are_seen_as_they_are_when_they_stand_still(reach):
    generator = np.random.default_rng(7)
    towards = generator.normal(size=(12, 3))
    towards *= generator.uniform(*reach, 12)[:, None] / np.linalg.norm(towards, axis=1, keepdims=True)
    poses = np.stack([pose_at(*place, turn=i) for i, place in enumerate(towards)])
    far = poses.copy()
    far[:, :3, 3] += 500.0
    shapes = [box(generator.uniform(0.05, 0.2, 3)) for _ in range(12)]
    moving = [mesh(shape, f"/World/B{i}", f"/World/B{i}") for i, shape in enumerate(shapes)]
    still = [
        mesh((points @ pose[:3, :3].T + pose[:3, 3], faces), f"/World/B{i}")
        for i, ((points, faces), pose) in enumerate(zip(shapes, poses, strict=True))
    ]
    directions = fan(20000)

    seen = CastWorld(moving, lambda _: far).cast(bundle((500.0,) * 3, directions, ordered=True), normals=True)
    fixed = CastWorld(still).cast(bundle((0.0,) * 3, directions), normals=True)

    same = np.isfinite(seen.distance) == np.isfinite(fixed.distance)
    assert np.mean(same) > 0.999  # rays that graze an edge may see it or not
    both = same & np.isfinite(fixed.distance)
    assert both.sum() > 1000
    assert np.mean(np.abs(seen.distance[both] - fixed.distance[both]) < 1e-5) > 0.999
    agree = both & (seen.surfaces() == fixed.surfaces())
    assert agree.sum() > 0.999 * both.sum()
    assert np.mean(np.abs(seen.normals[agree] - fixed.normals[agree]).max(axis=1) < 1e-4) > 0.999


ROWS_OF_A_LIDAR = [
    [np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)]
    for a in np.linspace(-np.pi, np.pi, 91)
    for e in np.deg2rad([-90, -60, -16, -1, 0, 1, 15, 89.99, 90])
]


@pytest.mark.parametrize("lidar", [True, False], ids=["in rows", "anywhere"])
@given(
    axes=st.lists(st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda v: math.hypot(*v) > 0.1), min_size=1, max_size=4),
    half=st.floats(0, math.pi + 0.1),
    turn=st.floats(-math.pi, math.pi),
)
@example(axes=[(0.0, 0.0, 1.0)], half=3.1875, turn=0.0)
@settings(deadline=None)
def test_a_window_has_each_ray_in_its_cone_and_none_twice(lidar, axes, half, turn):
    local = np.asarray(ROWS_OF_A_LIDAR if lidar else fan(3000), np.float32)
    local /= np.linalg.norm(local, axis=1, keepdims=True)
    grid = RayGrid(local)
    grid.rotation = pose_at(0, 0, 0, turn)[:3, :3]

    index, counts = grid.near(np.array(axes), np.full(len(axes), half))

    assert counts.sum() == len(index)
    for axis, found in zip(axes, np.split(index, np.cumsum(counts)[:-1]), strict=True):
        cosine = local.astype(float) @ (grid.rotation.T @ axis) / math.hypot(*axis)
        assert len(set(found)) == len(found)
        assert set(np.flatnonzero(np.arccos(np.clip(cosine, -1, 1)) <= half)) <= set(found)


@pytest.mark.parametrize("starts", [(0, 100, 300), tuple(range(0, 810, 9))])
@given(axis=st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda v: math.hypot(*v) > 0.1), half=st.floats(0, math.pi + 0.1))
@settings(deadline=None)
def test_a_window_in_one_span_has_the_rays_of_that_span_only(starts, axis, half):
    local = np.asarray(ROWS_OF_A_LIDAR, np.float32)
    grid, span = RayGrid(local, starts), np.arange(len(starts))

    index, counts = grid.near_local(np.tile(axis, (len(starts), 1)), np.full(len(starts), half), span)

    cosine = local.astype(float) @ np.array(axis) / math.hypot(*axis) / np.linalg.norm(local.astype(float), axis=1)
    inside = np.arccos(np.clip(cosine, -1, 1)) <= half
    ends = [*starts[1:], len(local)]
    for first, last, found in zip(starts, ends, np.split(index, np.cumsum(counts)[:-1]), strict=True):
        assert len(set(found)) == len(found)
        assert set(first + np.flatnonzero(inside[first:last])) <= set(found) <= set(range(first, last))


@pytest.fixture
def casts(monkeypatch):
    """How many rays each cast had."""
    found, cast = [], triangles.TriangleScene.cast

    def counted(self, rays, threads, **options):
        found.append(len(rays))
        return cast(self, rays, threads, **options)

    monkeypatch.setattr(triangles.TriangleScene, "cast", counted)
    return found


def test_rays_that_keep_still_are_cast_twice_at_what_does_and_then_no_more(casts):
    place = {"now": pose_at(0.0, 0.0, 0.0)}
    world = CastWorld(
        [mesh(box(20.0)), mesh(box(0.5), "/World/B/m", "/World/B"), Plane("/World/P", None, (0, 0, -3), (0, 0, 1))],
        lambda _: place["now"][None],
    )
    directions = fan(FEW_RAYS + 1)  # all of fewer are cast at what moves, too
    rays = bundle((0, 0, 0), directions, ordered=True)
    rays.memory = RayMemory()
    whole = []
    for step in range(5):
        place["now"] = pose_at(3.0 + step, 2.0, 0.0)
        casts.clear()
        hits = world.cast(rays, normals=True)
        whole.append(casts.count(len(rays.table)))
        fresh = world.cast(bundle((0, 0, 0), directions, ordered=True), normals=True)
        for name in ("distance", "normals", "number"):
            np.testing.assert_array_equal(getattr(hits, name), getattr(fresh, name))

    assert whole == [1, 1, 0, 0, 0]


def test_rays_that_turn_or_start_elsewhere_or_miss_out_something_are_cast_again(casts):
    world = CastWorld([mesh(box(20.0)), mesh(box(1.0, (5.0, 0.0, 0.0)), "/World/Pole")])
    rays = bundle((0, 0, 0), fan())
    rays.memory = RayMemory()

    def distances():
        casts.clear()
        return world.cast(rays).distance, casts.count(len(rays.table))

    for _ in range(2):
        distances()
    assert distances()[1] == 0
    rays.origin = np.array([1.0, 0.0, 0.0])
    moved, count = distances()
    assert count == 1
    np.testing.assert_array_equal(moved, world.cast(bundle((1, 0, 0), fan())).distance)
    rays.exclude = frozenset({"/World/Pole"})
    through, count = distances()
    assert count == 1
    np.testing.assert_array_equal(through, world.cast(bundle((1, 0, 0), fan(), rays.exclude)).distance)
    rays.table[:, 3:6] *= -1
    rays.columns = None
    rays.memory.forget()
    turned, count = distances()
    assert count == 1
    np.testing.assert_array_equal(turned, world.cast(bundle((1, 0, 0), -fan(), rays.exclude)).distance)


def test_no_scene_is_built_when_a_mesh_of_many_triangles_moves(monkeypatch):
    places = {"now": pose_at(5.0, 0.0, 0.0)}
    world = CastWorld([mesh(sphere(0.5, 20), "/World/B", "/World/B")], lambda _: places["now"][None])
    world.cast(bundle((0, 0, 0), [[1, 0.01, 0]]))  # builds the one scene of all moving meshes
    built = []
    monkeypatch.setattr(triangles.TriangleScene, "__init__", lambda self, *given, **more: built.append(1))

    for x in (5.0, 6.0, 7.0):
        places["now"] = pose_at(x, 0.0, 0.0)
        assert world.cast(bundle((0, 0, 0), [[1, 0.01, 0]])).distance[0] == pytest.approx(x - 0.5, abs=1e-2)

    assert not built


def test_a_ray_that_misses_a_moving_mesh_meets_no_other_that_is_not_on_its_way():
    """The meshes stand in neighbouring cells of one scene; in the world each is alone in its direction."""
    generator = np.random.default_rng(3)
    shapes = [box(tuple(generator.uniform(0.1, 1.0, 3))) for _ in range(40)]
    angle = np.arange(40) * 2 * np.pi / 40
    poses = np.stack([pose_at(60 * np.cos(a), 60 * np.sin(a), 0.0, turn=a) for a in angle])
    world = CastWorld([mesh(s, f"/World/B{i}", f"/World/B{i}") for i, s in enumerate(shapes)], lambda _: poses)
    direction = fan(20000) * [1, 1, 0.02]

    hits = world.cast(bundle((0, 0, 0), direction, ordered=True))

    toward = np.round(np.arctan2(direction[:, 1], direction[:, 0]) / (2 * np.pi / 40)).astype(int) % 40
    hit = np.isfinite(hits.distance)
    assert 500 < hit.sum() < 10000
    np.testing.assert_array_equal(hits.surfaces()[hit], toward[hit])
    assert np.all(np.abs(hits.distance[hit] - 60) < 1.75)  # no corner is farther from its middle than sqrt(3)


@pytest.mark.parametrize("inside", [(0.0, 0.0, 0.0), (0.9, 0.9, 0.9), (1.1, 0.0, 0.0)])
def test_a_sensor_within_the_bounds_of_a_moving_mesh_sees_what_a_static_one_shows(inside):
    shape = box((1.0, 1.0, 1.0))
    pose = pose_at(3.0, -2.0, 0.5, turn=0.3)
    origin = pose[:3, :3] @ np.array(inside) + pose[:3, 3]
    standing = mesh((shape[0] @ pose[:3, :3].T + pose[:3, 3], shape[1]))
    rays = fan(3000)

    moving = CastWorld([mesh(shape, "/World/B", "/World/B")], lambda _: pose[None]).cast(bundle(origin, rays))
    static = CastWorld([standing]).cast(bundle(origin, rays))

    np.testing.assert_allclose(moving.distance, static.distance, atol=2e-5)


@pytest.mark.parametrize("offset", OFFSETS)
def test_a_mesh_that_deforms_is_hit_where_its_points_are(offset):
    """A square across the way, which bulges towards the sensor: its middle comes nearer by as much."""
    edge = np.linspace(-1.0, 1.0, 3)
    flat = np.array([[0.0, y, z] for y in edge for z in edge])
    faces = np.array([[a, a + 1, a + 4, a, a + 4, a + 3] for a in (0, 1, 3, 4)], np.uint32).reshape(-1, 3)
    cloth = mesh((flat, faces), "/World/Cloth")
    wall = mesh(box((0.5, 9.0, 9.0), (offset + 8.5, 0.0, 0.0)), "/World/Wall")
    state = {"bulge": 0.0}

    def points(mesh, _):
        assert mesh is cloth
        moved = np.add(flat, [offset + 5.0, 0.0, 0.0])
        moved[4, 0] -= state["bulge"]
        return moved

    world = CastWorld([cloth, wall], soft=frozenset({"/World/Cloth"}), points=points)
    rays = bundle((offset, 0.0, 0.0), [[1.0, 0.0, 0.0], [1.0, 0.9, 0.0], [-1.0, 0.0, 0.0]], ordered=True)

    for bulge in (0.0, 0.5, 1.25):
        state["bulge"] = bulge
        hits = world.cast(rays)
        # Beside the square a ray meets the wall 8 m ahead.
        np.testing.assert_allclose(hits.distance, [5.0 - bulge, 8.0 * math.hypot(1.0, 0.9), np.inf], rtol=1e-6)
        assert hits.surfaces().tolist() == [0, 1, -1]
    assert world.cast(bundle((offset, 0.0, 0.0), [[1.0, 0.0, 0.0]], frozenset({"/World/Cloth"}))).surfaces() == [1]


def test_what_is_excluded_is_never_hit_nor_what_lies_below_it():
    meshes = [
        mesh(box((0.5, 0.5, 0.5), (2.0, 0.01, 0.02)), "/World/Robot/Cover"),
        mesh(sphere(0.5, 30), "/World/Robot/Arm/m", "/World/Robot/Arm"),
        mesh(box((0.5, 0.5, 0.5)), "/World/Robot2", "/World/Robot2"),
        Plane("/World/Robot/Pad", None, np.array([1.0, 0, 0]), np.array([1.0, 0, 0])),
    ]
    poses = np.stack([pose_at(4.0, 0.01, 0.02), pose_at(8.0, 0.01, 0.02)])
    world = CastWorld(meshes, lambda _: poses)
    forward = [[1.0, 0.0, 0.0]]

    assert world.cast(bundle((0, 0, 0), forward)).distance[0] == pytest.approx(1.0)
    hits = world.cast(bundle((0, 0, 0), forward, frozenset({"/World/Robot"})))
    assert hits.distance[0] == pytest.approx(7.5)
    assert hits.surfaces().tolist() == [2]


def test_the_nearest_of_static_moving_and_plane_wins():
    meshes = [
        mesh(box((0.5, 0.5, 0.5), (8.0, 0.01, 0.02)), "/World/Static"),
        mesh(box((0.5, 0.5, 0.5)), "/World/Light", "/World/Light"),
        mesh(sphere(0.5, 30), "/World/Heavy", "/World/Heavy"),
        Plane("/World/Wall", None, np.array([20.0, 0, 0]), np.array([-1.0, 0, 0])),
    ]
    places = {"/World/Light": 10.0, "/World/Heavy": 12.0}
    world = CastWorld(meshes, lambda _: np.stack([pose_at(x, 0.01, 0.02) for x in places.values()]))
    ray = bundle((0, 0, 0), [[1.0, 0.0, 0.0]])

    def nearest():
        hits = world.cast(ray, normals=True)
        np.testing.assert_allclose(np.abs(hits.normals[0]), [1, 0, 0], atol=0.1)
        return int(hits.surfaces()[0]), round(float(hits.distance[0]), 1)

    assert nearest() == (0, 7.5)
    places["/World/Light"] = 5.0
    assert nearest() == (1, 4.5)
    places["/World/Heavy"] = 3.0
    assert nearest() == (2, 2.5)
    places.update({"/World/Light": -5.0, "/World/Heavy": -5.0})
    assert nearest() == (0, 7.5)


def test_rays_may_start_beside_the_origin():
    world = CastWorld([Plane("/World/G", None, np.zeros(3), np.array([0, 0, 1.0])), mesh(box((1, 1, 1), (9, 0, 5)))])
    offsets = np.array([[0, 0, 0.5], [0.25, 0, 0]], np.float32)

    hits = world.cast(bundle((0, 0.01, 5.02), [[0, 0, -1], [1, 0, 0]], offsets=offsets))

    np.testing.assert_allclose(hits.distance, [5.52, 7.75], atol=1e-5)


def test_thread_count_and_other_sensors_change_no_bit():
    points, faces = sphere(4.0, 40)
    meshes = [
        mesh(box((30.0, 30.0, 5.0))),
        mesh((points, faces), "/World/Heavy", "/World/Heavy"),
        mesh(box((0.5, 0.5, 0.5)), "/World/Light", "/World/Light"),
    ]
    poses = np.stack([pose_at(9.0, 2.0, 0.0, 0.3), pose_at(-4.0, 0.0, 1.0, 1.0)])

    def measured(threads, others):
        world = CastWorld(meshes, lambda _: poses, lambda: threads)
        for number in range(others):
            world.cast(bundle((700.0 * number, 0.1 * number, 0.0), fan(500, number)), normals=True)
        hits = world.cast(bundle((0.3, 0.2, 0.1), fan(), ordered=True), normals=True)
        return hits.distance.tobytes() + hits.normals.tobytes()

    alone = measured(1, 0)
    assert measured(2, 0) == measured(0, 0) == alone
    assert measured(2, 3) == measured(2, 10) == alone


@pytest.mark.parametrize("moves", [False, True])
@pytest.mark.parametrize("offset", [0.0, 333.3, 1e6 + 333.3])
@pytest.mark.parametrize("turn", [0.0, 0.3])
def test_a_sensor_exactly_on_its_mount_sees_what_it_looks_up_at_and_not_into_the_mount(moves, offset, turn):
    place = pose_at(offset, -offset, 0.0, turn)
    top = place[:3, 3] + [0.1, 0.2, 0.5]
    mount, room = box(0.5), box((20.0, 30.0, 5.0), place[:3, 3])
    body = "/World/Mount" if moves else None
    points = mount[0] if moves else mount[0] @ place[:3, :3].T + place[:3, 3]
    world = CastWorld([mesh(room), mesh((points, FACES), "/World/Mount", body)], lambda _: place[None])
    up = np.array([d for d in fan() if d[2] > 0.1 * np.linalg.norm(d)])

    seen = world.cast(bundle(top, up), normals=True)
    into = world.cast(bundle(top, -up))

    alone = CastWorld([mesh(room)]).cast(bundle(top, up), normals=True)
    np.testing.assert_allclose(seen.distance, alone.distance, atol=1e-4)
    assert np.all(seen.surfaces() == 0)
    np.testing.assert_array_equal(seen.normals, alone.normals)
    assert np.all(into.distance < 1e-3)


def test_an_empty_world_is_all_misses():
    hits = CastWorld([]).cast(bundle((0, 0, 0), fan(10)), normals=True)

    assert np.all(np.isinf(hits.distance))
    assert np.all(hits.surfaces() == -1)
    assert not hits.normals.any()


def test_too_many_scenes_are_refused_before_the_process_crashes(monkeypatch):
    gc.collect()  # so that no scene of an earlier test goes in between
    monkeypatch.setattr(triangles, "MAX_SCENES", triangles.alive())

    with pytest.raises(RunError, match=r"ray casting: .* scenes are alive"):
        CastWorld([mesh(box((1, 1, 1)))]).cast(bundle((0, 0, 0), [[1, 0, 0]]))


def test_scenes_that_nobody_holds_make_room_again():
    gc.collect()
    before = triangles.alive()
    world = CastWorld([mesh(box((1, 1, 1)))])
    world.cast(bundle((0, 0, 0), [[1, 0, 0]]))
    assert triangles.alive() == before + 1

    del world

    assert triangles.alive() == before


def ball(path):
    form = closed_form("Sphere", {"radius": 0.6}, "Z")
    return Solid(path, path, form, lambda: sphere(0.6, 10))


def soft_points(surface, state):
    return surface.vertices + 0.3 * np.array([0.0, 0.0, state or 0])


@pytest.mark.parametrize("heavy", [False, True], ids=["gathered meshes", "meshes in cells"])
@pytest.mark.parametrize("offset", [False, True], ids=["one origin", "an origin for each ray"])
@pytest.mark.parametrize("grid", ["none", "whole", "cut"])
def test_rays_in_spans_meet_what_they_meet_when_each_state_is_cast_alone(heavy, offset, grid):
    """Moving solids, meshes and a plane, cloth, and a room that stands still; twice, as what stands still is kept."""
    shape = sphere(0.7, 30) if heavy else box((0.5, 0.7, 0.6))
    names = [f"/World/B{number}" for number in range(8)]
    moving = [ball(name) if number % 2 else mesh(shape, name, name) for number, name in enumerate(names)]
    floor = Plane("/World/Lift", "/World/Lift", np.array([0.0, 0.0, -1.0]), np.array([0.0, 0.0, 1.0]))
    cloth = mesh(box((0.8, 0.8, 0.05), (2.0, 2.0, 1.0)), "/World/Cloth")
    bodies = {name: number for number, name in enumerate([*names, "/World/Lift"])}

    def poses(state):
        turns = [0.7 * number + 0.2 * state for number in bodies.values()]
        return np.stack([pose_at(3 * math.cos(a), 3 * math.sin(a), 0.1 * state, turn=a) for a in turns])

    world = CastWorld(
        [mesh(box((9, 9, 9)), "/World/Room"), *moving, floor, cloth],
        poses,
        soft=frozenset({"/World/Cloth"}),
        points=soft_points,
    )
    ends, states = (0, 500, 1300, 4000), (0, 1, 2)
    offsets = np.random.default_rng(3).uniform(-0.05, 0.05, (4000, 3)).astype(np.float32) if offset else None
    whole = bundle((0.1, 0.2, 0.3), fan(), offsets=offsets)
    whole.memory = RayMemory()
    rows = [slice(*each) for each in itertools.pairwise(ends)]
    alone = []
    for part, state in zip(rows, states, strict=True):
        table = whole.table[part].copy()
        own = RayBundle(whole.origin, table, None if offsets is None else offsets[part])
        alone.append(world.cast(own, state, normals=True, spots=True))
    whole.spans = [whole.some(part) for part in rows]
    found = RayGrid(whole.table[:, 3:].copy(), ends[:-1] if grid == "cut" else (0,))
    for number, span in enumerate(whole.spans if grid != "none" else ()):
        span.grid, span.first, span.span = found, ends[number], number if grid == "cut" else 0

    for _ in range(3):
        together = world.cast(whole, states, normals=True, spots=True)

        for hits, part in zip(alone, rows, strict=True):
            mine = together.some(part)
            np.testing.assert_array_equal(mine.distance, hits.distance)
            np.testing.assert_array_equal(mine.normals, hits.normals)
            np.testing.assert_array_equal(mine.surfaces(), hits.surfaces())
            np.testing.assert_array_equal(mine.spots.triangle, hits.spots.triangle)
    assert len(set(together.surfaces())) == len(world.surfaces)
