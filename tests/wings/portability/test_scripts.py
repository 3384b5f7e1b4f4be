"""`graph check --target` on Python scripts: they are read, never run."""

import json

import pytest

from graph.cli.main import main
from wings.portability.rules import RULES

APP = "from isaacsim import SimulationApp\napp = SimulationApp({'headless': True})\n"
TIMELINE = "import omni.timeline\ntimeline = omni.timeline.get_timeline_interface()\n"
RTX = (
    "from isaacsim.sensors.experimental.rtx import Lidar, LidarSensor, Radar, RadarSensor\n"
    "from isaacsim.sensors.experimental.rtx import parse_generic_model_output_data\n"
)
MANAGER = "from isaacsim.core.simulation_manager import SimulationEvent, SimulationManager\n"
SETTINGS = "import carb\nsettings = carb.settings.get_settings()\n"
EDIT = """
import omni.graph.core as og
keys = og.Controller.Keys
og.Controller.edit("/G", {keys.CREATE_NODES: [%s], keys.SET_VALUES: [%s], keys.CONNECT: [%s]})
"""
STAGE = "import isaacsim.core.experimental.utils.stage as stage_utils\n"
UTILS = "import isaacsim.core.experimental.utils.app as app_utils\n"
CUBE = "from isaacsim.core.experimental.objects import Cube\n"
ROOT = "from isaacsim.storage.native import get_assets_root_path\n"
IDS = "from isaacsim.sensors.experimental.rtx import parse_stable_id_map_data\n"
WAITS = "from omni.syntheticdata import sensors\n"
STARTED = "SimulationEvent.SIMULATION_STARTED"

CORE = "omni:sensor:Core:"
STATE = f"{CORE}outputMotionCompensationState"
SCAN = f"{CORE}scanRateBaseHz"
PRIM = "prim = stage.DefinePrim('/L', 'OmniLidar')\n"
BVH = "from isaacsim import SimulationApp\napp = SimulationApp({'headless': quiet, 'enable_motion_bvh': True})\n"
ASKS = """
from isaacsim.sensors.experimental.rtx import Lidar
lidar = Lidar('/L', aux_output_level='NONE')
product = rep.create.render_product(lidar.path, (1, 1))
annotator = rep.AnnotatorRegistry.get_annotator('IsaacExtractRTXSensorPointCloud')
annotator.initialize(outputHitNormal=%s)
annotator.attach([product.path])
"""

