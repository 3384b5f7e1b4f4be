"""Edits of a stage that plays: refused, restarted or compiled in place; transforms count at once."""

from __future__ import annotations

import numpy as np
import pytest

from graph.base.errors import RunError, UserError
from graph.sim import App
from graph.sim.scene.stage import open_stage
from graph.sim.usd import Gf, Sdf, UsdGeom, UsdPhysics, UsdShade

PRIMS = {
    "/World/Ground": {"type": "Plane"},
    "/World/Ball": {"type": "Sphere", "radius": 0.2, "translate": [0, 0, 9], "rigid_body": True, "velocity": [1, 0, 0]},
    "/World/Wall": {"type": "Cube", "translate": [5, 0, 1]},
    "/World/Picture": {"type": "Cube", "translate": [0, 5, 1], "collision": False},
    "/World/Group": {},
    "/World/Group/Box": {"type": "Cube", "translate": [-5, 0, 1], "rigid_body": True},
    "/World/Group/Lift": {"type": "Cube", "translate": [-5, 5, 1], "rigid_body": True,
                          "attributes": {"physics:kinematicEnabled": True}},
    "/World/Arm": {"type": "Cube", "size": 0.2, "translate": [8, 8, 3], "rigid_body": True},
    "/World/Hinge": {"type": "PhysicsRevoluteJoint", "attributes": {"physics:axis": "Y", "physics:localPos0": [8, 8, 4],
                     "physics:localPos1": [0, 0, 1], "physics:body1": "/World/Arm"}},
}  # fmt: skip
NEW = {"/World/New": {"type": "Sphere", "radius": 0.3, "translate": [3, 3, 7], "rigid_body": True}}


@pytest.fixture(params=["on", "off"])
def fabric(request):
    return request.param


def playing(when_playing="refuse", fabric="on", prims=PRIMS, updates=6):
    app = App(physics_hz=240, loop_hz=60, when_playing=when_playing, fidelity={"fabric": fabric})
    app.add_prims({path: {**keys} for path, keys in prims.items() if path != "/World/Hinge"})
    if "/World/Hinge" in prims:
        joint = UsdPhysics.RevoluteJoint.Define(app.stage, "/World/Hinge")
        joint.CreateAxisAttr("Y")
        joint.CreateBody1Rel().SetTargets(["/World/Arm"])
        joint.CreateLocalPos0Attr((8, 8, 4))
        joint.CreateLocalPos1Attr((0, 0, 1))
        joint.GetPrim().GetAttribute("physics:localPos1").Set((0, 0, 1))
    app.play()
    app.update(updates)
    return app


def place(app, path):
    return app.fabric.world_matrix(path)[:3, 3]


def translate(app, path, *value):
    app.stage.GetPrimAtPath(path).GetAttribute("xformOp:translate").Set(Gf.Vec3d(*value))


def layers(stage):
    return [layer.ExportToString() for layer in stage.GetUsedLayers()]


# -- refused ----------------------------------------------------------------------------------------------------------


def add_a_surface(stage):
    UsdGeom.Cube.Define(stage, "/World/New")


def add_a_collider(stage):
    UsdPhysics.CollisionAPI.Apply(stage.GetPrimAtPath("/World/Picture"))


def remove_a_body(stage):
    stage.RemovePrim("/World/Ball")


def switch_off(stage):
    stage.GetPrimAtPath("/World/Group").SetActive(False)


def reparent(stage):
    from graph.sim.usd import Sdf

    edit = Sdf.BatchNamespaceEdit()
    edit.Add(Sdf.NamespaceEdit.Reparent("/World/Wall", "/World/Group", -1))
    stage.GetRootLayer().Apply(edit)


def scale(stage):
    stage.GetPrimAtPath("/World/Wall").GetAttribute("xformOp:scale").Set(Gf.Vec3d(1, 2, 1))


def scale_from_above(stage):
    UsdGeom.Xformable(stage.GetPrimAtPath("/World/Group")).AddScaleOp(opSuffix="more").Set((2, 2, 2))


def lose(stage):
    stage.GetPrimAtPath("/World/Wall").GetAttribute("xformOp:translate").Set(Gf.Vec3d(float("nan"), 0, 0))


def grow(stage):
    stage.GetPrimAtPath("/World/Wall").GetAttribute("size").Set(3.0)


