"""Every rule of `graph check --target`: a planted fault is found at its place, and the shipped graphs are silent."""

import json

import pytest

from graph.cli.main import main
from tests.support.places import ROOT
from tests.wings.portability.test_scripts import PLANTED as IN_SCRIPTS
from wings.portability.rules import ISAAC, OVRTX, RULES

BVH = "/renderer/raytracingMotion/enabled"
CORE = "omni:sensor:Core:"
LIDAR = {"type": "OmniLidar", "config": "Example_Rotary"}
FLAT = {"type": "OmniLidar", "config": "RPLIDAR_S2E"}
RADAR = {"type": "OmniRadar"}
LIDAR_WITH = 'def OmniLidar "Lidar" (prepend apiSchemas = ["OmniSensorGenericLidarCoreAPI"]) { %s; }'
ELSEWHERE = ("type-renamed", "attribute-removed")
"""Rules that loading a file reports by itself."""


def product(prim="/World/Lidar"):
    return {"type": "IsaacCreateRenderProduct", "inputs": {"cameraPrim": prim}}


def helper(**inputs):
    return {"type": "ROS2RtxLidarHelper", "inputs": {"type": "point_cloud", **inputs}}


def rendered(prim="/World/Lidar", **nodes):
    """A graph that renders a prim and feeds the product to further nodes."""
    connections = ["tick.tick -> product.execIn"]
    for name, node in nodes.items():
        entry = "exec" if "RTXLidar" in node["type"] else "execIn"
        connections += [f"product.execOut -> {name}.{entry}", f"product.renderProductPath -> {name}.renderProductPath"]
    return {"nodes": {"tick": "OnPlaybackTick", "product": product(prim), **nodes}, "connections": connections}


def ticked(node, *connections, **more):
    return {"nodes": {"tick": "OnPlaybackTick", "it": node, **more}, "connections": [*connections]}


def lidar(**keys):
    return {"prims": {"/World/Lidar": {**LIDAR, **keys}}}


BODY = {"type": "Cube", "rigid_body": True, "translate": [0, 0, 1]}
WRITE = {"type": "omni.graph.nodes.WritePrimAttribute", "inputs": {"prim": "/World/Cart", "usdWriteBack": True}}


def writing(name, value, kind):
    """A graph that writes an attribute of a prim in every update."""
    node = {"type": WRITE["type"], "inputs": {**WRITE["inputs"], "name": name}}
    constant = {"type": f"Constant{kind}", "inputs": {"value": value}}
    return ticked(node, "tick.tick -> it.execIn", "value.value -> it.value", value=constant)


CART = {"/World/Cart": {"type": "Xform"}, "/World/Cart/Box": BODY}

