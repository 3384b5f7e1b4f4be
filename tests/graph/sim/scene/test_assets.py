"""Assets that scenes name by addresses: mapped folders, built-in sensors, stand-ins, and what is missing."""

import json

import numpy as np
import pytest

from graph.base import asset_roots
from graph.base.errors import UserError
from graph.cli.main import main
from graph.sim import App
from graph.sim.scene.assets import missing_above
from graph.sim.scene.stage import open_stage
from graph.sim.usd import UsdGeom, UsdPhysics
from sensors.configs.catalog import assets, find
from sensors.lidar.prim import read_config
from sensors.xform import place

ROOT = "omniverse://localhost/NVIDIA/Assets/Isaac/6.0"
GROUND = f"{ROOT}/Isaac/Environments/Grid/default_environment.usd"
SCENE = '#usda 1.0\n(\n    metersPerUnit = 1\n    upAxis = "Z"\n)\n'


def scene(tmp_path, *assets_of_prims, more=""):
    """A scene with prims /P0, /P1... that refer to assets."""
    prim = 'def "P%s" (\n    references = @%s@\n    %s\n) {\n}\n'
    prims = "".join(prim % (number, asset, more) for number, asset in enumerate(assets_of_prims))
    file = tmp_path / "scene.usda"
    file.write_text(f"{SCENE}{prims}")
    return file


def opened(file, **options):
    warnings = []
    stage = open_stage(file, warn=lambda *warning: warnings.append(warning), **options)
    return stage, warnings


@pytest.mark.parametrize("prefix", [ROOT, "omniverse://localhost", f"{ROOT}/"])
def test_an_address_is_read_below_its_asset_root(tmp_path, prefix):
    folder = tmp_path / "assets"
    below = f"{ROOT}/Isaac/Robots/mine.usda".removeprefix(prefix.rstrip("/")).lstrip("/")
    (folder / below).parent.mkdir(parents=True)
    (folder / below).write_text(f'{SCENE}def Cube "shape" {{\n}}\n'.replace("(\n", '(\n    defaultPrim = "shape"\n', 1))
    with asset_roots.mapped({prefix: folder}):
        stage, warnings = opened(scene(tmp_path, f"{ROOT}/Isaac/Robots/mine.usda"))
    assert stage.GetPrimAtPath("/P0").GetTypeName() == "Cube"
    assert warnings == []


def test_an_address_does_not_lead_out_of_its_asset_root(tmp_path):
    (tmp_path / "assets").mkdir()
    (tmp_path / "secret.usda").write_text(SCENE)
    with asset_roots.mapped({ROOT: tmp_path / "assets"}), pytest.raises(UserError, match="leads out of"):
        opened(scene(tmp_path, f"{ROOT}/../secret.usda"))


def test_a_link_in_an_asset_root_does_not_lead_out_of_it(tmp_path):
    (tmp_path / "assets").mkdir()
    (tmp_path / "secret.usda").write_text(SCENE)
    (tmp_path / "assets" / "link.usda").symlink_to(tmp_path / "secret.usda")
    with asset_roots.mapped({ROOT: tmp_path / "assets"}), pytest.raises(UserError, match="leads out of"):
        opened(scene(tmp_path, f"{ROOT}/link.usda"))


def test_the_file_of_a_scene_stays_unchanged(tmp_path):
    file = scene(tmp_path, f"{ROOT}/Isaac/Environments/Grid/default_environment.usd")
    before = file.read_bytes()
    opened(file)
    assert file.read_bytes() == before


@pytest.mark.parametrize("asset", assets(), ids=lambda one: one.short_name)
def test_a_sensor_asset_is_its_built_in_configuration(tmp_path, asset):
    stage, warnings = opened(scene(tmp_path, f"{ROOT}{asset.path}"))
    path = "/P0" if asset.path.endswith(".usda") else "/P0/sensor"
    assert read_config(stage.GetPrimAtPath(path)).scan_rate_base_hz == asset.config().scan_rate_base_hz
    assert [code for code, *_ in warnings] == ["asset-built-in"]


def test_a_variant_of_a_sensor_asset_is_chosen_as_in_the_original(tmp_path):
    name = "OS1_REV6_32ch20hz1024res"
    file = scene(
        tmp_path, f"{ROOT}/Isaac/Sensors/Ouster/OS1/OS1.usd", more=f'variants = {{ string sensor = "{name}" }}'
    )
    stage, _ = opened(file)
    config = read_config(stage.GetPrimAtPath("/P0/sensor"))
    wanted = find("OS1", name)
    assert (config.scan_rate_base_hz, config.number_of_emitters) == (20, 32)
    assert config.scan_rate_base_hz == wanted.scan_rate_base_hz