def change_kind(stage):
    stage.GetPrimAtPath("/World/Wall").SetTypeName("Sphere")


@pytest.mark.parametrize(
    ("edit", "says"),
    [
        (add_a_surface, "/World/New (Cube) was added"),
        (add_a_collider, "/World/Picture was Cube and is Cube PhysicsCollisionAPI"),
        (remove_a_body, "/World/Ball (Sphere PhysicsRigidBodyAPI PhysicsCollisionAPI) was removed"),
        (switch_off, "/World/Group/Box (Cube PhysicsRigidBodyAPI PhysicsCollisionAPI) was removed"),
        (reparent, "/World/Wall (Cube PhysicsCollisionAPI) was removed"),
        (scale, "/World/Wall got another scale"),
        (scale_from_above, "/World/Group got another scale"),
        (lose, "/World/Wall got a transform that is not finite"),
        (grow, "/World/Wall got another size"),
        (change_kind, "/World/Wall was Cube PhysicsCollisionAPI and is Sphere PhysicsCollisionAPI"),
    ],
)
def test_an_edit_straight_on_the_stage_is_refused_at_the_next_update(edit, says, fabric):
    app = playing(fabric=fabric)
    before = layers(app.stage)
    edit(app.stage)
    for _ in range(2):  # and at every one after it
        with pytest.raises(RunError) as error:
            app.update()
        assert says in str(error.value)
        assert "stop" in str(error.value)
        assert 'app.edit(when_playing="recompile")' in str(error.value)
        assert "\n" not in str(error.value)
    app.stop()
    app.play()
    app.update()
    app.stop()
    assert before[0] == layers(app.stage)[0] or fabric == "off"


@pytest.mark.parametrize(("edit", "undo"), [
    (add_a_surface, lambda stage: stage.RemovePrim("/World/New")),
    (scale, lambda stage: stage.GetPrimAtPath("/World/Wall").GetAttribute("xformOp:scale").Set(Gf.Vec3d(1, 1, 1))),
    (switch_off, lambda stage: stage.GetPrimAtPath("/World/Group").SetActive(True)),
])  # fmt: skip
def test_what_is_undone_is_no_longer_refused(edit, undo):
    app = playing()
    edit(app.stage)
    with pytest.raises(RunError):
        app.update()
    undo(app.stage)
    before = place(app, "/World/Ball")[0]
    app.update()
    assert place(app, "/World/Ball")[0] > before


def test_a_direct_step_refuses_it_too():
    app = playing()
    add_a_surface(app.stage)
    with pytest.raises(RunError, match="/World/New"):
        app.simulation.step()


def test_what_has_no_role_may_be_edited(fabric):
    app = playing(fabric=fabric)
    stage = app.stage
    stage.DefinePrim("/World/Marker", "Xform")
    stage.DefinePrim("/World/Lidar", "OmniLidar")
    UsdGeom.Camera.Define(stage, "/World/Camera")
    wall = stage.GetPrimAtPath("/World/Wall")
    UsdGeom.Gprim(wall).CreateDisplayColorAttr([(1, 0, 0)])
    wall.CreateAttribute("mine", UsdGeom.Cube(wall).GetSizeAttr().GetTypeName()).Set(1.0)
    wall.SetCustomDataByKey("note", "x")
    material = UsdShade.Material.Define(stage, "/World/Red")
    UsdShade.MaterialBindingAPI.Apply(wall).Bind(material)
    stage.SetTimeCodesPerSecond(30)
    app.update()
    stage.RemovePrim("/World/Marker")
    app.update()
    # It played on: 6 + 2 updates of 1/60 s at 1 m/s.
    assert place(app, "/World/Ball")[0] == pytest.approx(8 / 60)


def test_a_surface_that_physics_does_not_know_may_change_its_shape_and_rays_see_it():
    app = playing()
    assert len([one for one in app.geometry() if one.path == "/World/Picture"]) == 1
    app.stage.GetPrimAtPath("/World/Picture").GetAttribute("size").Set(4.0)
    app.update()
    (picture,) = (one for one in app.geometry() if one.path == "/World/Picture")
    assert np.ptp(picture.vertices, axis=0).tolist() == [4, 4, 4]


