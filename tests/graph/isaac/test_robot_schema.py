"""The robot schema: links, joints, sites and poses of a robot, as prims list them."""

from importlib import import_module

import pytest
from pxr import Gf, Sdf, Tf, Usd, UsdGeom, UsdPhysics

import graph.isaac
from graph.isaac.modules import robot_schema as schema
from graph.isaac.modules import robot_schema_utils as utils
from graph.isaac.modules.sensor_schema import IsaacSensorSchema
from graph.sim import App

LINKS, JOINTS = "isaac:physics:robotLinks", "isaac:physics:robotJoints"


def body(stage, path):
    prim = UsdGeom.Xform.Define(stage, path).GetPrim()
    UsdPhysics.RigidBodyAPI.Apply(prim)
    return prim


def joint(stage, path, first, second, kind=UsdPhysics.RevoluteJoint):
    made = kind.Define(stage, path)
    made.CreateBody0Rel().SetTargets([first] if first else [])
    made.CreateBody1Rel().SetTargets([second])
    return made.GetPrim()


@pytest.fixture
def stage():
    return Usd.Stage.CreateInMemory()


@pytest.fixture
def arm(stage):
    """A base with two branches: base - a - b, and base - c; joint names say which bodies they connect."""
    base = body(stage, "/arm")
    UsdPhysics.ArticulationRootAPI.Apply(base)
    for name in "abc":
        body(stage, f"/arm/{name}")
    joint(stage, "/arm/base_a", "/arm", "/arm/a")
    joint(stage, "/arm/base_c", "/arm", "/arm/c")
    joint(stage, "/arm/a_b", "/arm/a", "/arm/b")
    return base


def listed(prim, name):
    return [str(one) for one in prim.GetRelationship(name).GetTargets()]


def test_a_script_imports_the_schema_and_its_functions():
    with App(), graph.isaac.importable():
        robot_schema = import_module("usd.schema.isaac.robot_schema")
        assert robot_schema.Attributes.DESCRIPTION.name == "isaac:description"
        assert robot_schema.Attributes.CHANGELOG.type == Sdf.ValueTypeNames.StringArray
        assert robot_schema.Relations.ROBOT_LINKS.display_name == "Robot Links"
        assert robot_schema.Classes.ROBOT_API.value == "IsaacRobotAPI"
        assert import_module("usd.schema.isaac.robot_schema.utils").GetAllRobotLinks is utils.GetAllRobotLinks


def test_a_robot_lists_its_links_branch_after_branch_and_marks_them(stage, arm):
    schema.ApplyRobotAPI(arm)
    assert listed(arm, LINKS) == ["/arm", "/arm/a", "/arm/b", "/arm/c"]
    assert listed(arm, JOINTS) == ["/arm/base_a", "/arm/base_c", "/arm/a_b"]
    assert all(stage.GetPrimAtPath(one).HasAPI("IsaacLinkAPI") for one in listed(arm, LINKS))
    assert all(stage.GetPrimAtPath(one).HasAPI("IsaacJointAPI") for one in listed(arm, JOINTS))
    utils.PopulateRobotSchemaFromArticulation(stage, arm, traversal="bfs")
    assert listed(arm, LINKS) == ["/arm", "/arm/a", "/arm/c", "/arm/b"]


def test_the_lists_are_prepended_so_that_stronger_layers_add_to_them(stage, arm):
    schema.ApplyRobotAPI(arm)
    paths = stage.GetRootLayer().GetRelationshipAtPath(f"/arm.{LINKS}").targetPathList
    assert [str(one) for one in paths.prependedItems] == ["/arm", "/arm/a", "/arm/b", "/arm/c"]
    assert not paths.isExplicit


def test_a_robot_on_a_robot_is_listed_whole_where_a_joint_reaches_it(stage, arm):
    body(stage, "/arm/hand/palm"), body(stage, "/arm/hand/finger")
    joint(stage, "/arm/hand/knuckle", "/arm/hand/palm", "/arm/hand/finger")
    joint(stage, "/arm/b_hand", "/arm/b", "/arm/hand/palm")
    hand = stage.GetPrimAtPath("/arm/hand")
    schema.ApplyRobotAPI(hand)
    schema.ApplyRobotAPI(arm)
    assert listed(arm, LINKS) == ["/arm", "/arm/a", "/arm/b", "/arm/hand", "/arm/c"]
    assert listed(arm, JOINTS) == ["/arm/base_a", "/arm/base_c", "/arm/a_b", "/arm/b_hand", "/arm/hand"]
    assert listed(hand, LINKS) == ["/arm/hand/palm", "/arm/hand/finger"]
    everything = [one.GetName() for one in utils.GetAllRobotLinks(stage, arm)]
    assert everything == ["arm", "a", "b", "c", "palm", "finger"]


