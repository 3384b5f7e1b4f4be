"""Rays and overlaps of colliders: a wall of which the front face is at x = 4, a ball of radius 0.5 at x = 2."""

import json
import math

import numpy as np
import pytest

from graph.sim import App
from graph.testing import run_node

SCENE = {"type": "PhysicsScene", "attributes": {"physics:gravityMagnitude": 0.0}}
BALL = {"type": "Sphere", "radius": 0.5, "translate": [2, 0, 1], "rigid_body": True}
PRIMS = {
    "/World/Scene": SCENE,
    "/World/Wall": {"type": "Cube", "size": 1.0, "scale": [2, 4, 2], "translate": [5, 0, 1]},
    "/World/Ball": BALL,
    "/World/Ghost": {"type": "Cube", "size": 0.2, "translate": [1, 0, 1], "collision": False},
}
TYPED = {
    **{
        "origin": "pointd[3]",
        "position": "pointd[3]",
        "direction": "vectord[3]",
        "raycastRange": "double",
        "sweepRange": "double",
    },
    **{"radius": "double", "dimensions": "double[3]", "rotation": "double[3]"},
}


def app_of(tmp_path, prims):
    file = tmp_path / "world.json"
    file.write_text(json.dumps({"tickgraph": 1, "scene": {"prims": prims}}))
    return App.from_file(file)


@pytest.fixture
def ask(tmp_path):
    """The trace of a query node that is asked once in a world without gravity."""

    def asked(name, **inputs):
        typed = {key: {"type": TYPED[key], "value": one} if key in TYPED else one for key, one in inputs.items()}
        with app_of(tmp_path, PRIMS) as app:
            return run_node(f"omni.physx.graph.SceneQuery{name}", inputs=typed, pulses={"execIn": [0]}, app=app)

    return asked


def test_the_nearest_collider_on_a_ray_is_found_with_place_and_normal(ask):
    """From x = 0 the ball begins at 2 - 0.5 = 1.5; what has no collider is passed."""
    trace = ask("RaycastClosest", origin=[0, 0, 1], direction=[10, 0, 0])
    assert trace.fired("execOut") == [0]
    assert trace.values("hit") == [True]
    assert (trace.values("colliderPrimPath"), trace.values("bodyPrimPath")) == (["/World/Ball"], ["/World/Ball"])
    assert trace.values("distance")[0] == pytest.approx(1.5, abs=1e-6)
    assert np.allclose(trace.values("position")[0], [1.5, 0, 1], atol=1e-6)
    assert np.allclose(trace.values("normal")[0], [-1, 0, 0], atol=1e-6)


def test_every_collider_on_a_ray_is_listed_the_nearest_first(ask):
    trace = ask("RaycastAll", origin=[0, 0, 1], direction=[1, 0, 0])
    assert list(trace.values("colliderPrimPaths")[0]) == ["/World/Ball", "/World/Wall"]
    assert list(trace.values("bodyPrimPaths")[0]) == ["/World/Ball", ""]
    assert np.allclose(trace.values("distances")[0], [1.5, 4.0], atol=1e-6)


@pytest.mark.parametrize(
    ("inputs", "hit"),
    [
        ({"direction": [1, 0, 0]}, True),
        ({"direction": [1, 0, 0], "raycastRange": 1.4}, False),
        ({"direction": [1, 0, 0], "raycastRange": 1.6}, True),
        ({"direction": [1, 0, 0], "raycastRange": -1.0}, True),
        ({"direction": [-1, 0, 0]}, False),
    ],
)
def test_a_ray_ends_at_its_range(ask, inputs, hit):
    assert ask("RaycastAny", origin=[0, 0, 1], **inputs).values("hit") == [hit]


def test_a_ray_from_inside_a_collider_hits_it_at_once(ask):
    trace = ask("RaycastClosest", origin=[2, 0, 1], direction=[0, 1, 0])
    assert trace.values("distance")[0] == 0
    assert np.allclose(trace.values("normal")[0], [0, -1, 0], atol=1e-6)


@pytest.mark.parametrize(
    ("radius", "found"), [(1.4, []), (1.6, ["/World/Ball"]), (4.1, ["/World/Ball", "/World/Wall"])]
)
def test_colliders_in_a_sphere_are_listed(ask, radius, found):
    """From the origin at height 1 the ball begins at 1.5, the wall at 4."""
    trace = ask("OverlapSphereAll", position=[0, 0, 1], radius=radius)
    assert sorted(trace.values("colliderPrimPaths")[0]) == found
    assert ask("OverlapSphereAny", position=[0, 0, 1], radius=radius).values("overlap") == [bool(found)]


@pytest.mark.parametrize(
    ("degrees", "found"),
    [(0.0, []), (45.0, ["/World/Ball"])],
)
def test_a_box_is_turned(ask, degrees, found):
    """A square of side 2 reaches 1 along x, turned by 45 degrees about z 1.414: the ball begins 0.1 + 1.0 away."""
    place = {"position": [0.4, 0, 1], "dimensions": [2, 2, 0.2], "rotation": [0, 0, degrees]}
    assert math.isclose(1.5 - 0.4, 1.1)
    assert list(ask("OverlapBoxAll", **place).values("colliderPrimPaths")[0]) == found
    assert ask("OverlapBoxAny", **place).values("overlap") == [bool(found)]


@pytest.mark.parametrize(
    ("name", "inputs", "message"),
    [
        ("RaycastAny", {"origin": [0, 0, 0], "direction": [0, 0, 0]}, "give it a length"),
        ("RaycastAny", {"origin": [0, math.nan, 0], "direction": [1, 0, 0]}, "give finite numbers"),
        ("OverlapSphereAny", {"position": [0, 0, 0], "radius": 0.0}, "give it a length above 0"),
        ("OverlapBoxAny", {"position": [0, 0, 0], "dimensions": [1, 0, 1], "rotation": [0, 0, 0]}, "above 0"),
    ],
)
def test_a_query_without_a_size_fails_and_says_why(ask, name, inputs, message):
    with pytest.raises(Exception, match=message):
        ask(name, **inputs)


def test_a_moving_sphere_meets_what_it_touches(ask):
    """0.6 beside the ball it touches at 0.5 + 0.3 = 0.8, so at x = 2 - sqrt(0.64 - 0.36); the wall at 4 - 0.3."""
    trace = ask("SweepSphereAll", origin=[0, 0.6, 1], direction=[1, 0, 0], radius=0.3)
    assert list(trace.values("colliderPrimPaths")[0]) == ["/World/Ball", "/World/Wall"]
    assert np.allclose(trace.values("distances")[0], [2 - math.sqrt(0.28), 3.7], atol=1e-3)
    assert np.allclose(trace.values("normals")[0][1], [-1, 0, 0], atol=1e-3)
    assert np.allclose(trace.values("positions")[0][1], [4, 0.6, 1], atol=1e-3)


@pytest.mark.parametrize(("side", "reach", "hit"), [(0.9, -1.0, True), (0.6, 1.4, False), (0.6, 1.6, True)])
def test_a_sweep_ends_at_its_range(ask, side, reach, hit):
    """At 0.9 beside the ball (0.5 + 0.3 = 0.8) only the wall is met; at 0.6 the ball after 1.47."""
    inputs = {"origin": [0, side, 1], "direction": [1, 0, 0], "radius": 0.3, "sweepRange": reach}
    assert ask("SweepSphereAny", **inputs).values("hit") == [hit]
    nearest = ask("SweepSphereClosest", **inputs).values("colliderPrimPath")[0]
    assert nearest == ("" if not hit else "/World/Wall" if side == 0.9 else "/World/Ball")
