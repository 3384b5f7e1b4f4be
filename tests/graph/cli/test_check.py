import json

import pytest

GOOD = """\
tickgraph: 1
scene: {prims: {/World/Ball: {type: Sphere, radius: 0.5}}}
graphs:
  /World/Graph:
    nodes: {tick: OnPlaybackTick, wait: {type: Countdown, inputs: {duration: 3}}}
    connections: [tick.tick -> wait.execIn]
"""
BAD = """\
tickgraph: 1
clock: {loop_hz: 0}
scene: {prims: {/World/Ball: {type: Sphere, radios: 0.5}}}
graphs:
  /World/Graph:
    nodes: {tick: OnPlaybackTick, wait: {type: Countdwon}}
    connections: [tick.tick -> wait.execIn]
"""


def test_a_good_file_is_one_line_with_its_counts(folder, graph):
    (folder / "good.yaml").write_text(GOOD)
    result = graph("check", "good.yaml")
    assert (result.code, result.err) == (0, "")
    assert result.out == "good.yaml: ok, 1 graph, 2 nodes, 1 connection, 1 prim\n"


def test_problems_of_text_graphs_and_scene_come_together_in_the_order_of_the_file(folder, graph):
    (folder / "bad.yaml").write_text(BAD)
    result = graph("check", "bad.yaml")
    assert (result.code, result.out) == (2, "")
    lines = result.err.splitlines()
    assert [line.split(": ")[0] for line in lines] == ["bad.yaml:2:18", "bad.yaml:3:45", "bad.yaml:6:35"]
    assert 'did you mean "radius"?' in lines[1]
    assert 'did you mean "Countdown"?' in lines[2]


def test_every_file_is_checked_and_one_bad_one_decides_the_exit_code(folder, graph):
    (folder / "good.yaml").write_text(GOOD)
    (folder / "bad.yaml").write_text("tickgraph: 1\nx: 1\n")
    result = graph("check", "bad.yaml", "good.yaml", "none.yaml")
    assert result.code == 2
    assert result.out == "good.yaml: ok, 1 graph, 2 nodes, 1 connection, 1 prim\n"
    assert [line.partition(" ")[0] for line in result.err.splitlines()] == ["bad.yaml:2:1:", "graph:"]
    assert "none.yaml: no such file" in result.err


def test_json_tells_all_files_and_every_place(folder, graph):
    (folder / "good.yaml").write_text(GOOD)
    (folder / "bad.yaml").write_text("tickgraph: 1\nrecrod: {}\n")
    result = graph("check", "good.yaml", "bad.yaml", "none.yaml", "--json")
    assert result.code == 2
    good, bad, none = json.loads(result.out)["files"]
    assert good == {
        "file": "good.yaml",
        "ok": True,
        "graphs": 1,
        "nodes": 2,
        "connections": 1,
        "prims": 1,
        "problems": [],
        "warnings": [],
    }
    assert bad["ok"] is False
    assert bad["problems"] == [
        {"message": 'unknown key "recrod"; did you mean "record"?', "file": "bad.yaml", "line": 2, "column": 1}
    ]
    assert none["problems"][0]["line"] is None


def test_a_check_writes_nothing(folder, graph):
    (folder / "good.yaml").write_text(GOOD)
    graph("check", "good.yaml")
    assert [path.name for path in folder.iterdir()] == ["good.yaml"]


def test_allow_widens_what_a_file_may_name(folder, graph):
    (folder / "sub").mkdir()
    (folder / "box.usda").write_text('#usda 1.0\n(\n    metersPerUnit = 1\n    upAxis = "Z"\n)\ndef Cube "Box" {}\n')
    (folder / "sub" / "a.yaml").write_text("tickgraph: 1\nscene: {usd: ../box.usda}\n")
    refused = graph("check", "sub/a.yaml")
    assert refused.code == 2
    assert "allow its folder with --allow" in refused.err
    assert graph("check", "sub/a.yaml", "--allow", ".").code == 0


def test_options_of_the_file_and_the_command_line_are_checked(folder, graph):
    (folder / "a.yaml").write_text("tickgraph: 1\nfidelity: {lidar.moton: frozen}\n")
    result = graph("check", "a.yaml")
    assert result.code == 2
    assert result.err.startswith("a.yaml:2:12: ")
    assert 'did you mean "lidar.motion"?' in result.err
    (folder / "b.yaml").write_text("tickgraph: 1\n")
    assert graph("check", "b.yaml", "--/rtx/hydra/supportMultiTickRate=true").code == 0
    assert graph("check", "b.yaml", "--/app/runLoops/main/rateLimitFrequency=-5").code == 2