def test_what_is_hidden_or_shown_rays_see_at_once():
    app = playing()
    UsdGeom.Imageable(app.stage.GetPrimAtPath("/World/Wall")).MakeInvisible()
    app.update()
    assert "/World/Wall" not in {one.path for one in app.geometry()}
    UsdGeom.Imageable(app.stage.GetPrimAtPath("/World/Wall")).MakeVisible()
    app.update()
    assert "/World/Wall" in {one.path for one in app.geometry()}


def test_physics_attributes_wait_for_the_next_play_and_that_is_reported():
    app = playing()
    UsdPhysics.MassAPI.Apply(app.stage.GetPrimAtPath("/World/Ball"))
    with pytest.raises(RunError, match="PhysicsMassAPI"):
        app.update()
    app.stop()
    UsdPhysics.MassAPI.Apply(app.stage.GetPrimAtPath("/World/Ball")).CreateMassAttr(3.0)
    app.play()
    app.stage.GetPrimAtPath("/World/Ball").GetAttribute("physics:mass").Set(7.0)
    app.update()
    (warning,) = (one for one in app.warnings if one.code == "edit-not-live")
    assert warning.where == "/World/Ball"
    assert "physics:mass" in warning.message


def test_a_velocity_that_is_written_counts_at_the_next_update(fabric):
    app = playing(fabric=fabric)
    body = UsdPhysics.RigidBodyAPI(app.stage.GetPrimAtPath("/World/Ball"))
    body.GetVelocityAttr().Set((0, 0, 30))
    body.GetAngularVelocityAttr().Set((0, 0, 180))
    app.update()
    row = app.physics.body_paths.index("/World/Ball")
    state = app.simulation.tensors
    assert state.linear_velocities[row] == pytest.approx([0, 0, 30 - 9.81 * 4 / 240])
    assert state.angular_velocities[row] == pytest.approx([0, 0, np.pi])
    assert not [one for one in app.warnings if one.code == "edit-not-live"]


def test_a_drive_goes_where_the_stage_says_from_the_next_update_on():
    app = playing(updates=0)
    app.stop()
    drive = UsdPhysics.DriveAPI.Apply(app.stage.GetPrimAtPath("/World/Hinge"), "angular")
    drive.CreateStiffnessAttr(1e5)
    drive.CreateDampingAttr(1e4)
    drive.CreateTargetPositionAttr(0.0)
    app.play()
    app.update(6)
    app.stage.GetPrimAtPath("/World/Hinge").GetAttribute("drive:angular:physics:targetPosition").Set(30.0)
    app.update(600)
    assert app.simulation.tensors.joint_positions[0] == pytest.approx(np.radians(30), abs=0.02)


def test_editing_helpers_refuse_before_they_edit():
    app = playing()
    before = layers(app.stage)
    with pytest.raises(RunError, match="cannot be edited while it plays; stop first"):
        app.add_prims(NEW)
    with pytest.raises(RunError, match="cannot be edited while it plays"), app.edit():
        pytest.fail("the block must not run")
    assert layers(app.stage) == before
    app.pause()
    with pytest.raises(RunError, match="cannot be edited while it plays"):
        app.remove_prims("/World/Ball")
    with pytest.raises(UserError, match="when_playing 'recompil' is not one of refuse, restart, recompile"):
        app.edit("recompil")
    with pytest.raises(UserError, match="is not one of"):
        App(when_playing="no")
    app.stop()
    app.remove_prims("/World/Ball")
    with pytest.raises(UserError, match="/World/Ball: no such prim"):
        app.remove_prims("/World/Ball")


# -- restart ----------------------------------------------------------------------------------------------------------


def test_restart_stops_edits_and_plays_again():
    app = playing("restart")
    seen = []
    for name in ("stop", "play"):
        app.on(name, lambda name=name: seen.append(name))
    app.add_prims(NEW)
    assert seen == ["stop", "play"]
    assert app.timeline.is_playing()
    assert app.simulation.get_num_physics_steps() == 0
    assert app.physics.body_paths[-1] == "/World/New"
    assert place(app, "/World/Ball").tolist() == [0, 0, 9]
    app.update(10)
    app.stop()
    assert app.stage.GetPrimAtPath("/World/New")


def test_restart_keeps_a_pause():
    app = playing("restart")
    app.pause()
    app.add_prims(NEW)
    assert app.timeline.is_paused()


# -- recompile --------------------------------------------------------------------------------------------------------


