"""Prims of Fabric one by one, as usdrt spells them, and reads that would be out of date."""

from __future__ import annotations

import numpy as np
import pytest

from graph.base.errors import RunError
from graph.sim import App
from graph.sim.state.fabric_prims import StaleReadError
from graph.sim.usd import Gf, UsdGeom

WORLD, LOCAL = "omni:fabric:worldMatrix", "omni:fabric:localMatrix"
PRIMS = {
    "/World/Still": {"translate": [1, 2, 3]},
    "/World/Still/Child": {"translate": [1, 0, 0]},
    "/World/Still/Child/Leaf": {"translate": [0, 1, 0]},
    "/World/Wall": {"type": "Cube", "translate": [5, 0, 0], "scale": [1, 2, 3]},
    "/World/Wall/Sign": {"type": "Cube", "size": 0.1, "translate": [0, 0, 2]},
    "/World/Body": {"type": "Cube", "rigid_body": True, "translate": [0, 0, 50]},
    "/World/Body/Mount": {"translate": [0, 0, 1]},
    "/World/Body/Mount/Lidar": {"type": "OmniLidar", "translate": [1, 0, 0]},
}


@pytest.fixture
def app():
    with App(physics_hz=240, loop_hz=60) as app:
        app.add_prims(PRIMS)
        app.play()
        yield app


def moved(x, y, z):
    return Gf.Matrix4d().SetTranslate(Gf.Vec3d(x, y, z))


def stale(app):
    return {(one.where, one.message.split(",")[0]) for one in app.warnings if one.code == "fabric-stale-transform"}


def test_matrices_are_usds_row_vectors_of_this_moment(app):
    prim = app.fabric.get_prim_at_path("/World/Body/Mount")
    assert prim.get_attribute(WORLD).get().ExtractTranslation() == Gf.Vec3d(0, 0, 51)
    app.update(6)
    fallen = 9.81 / 240**2 * 24 * 25 / 2
    assert prim.GetAttribute(WORLD).Get().ExtractTranslation()[2] == pytest.approx(51 - fallen)
    assert prim.GetAttribute(LOCAL).Get().ExtractTranslation() == Gf.Vec3d(0, 0, 1)
    wall = app.fabric.GetPrimAtPath("/World/Wall").GetAttribute(WORLD).Get()
    assert np.array(wall).tolist() == [[1, 0, 0, 0], [0, 2, 0, 0], [0, 0, 3, 0], [5, 0, 0, 1]]


def test_the_external_time_is_an_attribute(app):
    time = app.fabric.get_prim_at_path("/ExternalSimulationTime").get_attribute("omni:time")
    assert time.get() == 0.0
    app.update(3)
    assert time.Get() == 0.05
    stamp = time.get_change_stamp()
    app.update()
    assert time.get_change_stamp() > stamp
    app.stop()
    assert time.Get() == 0.0


def test_what_is_not_there_is_false_and_says_so_when_read(app):
    fabric = app.fabric
    assert not fabric.get_prim_at_path("/Nowhere")
    assert not fabric.get_prim_at_path("no path").IsValid()
    assert fabric.get_prim_at_path("/World/Wall")
    assert fabric.get_prim_at_path("/World/Wall").HasAttribute("size")
    assert not fabric.get_prim_at_path("/World/Wall").get_attribute("radius")
    with pytest.raises(RunError, match=r"/World/Wall.radius: there is no such attribute"):
        fabric.get_prim_at_path("/World/Wall").get_attribute("radius").get()
    with pytest.raises(RunError, match="/Nowhere: it has no transform"):
        fabric.get_prim_at_path("/Nowhere").get_attribute(WORLD).get()
    with pytest.raises(RunError, match=r"a matrix is \(4, 4\), not \(3,\)"):
        fabric.get_prim_at_path("/World/Wall").get_attribute(WORLD).set([1, 2, 3])