PLANTED = {
    "lidar-partial-scan": f"{RTX}lidar = Lidar.create('/L', config='Example_Rotary', tick_rate=5.0)\n",
    "sensor-every-frame": "lidar = stage.DefinePrim('/L', 'OmniLidar')\n",
    "sensor-api-missing": "from pxr import UsdGeom\ncamera = UsdGeom.Camera.Define(stage, '/C').GetPrim()\n"
    "camera.CreateAttribute('omni:sensor:tickRate', kind).Set(10.0)\n",
    "radar-tick-rate-ignored": f"{RTX}radar = Radar('/R', tick_rate=20)\nRadarSensor(radar)\n",
    "fif-race": f"{BVH}{RTX}LidarSensor(Lidar('/L'))\nRadarSensor(Radar('/R'))\n",
    "motion-compensation-off": f"{APP}{RTX}Lidar('/L', attributes={{'{STATE}': 'COMPENSATED'}})\n",
    "aux-level-too-low": ASKS % "True",
    "normals-off": ASKS.replace("NONE", "FULL") % "True",
    "aux-last-product-wins": f"{RTX}LidarSensor(Lidar('/L', aux_output_level='FULL'))\nLidarSensor(Lidar('/M'))\n",
    "report-rate-ignored": f"{PRIM}prim.CreateAttribute('{CORE}reportRateBaseHz', kind).Set(36000)\n",
    "ovrtx-vocabulary": f"{PRIM}prim.CreateAttribute('{CORE}partialOutputs', kind).Set(False)\n",
    "fabric-parent-moved": f"{TIMELINE}from isaacsim.core.experimental.prims import RigidPrim, XformPrim\n"
    "body, base = RigidPrim('/W/rig/ball'), XformPrim('/W/rig')\ntimeline.play()\nbase.set_world_poses([[0, 0, 1]])\n",
    "physics-slower-than-loop": f"{MANAGER}SimulationManager.set_physics_dt(1 / 30)\n",
    "catch-up-cap": f"{MANAGER}SimulationManager.setup_simulation(dt=1 / 500)\n"
    "from isaacsim.core.rendering_manager import RenderingManager\nRenderingManager.set_dt(1 / 20)\n",
    "rate-limit-stock-frequency": f"{SETTINGS}settings.set('/app/runLoops/main/rateLimitEnabled', True)\n",
    "flat-scan-3d": EDIT
    % (
        "('p', 'isaacsim.core.nodes.IsaacCreateRenderProduct'), ('h', 'isaacsim.ros2.bridge.ROS2RtxLidarHelper')",
        "('p.inputs:cameraPrim', ['/L']), ('h.inputs:type', 'laser_scan')",
        "('p.outputs:renderProductPath', 'h.inputs:renderProductPath')",
    )
    + f"{RTX}Lidar.create('/L', config='Example_Rotary')\n",
    "physics-step-stage": EDIT % ("('s', 'isaacsim.core.nodes.OnPhysicsStep')", "", ""),
    "edit-refused": EDIT
    % (
        "('t', 'omni.graph.action.OnPlaybackTick'), ('c', 'isaacsim.ros2.bridge.ROS2CameraHelper')",
        "",
        "('t.outputs:tick', 'c.inputs:execIn'), ('c.outputs:execOut', 't.inputs:execIn')",
    ),
    "attribute-removed": EDIT
    % ("('t', 'isaacsim.core.nodes.IsaacReadSimulationTime')", "('t.inputs:swhFrameNumber', 3)", ""),
    "system-time-never-resets": EDIT
    % (
        "('h', 'isaacsim.ros2.bridge.ROS2CameraHelper')",
        "('h.inputs:useSystemTime', True), ('h.inputs:resetSimulationTimeOnStop', True)",
        "",
    ),
    "radar-motion-bvh-off": f"{APP}{RTX}radar = Radar('/R')\n",
    "aux-level-reset": f"{RTX}Lidar('/L', aux_output_level='FULL')\nsensor = LidarSensor('/L')\n",
    "output-buffer-on-gpu": f"{SETTINGS}settings.set('/app/sensors/nv/lidar/outputBufferOnGPU', True)\n",
    "multi-tick-off": f"{SETTINGS}settings.set('/rtx/hydra/supportMultiTickRate', False)\n",
    "manual-mode-lag": f"{SETTINGS}settings.set('/app/runLoops/main/manualModeEnabled', True)\n",
    "rate-limit-without-time-codes": f"{SETTINGS}settings.set('/app/runLoops/main/rateLimitFrequency', 30)\n",
    "fast-mode-wall-time": f"{TIMELINE}import time\ntimeline.set_play_every_frame(True)\ntime.sleep(1)\n",
    "physics-rate-truncated": f"{MANAGER}SimulationManager.setup_simulation(dt=1 / 99)\n",
    "min-frame-rate-changed": "world = World()\nworld.set_simulation_dt(1 / 100, 1 / 60)\n",
    "physics-dt-while-playing": f"{TIMELINE}{MANAGER}timeline.play()\nSimulationManager.set_physics_dt(1 / 60)\n",
    "prims-added-while-playing": f"{TIMELINE}{CUBE}timeline.play()\nCube('/C')\n",
    "edit-not-live": f"{TIMELINE}timeline.play()\nUsdPhysics.MassAPI(prim).CreateMassAttr(2.0)\n",
    "callback-arguments-swapped": f"{MANAGER}SimulationManager.register_callback({STARTED}, f)\n",
    "callback-dropped": f"{MANAGER}SimulationManager.register_callback(Robot().step, {STARTED})\n",
    "default-callbacks-off": f"{MANAGER}SimulationManager.enable_default_callbacks(enable_warm_start=True)\n",
    "assets-root-raises": f"{ROOT}root = get_assets_root_path()\nif root is None:\n    pass\n",
    "open-stage-always-true": f"{STAGE}if not stage_utils.open_stage('a.usd'):\n    pass\n",
    "import-before-app": f"import omni.usd\n{APP}",
    "code-after-close": f"{APP}app.close()\nprint('done')\n",
    "asyncio-run": "import asyncio\nasyncio.run(main())\n",
    "gmo-parser-deprecated": "from isaacsim.sensors.rtx.generic_model_output import get_gmo_data\nget_gmo_data(data)\n",
    "gmo-attribute-missing": f"{RTX}gmo = parse_generic_model_output_data(data)\nprint(gmo.azimuth)\n",
    "object-id-without-entry": f"{IDS}ids = parse_stable_id_map_data(data)\nprint(ids[3])\n",
    "class-deprecated": "import omni.kit.commands\nomni.kit.commands.execute('IsaacSensorCreateRtxLidar', path='/L')\n",
    "extension-renamed": f"{UTILS}app_utils.enable_extension('omni.isaac.ros2_bridge')\n",
    "module-deprecated": "from isaacsim.core.api import World\n",
    "module-unknown": "from isaacsim.core.nosuch import thing\n",
    "import-renamed": "from omni.isaac.core.utils.prims import get_prim_at_path\n",
    "annotator-deprecated": "annotator = rep.AnnotatorRegistry.get_annotator('IsaacCreateRTXLidarScanBuffer')\n",
    "next-render-simulation-deprecated": f"{WAITS}await sensors.next_render_simulation_async('/P', 1)\n",
    "node-deprecated": EDIT % ("('a', 'isaacsim.sensors.rtx.OgnIsaacReadRTXLidarData')", "", ""),
    "type-renamed": EDIT % ("('a', 'omni.isaac.ros2_bridge.ROS2PublishClock')", "", ""),
    "frame-skip-deprecated": EDIT % ("", "('a.inputs:frameSkipCount', 2)", ""),
    "full-scan-deprecated": EDIT % ("", "('a.inputs:fullScan', True)", ""),
    "gate-step-zero": EDIT % ("('g', 'isaacsim.core.nodes.IsaacSimulationGate')", "('g.inputs:step', 0)", ""),
    "joint-indices-zero": EDIT % ("", "('a.inputs:jointIndices', [0])", ""),
    "timeline-stamp": EDIT
    % (
        "('t', 'omni.graph.action.OnPlaybackTick'), ('clock', 'isaacsim.ros2.bridge.ROS2PublishClock')",
        "",
        "('t.outputs:time', 'clock.inputs:timeStamp')",
    ),
}

