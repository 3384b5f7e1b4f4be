import subprocess
import sys

import pytest

from graph.sim.scene.stage import open_stage, register_schemas
from graph.sim.usd import SCHEMAS, Usd
from tests.support.places import ROOT


def run(code):
    return subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=False)


def test_a_bare_lidar_has_the_documented_attributes_without_any_apply():
    stage = open_stage()
    lidar = stage.DefinePrim("/Lidar", "OmniLidar")
    assert lidar.GetAppliedSchemas() == [
        "OmniSensorAPI",
        "OmniSensorGenericLidarCoreAPI",
        "OmniSensorGenericLidarCoreEmitterStateAPI:s001",
    ]
    assert lidar.GetAttribute("omni:sensor:tickRate").Get() == 0.0
    core = {
        "scanType": "ROTARY",
        "scanRateBaseHz": 10,
        "patternFiringRateHz": 36000,
        "numberOfEmitters": 128,
        "maxReturns": 2,
        "nearRangeM": pytest.approx(0.3),
        "farRangeM": 200.0,
        "validEndAzimuthDeg": 360.0,
        "rotationDirection": "CW",
        "elementsCoordsType": "SPHERICAL",
        "outputFrameOfReference": "SENSOR",
        "accumulateOutputs": True,
        "skipDroppingInvalidPoints": False,
        "numLines": None,
    }
    assert {name: lidar.GetAttribute(f"omni:sensor:Core:{name}").Get() for name in core} == core


def test_sensors_have_a_place_in_the_world():
    stage = open_stage()
    for kind in ("OmniLidar", "OmniRadar", "OmniAcoustic"):
        prim = stage.DefinePrim(f"/{kind}", kind)
        assert prim.HasAttribute("xformOpOrder")
        assert prim.GetAttribute("visibility").Get() == "inherited"


def test_emitter_states_and_scan_configurations_come_in_instances():
    stage = open_stage()
    lidar, radar = stage.DefinePrim("/L", "OmniLidar"), stage.DefinePrim("/R", "OmniRadar")
    assert lidar.ApplyAPI("OmniSensorGenericLidarCoreEmitterStateAPI", "s002")
    assert lidar.GetAttribute("omni:sensor:Core:emitterState:s002:fireTimeNs").GetTypeName() == "uint[]"
    assert radar.ApplyAPI("OmniSensorGenericRadarWpmDmatScanCfgAPI", "s002")
    assert radar.GetAttribute("omni:sensor:WpmDmat:scan:s002:maxAzAngDeg").Get() == 75.0


def test_a_camera_with_the_sensor_api_renders_in_every_update():
    stage = open_stage()
    camera = stage.DefinePrim("/Camera", "Camera")
    camera.ApplyAPI("OmniSensorAPI")
    assert camera.GetAttribute("omni:sensor:tickRate").Get() == 0.0


def test_sensor_prims_survive_a_round_trip_through_a_file(tmp_path):
    stage = open_stage()
    stage.DefinePrim("/L", "OmniLidar").GetAttribute("omni:sensor:tickRate").Set(20.0)
    stage.GetRootLayer().Export(str(tmp_path / "scene.usdc"))
    again = open_stage(tmp_path / "scene.usdc")
    assert again.GetPrimAtPath("/L").GetTypeName() == "OmniLidar"
    assert again.GetPrimAtPath("/L").GetAttribute("omni:sensor:tickRate").Get() == 20.0


def test_graph_prims_are_known():
    stage = open_stage()
    assert stage.DefinePrim("/G", "OmniGraph").HasAttribute("evaluator:type")
    assert stage.DefinePrim("/G/n", "OmniGraphNode").HasAttribute("node:typeVersion")


def test_registering_after_the_first_stage_is_refused_naming_the_call():
    late = "from pxr import Usd; Usd.Stage.CreateInMemory().DefinePrim('/A', 'Xform')\n"
    done = run(late + "from graph.sim import register_schemas; register_schemas()")
    assert done.returncode == 1
    assert "Call graph.sim.register_schemas() before the first stage" in done.stderr


def test_registering_first_makes_a_stage_opened_by_others_know_the_sensors():
    done = run(
        "from graph.sim import register_schemas; register_schemas(); register_schemas()\n"
        "from pxr import Usd; s = Usd.Stage.CreateInMemory()\n"
        "assert s.DefinePrim('/L', 'OmniLidar').GetAttribute('omni:sensor:tickRate').Get() == 0.0"
    )
    assert done.returncode == 0, done.stderr


def test_the_schema_files_lie_inside_the_package():
    assert {path.name for path in SCHEMAS.iterdir()} >= {"plugInfo.json", "generatedSchema.usda"}
    assert Usd.SchemaRegistry().FindConcretePrimDefinition("OmniLidar")
    register_schemas()