def test_what_is_added_falls_while_all_others_go_on(fabric):
    app, other = playing("recompile", fabric), playing("refuse", fabric)
    state = app.simulation.tensors
    before = [array.copy() for array in (state.positions, state.orientations, state.linear_velocities)]
    steps = app.simulation.get_num_physics_steps()
    app.add_prims(NEW)
    assert app.simulation.get_num_physics_steps() == steps
    names = list(state.body_paths)
    kept = [names.index(path) for path in names if path != "/World/New"]
    for array, was in zip((state.positions, state.orientations, state.linear_velocities), before, strict=True):
        assert np.array_equal(array[kept], was)
    assert place(app, "/World/New").tolist() == [3, 3, 7]
    app.update(24)
    other.update(24)
    for path in ("/World/Ball", "/World/Group/Box", "/World/Arm"):
        assert place(app, path) == pytest.approx(place(other, path), abs=1e-9)
    # 24 updates are 96 steps of 1/240 s from rest.
    assert place(app, "/World/New")[2] == pytest.approx(7 - 9.81 / 240**2 * 96 * 97 / 2)


def test_what_is_added_straight_with_pxr_is_compiled_in_where_the_app_says_so():
    app = playing("recompile")
    ball = UsdGeom.Sphere.Define(app.stage, "/World/New")
    ball.AddTranslateOp().Set((3, 3, 7))
    UsdPhysics.RigidBodyAPI.Apply(ball.GetPrim())
    UsdPhysics.CollisionAPI.Apply(ball.GetPrim())
    app.update()
    assert "/World/New" in app.physics.body_paths
    assert place(app, "/World/New")[2] < 7
    assert "/World/New" in {one.path for one in app.geometry()}


def test_an_edit_that_was_refused_is_taken_by_an_empty_one_that_compiles():
    app = playing()
    add_a_surface(app.stage)
    with pytest.raises(RunError):
        app.update()
    with app.edit("recompile"):
        pass
    app.update()
    assert "/World/New" in {one.path for one in app.geometry()}


def test_what_is_removed_is_gone_from_physics_and_rays_and_back_after_stop(fabric):
    app = playing(fabric=fabric)
    before = app.simulation.tensors.body_paths
    app.remove_prims("/World/Ball", when_playing="recompile")
    assert set(before) - set(app.physics.body_paths) == {"/World/Ball"}
    assert "/World/Ball" not in {one.path for one in app.geometry()}
    app.update(5)
    app.stop()
    assert app.stage.GetPrimAtPath("/World/Ball").IsActive()


def test_the_first_body_brings_physics_and_the_last_takes_it_away():
    app = playing("recompile", prims={"/World/Wall": PRIMS["/World/Wall"]})
    assert app.physics is None
    app.add_prims(NEW)
    app.update(10)
    assert place(app, "/World/New")[2] < 7
    app.remove_prims("/World/New")
    assert app.physics is None
    app.update(3)
    app.stop()


def test_a_body_that_is_scaled_keeps_its_state_and_collides_in_its_new_size():
    app = playing("recompile")
    app.simulation.tensors.set_poses([-5, 0, 2.01], bodies="/World/Group/Box")
    speed = app.simulation.tensors.linear_velocities[app.physics.body_paths.index("/World/Group/Box")]
    with app.edit() as stage:
        stage.GetPrimAtPath("/World/Group/Box").GetAttribute("xformOp:scale").Set(Gf.Vec3d(1, 1, 2))
    now = app.simulation.tensors.linear_velocities[app.physics.body_paths.index("/World/Group/Box")]
    assert np.array_equal(now, speed)
    app.update(240)
    assert place(app, "/World/Group/Box")[2] == pytest.approx(2, abs=0.01)  # 4 m high now, on the ground
    assert app.fabric.world_matrix("/World/Group/Box")[2, 2] == pytest.approx(2, abs=1e-6)


def test_a_joint_that_is_removed_lets_its_body_fly_on_with_its_speed():
    app = playing("recompile")
    with app.edit() as stage:
        stage.GetPrimAtPath("/World/Arm").GetAttribute("xformOp:translate")
    app.simulation.tensors.set_joint_velocities([2.0])
    app.remove_prims("/World/Hinge")
    state = app.simulation.tensors
    row = state.body_paths.index("/World/Arm")
    assert state.joint_paths == ()
    # 1 m below the hinge, turning at 2 rad/s about Y: v = w x r = (0, 2, 0) x (0, 0, -1).
    assert state.linear_velocities[row] == pytest.approx([-2, 0, 0], abs=0.05)
    assert state.angular_velocities[row] == pytest.approx([0, 2, 0], abs=0.05)
    app.update(24)
    assert place(app, "/World/Arm")[2] < 2.5


