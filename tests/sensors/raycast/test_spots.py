"""Triangle and place in it of each hit: its corners, weighted, are where the ray ends, however the mesh was cast."""

import numpy as np
import pytest

from graph.sim.geometry.surfaces import Mesh, Plane
from sensors.raycast.rays import NOTHING, RayBundle, RayMemory
from sensors.raycast.world import CastWorld

FACES = np.array(
    [
        *([0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1]),
        *([2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]),
    ],
    np.uint32,
)
POSE = np.array([[0.0, -1, 0, 1.5], [1, 0, 0, -0.5], [0, 0, 1, 0.25], [0, 0, 0, 1]])


def box(path, centre, half=0.4, body=None, repeats=1):
    """repeats: each face so many times, further and further inside, so that the mesh is large."""
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], np.float64) * half
    points = np.concatenate([corners * (1 - 1e-4 * k) for k in range(repeats)]) + centre
    return Mesh(path, body, points, np.concatenate([FACES + np.uint32(8 * k) for k in range(repeats)]))


def cast(world, origin, memory=None, count=20_000):
    directions = np.random.default_rng(7).normal(size=(count, 3))
    table = np.zeros((count, 6), np.float32)
    table[:, 3:6] = directions / np.linalg.norm(directions, axis=1, keepdims=True)
    rays = RayBundle(np.array(origin), table, memory=memory)
    return rays, world.cast(rays, spots=True)


def places(world, hits, poses):
    """(n, 3) [m] by the triangles; not a number where nothing, or a plane, is hit."""
    out = np.full((len(hits.distance), 3), np.nan)
    surfaces = hits.surfaces()
    for number, surface in enumerate(world.surfaces):
        rows = np.flatnonzero(surfaces == number)
        if isinstance(surface, Mesh) and len(rows):
            a, b, c = np.moveaxis(world.vertices(number, poses)[surface.triangles[hits.spots.triangle[rows]]], 1, 0)
            u, v = hits.spots.uv[rows, :1].astype(float), hits.spots.uv[rows, 1:].astype(float)
            out[rows] = a * (1 - u - v) + b * u + c * v
    return out


@pytest.mark.parametrize(
    ("body", "repeats"),
    [(None, 1), ("/World/B", 1), ("/World/B", 200)],  # 2,400 triangles are too many to be gathered: they get cells
    ids=["static", "gathered", "cells"],
)
def test_the_corners_of_the_triangle_weighted_are_where_the_ray_ends(body, repeats):
    pose = POSE if body else np.eye(4)
    meshes = [
        box("/World/A", (2, 0, 0), body=body, repeats=repeats),
        box("/World/B", (0, 2, 0), 0.7, body=body, repeats=repeats),
        box("/World/C", (0, 0, 2), body=body, repeats=repeats),
    ]
    world = CastWorld(meshes, lambda state: pose[None])
    rays, hits = cast(world, (pose @ (0.1, 0.2, 0.0, 1.0))[:3])
    hit = np.isfinite(hits.distance)
    assert set(hits.surfaces()[hit].tolist()) == {0, 1, 2}
    ends = rays.origin + hits.distance[:, None].astype(float) * rays.directions.T
    np.testing.assert_allclose(places(world, hits, pose[None])[hit], ends[hit], atol=2e-5)


def test_what_is_nearer_brings_its_triangle_and_planes_have_none():
    meshes = [
        box("/World/Far", (3, 0, 0), 1.0),
        box("/World/Near", (1.5, 0, 0), 0.3, body="/World/Near"),
        Plane("/World/Wall", None, np.array([0.0, 0, -1]), np.array([0.0, 0, 1])),
    ]
    world = CastWorld(meshes, lambda state: np.eye(4)[None])
    rays, hits = cast(world, (0.0, 0.0, 0.0))
    surfaces = hits.surfaces()
    assert set(surfaces.tolist()) == {-1, 0, 1, 2}
    assert (hits.spots.triangle[(surfaces == 2) | (surfaces == -1)] == NOTHING).all()
    ends = rays.origin + hits.distance[:, None].astype(float) * rays.directions.T
    meshed = (surfaces == 0) | (surfaces == 1)
    np.testing.assert_allclose(places(world, hits, np.eye(4)[None])[meshed], ends[meshed], atol=2e-5)


def test_kept_hits_of_a_still_sensor_have_their_spots_and_casts_without_spots_do_not_spoil_them():
    world = CastWorld([box("/World/A", (2, 0, 0))])
    memory = RayMemory()
    rays, first = cast(world, (0.0, 0.0, 0.0), memory)
    assert world.cast(rays).spots is None
    for _ in range(3):
        again = world.cast(rays, spots=True)
        np.testing.assert_array_equal(again.spots.triangle, first.spots.triangle)
        np.testing.assert_array_equal(again.spots.uv, first.spots.uv)
        again.spots.uv[:] = -1  # the frame's own


def test_rays_that_start_apart_meet_only_the_mesh_in_whose_cell_they_are_cast():
    """Each moving mesh has a cell of its own; a ray that starts beyond its mesh could start in the cell of another."""
    places = {"A": ((3, 0, 0), 0.4), "B": ((0, 3, 0), 0.7), "C": ((-3, 0, 0.5), 0.5)}
    generator = np.random.default_rng(5)
    directions = generator.normal(size=(20_000, 3))
    offsets = generator.uniform(-6, 6, size=directions.shape).astype(np.float32)
    found = []
    for body in (None, "/World/B"):
        meshes = [box(f"/World/{name}", at, half, body=body, repeats=200) for name, (at, half) in places.items()]
        world = CastWorld(meshes, lambda state: np.eye(4)[None])
        table = np.zeros((len(directions), 6), np.float32)
        table[:, 3:6] = directions / np.linalg.norm(directions, axis=1, keepdims=True)
        hits = world.cast(RayBundle(np.zeros(3), table, offsets), spots=True)
        hit = np.isfinite(hits.distance)
        assert hits.spots.triangle[hit].max() < 200 * len(FACES)
        found.append((hit, hits.distance[hit]))
    (still, distances), (moving, others) = found
    assert still.sum() > 100
    assert (still != moving).sum() <= 3  # grazing rays
    both = still & moving
    np.testing.assert_allclose(distances[both[still]], others[both[moving]], atol=1e-4)
