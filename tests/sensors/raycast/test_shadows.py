"""Which points lie in the shadow of what moves, stands, deforms or is a plane."""

import numpy as np
import pytest

from graph.sim.geometry.surfaces import Mesh, Plane
from sensors.raycast.shadows import Shadows
from sensors.raycast.world import CastWorld

FACES = np.array(
    [
        *([0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1]),
        *([2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]),
    ],
    np.uint32,
)
CORNERS = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
AXIS = np.linspace(-6, 6, 121) + 0.013  # beside the edges of shadows
X, Y = (each.ravel() for each in np.meshgrid(AXIS, AXIS))
ON_GROUND = np.stack([X, Y, np.zeros(len(X))]).astype(np.float32)
SUN = np.array([0.0, 0.0, 1.0])


def cube(path, body=None, at=(0.0, 0.0, 0.0)):
    return Mesh(path, body, CORNERS + at, FACES, source=path)


def poses(state):
    """/A stands 2 m above the ground at x = state, /B 4 m above it at y = state."""
    found = np.tile(np.eye(4), (2, 1, 1))
    found[0, :3, 3], found[1, :3, 3] = (state, 0.0, 2.0), (0.0, state, 4.0)
    return found


def dark(shadows, light=SUN, state=0.0, far=True, origin=(0.0, 0.0, 0.0), points=ON_GROUND):
    light, origin = np.asarray(light), np.asarray(origin)
    ways = (light[:, None] if far else (light - origin)[:, None] - points).astype(np.float32)
    return shadows.blocked(origin, points, ways, np.arange(points.shape[1]), state, far=far)


def square(x, y, half):
    return (abs(X - x) < half) & (abs(Y - y) < half)


@pytest.mark.parametrize("boxes", [2, 80], ids=["all in one scene", "in cells"])
def test_a_moving_box_takes_its_shadow_with_it(boxes):
    """A cube under the sun darkens the square below it; many are kept in cells, those beside the way change nothing."""
    others = [cube(f"/C{number}", "/C", (50.0 + 2 * number, 0.0, 0.0)) for number in range(boxes - 2)]

    def all_poses(state):
        return np.concatenate([poses(state), np.eye(4)[None]])[: 3 if others else 2]

    shadows = Shadows(CastWorld([cube("/A", "/A"), cube("/B", "/B"), *others], all_poses), frozenset())
    for state in (0.0, 1.0, -3.0):
        assert np.array_equal(dark(shadows, state=state), square(state, 0.0, 0.5) | square(0.0, state, 0.5))


def test_a_lamp_throws_a_wider_shadow_and_none_of_what_hangs_above_it():
    """A lamp 3 m high over a cube whose upper face is 2.5 m high: rays of slope 0.5 / 0.5 reach 3 m aside."""
    shadows = Shadows(CastWorld([cube("/A", "/A"), cube("/B", "/B")], poses), frozenset())
    assert np.array_equal(dark(shadows, light=(0.0, 0.0, 3.0), far=False), square(0.0, 0.0, 3.0))


def test_what_is_excluded_throws_no_shadow():
    world = CastWorld([cube("/A", "/A"), cube("/B", "/B")], poses)
    assert np.array_equal(dark(Shadows(world, frozenset({"/A"})), state=2.0), square(0.0, 2.0, 0.5))
    assert not dark(Shadows(world, frozenset({"/A", "/B"}))).any()


def test_what_stands_what_moves_and_what_deforms_darken_together():
    def points(mesh, state):
        return np.add(CORNERS, (state, state, 1.0))

    cloth, post = cube("/Cloth"), cube("/Post", at=(-4.0, -4.0, 3.0))
    world = CastWorld(
        [post, cube("/A", "/A"), cloth], lambda state: poses(state)[:1], soft=frozenset({"/Cloth"}), points=points
    )
    for state in (1.0, 3.0):
        expected = square(-4.0, -4.0, 0.5) | square(state, 0.0, 0.5) | square(state, state, 0.5)
        assert np.array_equal(dark(Shadows(world, frozenset()), state=state), expected)


def test_a_plane_before_the_light_darkens_all_and_one_behind_the_points_none():
    below, above = (Plane("/P", None, np.array([0.0, 0.0, z]), SUN) for z in (-1.0, 5.0))
    assert not dark(Shadows(CastWorld([below]), frozenset())).any()
    assert dark(Shadows(CastWorld([above]), frozenset())).all()
    assert not dark(Shadows(CastWorld([above]), frozenset()), light=(0.0, 0.0, 4.0), far=False).any()


def test_far_from_the_origin_of_the_world_shadows_are_as_near_it():
    away = np.array([4e5, 3e5, 100.0])

    def moved(state):
        found = poses(state)
        found[:, :3, 3] += away
        return found

    shadows = Shadows(CastWorld([cube("/A", "/A"), cube("/B", "/B")], moved), frozenset())
    assert np.array_equal(dark(shadows, state=2.0, origin=away), square(2.0, 0.0, 0.5) | square(0.0, 2.0, 0.5))


def test_no_points_have_no_shadows():
    shadows = Shadows(CastWorld([cube("/A", "/A"), cube("/B", "/B")], poses), frozenset())
    for far in (True, False):
        assert dark(shadows, far=far, points=ON_GROUND[:, :0]).shape == (0,)