def test_articulations_targets_and_drives_at_hand_go_on():
    app = playing("recompile")
    arm = app.physics.articulation("/World/Arm")
    arm.set_positions([0.3])
    app.add_prims(NEW)
    assert arm.positions.tolist() == [0.3]
    assert app.physics.articulation("/World/Arm") is arm
    arm.set_targets(efforts=[5.0])
    app.update()
    assert arm.positions[0] != 0.3


def test_an_edit_that_is_given_up_leaves_physics_as_it_was():
    app = playing("recompile")
    before = app.simulation.tensors.positions

    def give_up():
        with app.edit() as stage:
            UsdPhysics.SphericalJoint.Define(stage, "/World/Bad").CreateBody0Rel().SetTargets(["/World/Ball"])
            raise UserError("enough")

    with pytest.raises(UserError, match="enough"):
        give_up()
    assert np.array_equal(app.simulation.tensors.positions, before)


def test_a_velocity_and_a_state_of_before_stay_readable():
    app = playing("recompile")
    then = app.fabric.capture()
    was = app.fabric.rigid_matrices(["/World/Ball", "/World/Group/Box"], then).copy()
    app.add_prims(NEW)
    app.update(3)
    assert np.array_equal(app.fabric.rigid_matrices(["/World/Ball", "/World/Group/Box"], then), was)
    assert app.fabric.velocities(["/World/Ball"], then)[0, 0] == pytest.approx(1)
    assert app.fabric.world_matrix("/World/Ball", then)[2, 3] == was[0, 2, 3]


# -- transforms -------------------------------------------------------------------------------------------------------


def test_a_free_body_goes_where_the_stage_says(fabric):
    app = playing(fabric=fabric)
    translate(app, "/World/Ball", 2, 2, 20)
    assert place(app, "/World/Ball").tolist() == [2, 2, 20]
    app.update()
    assert 19 < place(app, "/World/Ball")[2] < 20


def test_a_body_is_put_back_to_where_it_began(fabric):
    app = playing(fabric=fabric)
    for _ in range(2):
        translate(app, "/World/Ball", 0, 0, 8)
        app.update(30)
        assert place(app, "/World/Ball")[2] < 8
        translate(app, "/World/Ball", 0, 0, 9)
        assert place(app, "/World/Ball").tolist() == [0, 0, 9]


def test_an_op_that_changes_nothing_moves_nothing():
    app = playing(updates=30)
    there = place(app, "/World/Ball")
    with app.edit("recompile") as stage:
        UsdGeom.Xformable(stage.GetPrimAtPath("/World/Ball")).AddScaleOp(opSuffix="more").Set((2, 2, 2))
    assert np.array_equal(place(app, "/World/Ball"), there)


def test_a_kinematic_body_goes_where_the_stage_says(fabric):
    app = playing(fabric=fabric)
    translate(app, "/World/Group/Lift", 1, 1, 4)
    app.update(5)
    assert place(app, "/World/Group/Lift").tolist() == [1, 1, 4]
    assert app.physics.positions[app.physics.body_paths.index("/World/Group/Lift")].tolist() == [1, 1, 4]


def test_a_still_collider_goes_along_for_rays_and_bodies(fabric):
    app = playing(fabric=fabric)
    translate(app, "/World/Wall", 0.2, 0, 2)  # under the ball, which flies on at 1 m/s
    app.update(120)
    assert place(app, "/World/Wall").tolist() == [0.2, 0, 2]
    assert place(app, "/World/Ball")[2] > 3.1 or place(app, "/World/Ball")[0] > 1.2
    assert app.physics.body_paths.count("/World/Wall") == 1
    (wall,) = (one for one in app.geometry() if one.path == "/World/Wall")
    assert wall.body == "/World/Wall"
    assert app.fabric.rigid_matrices(["/World/Wall"])[0, :3, 3].tolist() == [0.2, 0, 2]
    geometry = app.geometry()
    translate(app, "/World/Wall", 9, 9, 9)
    app.update()
    assert app.geometry() is geometry
    assert place(app, "/World/Wall").tolist() == [9, 9, 9]
    app.stop()
    assert place(app, "/World/Wall").tolist() == [5, 0, 1]