FLAT = """\
tickgraph: 1
scene: {{prims: {{/World/Lidar: {{type: OmniLidar, config: {config}}}}}}}
clock: {{parity: {parity}}}
graphs:
  /World/Make:
    nodes: {{tick: OnPlaybackTick, product: {{type: IsaacCreateRenderProduct, inputs: {{cameraPrim: /World/Lidar}}}}}}
    connections: [tick.tick -> product.execIn]
  /World/Frames:
    pipeline_stage: post_render
    nodes:
      flat: IsaacComputeRTXLidarFlatScan
    connections: [/World/Make/product.outputs:renderProductPath -> flat.renderProductPath]
"""


def test_a_wrong_value_is_not_checked_on_as_if_it_were_the_default(folder, graph):
    """The default of `type` is laser_scan, which this lidar cannot give; a mistake in another input is still told."""
    product = "made: {type: IsaacCreateRenderProduct, inputs: {cameraPrim: /World/Lidar}}"
    (folder / "a.yaml").write_text(f"""\
tickgraph: 1
scene: {{prims: {{/World/Lidar: {{type: OmniLidar, config: OS1}}}}}}
graphs:
  /World/Graph:
    nodes:
      tick: OnPlaybackTick
      {product}
      cloud: {{type: ROS2RtxLidarHelper, inputs: {{type: pointcloud, selectedMetadata: [Colour]}}}}
    connections: [tick.tick -> made.execIn, made.renderProductPath -> cloud.renderProductPath]
""")
    wrong, other = graph("check", "a.yaml").err.splitlines()
    assert wrong.startswith("a.yaml:8:50: node \"cloud\": type: 'pointcloud' is not one of")
    assert other.startswith("a.yaml:8:68: /World/Graph/cloud.inputs:selectedMetadata: ")


def test_a_flat_scan_of_a_3d_lidar_is_reported_before_anything_runs(folder, graph):
    (folder / "tall.yaml").write_text(FLAT.format(config="XT32", parity="documented"))
    (folder / "flat.yaml").write_text(FLAT.format(config="Example_Rotary_2D", parity="documented"))
    (folder / "product.yaml").write_text(FLAT.format(config="XT32", parity="isaacsim-6.0.1"))

    result = graph("run", "tall.yaml", "--out", "out")

    assert result.code == 2
    assert result.err.splitlines() == [
        "tall.yaml:11:7: /World/Frames/flat: /World/Lidar: a flat or laser scan needs a 2D lidar, but emitter 0 points "
        "15 deg up; use a lidar of one plane, such as config Example_Rotary_2D, or publish its point_cloud"
    ]
    assert not (folder / "out").exists()
    assert graph("check", "flat.yaml").code == 0
    assert graph("check", "product.yaml").code == 0  # logs it at run time, and goes on


def test_a_prim_where_a_render_product_belongs_is_reported(folder, graph):
    text = FLAT.format(config="Example_Rotary_2D", parity="documented")
    text = text.replace("flat: IsaacCompute", "flat: {type: IsaacCompute").replace(
        "FlatScan\n", "FlatScan, inputs: {renderProductPath: /World/Lidar}}\n"
    )
    (folder / "prim.yaml").write_text(text[: text.rindex("    connections")])

    result = graph("check", "prim.yaml")

    assert result.code == 2
    assert result.err == (
        "prim.yaml:11:59: /World/Frames/flat.inputs:renderProductPath: /World/Lidar is a prim, not a render product; "
        "connect it to IsaacCreateRenderProduct with cameraPrim /World/Lidar\n"
    )


def test_a_scene_that_is_refused_is_one_problem_and_not_one_for_each_prim(folder, graph):
    (folder / "far.yaml").write_text(
        "tickgraph: 1\nscene: {usd: ../../elsewhere/s.usda}\ngraphs:\n  /G:\n    nodes:\n"
        "      a: {type: ROS2PublishTransformTree, inputs: {targetPrims: /World/Robot}}\n"
    )
    [line] = graph("check", "far.yaml").err.splitlines()
    assert line.startswith("far.yaml:2:14: scene.usd: ")


def test_a_clash_of_rates_is_one_problem(folder, graph):
    (folder / "z.yaml").write_text("tickgraph: 1\nclock: {experience: zero_delay, physics_hz: 120, loop_hz: 60}\n")
    assert len(graph("check", "z.yaml").err.splitlines()) == 1


def test_no_other_type_is_offered_for_one_that_cannot_work_here(folder, graph):
    (folder / "c.yaml").write_text(
        "tickgraph: 1\ngraphs:\n  /G:\n    nodes:\n"
        "      a: isaacsim.streaming.rtsp.RTSPCameraHelper\n      b: OnMouseInput\n"
    )
    assert graph("check", "c.yaml").err.splitlines() == [
        'c.yaml:5:7: node "a": no node type "isaacsim.streaming.rtsp.RTSPCameraHelper": there is no RTSP server '
        "here; ROS2CameraHelper with type rgb_h264 publishes the same video; "
        "--skip-unknown runs the rest of the file",
        'c.yaml:6:7: node "b": no node type "OnMouseInput": there is no window here; '
        "--skip-unknown runs the rest of the file",
    ]