FINE = f"""
import argparse
{APP}
import omni.timeline
import omni.graph.core as og
from isaacsim.core.experimental.objects import Cube
{MANAGER}{RTX}
{TIMELINE}
Cube('/C', sizes=1.0)
lidar = Lidar.create('/L', config='Example_Rotary', tick_rate=10.0, aux_output_level='FULL')
sensor = LidarSensor(lidar)
SimulationManager.setup_simulation(dt=1 / 60)
SimulationManager.register_callback(step, SimulationEvent.SIMULATION_STARTED)
timeline.play()
for _ in range(60):
    app.update()
gmo = parse_generic_model_output_data(sensor.get_data('generic-model-output')[0])
print(gmo.x, gmo.z)
timeline.stop()
Cube('/D')
app.close()
"""


def findings(tmp_path, capsys, text, target="isaacsim-6.0"):
    file = tmp_path / "script.py"
    file.write_text(text) if isinstance(text, str) else file.write_bytes(text)
    code = main(["check", str(file), "--target", target, "--json"])
    return code, json.loads(capsys.readouterr().out)["files"][0]


@pytest.fixture
def checked(tmp_path, capsys):
    """The warnings about a script's text."""
    return lambda text: findings(tmp_path, capsys, text)[1]["warnings"]


@pytest.mark.parametrize("code", PLANTED)
def test_a_planted_fault_in_a_script_is_found_at_its_line(tmp_path, capsys, code):
    _, file = findings(tmp_path, capsys, PLANTED[code])
    hits = [one for one in file["warnings"] if one["code"] == code]
    assert len(hits) == 1, file
    assert f":{hits[0]['line']}:{hits[0]['column']}" in hits[0]["where"]
    assert RULES[code].fix in hits[0]["message"]


def test_a_script_without_faults_gives_none(tmp_path, capsys):
    code, file = findings(tmp_path, capsys, FINE)
    assert (code, file["warnings"], file["findings"]) == (0, [], 0)


@pytest.mark.parametrize(
    "module",
    [
        "omni.isaac.RangeSensorSchema",
        "omni.isaac.IsaacSensorSchema",
        "isaacsim.core.utils.fabric",
        "isaacsim.core.experimental.utils.stage",
        "isaacsim.robot.wheeled_robots.nodes",
    ],
)
def test_a_module_that_the_product_has_gives_none(tmp_path, capsys, module):
    _, file = findings(tmp_path, capsys, f"import {module}\n")
    codes = {one["code"] for one in file["warnings"]}
    assert not codes & {"import-renamed", "module-unknown"}
    assert ("module-deprecated" in codes) == module.startswith("isaacsim.core.utils")


@pytest.mark.parametrize(
    "module", ["isaacsim.core.utils.nosuch", "isaacsim.core.experimental.robots", "isaacsim.sensors.lidar"]
)
def test_a_module_that_no_package_has_is_told(tmp_path, capsys, module):
    _, file = findings(tmp_path, capsys, f"import {module}\n")
    assert "module-unknown" in {one["code"] for one in file["warnings"]}