def test_a_ball_lands_on_a_collider_that_was_moved_under_it(fabric):
    app = playing(fabric=fabric, prims={**PRIMS, "/World/Ball": {**PRIMS["/World/Ball"], "velocity": [0, 0, 0]}})
    translate(app, "/World/Wall", 0, 0, 3)
    app.update(240)
    assert place(app, "/World/Ball")[2] == pytest.approx(4.2, abs=0.01)


def test_a_ball_lands_on_an_endless_ground_that_was_moved(fabric):
    """The Plane that moves is still endless: the ball, of radius 0.2, comes down 50 m away from the Plane's place."""
    still = {"/World/Ball": {**PRIMS["/World/Ball"], "velocity": [0, 0, 0]}}
    app = playing(fabric=fabric, prims={"/World/Ground": {"type": "Plane", "translate": [0, 0, 0]}, **still})
    translate(app, "/World/Ground", 50, 0, 3)
    app.update(240)
    assert place(app, "/World/Ball")[2] == pytest.approx(3.2, abs=0.01)


def test_a_picture_goes_along_for_rays_without_physics(fabric):
    app = playing(fabric=fabric, prims={"/World/Picture": PRIMS["/World/Picture"]})
    app.geometry()
    translate(app, "/World/Picture", 1, 2, 3)
    app.update()
    (picture,) = app.geometry()
    pose = app.fabric.rigid_matrices([picture.body])[0]
    assert (picture.vertices @ pose[:3, :3].T + pose[:3, 3]).mean(axis=0) == pytest.approx([1, 2, 3])


def test_a_group_that_is_moved_takes_what_users_move_along_and_leaves_what_physics_moves():
    app = playing()
    box = place(app, "/World/Group/Box")
    UsdGeom.Xformable(app.stage.GetPrimAtPath("/World/Group")).AddTranslateOp(opSuffix="more").Set((0, 0, 10))
    assert place(app, "/World/Group/Lift").tolist() == [-5, 5, 11]
    assert np.array_equal(place(app, "/World/Group/Box"), box)
    assert {(one.code, one.where) for one in app.warnings} >= {("fabric-parent-moved", "/World/Group")}


def test_with_fabric_off_a_group_takes_all_along():
    app = playing(fabric="off")
    box = place(app, "/World/Group/Box")
    UsdGeom.Xformable(app.stage.GetPrimAtPath("/World/Group")).AddTranslateOp(opSuffix="more").Set((0, 0, 10))
    assert place(app, "/World/Group/Lift").tolist() == [-5, 5, 11]
    assert place(app, "/World/Group/Box") == pytest.approx(box + np.array([0, 0, 10]))
    app.update()


def test_a_body_that_a_joint_holds_cannot_be_put_anywhere():
    app = playing()
    translate(app, "/World/Arm", 0, 0, 0)
    with pytest.raises(RunError, match="/World/Arm: a joint holds this body"):
        app.update()


def test_a_part_of_a_body_that_is_moved_collides_at_its_new_place():
    prims = {
        "/World/Ground": {"type": "Plane"},
        "/World/Body": {"type": "Cube", "size": 0.5, "translate": [0, 0, 1], "rigid_body": True},
        "/World/Body/Foot": {"type": "Cube", "size": 0.5, "translate": [0, 0, -0.5]},
    }
    app = playing(prims=prims, updates=240)
    assert place(app, "/World/Body")[2] == pytest.approx(0.75, abs=0.01)
    translate(app, "/World/Body/Foot", 0, 0, 0.5)
    app.update(240)
    assert place(app, "/World/Body")[2] == pytest.approx(0.25, abs=0.01)


# -- play and stop ----------------------------------------------------------------------------------------------------