PLANTED = {
    "lidar-partial-scan": (lidar(attributes={"omni:sensor:tickRate": 5}), "/World/Lidar.omni:sensor:tickRate"),
    "sensor-every-frame": (lidar(attributes={"omni:sensor:tickRate": 0}), "/World/Lidar.omni:sensor:tickRate"),
    "sensor-api-missing": (
        {"usd": 'def Camera "Cam" { custom float omni:sensor:tickRate = 10; }'},
        "/Cam.omni:sensor:tickRate",
    ),
    "radar-motion-bvh-off": ({"prims": {"/World/R": RADAR}, "graph": rendered("/World/R")}, "/World/R"),
    "radar-tick-rate-ignored": (
        {"prims": {"/World/R": {**RADAR, "attributes": {"omni:sensor:tickRate": 20}}}, "graph": rendered("/World/R")},
        "/World/R.omni:sensor:tickRate",
    ),
    "fif-race": (
        {
            "prims": {"/World/R": RADAR, "/World/Lidar": LIDAR},
            "settings": {BVH: True},
            "graph": {
                "nodes": {"tick": "OnPlaybackTick", "a": product("/World/R"), "b": product()},
                "connections": ["tick.tick -> [a.execIn, b.execIn]"],
            },
        },
        "/World/G/a",
    ),
    "motion-compensation-off": (
        lidar(attributes={f"{CORE}outputMotionCompensationState": "COMPENSATED"}),
        f"/World/Lidar.{CORE}outputMotionCompensationState",
    ),
    "aux-level-too-low": (
        {**lidar(), "graph": rendered(cloud=helper(selectedMetadata=["EmitterId"]))},
        "/World/Lidar",
    ),
    "aux-last-product-wins": (
        {
            "prims": {"/World/R": {**RADAR, "aux_output_level": "BASIC"}, "/World/Lidar": LIDAR},
            "graph": {
                "nodes": {"tick": "OnPlaybackTick", "a": product("/World/R"), "b": product()},
                "connections": ["tick.tick -> [a.execIn, b.execIn]"],
            },
        },
        "/World/R",
    ),
    "aux-output-type-ignored": (
        {"usd": LIDAR_WITH % 'custom token omni:sensor:Core:auxOutputType = "FULL"'},
        f"/Lidar.{CORE}auxOutputType",
    ),
    "report-rate-ignored": (
        {"usd": LIDAR_WITH % "custom uint omni:sensor:Core:reportRateBaseHz = 36000"},
        f"/Lidar.{CORE}reportRateBaseHz",
    ),
    "scan-rate-too-low": (
        {"usd": LIDAR_WITH % 'custom string tickgraph:scanRateBaseHz = "1/3"'},
        f"/Lidar.{CORE}scanRateBaseHz",
    ),
    "normals-off": (
        {**lidar(aux_output_level="FULL"), "graph": rendered(cloud=helper(selectedMetadata=["HitNormal"]))},
        "/World/G/cloud",
    ),
    "stable-ids-off": (
        {**lidar(aux_output_level="FULL"), "graph": rendered(cloud=helper(selectedMetadata=["ObjectId"]))},
        "/World/G/cloud",
    ),
    "object-id-map-off": (
        {**lidar(aux_output_level="FULL"), "graph": rendered(cloud=helper(selectedMetadata=["ObjectId"]))},
        "/World/G/cloud.inputs:enableObjectIdMap",
    ),
    "output-buffer-on-gpu": (
        {"settings": {"/app/sensors/nv/lidar/outputBufferOnGPU": True}},
        "/app/sensors/nv/lidar/outputBufferOnGPU",
    ),
    "flat-scan-3d": (
        {
            **lidar(),
            "parity": "isaacsim-6.0.1",
            "graph": rendered(it={"type": "isaacsim.sensors.rtx.IsaacComputeRTXLidarFlatScan"}),
        },
        "/World/G/it",
    ),
    "scan-not-spherical": (
        {
            "prims": {"/World/Lidar": {**FLAT, "attributes": {f"{CORE}elementsCoordsType": "CARTESIAN"}}},
            "graph": rendered(it={"type": "isaacsim.sensors.rtx.IsaacCreateRTXLidarScanBuffer"}),
        },
        "/World/G/it",
    ),
    "multi-tick-off": (
        {**lidar(), "settings": {"/rtx/hydra/supportMultiTickRate": False}},
        "/rtx/hydra/supportMultiTickRate",
    ),
    "ovrtx-vocabulary": (
        {"usd": LIDAR_WITH % "double2 omni:sensor:frameRate = (10, 1)"},
        "/Lidar.omni:sensor:frameRate",
    ),
    "isaac-vocabulary": (lidar(attributes={"omni:sensor:tickRate": 10}), "/World/Lidar.omni:sensor:tickRate"),
    "frame-skip-deprecated": (
        {**lidar(), "graph": rendered(cloud=helper(frameSkipCount=2))},
        "/World/G/cloud.inputs:frameSkipCount",
    ),
    "full-scan-deprecated": (
        {**lidar(), "graph": rendered(cloud=helper(fullScan=True))},
        "/World/G/cloud.inputs:fullScan",
    ),
    "node-deprecated": (
        {
            "prims": {"/World/Lidar": FLAT},
            "graph": rendered(it={"type": "isaacsim.sensors.rtx.IsaacComputeRTXLidarFlatScan"}),
        },
        "/World/G/it",
    ),
    "type-renamed": (
        {"graph": ticked("omni.isaac.ros2_bridge.ROS2PublishClock", "tick.tick -> it.execIn")},
        "omni.isaac.ros2_bridge.ROS2PublishClock",
    ),
    "attribute-removed": (
        {"graph": ticked({"type": "isaacsim.core.nodes.IsaacReadSimulationTime", "inputs": {"swhFrameNumber": 3}})},
        "swhFrameNumber",
    ),
    "timeline-stamp": (
        {"graph": ticked("ROS2PublishClock", "tick.tick -> it.execIn", "tick.time -> it.timeStamp")},
        "/World/G/it.inputs:timeStamp",
    ),
    "system-time-never-resets": (
        {**lidar(), "graph": rendered(cloud=helper(useSystemTime=True))},
        "/World/G/cloud.inputs:resetSimulationTimeOnStop",
    ),
    "physics-step-stage": ({"graph": {"nodes": {"step": "OnPhysicsStep"}}}, "/World/G/step"),
    "gate-step-zero": (
        {"graph": ticked({"type": "IsaacSimulationGate", "inputs": {"step": 0}}, "tick.tick -> it.execIn")},
        "/World/G/it.inputs:step",
    ),
    "joint-indices-zero": (
        {
            "prims": {"/World/Robot": {"type": "Xform"}},
            "graph": ticked(
                {
                    "type": "IsaacArticulationController",
                    "inputs": {"targetPrim": "/World/Robot", "jointIndices": [0], "velocityCommand": [1.0]},
                },
                "tick.tick -> it.execIn",
            ),
        },
        "/World/G/it.inputs:jointIndices",
    ),
    "fabric-parent-moved": (
        {"prims": CART, "graph": writing("xformOp:translate", [1, 0, 0], "Double3")},
        "/World/G/it.inputs:name",
    ),
    "edit-not-live": (
        {"prims": {"/World/Cart": BODY}, "graph": writing("physics:mass", 2.0, "Float")},
        "/World/G/it.inputs:name",
    ),
    "physics-slower-than-loop": ({"clock": {"physics_hz": 30, "loop_hz": 60}}, "clock"),
    "catch-up-cap": ({"clock": {"physics_hz": 60, "loop_hz": 24}}, "/persistent/simulation/minFrameRate"),
    "physics-rate-truncated": ({"clock": {"physics_hz": "180000/1001", "loop_hz": 60}}, "clock"),
    "rate-limit-without-time-codes": (
        {"clock": {"experience": "full"}, "settings": {"/app/runLoops/main/rateLimitFrequency": 30}},
        "/app/runLoops/main/rateLimitFrequency",
    ),
    "rate-limit-stock-frequency": (
        {"settings": {"/app/runLoops/main/rateLimitEnabled": True}},
        "/app/runLoops/main/rateLimitEnabled",
    ),
    "fast-mode-wall-time": (
        {
            "settings": {"/app/player/useFastMode": True},
            "graph": ticked("isaacsim.core.nodes.IsaacReadSystemTime"),
        },
        "/World/G/it",
    ),
}


