"""URDF robots: their links, joints, limits and masses as the file says; safe to open."""

import math

import numpy as np
import pytest

from graph.base import asset_roots
from graph.base.errors import UserError
from graph.cli.main import main
from graph.sim import App, MemorySink
from graph.testing import run_node
from tests.support.mjcf_robots import TETRAHEDRON, stl

INERTIAL = "<inertial><mass value='{}'/><inertia ixx='.1' iyy='.2' izz='.15' ixy='0' ixz='0' iyz='0'/></inertial>"
ROBOT = f"""<robot name="lifter">
  <material name="blue"><color rgba="0 0 1 1"/><texture filename="/etc/passwd"/></material>
  <link name="base_link">{INERTIAL.format(2)}
    <visual><geometry><box size=".2 .2 .2"/></geometry><material name="blue"/></visual>
    <collision><geometry><box size=".4 .4 .4"/></geometry></collision>
  </link>
  <link name="arm-1.l">{INERTIAL.format(1)}
    <visual><origin xyz="0 0 .5"/><geometry><mesh filename="MESH" scale="2 2 2"/></geometry></visual>
    <collision><geometry><mesh filename="MESH"/></geometry></collision>
  </link>
  <link name="finger">{INERTIAL.format(0.5)}<visual><geometry><sphere radius=".1"/></geometry></visual></link>
  <link name="tool"/>
  <joint name="hip-yaw.l" type="revolute">
    <parent link="base_link"/><child link="arm-1.l"/><origin xyz="0 0 1" rpy="0 0 1.5707963267948966"/>
    <axis xyz="0 0 1"/><limit lower="-1" upper="2" effort="10" velocity="3"/><dynamics damping=".5" friction=".1"/>
  </joint>
  <joint name="slide" type="prismatic">
    <parent link="arm-1.l"/><child link="finger"/><origin xyz="0 1 0"/><axis xyz="1 0 0"/>
    <limit lower="0" upper=".5" effort="20" velocity="3"/><mimic joint="hip-yaw.l" multiplier="0.5" offset="0.1"/>
  </joint>
  <joint name="mount" type="fixed">
    <parent link="finger"/><child link="tool"/><origin xyz="0 .2 0"/>
  </joint>
</robot>
"""
GRAPH = "tickgraph: 1\nscene: {urdf: lifter/urdf/robot.urdf}\n"


@pytest.fixture
def robot(tmp_path):
    """Writes a robot whose mesh has this address, and a graph file with it; gives the graph file."""

    def write(mesh="../meshes/arm.obj", text=ROBOT):
        for folder in ("urdf", "meshes"):
            (tmp_path / "lifter" / folder).mkdir(parents=True, exist_ok=True)
        (tmp_path / "lifter" / "meshes" / "arm.obj").write_text(TETRAHEDRON)
        points, faces = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]
        (tmp_path / "lifter" / "meshes" / "arm.stl").write_bytes(stl(points, faces))
        (tmp_path / "lifter" / "urdf" / "robot.urdf").write_text(text.replace("MESH", mesh))
        (tmp_path / "graph.yaml").write_text(GRAPH)
        return tmp_path / "graph.yaml"

    return write


def test_links_joints_and_limits_are_the_urdfs(robot):
    with App.from_file(robot()) as app:
        app.sink = MemorySink()
        app.bus.subscribe(app.sink)
        inputs = {"targetPrims": ["/World/base_link"]}
        run_node("ROS2PublishTransformTree", inputs=inputs, pulses={"execIn": [0]}, updates=1, app=app)
        inputs = {"targetPrim": ["/World/base_link"]}
        run_node("ROS2PublishJointState", inputs=inputs, pulses={"execIn": [0]}, updates=1, app=app)
        transforms = app.sink["/tf"][0].message.transforms
        edges = [(one.header.frame_id, one.child_frame_id) for one in transforms]
        chain = [("base_link", "arm-1.l"), ("arm-1.l", "finger"), ("finger", "tool")]
        assert edges == [("world", "base_link"), *chain]
        turn, shift = transforms[1].transform.rotation, transforms[3].transform.translation
        assert (turn.z, turn.w) == pytest.approx(
            (math.sqrt(0.5), math.sqrt(0.5)), abs=0.01
        )  # 90 deg about z; the mimic pulls it
        assert (shift.x, shift.y, shift.z) == pytest.approx((0, 0.2, 0), abs=1e-9)
        assert list(app.sink["/joint_states"][0].message.name) == ["hip-yaw.l", "slide"]
        arm = app.physics.articulation("/World/tool")
        assert arm.limits == pytest.approx(np.array([[-1, 2], [0, 0.5]]))
        masses = dict(zip(app.physics.body_paths, app.physics.masses, strict=True))
        assert masses["/World/arm_1_l"] == pytest.approx(1.0)
        assert masses["/World/finger"] == pytest.approx(0.5)