def test_stop_restores_every_layer_to_the_last_bit(fabric, tmp_path):
    scene = tmp_path / "scene.usda"
    scene.write_text('#usda 1.0\n(\n    upAxis = "Z"\n)\ndef Xform "World" {\n def Cube "Old" {}\n}\n')
    stage = open_stage(scene)
    with App(stage, fidelity={"fabric": fabric}, when_playing="recompile") as app:
        app.add_prims(PRIMS | {"/World/Hinge": {"type": "PhysicsFixedJoint"}})
        with app.edit():
            stage.SetEditTarget(stage.GetSessionLayer())
            stage.DefinePrim("/Mine", "Scope")
            stage.GetPrimAtPath("/World/Ball").GetAttribute("xformOp:translate").Set(Gf.Vec3d(0, 1, 9))
            stage.SetEditTarget(stage.GetRootLayer())
        before, file = layers(stage), scene.read_bytes()
        for _ in range(2):
            app.play()
            app.update(3)
            app.add_prims(NEW)
            app.remove_prims("/World/Old", "/World/Wall")
            translate(app, "/World/Group/Lift", 1, 2, 3)
            stage.DefinePrim("/World/Marker", "Xform")
            stage.SetEditTarget(stage.GetSessionLayer())
            stage.DefinePrim("/Mine/Too", "Scope")
            UsdGeom.Imageable(stage.GetPrimAtPath("/World/Ball")).MakeInvisible()
            stage.SetEditTarget(stage.GetRootLayer())
            app.fabric.set_world_matrix("/World/Picture", np.eye(4))
            app.update(3)
            assert layers(stage) != before
            app.stop()
            assert layers(stage) == before
            assert scene.read_bytes() == file


def test_a_play_that_fails_leaves_the_stage_as_it_was(fabric):
    stage = open_stage()
    cube = UsdGeom.Cube.Define(stage, "/Heavy")
    UsdPhysics.RigidBodyAPI.Apply(cube.GetPrim())
    stage.DefinePrim("/Kit", "Xform")
    UsdPhysics.RigidBodyAPI.Apply(UsdGeom.Cube.Define(stage, "/Kit/Box").GetPrim())
    copy = stage.DefinePrim("/Copy", "Xform")
    copy.GetReferences().AddInternalReference("/Kit")
    copy.SetInstanceable(True)
    with App(stage, fidelity={"fabric": "off"}) as app:
        before = layers(stage)
        with pytest.raises(UserError, match="/Copy/Box"):
            app.play()
        assert layers(stage) == before
        assert app.timeline.is_stopped()
        copy.SetInstanceable(False)
        app.play()
        app.update()


SLIDE = {
    "/World/Floor": {"type": "Cube", "size": 1.0, "scale": [40, 40, 1], "translate": [0, 0, -0.5]},
    "/World/Sled": {"type": "Cube", "size": 1.0, "scale": [1, 1, 0.2], "translate": [0, 0, 0.1], "rigid_body": True,
                    "velocity": [3, 0, 0]},
    "/World/Other": {"type": "Cube", "size": 1.0, "translate": [0, 9, 0.5], "rigid_body": True},
}  # fmt: skip


def test_a_material_that_is_made_slippery_counts_for_bodies_left_alone():
    with playing(prims=SLIDE) as app:
        with app.edit(when_playing="recompile") as stage:
            material = UsdShade.Material.Define(stage, "/World/Ice")
            UsdPhysics.MaterialAPI.Apply(material.GetPrim()).CreateDynamicFrictionAttr(0.5)
            for path in ("/World/Floor", "/World/Sled"):
                UsdShade.MaterialBindingAPI.Apply(stage.GetPrimAtPath(path)).Bind(material, materialPurpose="physics")
        app.update(6)
        with app.edit(when_playing="recompile") as stage:
            UsdPhysics.MaterialAPI(stage.GetPrimAtPath("/World/Ice")).GetDynamicFrictionAttr().Set(0.0)
        tensors = app.simulation.tensors
        row = tensors.body_paths.index("/World/Sled")
        before = tensors.linear_velocities[row, 0]
        app.update(30)
        assert 0.5 < before < 3
        assert tensors.linear_velocities[row, 0] == pytest.approx(before, abs=1e-6)


