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


TOUCHING = """
from isaacsim import SimulationApp
app = SimulationApp({"headless": True})
import numpy as np
import omni.timeline, omni.usd
from omni.physx import get_physx_simulation_interface
from omni.physx.bindings._physx import ContactEventHeaderVector, ContactEventType
from isaacsim.core.experimental.prims import RigidPrim
from pxr import PhysicsSchemaTools, PhysxSchema, UsdGeom, UsdPhysics
stage = omni.usd.get_context().get_stage()
UsdPhysics.Scene.Define(stage, "/World/Scene")
car = UsdGeom.Xform.Define(stage, "/World/Car").GetPrim()
floor, box = (UsdGeom.Cube.Define(stage, path) for path in ("/World/Floor", "/World/Car/Box"))
floor.AddTranslateOp().Set((0, 0, -1))
UsdGeom.Xformable(car).AddTranslateOp().Set((0, 0, 1))
UsdPhysics.RigidBodyAPI.Apply(car)
UsdPhysics.MassAPI.Apply(car).CreateMassAttr(2.0)
for one in (floor, box):
    UsdPhysics.CollisionAPI.Apply(one.GetPrim())
asked = PhysxSchema.PhysxContactReportAPI.Apply(car)
name = lambda number: str(PhysicsSchemaTools.intToSdfPath(number))
reports = []
def on_contact(headers: ContactEventHeaderVector, data):
    reports.append((headers, data))
held = get_physx_simulation_interface().subscribe_contact_report_events(on_contact)
timeline = omni.timeline.get_timeline_interface()
"""


def test_contact_reports_name_the_pair_and_carry_the_weight_in_each_step(run_script):
    """A body of 2 kg at rest: the impulses of a step of 1/60 s on it add up to 2 * 9.81 / 60 N s upwards."""
    code, out, err = run_script(
        TOUCHING
        + """asked.CreateThresholdAttr(0.0)
timeline.play()
for _ in range(60):
    app.update()
headers, data = reports[-1]
(header,) = headers
mine = data[header.contact_data_offset:header.contact_data_offset + header.num_contact_data]
first = name(header.actor0) == "/World/Car"
total = sum(np.array(one.impulse) for one in mine) * (1 if first else -1)
print(sorted((name(header.actor0), name(header.actor1))), sorted((name(header.collider0), name(header.collider1))))
print(round(float(total[2]), 3), round(abs(mine[0].normal.z), 3), abs(mine[0].separation) < 0.01)
print([one.type.name for one in (reports[0][0][0], header)])
RigidPrim("/World/Car").set_world_poses(positions=[[0, 0, 9]])
app.update()
print([(one.type.name, one.num_contact_data) for one in reports[-1][0]])
app.close()
"""
    )
    assert code == 0, err
    assert out.splitlines() == [
        "['/World/Car', '/World/Floor'] ['/World/Car/Box', '/World/Floor']",
        "0.327 1.0 True",
        "['CONTACT_FOUND', 'CONTACT_PERSIST']",
        "[('CONTACT_LOST', 0)]",
    ]


def test_contact_reports_keep_to_their_threshold_and_their_pairs(run_script):
    """At rest the force is 2 * 9.81 = 19.6 N: below a threshold of 30 N, above the default of 1 N."""
    code, out, err = run_script(
        TOUCHING
        + """def count(threshold, *others):
    timeline.stop(); app.update()
    asked.CreateThresholdAttr(threshold)
    asked.CreateReportPairsRel().SetTargets([*others])
    timeline.play()
    for _ in range(60):
        app.update()
    reports.clear()
    app.update(); app.update()
    return len(reports)
print(count(30.0), count(1.0), count(1.0, "/World/Other"), count(1.0, "/World/Floor"))
held.unsubscribe()
print(count(1.0), [len(one) for one in get_physx_simulation_interface().get_contact_report()])
app.close()
"""
    )
    assert code == 0, err
    lines = out.splitlines()
    assert lines[0] == "0 2 0 2"
    assert lines[1].startswith("0 [1, ")