LIMITED = f"""<robot name="spinner">
  <link name="base">{INERTIAL.format(5)}</link>
  <link name="arm">{INERTIAL.format(1)}</link>
  <joint name="yaw" type="continuous">
    <parent link="base"/><child link="arm"/><axis xyz="0 0 1"/><limit effort="0.6" velocity="3"/>
  </joint>
</robot>
"""


def test_efforts_and_speeds_stay_within_the_limits_of_the_joint(robot):
    """10 N m are cut to 0.6: 0.6 / 0.15 = 4 rad/s2, so 2 rad/s after 0.5 s, and 3 rad/s from 0.75 s on."""
    with App.from_file(robot(text=LIMITED)) as app:
        app.play()
        arm = app.physics.articulation("/World/base")
        arm.set_targets(efforts=[10.0])
        app.update(30)
        assert arm.velocities == pytest.approx([2.0], abs=4 / 60)
        assert arm.efforts == pytest.approx([0.6])
        app.update(30)
        assert arm.velocities == pytest.approx([3.0])


def test_a_position_command_to_a_joint_of_a_urdf_is_warned_of(robot):
    with App.from_file(robot(text=LIMITED)) as app:
        inputs = {"robotPath": "/World/base", "positionCommand": [1.0]}
        trace = run_node("IsaacArticulationController", inputs=inputs, pulses={"execIn": [0]}, updates=2, app=app)
    [warning] = trace.warnings
    assert (warning.code, warning.message.split(":")[0]) == (
        "joint-without-drive",
        "yaw of /World/base do not follow positions",
    )


def test_a_speed_limit_that_is_no_number_is_refused(robot):
    with pytest.raises(UserError, match=r"robot.urdf:5:\d+: limit velocity is not a number"):
        App.from_file(robot(text=LIMITED.replace('velocity="3"', 'velocity="fast"')))


def test_a_joint_that_mimics_follows(robot):
    # slide = 0.1 + 0.5 hip: the hip is put at 0.4 rad and held there by an effort of 0 against its friction.
    with App.from_file(robot()) as app:
        app.play()
        arm = app.physics.articulation("/World/base_link")
        arm.set_positions([0.4, 0.3])
        app.update(60)
        hip, slide = arm.positions
        assert slide == pytest.approx(0.1 + 0.5 * hip, abs=2e-3)
        assert hip == pytest.approx(0.4, abs=0.05)


def test_rays_see_visual_geometry_and_bodies_collide_with_the_other(robot):
    with App.from_file(robot()) as app:
        cubes = [prim for prim in app.stage.Traverse() if prim.GetTypeName() == "Cube"]
        seen = {prim.GetAttribute("xformOp:scale").Get()[0]: prim.GetAttribute("purpose").Get() for prim in cubes}
    assert seen == {0.1: "default", 0.2: "guide"}


@pytest.mark.parametrize(
    "address",
    ["../meshes/arm.stl", "package://lifter/meshes/arm.obj", "package://elsewhere/arm.obj", "model://m/arm.obj"],
)
def test_meshes_are_found_by_relative_names_packages_and_mapped_addresses(robot, tmp_path, address):
    folder = str(tmp_path / "lifter" / "meshes")
    file = robot(address)
    options = ["--asset-root", f"package://elsewhere={folder}", "--asset-root", f"model://m={folder}"]
    assert main(["check", str(file), *options]) == 0
    with asset_roots.mapped({"package://elsewhere": folder, "model://m": folder}), App.from_file(file) as app:
        assert app.mjcf.model.nmesh >= 1


