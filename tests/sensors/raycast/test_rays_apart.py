"""Which rays that begin apart from each other are tried against moving surfaces."""

import numpy as np

from sensors.raycast.places import Bounds, windows
from sensors.raycast.rays import RayBundle

CENTRES, RADII = np.array([[10.0, 7.0, 0.0], [10.0, 100.0, 0.0]]), np.array([0.5, 1.5])


def tried(distance):
    """For each of two spheres 10 m ahead, the rays that are tried: 130 rays ahead, 1 m apart, that end at distances."""
    table, offsets = np.zeros((130, 6), np.float32), np.zeros((130, 3), np.float32)
    table[:, 3], offsets[:, 1] = 1.0, np.arange(130)
    rays = RayBundle(np.zeros(3), table, offsets)
    half = RADII[:, None] * np.ones(3) / np.sqrt(3)
    bounds = Bounds(np.stack([CENTRES - half, CENTRES + half], 1), RADII, np.zeros(2, np.intp))
    places = bounds.places([rays], np.eye(4)[None, None])
    pairs = windows(rays, [rays], places, np.ones((1, 2), bool), distance.astype(np.float32))
    found = {int(surface): pairs.index[pairs.pair == row].tolist() for row, surface in enumerate(pairs.surface)}
    return [found.get(sphere, []) for sphere in range(2)]


def test_a_ray_is_tried_where_its_own_line_passes_a_sphere():
    """Ray i is at y = i: within 0.5 m of 7 is one, within 1.5 m of 100 are three, in another block of 64."""
    assert tried(np.full(130, np.inf)) == [[7], [99, 100, 101]]


def test_a_ray_that_ends_before_a_sphere_is_not_tried():
    """The spheres begin at 9.5 m and 8.5 m, the second one beside its middle at 10 - sqrt(1.5^2 - 1) = 8.88 m."""
    ends = np.full(130, np.inf)
    ends[[7, 99, 100]] = 9.4, 8.8, 8.6
    assert tried(ends) == [[], [100, 101]]


def test_a_distance_that_is_not_a_number_loses_no_other_ray():
    rays = np.full(130, np.inf)
    rays[5] = np.nan
    assert tried(rays) == [[7], [99, 100, 101]]