SILENT = {
    "a rate that only a run knows": "prim = stage.DefinePrim('/L', 'OmniLidar')\nprim.GetAttribute(RATE).Set(rate)\n",
    "an attribute by a name that only a run knows": "prim = stage.DefinePrim('/L', 'OmniLidar')\n"
    "for name, value in given.items():\n    prim.GetAttribute(name).Set(value)\n",
    "a prim of another name": "stage.DefinePrim(path, 'OmniLidar')\n"
    "stage.GetPrimAtPath(other).GetAttribute('omni:sensor:tickRate').Set(10.0)\n",
    "a configuration that is not here": f"{RTX}Lidar.create('/L', config='Nobody_Has_It', tick_rate=5.0)\n",
    "a configuration that only a run knows": f"{RTX}Lidar.create('/L', config=config, tick_rate=5.0)\n",
    "a lidar by its class": f"{RTX}LidarSensor(Lidar('/L'))\n",
    "a rate of a class that only a run knows": f"{RTX}Lidar('/L', tick_rate=rate, attributes={{'{SCAN}': 20}})\n",
    "a level that only a run knows": SETTINGS
    + "settings.set('/app/sensors/nv/lidar/publishNormals', True)\n"
    + ASKS.replace("'NONE'", "level") % "True",
    "both rates": f"{RTX}Lidar('/L', tick_rate=20, attributes={{'{CORE}scanRateBaseHz': 20}})\n",
    "a radar of the editor": f"{RTX}RadarSensor(Radar('/R'))\n",
    "Motion BVH that only a run knows": f"{BVH.replace('True', 'wanted')}{RTX}RadarSensor(Radar('/R'))\n",
    "a scan rate that only a run knows": f"{RTX}Lidar('/L', tick_rate=20, attributes={{'{SCAN}': rate}})\n",
    "a radar after five updates": f"{BVH}{TIMELINE}{RTX}LidarSensor(Lidar('/L'))\nradar = Radar('/R')\n"
    "timeline.play()\nfor _ in range(5):\n    app.update()\nRadarSensor(radar)\n",
    "rates of a World": "world = World(physics_dt=1 / 400, rendering_dt=1 / 20)\n",
}


@pytest.mark.parametrize("text", SILENT.values(), ids=SILENT)
def test_what_a_run_may_set_right_is_not_told(tmp_path, capsys, text):
    text = text.replace("RATE", "'omni:sensor:tickRate'")
    assert findings(tmp_path, capsys, text)[1]["warnings"] == []


def test_a_prim_without_a_known_path_has_no_invented_name(tmp_path, capsys):
    _, file = findings(tmp_path, capsys, "prim = stage.DefinePrim(f'{root}/lidar', 'OmniLidar')\n")
    assert [one["code"] for one in file["warnings"]] == ["sensor-every-frame"]
    assert "unknown" not in file["warnings"][0]["message"]


def test_a_prim_with_a_path_that_usd_refuses_is_passed_over_and_the_rest_is_told(tmp_path, capfd):
    file = tmp_path / "script.py"
    file.write_text("stage.DefinePrim('no path//x', 'OmniLidar')\nstage.DefinePrim('/L', 'OmniLidar')\n")
    assert main(["check", str(file), "--target", "isaacsim-6.0"]) == 0
    lines = capfd.readouterr().err.splitlines()
    assert [line.split(": ")[0] for line in lines] == ["warning sensor-every-frame"]
    assert "script.py:2:1" in lines[0]


def test_a_value_is_found_through_names_sums_and_texts(tmp_path, capsys):
    text = """
root = "/World"
path = f"{root}/lidar"
prim = stage.DefinePrim(path, "OmniLidar")
rate = stage.GetAttributeAtPath(path + ".omni:sensor:tickRate")
rate.Set(2 * 10)
stage.GetPrimAtPath(Sdf.Path("/World/lidar")).CreateAttribute("omni:sensor:Core:scanRateBaseHz", kind).Set(10)
"""
    _, file = findings(tmp_path, capsys, text)
    [one] = file["warnings"]
    assert (one["code"], one["line"]) == ("lidar-partial-scan", 6)
    assert "tickRate is 20 Hz, scanRateBaseHz 10 Hz" in one["message"]


@pytest.mark.parametrize("text", ["a = a + a\n", "a = [a, a]\n", "a = b + b\nb = a + a\n", "a = f'{a}{a}'\n"])
def test_names_that_stand_for_themselves_have_no_value(tmp_path, capsys, text):
    assert findings(tmp_path, capsys, f"{text}stage.DefinePrim(a, 'OmniRadar')\n")[1]["warnings"] == []