MISMATCHES = {
    ("ConstantDouble3", "value", "Delay", "duration"): "(double); take a component with BreakVector3",
    ("ConstantDouble", "value", "IsaacReadWorldPose", "prim"): "(target)",
    ("ConstantBool", "value", "Delay", "duration"): "(double); convert it with ToDouble",
    ("ConstantInt", "value", "PrintText", "text"): "(string); convert it with ToString",
    ("ConstantDouble", "value", "DifferentialController", "execIn"): "execution and data do not mix",
    ("ConstantDouble", "value", "ROS2PublishJointState", "targetPrim"): "(target)",
    ("ConstantDouble", "value", "IsaacArticulationController", "velocityCommand"): (
        "(double[]); make an array with ConstructArray"
    ),
    ("DifferentialController", "velocityCommand", "Delay", "duration"): "(double); take an element with ArrayIndex",
    ("ConstantDouble", "value", "ROS2PublishOdometry", "position"): "(vectord[3]); make one with MakeVector3",
    ("ConstantString", "value", "ROS2PublishTransformTree", "targetPrims"): "(target); convert it with ToTarget",
}


@pytest.mark.parametrize("ends", MISMATCHES)
def test_types_that_cannot_meet_are_reported_with_the_node_that_leads_from_one_to_the_other(folder, graph, ends):
    source, output, target, entry = ends
    (folder / "m.yaml").write_text(
        f"tickgraph: 1\ngraphs:\n  /G:\n    nodes: {{a: {source}, b: {target}}}\n"
        f"    connections: [a.{output} -> b.{entry}]\n"
    )
    lines = [line for line in graph("check", "m.yaml").err.splitlines() if line.startswith("m.yaml:5:19: ")]
    assert [line.endswith(MISMATCHES[ends]) for line in lines] == [True], lines


NUMERICS = "not one of its types (numerics); give it a number, "
UNFIT = {
    "Add, inputs: {b: 1, a: {type: token, value: x}}": f"a: 'x' (token) is {NUMERICS}",
    "Add, inputs: {b: 1, a: hello}": f"a: 'hello' (token) is {NUMERICS}",
    "SelectIf, inputs: {ifTrue: 1, ifFalse: 2, condition: 7}": (
        "condition: 7 (int) is not one of its types (bool | bool[]); give it bool or bool[]"
    ),
    "Add, inputs: {b: 1, a: {x: 1}}": "a: cannot tell the type of {'x': 1}; write {type: ..., value: ...}",
}


@pytest.mark.parametrize("node", UNFIT)
def test_a_value_that_an_open_input_cannot_take_is_reported_with_what_it_takes(folder, graph, node):
    (folder / "u.yaml").write_text(
        f"tickgraph: 1\ngraphs: {{/G: {{evaluator: push, nodes: {{n: {{type: {node}}}}}}}}}\n"
    )
    [line] = graph("check", "u.yaml").err.splitlines()
    assert f'node "n": {UNFIT[node]}' in line


def test_a_cycle_is_one_line_whatever_its_types_would_have_been(folder, graph):
    """Types that only the cycle could settle are not reported as further mistakes, in it or behind it."""
    (folder / "cycle.yaml").write_text(
        "tickgraph: 1\ngraphs:\n  /World/G:\n"
        "    nodes: {tick: OnPlaybackTick, a: Add, b: Add, c: Add, out: PrintText}\n"
        "    connections:\n      - tick.tick -> out.execIn\n      - a.sum -> [b.a, b.b]\n      - b.sum -> [a.a, a.b]\n"
        "      - b.sum -> [c.a, c.b]\n      - c.sum -> out.text\n"
    )
    result = graph("check", "cycle.yaml")
    assert result.code == 2
    assert result.err.splitlines() == [
        "cycle.yaml:8:19: data goes round in a cycle: a.outputs:sum -> b.inputs:a, b.outputs:sum -> a.inputs:a. "
        "Remove one of these connections, or pass the value on by a variable"
    ]


def test_a_translation_of_an_unknown_type_is_left_out_with_a_warning(folder, graph):
    """USD raises where it computes such a transform, after the file was opened."""
    prim = 'def Cube "A" (prepend apiSchemas = ["PhysicsRigidBodyAPI"])\n{\n'
    move = 'Nothing xformOp:translate = (0, 0, 2)\nuniform token[] xformOpOrder = ["xformOp:translate"]\n}\n'
    (folder / "a.usda").write_text('#usda 1.0\n(\nmetersPerUnit = 1\nupAxis = "Z"\n)\n' + prim + move)
    for command in (("check", "a.usda"), ("run", "a.usda", "--updates", "1")):
        result = graph(*command)
        assert result.code == 0
        assert "/A: its transform names xformOp:translate (of an unknown type); that is left out" in result.err