def test_collision_groups_that_come_while_playing_count_for_bodies_left_alone():
    with playing(prims=SLIDE) as app:
        with app.edit(when_playing="recompile") as stage:
            groups = [UsdPhysics.CollisionGroup.Define(stage, f"/World/Group{name}") for name in "AB"]
            groups[0].CreateFilteredGroupsRel().AddTarget(groups[1].GetPath())
            for group, member in zip(groups, ("/World/Other", "/World/Floor"), strict=True):
                group.GetCollidersCollectionAPI().CreateIncludesRel().AddTarget(member)
        app.update(60)
        assert place(app, "/World/Other")[2] == pytest.approx(0.5 - 9.81 / 2, abs=0.1)  # a second of falling
        assert place(app, "/World/Sled")[2] == pytest.approx(0.1, abs=0.01)


def test_what_instances_share_is_refused_and_compiled_like_a_prim_of_its_own():
    prims = {"/World/Ball": {"type": "Sphere", "radius": 0.5, "translate": [0, 0, 3], "rigid_body": True}}
    with App(physics_hz=240, loop_hz=60) as app:
        app.add_prims(prims)
        part = UsdGeom.Cube.Define(app.stage, "/Shared/Part")
        UsdPhysics.CollisionAPI.Apply(part.GetPrim())
        app.stage.GetPrimAtPath("/Shared").SetSpecifier(Sdf.SpecifierClass)
        for number in range(2):
            instance = UsdGeom.Xform.Define(app.stage, f"/World/Instance{number}")
            UsdGeom.XformCommonAPI(instance).SetTranslate((9.0 * number, 0, 0))
            instance.GetPrim().GetReferences().AddInternalReference("/Shared")
            instance.GetPrim().SetInstanceable(True)
        app.play()
        app.update(2)
        part.GetSizeAttr().Set(1.0)
        with pytest.raises(RunError, match=r"/World/Instance[01]/Part got another size"):
            app.update()
        part.GetSizeAttr().Set(2.0)
        with app.edit(when_playing="recompile"):
            UsdGeom.XformCommonAPI(part).SetTranslate((0, 0, 1))
        app.update(120)
        assert place(app, "/World/Ball")[2] == pytest.approx(2.5, abs=0.01)


def stage_of_a_ball():
    stage = open_stage(None)
    ball = UsdGeom.Sphere.Define(stage, "/World/Ball")
    ball.AddTranslateOp().Set((0, 0, 5))
    UsdPhysics.RigidBodyAPI.Apply(ball.GetPrim())
    UsdGeom.Cube.Define(stage, "/World/Post")
    return stage


@pytest.mark.parametrize("fabric", [True, False])
def test_what_is_edited_after_a_stop_was_requested_stays(fabric):
    stage = stage_of_a_ball()
    with App(stage, fidelity={"fabric": fabric}) as app:
        app.play()
        app.update(30)
        UsdGeom.Cube.Define(stage, "/World/While")
        app.timeline.stop()
        new = UsdGeom.Cube.Define(stage, "/World/New/Cube")
        new.GetSizeAttr().Set(3.0)
        stage.GetPrimAtPath("/World/Ball").SetMetadata("comment", "late")
        stage.GetPrimAtPath("/World/Ball").GetAttribute("radius").Set(0.5)
        stage.RemovePrim("/World/Post")
        UsdGeom.SetStageUpAxis(stage, "Y")
        app.update()
        ball = stage.GetPrimAtPath("/World/Ball")
        assert tuple(ball.GetAttribute("xformOp:translate").Get()) == (0, 0, 5)  # what physics wrote is gone
        assert (ball.GetMetadata("comment"), ball.GetAttribute("radius").Get()) == ("late", 0.5)
        assert new.GetSizeAttr().Get() == 3.0  # the same prim: what refers to it still works
        assert not stage.GetPrimAtPath("/World/Post")
        assert not stage.GetPrimAtPath("/World/While")
        assert UsdGeom.GetStageUpAxis(stage) == "Y"
        app.play()
        app.update(30)
        x, y, z = app.fabric.world_matrix("/World/Ball")[:3, 3]
        assert (x, z) == (0, 5)
        assert y < -1.0  # it falls along the new up axis


def test_a_stop_requested_inside_an_update_keeps_no_edit_of_it():
    stage = stage_of_a_ball()
    with App(stage) as app:
        app.play()
        app.update(2)

        def stop():
            app.timeline.stop()
            stage.GetPrimAtPath("/World/Post").GetAttribute("size").Set(7.0)

        end = app.on("physics_post_step", stop)
        app.update()
        end()
        app.update()
        assert stage.GetPrimAtPath("/World/Post").GetAttribute("size").Get() == 2.0