def test_without_an_articulation_the_body_that_others_hang_on_comes_first(stage):
    group = UsdGeom.Xform.Define(stage, "/group").GetPrim()
    body(stage, "/group/tool"), body(stage, "/group/base")
    joint(stage, "/group/j", "/group/base", "/group/tool")
    root, first = utils.PopulateRobotSchemaFromArticulation(stage, group)
    assert (str(root.GetPath()), first) == ("/group/base", None)
    assert listed(group, LINKS) == ["/group/base", "/group/tool"]


def test_bodies_without_joints_are_links(stage):
    drone = UsdGeom.Xform.Define(stage, "/drone").GetPrim()
    body(stage, "/drone/frame"), body(stage, "/drone/rotor")
    utils.PopulateRobotSchemaFromArticulation(stage, drone)
    assert listed(drone, LINKS) == ["/drone/frame", "/drone/rotor"]
    assert listed(drone, JOINTS) == []


def test_a_joint_excluded_from_the_articulation_leads_nowhere(stage, arm):
    UsdPhysics.Joint(stage.GetPrimAtPath("/arm/a_b")).CreateExcludeFromArticulationAttr(True)
    schema.ApplyRobotAPI(arm)
    assert listed(arm, LINKS) == ["/arm", "/arm/a", "/arm/c"]


def test_recalculating_keeps_the_order_adds_what_came_and_drops_what_left(stage, arm):
    schema.ApplyRobotAPI(arm)
    utils.RebuildRelationshipAsPrepend(arm, LINKS, ["/arm", "/arm/c", "/arm/b", "/arm/a"])
    body(stage, "/arm/d")
    joint(stage, "/arm/c_d", "/arm/c", "/arm/d")
    stage.RemovePrim("/arm/b")
    utils.RecalculateRobotSchema(stage, arm)
    assert listed(arm, LINKS) == ["/arm", "/arm/c", "/arm/a", "/arm/d"]
    utils.RecalculateRobotSchema(stage, arm, force_update=True)
    assert listed(arm, LINKS) == ["/arm", "/arm/a", "/arm/c", "/arm/d"]
    with pytest.raises(ValueError, match="the stage is not valid"):
        utils.RecalculateRobotSchema(None, arm)
    with pytest.raises(ValueError, match="the robot prim is not valid"):
        utils.RecalculateRobotSchema(stage, None)
    with pytest.raises(ValueError, match='"dfs" or "bfs", not \'deep\''):
        utils.RecalculateRobotSchema(stage, arm, traversal="deep")


def test_links_that_the_robot_does_not_list_are_given_with_a_warning(stage, arm, caplog):
    arm.AddAppliedSchema("IsaacRobotAPI")
    assert [one.GetName() for one in utils.GetAllRobotLinks(stage, arm)] == ["arm", "a", "b", "c"]
    assert "/arm does not list these links: /arm, /arm/a, /arm/b, /arm/c" in caplog.text


def test_an_empty_xform_below_a_link_is_a_site_listed_behind_it_or_last(stage, arm):
    UsdGeom.Xform.Define(stage, "/arm/a/flange")
    UsdGeom.Xform.Define(stage, "/arm/a/group/inner")
    schema.ApplyRobotAPI(arm)
    sites, by_link = utils.DetectAndApplySites(stage, arm)
    flange = stage.GetPrimAtPath("/arm/a/flange")
    assert (sites, by_link) == ([flange], {"/arm/a": [flange]})
    assert flange.HasAPI("IsaacSiteAPI")
    utils.AddSitesToRobotLinks(arm, sites_by_parent=by_link)
    assert listed(arm, LINKS) == ["/arm", "/arm/a", "/arm/a/flange", "/arm/b", "/arm/c"]
    assert flange in utils.GetAllRobotLinks(stage, arm, include_reference_points=True)
    assert flange not in utils.GetAllRobotLinks(stage, arm)
    utils.RebuildRelationshipAsPrepend(arm, LINKS, ["/arm", "/arm/a", "/arm/b"])
    utils.AddSitesToRobotLinks(arm, sites, sites_last=True)
    assert listed(arm, LINKS) == ["/arm", "/arm/a", "/arm/b", "/arm/a/flange"]


def test_the_tree_gives_the_links_before_and_behind_a_joint(stage, arm):
    schema.ApplyRobotAPI(arm)
    tree = utils.GenerateRobotLinkTree(stage, arm)
    before, behind = utils.GetLinksFromJoint(tree, stage.GetPrimAtPath("/arm/base_a"))
    assert [one.GetName() for one in before] == ["arm", "c"]
    assert [one.GetName() for one in behind] == ["a", "b"]
    assert utils.GetLinksFromJoint(tree, stage.GetPrimAtPath("/arm/c")) == ([], [])