@pytest.mark.parametrize(
    ("asset", "prim", "kind"),
    [
        ("Environments/Grid/default_environment.usd", "GroundPlane", "Plane"),
        ("Environments/Grid/default_environment.usd", "SphereLight", "SphereLight"),
        ("Environments/Simple_Room/simple_room.usd", "wall_east", "Cube"),
        ("Environments/Simple_Room/simple_room.usd", "SphereLight", "SphereLight"),
        ("Environments/Simple_Warehouse/warehouse.usd", "SphereLight", "SphereLight"),
        ("Environments/Simple_Warehouse/full_warehouse.usd", "rack_0_shelf_0", "Cube"),
        ("Props/Blocks/basic_block.usd", "Cube", "Cube"),
        ("Robots/IsaacSim/Ant/ant_colored.usd", "Arm_04/Lower_Arm/lower_arm_joint", "PhysicsRevoluteJoint"),
        (
            "Robots/IsaacSim/SimpleArticulation/simple_articulation.usd",
            "Slider/PrismaticJoint",
            "PhysicsPrismaticJoint",
        ),
        ("Robots/NVIDIA/Jetbot/jetbot.usd", "chassis/left_wheel_joint", "PhysicsRevoluteJoint"),
        ("Robots/FrankaRobotics/FrankaPanda/franka.usd", "panda_link6/panda_joint7", "PhysicsRevoluteJoint"),
    ],
)
def test_a_known_asset_that_is_not_here_has_a_stand_in_that_is_said_once(tmp_path, asset, prim, kind):
    address = f"{ROOT}/Isaac/{asset}"
    stage, warnings = opened(scene(tmp_path, address, address))
    assert stage.GetPrimAtPath(f"/P1/{prim}").GetTypeName() == kind
    ((code, where, message),) = warnings
    assert (code, where) == ("asset-stand-in", address)
    assert message.startswith("it is not downloaded; in its place: ")


def test_the_franka_has_the_joints_and_limits_of_the_original(tmp_path):
    file = scene(tmp_path, f"{ROOT}/Isaac/Robots/FrankaRobotics/FrankaPanda/franka.usd")
    with App(open_stage(file)) as app:
        app.play()
        tensors = app.simulation.tensors
        names = [path.rpartition("/")[2] for path in tensors.joint_paths]
        assert names == [f"panda_joint{n}" for n in range(1, 8)] + ["panda_finger_joint1", "panda_finger_joint2"]
        home = [0, -0.57, 0, -2.81, 0, 3.037, 0.741, 0.04, 0.04]
        assert np.allclose(tensors.joint_positions, home, atol=1e-3)
        app.update(steps=60)
        assert np.allclose(tensors.joint_positions, home, atol=0.02)  # its drives hold it against gravity
        joint = app.stage.GetPrimAtPath("/P0/panda_link3/panda_joint4")
        limits = [joint.GetAttribute(f"physics:{side}Limit").Get() for side in ("lower", "upper")]
        assert np.allclose(np.radians(limits), [-3.0718, -0.0698], atol=1e-4)


def test_the_jetbot_drives_by_its_wheels(tmp_path):
    """0.03 m x 10 rad/s x 1 s = 0.3 m, less the start."""
    with App(open_stage(scene(tmp_path, f"{ROOT}/Isaac/Robots/Jetbot/jetbot.usd", GROUND))) as app:
        app.play()
        tensors = app.simulation.tensors
        tensors.set_joint_targets(velocities=[10.0, 10.0])
        app.update(steps=60)
        x, y, _ = app.simulation.tensors.positions[list(tensors.body_paths).index("/P0/chassis")]
        assert 0.25 < x < 0.305
        assert abs(y) < 0.01


def test_what_is_missing_below_a_missing_asset_names_the_asset(tmp_path):
    address = f"{ROOT}/Isaac/Robots/NVIDIA/Carter/nova_carter.usd"
    stage, warnings = opened(scene(tmp_path, address))
    told = f"nova_carter.usd is not downloaded ({address}; give its folder with --asset-root {ROOT}=DIR)"
    assert warnings[0][2] == f"{told} so that /P0 stays empty; it is left out"
    assert missing_above(stage, "/P0/chassis_link/imu") == f"/P0 is empty because {told}"
    assert missing_above(stage, "/Elsewhere") == ""
    assert missing_above(stage, "not/absolute") == ""  # its parents are "..", "../..", without end


def test_an_inline_prim_refers_to_an_asset_as_a_scene_does(tmp_path):
    file = tmp_path / "graph.yaml"
    file.write_text(
        "tickgraph: 1\nscene: {prims: {/World/Lidar: {reference: /Isaac/Sensors/NVIDIA/Example_Rotary.usda}}}\n"
    )
    with App.from_file(file) as app:
        prim = app.stage.GetPrimAtPath("/World/Lidar")
        assert prim.GetTypeName() == "OmniLidar"
        assert np.isclose(prim.GetAttribute("omni:sensor:tickRate").Get(), 10)


def test_an_inline_prim_with_an_unknown_address_says_how_to_map_it(tmp_path):
    file = tmp_path / "graph.yaml"
    file.write_text(f"tickgraph: 1\nscene: {{prims: {{/World/R: {{reference: '{ROOT}/Isaac/Robots/mine.usd'}}}}}}\n")
    with pytest.raises(UserError, match=f"mine.usd is not downloaded .*--asset-root {ROOT}=DIR"):
        App.from_file(file)