def test_attributes_are_set_beside_the_stage(app):
    size = app.fabric.get_prim_at_path("/World/Wall").get_attribute("size")
    assert (size.get(), size.get_name(), size.get_path()) == (2.0, "size", "/World/Wall.size")
    size.set(3.0)
    assert (size.Get(), app.stage.GetPrimAtPath("/World/Wall").GetAttribute("size").Get()) == (3.0, 2.0)
    mine = app.fabric.get_prim_at_path("/World/Wall").CreateAttribute("mine")
    assert not mine.HasValue()
    mine.Set([1, 2])
    assert app.fabric.GetPrimAtPath("/World/Wall").GetAttribute("mine").Get() == [1, 2]


@pytest.mark.parametrize("name", [WORLD, LOCAL])
def test_a_child_of_what_a_user_has_moved_in_fabric_is_stale(app, name):
    still, child = (app.fabric.get_prim_at_path(path) for path in ("/World/Still", "/World/Still/Child"))
    before = app.fabric.world_matrix("/World/Still/Child").copy()
    still.get_attribute(name).set(moved(7, 7, 7))
    assert still.get_attribute(WORLD).get().ExtractTranslation() == Gf.Vec3d(7, 7, 7)
    with pytest.raises(StaleReadError, match="/World/Still, above it, was placed in Fabric after it") as error:
        child.get_attribute(WORLD).get()
    assert "update_world_xforms()" in str(error.value)
    assert isinstance(error.value, RunError)
    with pytest.raises(StaleReadError):
        child.get_attribute(LOCAL).get()
    with pytest.raises(StaleReadError):
        app.fabric.get_prim_at_path("/World/Still/Child/Leaf").get_attribute(WORLD).get()
    # Fabric's own readers answer with the old place, as Fabric does, and say so once for each prim.
    for _ in range(3):
        assert np.array_equal(app.fabric.world_matrix("/World/Still/Child"), before)
    assert stale(app) == {("/World/Still/Child", "/World/Still")}


def test_on_the_stage_a_child_follows_and_nothing_is_stale(app):
    app.stage.GetPrimAtPath("/World/Still").GetAttribute("xformOp:translate").Set(Gf.Vec3d(7, 7, 7))
    child = app.fabric.get_prim_at_path("/World/Still/Child")
    assert child.get_attribute(WORLD).get().ExtractTranslation() == Gf.Vec3d(8, 7, 7)
    assert not stale(app)


def test_with_fabric_off_a_child_follows_in_any_case():
    with App(fidelity={"fabric": "off"}) as app:
        app.add_prims(PRIMS)
        for begin in (lambda: None, app.play):
            begin()
            still, child = (app.fabric.get_prim_at_path(path) for path in ("/World/Still", "/World/Still/Child"))
            still.get_attribute(WORLD).set(moved(7, 7, 7))
            assert child.get_attribute(WORLD).get().ExtractTranslation() == Gf.Vec3d(8, 7, 7)
            xforms = UsdGeom.XformCache()
            seen = xforms.GetLocalToWorldTransform(app.stage.GetPrimAtPath("/World/Still/Child")).ExtractTranslation()
            assert seen == Gf.Vec3d(8, 7, 7)
        app.update(10)
        op = app.fabric.get_prim_at_path("/World/Body").get_attribute("xformOp:translate")
        assert op.get()[2] == app.fabric.world_matrix("/World/Body")[2, 3] < 50
        assert not stale(app)


def test_placing_the_child_too_makes_it_current(app):
    still, child = (app.fabric.get_prim_at_path(path) for path in ("/World/Still", "/World/Still/Child"))
    still.get_attribute(WORLD).set(moved(7, 7, 7))
    child.get_attribute(WORLD).set(moved(1, 1, 1))
    assert child.get_attribute(WORLD).get().ExtractTranslation() == Gf.Vec3d(1, 1, 1)
    assert child.get_attribute(LOCAL).get().ExtractTranslation() == Gf.Vec3d(-6, -6, -6)
    still.get_attribute(WORLD).set(moved(8, 8, 8))
    with pytest.raises(StaleReadError):
        child.get_attribute(WORLD).get()