def test_a_joint_stands_where_its_first_body_and_its_frame_there_put_it(stage, arm):
    UsdGeom.Xformable(arm).AddTranslateOp().Set((10, 0, 0))
    UsdGeom.Xformable(stage.GetPrimAtPath("/arm/a")).AddTranslateOp().Set((0, 2, 0))
    prim = stage.GetPrimAtPath("/arm/a_b")
    prim.GetAttribute("physics:localPos0").Set(Gf.Vec3f(0, 0, 0.5))
    # In the robot's frame: 2 m to a, and half a metre up from there.
    assert Gf.IsClose(utils.GetJointPose(arm, prim).ExtractTranslation(), Gf.Vec3d(0, 2, 0.5), 1e-9)


def test_stale_targets_are_told_apart(stage, arm):
    schema.ApplyRobotAPI(arm)
    arm.GetRelationship(LINKS).AddTarget("/arm/ghost")
    good, stale, joints, stale_joints = utils.ValidateRobotSchemaRelationships(arm)
    assert (len(good), [str(one) for one in stale], len(joints), stale_joints) == (4, ["/arm/ghost"], 3, [])
    assert utils.ValidateRobotSchemaRelationships(stage.GetPrimAtPath("/none")) == ([], [], [], [])


def test_old_offsets_become_an_order_and_reference_points_become_sites(stage, arm):
    free = joint(stage, "/arm/free", "/arm/b", "/arm/c", UsdPhysics.Joint)
    schema.ApplyJointAPI(free)
    for axis, place in (("Tr_X", 1), ("Rot_Z", 0), ("Tr_Y", 1)):
        free.CreateAttribute(f"isaac:physics:{axis}:DoFOffset", Sdf.ValueTypeNames.Int).Set(place)
    stage.GetPrimAtPath("/arm/a").AddAppliedSchema("IsaacReferencePointAPI")
    utils.UpdateDeprecatedSchemas(arm)
    assert list(free.GetAttribute("isaac:physics:DofOffsetOpOrder").Get()) == ["RotZ", "TransX", "TransY"]
    assert not free.GetAttribute("isaac:physics:Tr_X:DoFOffset")
    assert stage.GetPrimAtPath("/arm/a").HasAPI("IsaacSiteAPI")
    assert not stage.GetPrimAtPath("/arm/a").HasAPI("IsaacReferencePointAPI")
    assert not utils.UpdateDeprecatedJointDofOrder(free)


def test_a_named_pose_gives_its_links_joints_and_values(stage, arm):
    pose = schema.CreateNamedPose(stage, "/arm/home")
    assert utils.GetNamedPoseStartLink(pose) is None
    assert utils.GetNamedPoseJointValues(pose) is None
    assert utils.GetNamedPoseValid(pose) is None
    pose.GetRelationship("isaac:robot:pose:startLink").SetTargets(["/arm"])
    pose.GetRelationship("isaac:robot:pose:joints").SetTargets(["/arm/base_a", "/arm/a_b"])
    pose.GetAttribute("isaac:robot:pose:jointValues").Set([0.5, -0.25])
    pose.GetAttribute("isaac:robot:pose:valid").Set(True)
    arm.CreateRelationship("isaac:robot:namedPoses").SetTargets(["/arm/home", "/arm/a"])
    assert utils.GetAllNamedPoses(stage, arm) == [pose]
    assert utils.GetNamedPoseStartLink(pose) == "/arm"
    assert utils.GetNamedPoseJoints(pose) == ["/arm/base_a", "/arm/a_b"]
    assert utils.GetNamedPoseJointValues(pose) == [0.5, -0.25]
    assert utils.GetNamedPoseValid(pose) is True


def test_sensor_prims_have_the_types_and_fallbacks_of_the_original(stage):
    for name, kind in (("RangeSensorLidar", "Lidar"), ("IsaacSensorIsaacImuSensor", "IsaacImuSensor")):
        prim = stage.DefinePrim(f"/{kind}", kind)
        assert prim.IsA(Tf.Type.FindByName(name))
        assert prim.IsA(UsdGeom.Xformable)
    contact = stage.DefinePrim("/contact", "IsaacContactSensor")
    assert contact.GetAttribute("threshold").Get() == Gf.Vec2f(0.01, 100000.0)
    assert contact.GetAttribute("sensorPeriod").Get() == pytest.approx(0.0025)


def test_an_old_scene_marks_a_camera_as_a_lidar(stage):
    camera = stage.DefinePrim("/camera", "Camera")
    made = IsaacSensorSchema.IsaacRtxLidarSensorAPI.Apply(camera)
    assert made.GetPrim() == camera
    assert camera.GetAppliedSchemas() == ["IsaacRtxLidarSensorAPI"]
    assert camera.HasAPI(IsaacSensorSchema.IsaacRtxLidarSensorAPI)
    assert not camera.HasAPI(IsaacSensorSchema.IsaacRtxRadarSensorAPI)
    assert not IsaacSensorSchema.IsaacRtxRadarSensorAPI(camera)
