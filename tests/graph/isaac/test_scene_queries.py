"""Queries of `omni.physx`: a box of 1 m with its centre at x = 5, a ball of 0.5 m radius behind it at x = 8."""

from importlib import import_module

import pytest

import graph.isaac
from graph.sim import App

PRIMS = {
    "/World/Box": {"type": "Cube", "size": 1.0, "translate": [5, 0, 0], "rigid_body": True},
    "/World/Ball": {"type": "Sphere", "radius": 0.5, "translate": [8, 0, 0]},
}


@pytest.fixture
def queries():
    with App(physics_hz=60, loop_hz=60) as app, graph.isaac.importable():
        app.add_prims(PRIMS)
        import_module("isaacsim.core.simulation_manager").SimulationManager.set_physics_dt(1 / 60)
        app.stage.DefinePrim("/Physics", "PhysicsScene").GetAttribute("physics:gravityMagnitude").Set(0.0)
        app.play()
        app.update()
        yield import_module("omni.physx").get_physx_scene_query_interface()


def test_a_ray_hits_the_nearest_collider(queries):
    hit = queries.raycast_closest((0, 0, 0), (2, 0, 0), 100.0)
    assert (hit["hit"], hit["rigidBody"], hit["collision"]) == (True, "/World/Box", "/World/Box")
    assert hit["distance"] == pytest.approx(4.5)
    assert hit["position"] == pytest.approx((4.5, 0, 0))
    assert hit["normal"] == pytest.approx((-1, 0, 0))
    assert queries.raycast_closest((0, 0, 0), (1, 0, 0), 4.0) == {"hit": False}
    assert queries.raycast_any((0, 0, 0), (1, 0, 0), 5.0)
    assert not queries.raycast_any((0, 0, 2), (1, 0, 0), 100.0)


def test_every_hit_is_reported_until_a_report_says_no(queries):
    seen = []
    assert queries.raycast_all((0, 0, 0), (1, 0, 0), 100.0, lambda hit: seen.append(hit) or True)
    assert [(hit.collision, hit.distance) for hit in seen] == [
        ("/World/Box", pytest.approx(4.5)),
        ("/World/Ball", pytest.approx(7.5, abs=1e-3)),
    ]
    seen.clear()
    assert queries.raycast_all((0, 0, 0), (1, 0, 0), 100.0, lambda hit: seen.append(hit))
    assert len(seen) == 1


def test_a_moving_sphere_stops_a_radius_before_the_box(queries):
    hit = queries.sweep_sphere_closest(0.25, (0, 0, 0), (1, 0, 0), 100.0)
    assert hit["distance"] == pytest.approx(4.25, abs=1e-3)
    assert queries.sweep_sphere_any(0.25, (0, 0, 0.7), (1, 0, 0), 100.0)  # 0.7 m up, less 0.25 m: below its top
    assert not queries.sweep_sphere_any(0.15, (0, 0, 0.7), (1, 0, 0), 100.0)


def test_spheres_and_boxes_overlap_what_is_in_them(queries):
    seen = []
    assert queries.overlap_sphere(4.0, (6.5, 0, 0), lambda hit: seen.append(hit.rigid_body) or True) == 2
    assert sorted(seen) == ["/World/Ball", "/World/Box"]
    assert queries.overlap_sphere(4.0, (6.5, 0, 0), lambda hit: True, True) == 1
    assert not queries.overlap_sphere_any(0.5, (0, 0, 0))
    # A box of 6 m along its x, turned by 90 degrees about y: it stands upright at x = 5, or lies and reaches x = 8.
    half, upright, level = (3.0, 0.1, 0.1), (0.0, 0.5**0.5, 0.0, 0.5**0.5), (0.0, 0.0, 0.0, 1.0)
    assert queries.overlap_box(half, (5, 0, 0), upright, lambda hit: True) == 1
    assert queries.overlap_box(half, (5, 0, 0), level, lambda hit: True) == 2
    assert queries.overlap_box_any(half, (5, 0, 3.4), upright)
    assert not queries.overlap_box_any(half, (5, 0, 3.6), upright)


def test_a_direction_without_a_length_is_refused(queries):
    with pytest.raises(ValueError, match="has no length"):
        queries.raycast_closest((0, 0, 0), (0, 0, 0), 1.0)