def listed(capsys, *arguments):
    assert main(["assets", *map(str, arguments), "--json"]) == 0
    return {one["asset"]: (one["state"], one["place"]) for one in json.loads(capsys.readouterr().out)["assets"]}


def test_the_command_lists_what_a_scene_wants_and_where_it_is(tmp_path, capsys):
    (tmp_path / "assets" / "Isaac").mkdir(parents=True)
    here, gone = f"{ROOT}/Isaac/here.usda", f"{ROOT}/Isaac/gone.usda"
    (tmp_path / "assets" / "Isaac" / "here.usda").write_text(SCENE)
    (tmp_path / "own.usda").write_text(SCENE)
    file = scene(tmp_path, here, gone, GROUND, "./own.usda", "./lost.usda")
    assert listed(capsys, file, "--asset-root", f"{ROOT}={tmp_path / 'assets'}") == {
        here: ("found", str(tmp_path / "assets/Isaac/here.usda")),
        gone: ("missing", str(tmp_path / "assets/Isaac/gone.usda")),
        GROUND: ("stand-in", "an endless ground plane"),
        "./own.usda": ("found", str(tmp_path / "own.usda")),
        "./lost.usda": ("missing", str(tmp_path / "lost.usda")),
    }


def test_the_command_lists_the_files_of_a_graph_file(tmp_path, capsys):
    scene(tmp_path, GROUND)
    file = tmp_path / "graph.yaml"
    sensor = "/Isaac/Sensors/NVIDIA/Example_Rotary.usda"
    prims = f"{{/World/A: {{reference: {ROOT}/Isaac/a.usd}}, /World/B: {{reference: {sensor}}}}}"
    file.write_text(f"tickgraph: 1\nscene: {{usd: scene.usda, prims: {prims}}}\n")
    assert listed(capsys, file) == {
        str(tmp_path / "scene.usda"): ("found", str(tmp_path / "scene.usda")),
        GROUND: ("stand-in", "an endless ground plane"),
        f"{ROOT}/Isaac/a.usd": ("missing", f"--asset-root {ROOT}=DIR"),
        sensor: ("stand-in", "the built-in configuration Example_Rotary"),
    }


def test_the_command_lists_the_assets_in_the_texts_of_a_script(tmp_path, capsys):
    file = tmp_path / "script.py"
    robot = "/Isaac/Robots/NVIDIA/Carter/nova_carter.usd"
    grid = "/Isaac/Environments/Grid/default_environment.usd"
    file.write_text(f"add(root + {robot!r})\nadd(f'{{root}}{grid}')\nx = 'no'\n")
    assert listed(capsys, file) == {
        robot: ("missing", "--asset-root /Isaac=DIR"),
        grid: ("stand-in", "an endless ground plane"),
    }


def test_the_pivot_arm_is_a_load_of_two_kilograms_at_a_metre(tmp_path):
    asset = f"{ROOT}/Isaac/Robots/IsaacSim/SimpleArticulation/simple_articulation.usd"
    stage, _ = opened(scene(tmp_path, asset))
    stage.GetPrimAtPath("/P0/Arm/RevoluteJoint").GetAttribute("physics:axis").Set("Y")
    with App(stage) as app:
        app.play()
        app.update(steps=4)
        efforts = app.simulation.tensors.joint_efforts
        # Arm and slider, 1 kg each, with their centres 1 m from the joint: 2 kg x 1 m x 9.81 m/s2, against gravity.
        assert efforts[0] == pytest.approx(-19.62, abs=0.05)


def test_the_ant_stands_on_four_legs_whose_tips_bear_its_weight(tmp_path):
    file = scene(tmp_path, f"{ROOT}/Isaac/Robots/IsaacSim/Ant/ant_colored.usd")
    stage, _ = opened(file)
    plane = UsdGeom.Plane.Define(stage, "/Ground")
    plane.AddTranslateOp().Set((0, 0, -0.78))
    UsdPhysics.CollisionAPI.Apply(plane.GetPrim())
    with App(stage) as app:
        app.play()
        app.update(steps=120)
        held = app.physics.contacts()
        forces = [abs(force[2]) for force in held.forces]
        # A ball of 2 kg and eight links of 0.25 kg: 4 kg.
        assert (len(forces), sum(forces)) == (4, pytest.approx(4 * 9.81, rel=0.02))


def test_a_pose_over_a_referenced_prim_keeps_the_precision_of_its_ops(tmp_path):
    stage, _ = opened(scene(tmp_path, f"{ROOT}/Isaac/Props/Blocks/basic_block.usd"))
    block = stage.GetPrimAtPath("/P0/Cube")
    place(block, positions=np.array([1.0, 2.0, 3.0]), scales=np.array([2.0, 2.0, 2.0]))
    ops = UsdGeom.Xformable(block).GetOrderedXformOps()
    assert [str(op.GetAttr().GetTypeName()) for op in ops] == ["double3", "quatd", "float3"]
    assert tuple(ops[0].Get()) == (1, 2, 3)
    assert tuple(ops[2].Get()) == (2, 2, 2)