@pytest.mark.parametrize(
    ("address", "told"),
    [
        ("package://unknown/arm.obj", "give the folder of the package with --asset-root package://unknown=DIR"),
        ("https://host/arm.obj", "give its folder with --asset-root https://host=DIR"),
        ("file:///etc/shadow.obj", "lies outside the model's folders"),
        ("../../../../etc/passwd.stl", "lies outside the model's folders"),
        ("package://mapped/../../../etc/passwd.stl", "leads out of"),
        ("../meshes/gone.stl", "there is no such file"),
    ],
)
def test_no_file_outside_the_named_folders_is_read(robot, tmp_path, address, told):
    file = robot(address)
    roots = asset_roots.mapped({"package://mapped": tmp_path / "lifter" / "meshes"})
    with roots, pytest.raises(UserError, match=r"robot\.urdf:8") as error:
        App.from_file(file)
    assert told in str(error.value)


def test_meshes_in_other_formats_are_left_out_and_it_is_said(robot):
    with App.from_file(robot("../meshes/arm.dae")) as app:
        said = [one.message for one in app.warnings if one.code == "urdf-left-out"]
        assert app.mjcf.model.nmesh == 0
    assert said == [
        "the visual mesh ../meshes/arm.dae of link arm-1.l is left out; convert it to one of .stl, .obj, .msh",
        "the collision mesh ../meshes/arm.dae of link arm-1.l is left out; convert it to one of .stl, .obj, .msh",
        "textures are left out; its materials have their colours",
    ]


@pytest.mark.parametrize(
    ("scene", "told"),
    [
        ("{mjcf: lifter/urdf/robot.urdf}", "did you mean scene: {urdf: lifter/urdf/robot.urdf}?"),
        ("{urdf: graph.yaml}", "does not end in .urdf or .xml"),
        ("{mjcf: robot.xml}", "this is a URDF; name it as scene: {urdf: robot.xml}"),
        ("{urdf: model.xml}", "this is an MJCF model; name it as scene: {mjcf: model.xml}"),
        ("{urdf: lifter/urdf/robot.urdf, mjcf: model.xml}", "give mjcf or urdf, not both"),
        ("{urdf: bad.urdf}", "bad.urdf:1:33: two links are called a"),
        ("{urdf: xacro.urdf}", "run xacro on it"),
        ("{urdf: doctype.urdf}", "has no DOCTYPE"),
    ],
)
def test_a_model_under_the_wrong_key_or_broken_is_one_line(robot, tmp_path, scene, told):
    file = robot()
    (tmp_path / "robot.xml").write_text(ROBOT.replace("MESH", "lifter/meshes/arm.obj"))
    (tmp_path / "model.xml").write_text("<mujoco/>")
    (tmp_path / "bad.urdf").write_text("<robot name='r'><link name='a'/><link name='a'/></robot>")
    (tmp_path / "xacro.urdf").write_text("<robot xmlns:xacro='x'><xacro:include filename='a'/><link name='a'/></robot>")
    (tmp_path / "doctype.urdf").write_text('<!DOCTYPE r [<!ENTITY a "b">]><robot/>')
    file.write_text(f"tickgraph: 1\nscene: {scene}\n")
    with pytest.raises(UserError) as error:
        App.from_file(file)
    assert told in str(error.value)


def test_an_app_takes_asset_roots(robot, tmp_path):
    meshes = tmp_path / "lifter" / "meshes"
    file, roots = robot("package://elsewhere/arm.obj"), {"package://elsewhere": meshes}
    for opened in (
        App.from_file(file, asset_roots=roots),
        App(mjcf=meshes.parent / "urdf/robot.urdf", asset_roots=roots),
    ):
        with opened as app:
            assert app.mjcf.model.nmesh >= 1


def test_an_asset_root_is_a_folder_that_exists(tmp_path, capsys):
    for option, told in (("package://a", "write it as PREFIX=VALUE"), ("package://a=/gone", "is not a folder")):
        assert main(["check", str(tmp_path / "g.yaml"), "--asset-root", option]) == 2
        assert told in capsys.readouterr().err
