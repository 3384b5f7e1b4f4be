"""Rays on a device meet what they meet on the processor; on a card too, where there is one."""

import numpy as np
import pytest

pytest.importorskip("warp", reason="pip install 'tickgraph[gpu]'")
pytest.importorskip("mujoco_warp", reason="pip install 'tickgraph[gpu]'")

from pxr import Gf, UsdGeom, UsdPhysics

from graph.base.errors import UserError
from graph.sim import App
from graph.sim.devices import warp
from graph.sim.geometry.surfaces import Mesh
from sensors.raycast.rays import RayBundle
from sensors.raycast.shared import cast_world
from tests.support.devices import on_each
from wings.device.check import compare
from wings.device.devices import allocating, device_of, refuse_beyond
from wings.device.geometry import Geometry


def bundle(directions, origin=(0.0, 0.0, 0.0), offsets=None, exclude=()):
    table = np.zeros((len(directions), 6), np.float32)
    table[:, 3:] = directions / np.linalg.norm(directions, axis=1)[:, None]
    return RayBundle(np.array(origin, float), table, offsets, frozenset(exclude))


def cast(device, make, rays, steps=0, **options):
    with App(device=device) as app:
        make(app.stage)
        app.play()
        app.update(steps=steps)
        hits = cast_world(app.world).cast(rays(), normals=True, **options)
        paths = [cast_world(app.world).surfaces[n].path if n >= 0 else "" for n in hits.surfaces()]
        return hits, paths


@on_each
def test_every_kind_of_surface_is_met_as_on_the_processor(device):
    assert compare(device).same


@on_each
def test_a_ball_is_met_where_its_formula_says(device):
    """A ball of radius 0.5 at x = 3: straight ahead 2.5 m; at height h of its middle 3 - sqrt(0.25 - h^2)."""

    def ball(stage):
        shape = UsdGeom.Sphere.Define(stage, "/World/Ball")
        shape.GetRadiusAttr().Set(0.5)
        shape.AddTranslateOp().Set(Gf.Vec3d(3, 0, 0))

    heights = np.array([0.0, 0.3, 0.4, 0.499, 0.501], np.float32)
    offsets = np.stack([0 * heights, 0 * heights, heights], 1)
    hits, _ = cast(device, ball, lambda: bundle(np.tile([1.0, 0, 0], (5, 1)), offsets=offsets))
    expected = 3 - np.sqrt(0.25 - heights[:4].astype(float) ** 2)
    assert hits.distance[:4] == pytest.approx(expected, abs=2e-6)
    assert np.isinf(hits.distance[4])
    assert hits.normals[0] == pytest.approx([-1, 0, 0], abs=1e-6)
    assert hits.normals[1] == pytest.approx([-0.8, 0, 0.6], abs=1e-5)


@on_each
def test_ranges_are_as_exact_a_thousand_kilometres_from_the_origin(device):
    def wall(stage):
        shape = UsdGeom.Cube.Define(stage, "/World/Wall")
        shape.AddTranslateOp().Set(Gf.Vec3d(1e6 + 5.25, 0, 0))
        mesh = UsdGeom.Mesh.Define(stage, "/World/Sail")
        mesh.GetPointsAttr().Set([(-3.5, -9, -9), (-3.5, 9, -9), (-3.5, 0, 9)])
        mesh.GetFaceVertexCountsAttr().Set([3])
        mesh.GetFaceVertexIndicesAttr().Set([0, 1, 2])
        mesh.AddTranslateOp().Set(Gf.Vec3d(1e6, 0, 0))

    ways = np.array([[1.0, 0, 0], [-1.0, 0, 0]])
    hits, paths = cast(device, wall, lambda: bundle(ways, origin=(1e6, 0, 0)))
    assert hits.distance == pytest.approx([4.25, 3.5], abs=1e-5)
    assert paths == ["/World/Wall", "/World/Sail"]


@on_each
def test_more_bodies_than_a_few_are_found_by_their_tree(device):
    """40 balls on a ring of 10 m, each on a body, and a ray to each: 9.5 m, its own ball."""

    def ring(stage):
        for number in range(40):
            angle = 2 * np.pi * number / 40
            shape = UsdGeom.Sphere.Define(stage, f"/World/Ball{number}")
            shape.GetRadiusAttr().Set(0.5)
            shape.AddTranslateOp().Set(Gf.Vec3d(10 * np.cos(angle), 10 * np.sin(angle), 0))
            UsdPhysics.RigidBodyAPI.Apply(shape.GetPrim()).GetKinematicEnabledAttr().Set(True)

    angles = 2 * np.pi * np.arange(40) / 40
    ways = np.stack([np.cos(angles), np.sin(angles), 0 * angles], 1)
    hits, paths = cast(device, ring, lambda: bundle(ways))
    assert hits.distance == pytest.approx(9.5, abs=2e-6)
    assert paths == [f"/World/Ball{number}" for number in range(40)]