def test_updating_world_transforms_takes_children_along(app):
    still = app.fabric.get_prim_at_path("/World/Still")
    still.get_attribute(WORLD).set(moved(7, 7, 7))
    app.fabric.update_world_xforms()
    for path, place in (("/World/Still/Child", (8, 7, 7)), ("/World/Still/Child/Leaf", (8, 8, 7))):
        assert app.fabric.get_prim_at_path(path).get_attribute(WORLD).get().ExtractTranslation() == Gf.Vec3d(*place)
    assert not stale(app)


def test_a_later_word_of_the_stage_counts(app):
    app.fabric.get_prim_at_path("/World/Still").get_attribute(WORLD).set(moved(7, 7, 7))
    app.stage.GetPrimAtPath("/World/Still").GetAttribute("xformOp:translate").Set(Gf.Vec3d(4, 4, 4))
    for path, place in (("/World/Still", (4, 4, 4)), ("/World/Still/Child", (5, 4, 4))):
        assert app.fabric.get_prim_at_path(path).get_attribute(WORLD).get().ExtractTranslation() == Gf.Vec3d(*place)


def test_what_follows_a_body_is_never_stale_of_what_is_above_the_body(app):
    app.fabric.get_prim_at_path("/World").get_attribute(WORLD).set(moved(7, 7, 7))
    lidar = app.fabric.get_prim_at_path("/World/Body/Mount/Lidar")
    assert lidar.get_attribute(WORLD).get().ExtractTranslation() == Gf.Vec3d(1, 0, 51)
    app.fabric.get_prim_at_path("/World/Body").get_attribute(WORLD).set(moved(0, 0, 9))
    assert lidar.get_attribute(WORLD).get().ExtractTranslation() == Gf.Vec3d(1, 0, 10)
    app.fabric.get_prim_at_path("/World/Body/Mount").get_attribute(WORLD).set(moved(0, 0, 20))
    with pytest.raises(StaleReadError):
        lidar.get_attribute(WORLD).get()


def test_the_stages_ops_of_what_physics_has_moved_are_stale(app):
    op = app.fabric.get_prim_at_path("/World/Body").get_attribute("xformOp:translate")
    assert op.get() == Gf.Vec3d(0, 0, 50)
    app.update()
    with pytest.raises(StaleReadError, match=r"/World/Body.xformOp:translate: physics moves it in Fabric"):
        op.get()
    assert app.fabric.get("/World/Body", "xformOp:translate") == Gf.Vec3d(0, 0, 50)
    assert [one.where for one in app.warnings if one.code == "fabric-stale-transform"] == [
        "/World/Body.xformOp:translate"
    ]
    app.fabric.get_prim_at_path("/World/Wall").get_attribute("xformOp:translate").get()
    app.fabric.get_prim_at_path("/World/Still").get_attribute(WORLD).set(moved(7, 7, 7))
    with pytest.raises(StaleReadError, match="a user has placed it in Fabric"):
        app.fabric.get_prim_at_path("/World/Still").get_attribute("xformOp:translate").get()
    app.stop()
    assert op.get() == Gf.Vec3d(0, 0, 50)


def test_rays_see_what_was_placed_in_fabric_and_not_what_is_below_it(app):
    app.geometry()
    app.fabric.get_prim_at_path("/World/Wall").get_attribute(WORLD).set(moved(9, 9, 9))
    bodies = {one.path: one.body for one in app.geometry()}
    assert bodies["/World/Wall"] == "/World/Wall"
    assert bodies["/World/Wall/Sign"] is None
    assert app.fabric.rigid_matrices(["/World/Wall"])[0, :3, 3].tolist() == [9, 9, 9]
    app.update()
    with pytest.raises(StaleReadError):
        app.fabric.get_prim_at_path("/World/Wall/Sign").get_attribute(WORLD).get()


def test_nodes_read_fabric_where_it_is_on_and_the_stage_where_it_is_off():
    seen = {}
    for fabric in ("on", "off"):
        with App(fidelity={"fabric": fabric}) as app:
            app.add_prims(PRIMS)
            app.play()
            app.fabric.set_world_matrix("/World/Still", np.array(moved(7, 7, 7)).T)
            seen[fabric] = app.fabric.world_matrix("/World/Still/Child")[:3, 3].tolist()
    assert seen == {"on": [2, 2, 3], "off": [8, 7, 7]}
