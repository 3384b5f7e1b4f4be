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
from sensors.configs.catalog import assets, find
from sensors.lidar.prim import read_config
from tests.support.without_wing import needs_wing

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


@needs_wing("stand_ins")
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


@needs_wing("stand_ins")
def test_what_is_missing_below_a_missing_asset_names_the_asset(tmp_path):
    address = f"{ROOT}/Isaac/Robots/NVIDIA/Carter/carter_v3.usd"
    stage, warnings = opened(scene(tmp_path, address))
    told = f"carter_v3.usd is not downloaded ({address}; give its folder with --asset-root {ROOT}=DIR)"
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


@needs_wing("stand_ins")
def test_an_inline_prim_with_an_unknown_address_says_how_to_map_it(tmp_path):
    file = tmp_path / "graph.yaml"
    file.write_text(f"tickgraph: 1\nscene: {{prims: {{/World/R: {{reference: '{ROOT}/Isaac/Robots/mine.usd'}}}}}}\n")
    with pytest.raises(UserError, match=f"mine.usd is not downloaded .*--asset-root {ROOT}=DIR"):
        App.from_file(file)


def listed(capsys, *arguments):
    assert main(["assets", *map(str, arguments), "--json"]) == 0
    return {one["asset"]: (one["state"], one["place"]) for one in json.loads(capsys.readouterr().out)["assets"]}


@needs_wing("stand_ins")
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


@needs_wing("stand_ins")
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


@needs_wing("stand_ins")
def test_the_command_lists_the_assets_in_the_texts_of_a_script(tmp_path, capsys):
    file = tmp_path / "script.py"
    robot = "/Isaac/Robots/Nobody/Walker/walker.usd"
    grid = "/Isaac/Environments/Grid/default_environment.usd"
    file.write_text(f"add(root + {robot!r})\nadd(f'{{root}}{grid}')\nx = 'no'\n")
    assert listed(capsys, file) == {
        robot: ("missing", "--asset-root /Isaac=DIR"),
        grid: ("stand-in", "an endless ground plane"),
    }