def written(tmp_path, *, prims=None, usd="", graph=None, settings=None, clock=None, parity="documented"):
    """A graph file of these parts, with a USD scene beside it for what inline prims refuse."""
    scene = {"prims": prims or {}}
    if usd:
        (tmp_path / "scene.usda").write_text(f'#usda 1.0\n(\n    metersPerUnit = 1\n    upAxis = "Z"\n)\n{usd}\n')
        scene["usd"] = "scene.usda"
    content = {"tickgraph": 1, "scene": scene, "clock": {"parity": parity, **(clock or {})}, "settings": settings or {}}
    if graph:
        content["graphs"] = {"/World/G": graph}
    file = tmp_path / "planted.json"
    file.write_text(json.dumps(content, indent=1))
    return file


def warnings_of(capsys, *arguments):
    main(["check", *map(str, arguments), "--json"])
    printed = capsys.readouterr()
    return json.loads(printed.out)["files"][0]["warnings"], printed.err


@pytest.mark.parametrize("code", [code for code in RULES if code in PLANTED])
def test_a_planted_fault_is_found_at_its_place_with_reason_and_remedy(tmp_path, capsys, code):
    parts, subject = PLANTED[code]
    file = written(tmp_path, **parts)
    target = RULES[code].targets[0]
    found, lines = warnings_of(capsys, file, "--target", target)
    hits = [one for one in found if one["code"] == code]
    assert len(hits) == 1, lines
    (hit,) = hits
    assert subject in f"{hit.get('subject')} {hit['message']}"
    assert ".json:" in hit["where"] or ".usda:" in hit["where"] or subject == hit["where"]
    if code not in ELSEWHERE:
        assert hit["subject"] == subject
        assert RULES[code].why in hit["message"]
        assert RULES[code].fix in hit["message"]