def test_findings_come_in_the_order_of_the_lines(tmp_path, capsys):
    _, file = findings(tmp_path, capsys, PLANTED["asyncio-run"] + PLANTED["import-renamed"])
    assert [(one["code"], one["line"], one["column"]) for one in file["warnings"]] == [
        ("asyncio-run", 2, 1),
        ("import-renamed", 3, 1),
    ]


def test_a_script_is_never_run(tmp_path, capsys):
    mark = tmp_path / "ran"
    findings(tmp_path, capsys, f"open({str(mark)!r}, 'w').close()\nraise SystemExit(3)\n")
    assert not mark.exists()


def test_names_that_grow_with_every_line_are_given_up(tmp_path, capsys):
    lines = "".join(f"a{n + 1} = a{n}.name.name\n" for n in range(5_000))
    assert findings(tmp_path, capsys, f"a0 = b\n{lines}")[1]["warnings"] == []


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("x = (\n", "script.py:1:5: Python cannot read it: '(' was never closed"),
        (b"x\0y", "Python cannot read it"),
        (b"\xff\xfe\x00", "not UTF-8 text"),
        ("-" * 100_000 + "1", "nest too deeply"),
        ("a" + ".b" * 100_000, "nest too deeply"),
        ("(" * 5_000 + ")" * 5_000, "too many nested parentheses"),
        ("x = 1\n" * 1_000_000, "too large"),
    ],
)
def test_a_hostile_script_is_one_line(tmp_path, capsys, text, said):
    code, file = findings(tmp_path, capsys, text)
    assert code == 2
    assert len(file["problems"]) == 1
    problem = file["problems"][0]
    place = f"{problem['file']}:{problem['line']}:{problem['column']}: " if problem["line"] else ""
    assert said in f"{place}{problem['message']}"


@pytest.mark.parametrize(
    "text",
    [
        "",
        "# only a comment\n",
        "a = a\n",
        "a = b\nb = a\na.c()\n",
        "x = y = z\nz = x()\n",
        "f(*a, **b)\n[i for i in j]\n",
        "a" + ".b" * 900 + ".Set(1)\n",
        "a" + "()" * 80 + ".Set(1)\n",
        "stage.DefinePrim(" + "a + " * 900 + "b, 'OmniRadar')\n",
    ],
)
def test_odd_scripts_give_nothing(tmp_path, capsys, text):
    assert findings(tmp_path, capsys, text)[1]["warnings"] == []


def test_a_script_without_a_target_is_checked_for_here(tmp_path, capsys):
    file = tmp_path / "script.py"
    file.write_text(FINE)
    assert main(["check", str(file)]) == 0
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize(
    "line",
    [
        f"set_value(lidar, '{CORE}reportRateBaseHz', 36000)\n",
        f"attributes = {{'{CORE}reportRateBaseHz': 36000}}\nrep.functional.create.omni_lidar(**attributes)\n",
    ],
)
def test_former_attributes_are_found_wherever_a_script_names_them(checked, line):
    assert [one["code"] for one in checked(line)] == ["report-rate-ignored"]


def test_an_edit_that_cannot_be_made_is_found_only_where_the_script_says_all(checked):
    """The graph of a helper, attributes that the script adds, and types of other extensions are a matter of the run."""
    wrong = EDIT % ("('c', 'isaacsim.ros2.bridge.ROS2CameraHelper')", "('c.inputs:colour', 1)", "")
    assert [one["code"] for one in checked(wrong)] == ["edit-refused"]
    for text in (
        wrong.replace("og.Controller.edit(", "helper("),
        wrong + "og.Controller.create_attribute(node, 'inputs:colour', 'int')\n",
        EDIT % ("('n', 'acme.robots.Arm'), ('m', 'omni.graph.ui_nodes.SetViewportMode')", "('n.inputs:x', 1)", ""),
    ):
        assert checked(text) == []


def test_the_stage_of_a_graph_that_a_helper_edits_is_a_matter_of_the_run(checked):
    steps = EDIT % ("('s', 'isaacsim.core.nodes.OnPhysicsStep')", "", "")
    settings = "spec = {'graph_path': '/G', 'pipeline_stage': og.GraphPipelineStage.GRAPH_PIPELINE_STAGE_ONDEMAND}\n"
    assert [one["code"] for one in checked(steps)] == ["physics-step-stage"]
    assert checked(steps.replace('og.Controller.edit("/G"', "helper(spec")) == []
    assert checked(steps.replace('og.Controller.edit("/G"', f"{settings}og.Controller.edit(spec")) == []