@on_each
def test_what_is_excluded_is_not_met_and_a_surface_under_the_origin_is_left(device):
    """From the top of a box, straight up: the lid at 2 m, or, without it, nothing. Straight down: the box at 0."""

    def boxes(stage):
        for name, height, size in (("Box", -0.5, 1.0), ("Lid", 2.5, 1.0)):
            shape = UsdGeom.Cube.Define(stage, f"/World/{name}")
            shape.GetSizeAttr().Set(size)
            shape.AddTranslateOp().Set(Gf.Vec3d(0, 0, height))

    up = np.array([[0.0, 0, 1.0]])
    hits, paths = cast(device, boxes, lambda: bundle(up))
    assert (hits.distance[0], paths) == (pytest.approx(2.0, abs=1e-6), ["/World/Lid"])
    hits, _ = cast(device, boxes, lambda: bundle(up, exclude=["/World/Lid"]))
    assert np.isinf(hits.distance[0])


@on_each
def test_a_falling_box_is_met_where_it_is_and_twice_the_same(device):
    """Dropped from 10 m; the ray from below meets it as on the processor, whose physics it is, and again to the bit."""

    def box(stage):
        shape = UsdGeom.Cube.Define(stage, "/World/Box")
        shape.AddTranslateOp().Set(Gf.Vec3d(0, 0, 10))
        UsdPhysics.RigidBodyAPI.Apply(shape.GetPrim())

    def rays():
        return bundle(np.array([[0.0, 0, 1.0]]))

    first, _ = cast(device, box, rays, steps=30)
    again, _ = cast(device, box, rays, steps=30)
    plain, _ = cast("cpu", box, rays, steps=30)
    assert 5 < first.distance[0] < 9
    assert first.distance[0] == pytest.approx(plain.distance[0], abs=1e-5)
    assert first.distance.tobytes() == again.distance.tobytes()
    assert first.normals.tobytes() == again.normals.tobytes()


def test_an_unknown_device_and_a_card_that_is_not_there_are_refused_in_a_line():
    with pytest.raises(UserError, match="'tpu' is not one of cpu, cuda"):
        App(device="tpu")
    if not warp().get_cuda_devices():
        with pytest.raises(UserError, match="no CUDA device is there"):
            App(device="cuda")


@pytest.mark.parametrize("name", ["tpu", "cuda:x", "cuda:", "cuda:-1", "warp"])
def test_a_device_that_does_not_exist_is_refused_by_its_name(name):
    with pytest.raises(UserError, match=f"device {name}: there is no such device; give cuda, cuda:N"):
        device_of(name)


def test_sensors_with_other_exclusions_share_the_meshes_of_a_device():
    """A sail that stands and one on a body: two geometries, one of which leaves a third out, have the same meshes."""
    sail = np.array([(3.0, -1, -1), (3, 1, -1), (3, 0, 1)])
    corners = np.array([[0, 1, 2]], np.uint32)
    surfaces = [
        Mesh("/A", None, sail, corners),
        Mesh("/B", "/B", sail + np.array([0, 9, 0]), corners),
        Mesh("/C", "/C", sail * 2, corners),
    ]
    made = [
        Geometry(device_of("warp-cpu"), surfaces, np.array([-1, 0, 1]), np.zeros(3), formulas=True, skip=skip)
        for skip in (frozenset(), frozenset([2]))
    ]
    assert made[0].ground.mesh == made[1].ground.mesh
    assert made[0].items.mesh.numpy()[:2].tolist() == made[1].items.mesh.numpy()[:2].tolist()


def test_an_allocation_that_fails_is_refused_with_its_bytes():
    class Card:
        name = "a card"

    with (
        pytest.raises(UserError, match=r"physics of 8 worlds need 2\.00 GiB more on a card than there is; use fewer"),
        allocating(Card, "physics of 8 worlds"),
    ):
        raise RuntimeError(f"Failed to allocate {2**31} bytes on device 'cuda:0'")
    with pytest.raises(RuntimeError, match="another"), allocating(Card, "physics"):
        raise RuntimeError("another mistake")


def test_what_does_not_fit_on_a_card_is_refused_with_the_memory_that_it_needs():
    class Card:
        is_cuda, name, free_memory = True, "a card", 2**30

    refuse_beyond(Card, 2**30, "a scan")
    with pytest.raises(UserError, match=r"a scan needs 4\.00 GiB on a card, which has 1\.00 GiB free"):
        refuse_beyond(Card, 2**32, "a scan")