def test_every_rule_has_a_planted_fault():
    assert PLANTED.keys() | IN_SCRIPTS.keys() == RULES.keys()


@pytest.mark.parametrize("rule", RULES.values(), ids=RULES)
def test_a_rule_says_what_why_and_how_in_cells_of_the_manual(rule):
    assert rule.targets
    assert set(rule.targets) <= {ISAAC, OVRTX}
    for text in (rule.what, rule.why, rule.fix):
        assert text
        assert len(text) < 110
        assert not text.endswith(".")


@pytest.mark.parametrize(
    "file", sorted(path for path in (ROOT / "graphs").glob("*.yaml") if not path.name.endswith(".test.yaml")), ids=str
)
def test_the_shipped_graphs_are_portable_or_say_what_they_accept(capsys, file):
    found, _ = warnings_of(capsys, file, "--target", ISAAC)
    assert found == []


def test_findings_that_the_author_accepts_are_not_reported(tmp_path, capsys):
    settings = {"/tickgraph/acceptedFindings": "catch-up-cap physics-slower-than-loop"}
    file = written(tmp_path, clock={"physics_hz": 60, "loop_hz": 24}, settings=settings)
    assert warnings_of(capsys, file, "--target", ISAAC)[0] == []


def test_without_a_target_only_what_concerns_this_product_is_reported(tmp_path, capsys):
    file = written(tmp_path, clock={"physics_hz": 60, "loop_hz": 24})
    assert warnings_of(capsys, file)[0] == []


def test_a_target_replaces_the_warning_without_a_place(tmp_path, capsys):
    parts, _ = PLANTED["lidar-partial-scan"]
    file = written(tmp_path, **{**parts, "graph": rendered()})
    found, _ = warnings_of(capsys, file, "--target", ISAAC)
    (hit,) = [one for one in found if one["code"] == "lidar-partial-scan"]
    assert hit["message"].startswith("/World/Lidar.omni:sensor:tickRate: tickRate is 5 Hz, scanRateBaseHz 10 Hz: ")
    assert hit["line"] == 8
    assert hit["fixable"] is True


def test_the_other_product_has_other_words(tmp_path, capsys):
    file = written(tmp_path, **PLANTED["isaac-vocabulary"][0])
    assert {one["code"] for one in warnings_of(capsys, file, "--target", OVRTX)[0]} == {"isaac-vocabulary"}
    assert warnings_of(capsys, file, "--target", ISAAC)[0] == []


@pytest.mark.parametrize(
    ("word", "value", "name", "meant"),
    [
        ("partialOutputs", True, "accumulate_outputs", False),
        ("partialOutputs", False, "accumulate_outputs", True),
        ("includeInvalidPoints", True, "skip_dropping_invalid_points", True),
    ],
)
def test_the_words_of_ovrtx_are_read(tmp_path, word, value, name, meant):
    from graph.sim import App
    from sensors.lidar.prim import read_config

    prims = {"/World/L": {"type": "OmniLidar", "attributes": {f"{CORE}{word}": value}}}
    with App.from_file(written(tmp_path, prims=prims)) as app:
        assert getattr(read_config(app.stage.GetPrimAtPath("/World/L")), name) is meant


def test_words_that_contradict_each_other_are_refused(tmp_path, capsys):
    attributes = {f"{CORE}partialOutputs": True, f"{CORE}accumulateOutputs": True}
    file = written(tmp_path, prims={"/World/L": {"type": "OmniLidar", "attributes": attributes}})
    assert main(["check", str(file)]) == 2
    assert "accumulateOutputs and partialOutputs contradict each other; give one" in capsys.readouterr().err