TRAPS = """\
tickgraph: 1
graphs:
  /World/G:
    nodes:
      tick: OnPlaybackTick
      clock: ROS2PublishClock
      first: {type: Countdown, inputs: {duration: 3}}
      second: {type: Countdown, inputs: {duration: 3}}
    connections:
      - tick.tick -> [clock.execIn, first.execIn, second.execIn]
      - first.tickValue -> second.duration
"""


def test_traps_that_lie_in_the_wires_are_warnings_of_check_and_of_the_run(folder, graph):
    (folder / "a.yaml").write_text(TRAPS)
    for arguments in (("check", "a.yaml"), ("run", "a.yaml", "--updates", "2")):
        result = graph(*arguments)
        assert result.code == 0
        codes = [line.split(": ")[0].removeprefix("warning ") for line in result.err.splitlines()]
        assert {"timestamp-unconnected", "fan-out-order"} <= set(codes)


def test_an_event_of_physics_steps_in_another_stage_is_a_warning_of_check(folder, graph):
    text = "tickgraph: 1\ngraphs: {/G: {pipeline_stage: STAGE, nodes: {s: OnPhysicsStep, n: Counter}, "
    text += "connections: [s.step -> n.execIn]}}\n"
    (folder / "a.yaml").write_text(text.replace("STAGE", "simulation"))
    (folder / "b.yaml").write_text(text.replace("STAGE", "on_demand"))
    told = graph("check", "a.yaml").err
    assert told == (
        "warning physics-step-stage: /G/s: it never fires in a simulation graph; give the graph pipeline_stage: "
        "on_demand\n"
    )
    assert graph("check", "b.yaml").err == ""


def test_traps_of_the_clock_are_warnings_of_the_run(folder, graph):
    # physics at 24 Hz under a loop of 60 Hz steps in 2 updates of 5: 3 of 5 are idle
    (folder / "a.yaml").write_text("tickgraph: 1\nclock: {loop_hz: 60, physics_hz: 24}\n")
    result = graph("run", "a.yaml", "--updates", "60")
    assert "physics-slower-than-loop: clock: 36 of 60 updates run no physics step" in result.err


@pytest.mark.parametrize("length", [("--duration", "1e30"), ("--updates", str(10**29))])
def test_a_run_without_end_is_refused_in_one_line(length, folder, graph):
    (folder / "a.yaml").write_text("tickgraph: 1\n")
    result = graph("run", "a.yaml", *length)
    assert result.code == 2
    [line] = result.err.splitlines()
    assert line.startswith(f"graph: {length[0]} {length[1]}: too many updates; the limit is 1,000,000,000 updates")


SEVERAL = """\
tickgraph: 1
scene:
  prims:
    /World/Wall: {type: Cube, siz: 2.0}
    /World/Lidar: {type: OmniLidar, config: Example_Rotary}
graphs:
  /World/Graph:
    nodes:
      tick: OnPlaybackTick
      product: {type: IsaacCreateRenderProduct, inputs: {cameraPrim: /World/Lidr}}
      cloud: {type: ROS2RtxLidarHelper, inputs: {frameID: lidar}}
    connections: [tick.tick -> product.execIn, product.execOut -> cloud.execIn]
"""


def test_a_wrong_prim_path_is_found_beside_mistakes_of_prims_and_nodes(folder, graph):
    (folder / "several.yaml").write_text(SEVERAL)
    lines = graph("check", "several.yaml").err.splitlines()
    assert [line.partition(": ")[0] for line in lines] == [f"several.yaml:{at}" for at in ("4:31", "10:58", "11:50")]
    assert lines[1].endswith('there is no prim /World/Lidr on the stage; did you mean "/World/Lidar"?')


def test_a_target_that_a_wrong_prim_would_be_is_not_a_second_mistake(folder, graph):
    text = SEVERAL.replace("siz", "size").replace("OmniLidar", "OmniLidr").replace("Lidr}", "Lidar}")
    (folder / "several.yaml").write_text(text.replace("frameID", "frameId"))
    lines = graph("check", "several.yaml").err.splitlines()
    assert [line.partition(": ")[0] for line in lines] == ["several.yaml:5:20"]


def test_a_rate_of_a_lidar_is_its_tick_rate(folder, graph):
    text = SEVERAL.replace("siz", "size").replace("Example_Rotary", "Example_Rotary, rate: 20")
    (folder / "rate.yaml").write_text(text.replace("Lidr", "Lidar").replace("frameID", "frameId"))
    assert graph("check", "rate.yaml").err.endswith(
        'there is no key "rate"; did you mean attributes: {"omni:sensor:tickRate": 20}?\n'
    )
