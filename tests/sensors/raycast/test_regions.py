import itertools
import math
from contextlib import nullcontext

import numpy as np
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from graph.sim.geometry.surfaces import Mesh
from sensors.raycast.rays import RayBundle
from sensors.raycast.standing import CELLS, Regions
from sensors.raycast.world import CastWorld
from tests.support.unpruned import unpruned

PLACES = st.tuples(*(st.floats(-500, 500),) * 3).map(np.array)
REACHES = st.floats(0.5, 300)
CORNERS = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
SIDES = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
FACES = np.array([half for a, b, c, d in SIDES for half in ([a, b, c], [a, c, d])], np.uint32)


def cube(number, place):
    return Mesh(f"/World/Cube{number}", None, CORNERS + place, FACES)


def members(boxes, origin, reach):
    within = Regions(boxes).within(origin, reach)
    return np.ones(len(boxes), bool) if within is None else np.frombuffer(within, bool)


@given(st.lists(PLACES, min_size=1, max_size=8), PLACES, REACHES)
def test_all_within_reach_is_in_and_nothing_far_beyond_it(places, origin, reach):
    """Beyond the reach rounded up (by a side at most) and the diagonal of a cell nothing is in."""
    boxes = np.array([(place - 0.5, place + 0.5) for place in places])
    gaps = np.maximum(0, np.maximum(boxes[:, 0] - origin, origin - boxes[:, 1]))
    distance = np.sqrt((gaps * gaps).sum(axis=1))
    side = 2.0 ** math.floor(math.log2(reach)) / CELLS
    found = members(boxes, origin, reach)
    assert found[distance <= reach].all()
    assert found.all() or not found[distance > (reach + side * (1 + math.sqrt(3))) * (1 + 1e-9)].any()


def test_a_place_in_the_same_cell_has_the_same_surfaces():
    """A reach of 10 m: cells of 2 m, and 10 m are whole sides. From the cell from 0 to 2 m it goes to 12 m, from the
    next one to 14 m.
    """
    boxes = np.array([[[-0.5] * 3, [0.5] * 3], [[13, -0.5, -0.5], [14, 0.5, 0.5]], [[11.9, 0, 0], [12.5, 1, 1]]])
    for x in (0.0, 1.0, 1.999):
        assert members(boxes, np.array([x, 0.5, 0.5]), 10.0).tolist() == [True, False, True]
    assert members(boxes, np.array([2.0, 0.5, 0.5]), 10.0).tolist() == [True, True, True]


def test_without_a_limit_everything_is_in():
    assert Regions(np.array([[[1e9] * 3, [2e9] * 3]])).within(np.zeros(3), math.inf) is None
    assert Regions(np.zeros((0, 2, 3))).within(np.zeros(3), 1.0) is None


@settings(deadline=None)
@given(st.lists(PLACES, min_size=1, max_size=6), PLACES, REACHES, st.integers(0, 2**32 - 1))
def test_hits_within_reach_are_the_same_without_pruning(places, origin, reach, seed):
    """Of cubes that touch none: which of two faces in one place is met is not said."""
    assume(all(np.abs(one - other).max() > 1.001 for one, other in itertools.combinations(places, 2)))
    meshes = [cube(number, place) for number, place in enumerate(places)]
    rng = np.random.default_rng(seed)
    towards = rng.normal(size=(40, 3)) + 3 * rng.choice([*places], 40)
    table = np.zeros((40, 6), np.float32)
    table[:, 3:] = towards / np.linalg.norm(towards, axis=1)[:, None]
    found = []
    for how in (nullcontext, unpruned):
        with how():
            hits = CastWorld(meshes).cast(RayBundle(origin, table.copy(), reach=reach), normals=True, spots=True)
        near = hits.distance <= reach
        found.append((near, hits.distance[near], hits.surfaces()[near], hits.normals[near], hits.spots.uv[near]))
    for pruned, whole in zip(*found, strict=True):
        assert np.array_equal(pruned, whole)
