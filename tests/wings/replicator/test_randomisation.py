import numpy as np
import pytest

from graph import ComputeError
from graph.testing import run_node
from wings.replicator.samplers import sample_shell

PATHS = [f"/World/Ball{number}" for number in range(40)]


@pytest.fixture
def balls(stage, world):
    """A function that opens a world with 40 Xforms below a parent at (10, 0, 0)."""
    from pxr import UsdGeom

    UsdGeom.Xform.Define(stage, "/World").AddTranslateOp().Set((10, 0, 0))
    for path in PATHS:
        UsdGeom.Xform.Define(stage, path)
    return world


def sample(app, node, updates=1, paths=PATHS, **inputs):
    """Distances of the prims from their parent after each update."""
    seen = []

    def look():
        seen.append([list(app.stage.GetPrimAtPath(path).GetAttribute("xformOp:translate").Get()) for path in paths])

    app.on("end", look)
    given = {"prims": paths, **inputs}
    trace = run_node(node, inputs=given, pulses={"execIn": range(updates)}, updates=updates, app=app)
    assert trace.fired("execOut") == list(range(updates))
    return np.array(seen)


def distances(places):
    return np.linalg.norm(places, axis=-1)


def test_prims_are_placed_in_a_ball_about_their_parent(balls):
    app = balls()
    places = sample(app, "OgnSampleInSphere", radius=2.0)[0]
    assert 1.5 < distances(places).max() <= 2.0
    matrix = app.fabric.world_matrix(PATHS[0])
    assert matrix[:3, 3] == pytest.approx(places[0] + [10, 0, 0])


def test_prims_are_placed_on_a_sphere(balls):
    assert distances(sample(balls(), "OgnSampleOnSphere", radius=3.0)) == pytest.approx(np.full((1, 40), 3.0))


@pytest.mark.parametrize("radii", [(1.0, 1.5), (1.5, 1.0)])
def test_prims_are_placed_between_two_spheres_given_in_any_order(balls, radii):
    found = distances(sample(balls(), "OgnSampleBetweenSpheres", radius1=radii[0], radius2=radii[1]))
    assert 1.0 <= found.min() < 1.2 < 1.4 < found.max() <= 1.5


def test_every_activation_places_again_and_equal_seeds_alike(balls):
    first = sample(balls(seed=3), "OgnSampleInSphere", 2)
    assert not np.allclose(first[0], first[1])
    assert np.array_equal(first, sample(balls(seed=3), "OgnSampleInSphere", 2))
    assert not np.allclose(first, sample(balls(seed=4), "OgnSampleInSphere", 2))


def test_points_are_spread_evenly_over_the_volume():
    points = sample_shell(np.random.default_rng(1), 1.0, 2.0, 200_000)
    # Half of the volume between 1 and 2 lies within cbrt(4.5); every direction is as likely.
    assert np.mean(distances(points) < 4.5 ** (1 / 3)) == pytest.approx(0.5, abs=0.005)
    assert points.mean(axis=0) == pytest.approx([0, 0, 0], abs=0.01)
    assert (points**2).mean(axis=0) == pytest.approx(np.full(3, (points**2).mean()), rel=0.01)


def test_a_body_is_moved_in_physics_too(stage, world):
    from pxr import UsdGeom, UsdPhysics

    ball = UsdGeom.Sphere.Define(stage, "/World/Ball")
    ball.AddTranslateOp(UsdGeom.XformOp.PrecisionFloat)
    UsdPhysics.RigidBodyAPI.Apply(ball.GetPrim())
    app = world(physics_hz=60, loop_hz=60)
    places = sample(app, "OgnSampleOnSphere", paths=["/World/Ball"], radius=5.0)
    assert app.fabric.world_matrix("/World/Ball")[:3, 3] == pytest.approx(places[0, 0], abs=1e-6)
    app.update(1)
    fallen = app.fabric.world_matrix("/World/Ball")[:3, 3] - places[0, 0]
    assert fallen[:2] == pytest.approx([0, 0], abs=1e-6)
    assert -0.02 < fallen[2] < 0


@pytest.mark.parametrize(
    ("inputs", "message"),
    [
        ({"prims": ["/World/Gone"]}, "there is no prim /World/Gone"),
        ({"prims": ["/World/Looks"]}, "/World/Looks is a Material, which has no place"),
        ({"radius": -1.0}, "a radius is -1; give a positive one"),
    ],
)
def test_what_cannot_be_placed_is_reported(balls, stage, inputs, message):
    stage.DefinePrim("/World/Looks", "Material")
    with pytest.raises(ComputeError, match=message):
        sample(balls(), "OgnSampleInSphere", **inputs)


def test_without_prims_nothing_follows(balls):
    trace = run_node("OgnSampleInSphere", pulses={"execIn": [0]}, app=balls())
    assert trace.fired("execOut") == []


def test_three_random_numbers_lie_within_their_bounds():
    trace = run_node("Random3f", inputs={"minimum": [0, 10, -1], "maximum": [1, 20, -1]}, updates=50)
    values = np.array(trace.values("output"))
    assert (values >= [0, 10, -1]).all()
    assert (values <= [1, 20, -1]).all()
    assert values[:, :2].std(axis=0).min() > 0.1
    again = run_node("Random3f", inputs={"minimum": [0, 10, -1], "maximum": [1, 20, -1]}, updates=50)
    assert np.array_equal(values, np.array(again.values("output")))


def test_bounds_the_wrong_way_round_are_refused():
    with pytest.raises(ComputeError, match=r"minimum \[1.0, 0.0, 0.0\] is above maximum"):
        run_node("Random3f", inputs={"minimum": [1, 0, 0], "maximum": [0, 0, 0]})


def test_indices_are_counted():
    assert run_node("OgnCountIndices", inputs={"indices": [4, 7, 9]}).value("count") == 3


def select(**inputs):
    trace = run_node("OgnIntervalFiltering", inputs=inputs, pulses={"execIn": [0]})
    assert trace.fired("execOut") == [0]
    return trace.value("outputs:indices").tolist(), trace.value("on_reset")


def test_environments_are_selected_every_interval():
    assert select(interval=5, frameCounts=[0, 5, 7, 10]) == ([1, 3], False)
    assert select(interval=5, frameCounts=[1, 2]) == ([], False)
    assert select(interval=0, frameCounts=[]) == ([], False)


def test_environments_that_were_reset_are_selected_as_they_are():
    assert select(ignoreInterval=True, indices=[2, 0], frameCounts=[5, 5], interval=5) == ([2, 0], True)


def test_an_interval_of_no_frames_is_refused():
    with pytest.raises(ComputeError, match="input interval is 0; give it at least 1 frame"):
        select(interval=0, frameCounts=[1])
