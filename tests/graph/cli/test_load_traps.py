"""What `graph check` tells of files that nothing is wrong with and that would still surprise."""

import json

import pytest

FILE = """\
tickgraph: 1
scene:
  prims:
    /World/Wall: {{type: Cube, size: 2.0, translate: [6, 0, 1]}}
    /World/Lidar: {{type: OmniLidar, config: Example_Rotary, translate: [{x}, 0, 1]{more}}}
clock: {{{clock}}}
graphs:
  /World/Graph:
    nodes:
      tick: OnPlaybackTick
      time: IsaacReadSimulationTime
      product: {{type: IsaacCreateRenderProduct, inputs: {{cameraPrim: /World/Lidar}}}}
      cloud: {{type: ROS2RtxLidarHelper, inputs: {{type: point_cloud, topicName: points{inputs}}}}}
      {nodes}
    connections:
      - tick.tick -> product.execIn
      - product.execOut -> cloud.execIn
      - product.renderProductPath -> cloud.renderProductPath
      {wires}
"""


@pytest.fixture
def warnings(folder, graph):
    """Writes the file with these parts; gives what `graph check` warns of: (code, where) to message."""

    def run(*, x=0, more="", clock="physics_hz: 240", inputs="", nodes="", wires="", command="check"):
        text = FILE.format(x=x, more=more, clock=clock, inputs=inputs, nodes=nodes, wires=wires)
        (folder / "a.yaml").write_text(text)
        result = graph(command, "a.yaml", "--json")
        assert result.code == 0, result.err
        told = json.loads(result.out)
        return {
            (one["code"], one["where"]): one["message"]
            for one in (told["files"][0]["warnings"] if command == "check" else told["traps"])
        }

    return run


def test_a_sound_file_has_no_traps(warnings):
    assert warnings() == {}


def test_an_empty_frame_is_reported(warnings):
    assert set(warnings(inputs=', frameId: ""')) == {("frame-empty", "/World/Graph/cloud.inputs:frameId")}


def test_a_sensor_inside_a_solid_is_reported_unless_it_excludes_it(warnings):
    # The wall reaches from x = 5 to x = 7.
    told = warnings(x=5.1)
    assert set(told) == {("sensor-in-solid", "/World/Lidar")}
    assert told["sensor-in-solid", "/World/Lidar"].endswith("exclude: [/World/Wall]")
    assert warnings(x=5.1, more=", exclude: [/World/Wall]") == {}
    assert warnings(x=4.9) == {}


@pytest.mark.parametrize("command", ["check", "explain"])
def test_two_message_types_on_one_topic_are_reported(command, warnings):
    nodes = "clock: {type: ROS2PublishClock, inputs: {topicName: /points}}"
    wires = "- tick.tick -> clock.execIn\n      - time.simulationTime -> clock.timeStamp"
    told = warnings(nodes=nodes, wires=wires, command=command)
    assert told["topic-of-two-types", "/points"] == (
        "/World/Graph/cloud sends sensor_msgs/msg/PointCloud2, but /World/Graph/clock sends rosgraph_msgs/msg/Clock; "
        "rename one of the two topics"
    )
    assert ("topic-of-two-types", "/points") not in warnings(nodes=nodes.replace("/points", "clock"), wires=wires)


@pytest.mark.parametrize(("kind", "sent"), [("depth", "Image"), ("rgb", "Image"), ("bbox_3d", "Detection3DArray")])
def test_the_message_of_a_camera_helper_is_known_before_the_run(warnings, kind, sent):
    nodes = f"camera: {{type: ROS2CameraHelper, inputs: {{type: {kind}, topicName: /points}}}}"
    told = warnings(nodes=nodes, wires="- tick.tick -> camera.execIn")
    package = "vision_msgs" if "Array" in sent else "sensor_msgs"
    assert f"/World/Graph/camera sends {package}/msg/{sent}" in told["topic-of-two-types", "/points"]


def test_a_node_that_nothing_starts_is_reported(warnings):
    assert set(warnings(nodes="wait: Countdown")) == {("node-never-runs", "a.yaml:14:7")}


def test_a_message_type_that_nobody_knows_is_an_error_though_its_node_never_runs(folder, graph):
    nodes = "send: {type: ROS2Publisher, inputs: {messagePackage: std_msgs, messageName: Strng}}"
    text = FILE.format(x=0, more="", clock="", inputs="", nodes=nodes, wires="")
    (folder / "a.yaml").write_text(text)
    result = graph("check", "a.yaml")
    assert result.code == 2
    assert (
        'a.yaml:14:70: /World/Graph/send.inputs:messageName: there is no ROS 2 type "std_msgs/msg/Strng"' in result.err
    )
    assert result.err.endswith('did you mean "std_msgs/msg/String"?\n')


def test_quantities_that_nobody_knows_are_an_error(folder, graph):
    inputs = ", selectedMetadata: [Intensty]"
    (folder / "a.yaml").write_text(FILE.format(x=0, more="", clock="", inputs=inputs, nodes="", wires=""))
    result = graph("check", "a.yaml")
    assert (result.code, result.err.partition(" ")[2]) == (
        2,
        '/World/Graph/cloud.inputs:selectedMetadata: no quantity "Intensty"; did you mean "Intensity"?\n',
    )


def test_a_rate_that_is_a_time_step_is_reported_with_the_rate_to_write(warnings):
    told = warnings(clock="physics_hz: 0.004, loop_hz: 60")
    assert told["rate-below-1", "a.yaml:6:1"].endswith("for a time step of 0.004 s write 250")  # 1 / 0.004
    assert ("physics-slower-than-loop", "clock") in told  # of 300 updates none has a step


def test_inputs_that_a_type_cannot_do_without_are_reported(warnings):
    nodes = "motors: {type: IsaacArticulationController, inputs: {jointNames: [a]}}"
    wires = "- tick.tick -> motors.execIn"
    assert warnings(nodes=nodes, wires=wires) == {
        (
            "input-not-set",
            "/World/Graph/motors.inputs:targetPrim",
        ): "IsaacArticulationController cannot work without it (or robotPath); give it a value or connect it"
    }
    robot = "robotPath: /World/Wall"
    told = warnings(nodes=nodes.replace("jointNames: [a]", robot), wires=wires)
    assert [code for code, _ in told] == ["input-unfed"]  # no command of its three is given
    given = f"{robot}, velocityCommand: [1.0]"
    assert warnings(nodes=nodes.replace("jointNames: [a]", given), wires=wires) == {}


def test_a_length_of_0_is_reported_as_it_is(warnings):
    nodes = "wheels: {type: DifferentialController, inputs: {wheelRadius: 0, wheelDistance: 1}}"
    assert warnings(nodes=nodes, wires="- tick.tick -> wheels.execIn") == {
        (
            "input-not-set",
            "/World/Graph/wheels.inputs:wheelRadius",
        ): "DifferentialController cannot work with 0; give it a value or connect it"
    }


def test_a_lidar_that_ticks_faster_than_it_turns_is_reported(warnings):
    told = warnings(more=', attributes: {"omni:sensor:tickRate": 20}')
    assert set(told) == {("lidar-partial-scan", "/World/Lidar")}


def test_sensors_that_tick_faster_than_the_loop_are_reported(warnings):
    # The example turns ten times a second: 8 updates a second give 40 of the 50 frames in five seconds.
    told = warnings(clock="physics_hz: 8, loop_hz: 8")
    assert told["sensor-faster-than-loop", "/World/Lidar"].startswith("10 of 50 ticks are passed over")


@pytest.mark.parametrize(
    "arguments",
    [("check",), ("show",), ("explain",), ("run", "--updates", "1"), ("convert", "b.yaml"), ("convert", "b.usda")],
)
def test_every_command_runs_with_what_its_line_about_files_outside_says(folder, graph, arguments):
    (folder / "own").mkdir()
    (folder / "part.usda").write_text('#usda 1.0\n(defaultPrim = "P")\ndef Cube "P" {}\n')
    (folder / "own" / "a.usda").write_text(
        '#usda 1.0\n(\n metersPerUnit = 1\n upAxis = "Z"\n)\ndef Xform "W" (references = @../part.usda@) {}\n'
    )
    command, *rest = arguments
    refused = graph(command, "own/a.usda", *rest)
    assert refused.code == 2
    assert refused.err.splitlines()[-1].endswith("; to run without it: --skip-outside")
    skipped = graph(command, "own/a.usda", *rest, "--skip-outside")
    assert skipped.code == 0
    assert "part.usda" in skipped.err + skipped.out
    words = refused.err.splitlines()[-1].partition("folder: ")[2].partition(";")[0].split()
    assert graph(command, "own/a.usda", *rest, *words).code == 0


@pytest.mark.parametrize("parity", ["documented", "isaacsim-6.0.1"])
def test_deprecated_inputs_are_named_before_the_run_as_the_run_names_them(parity, folder, graph):
    text = FILE.format(
        x=0,
        more="",
        clock=f"physics_hz: 60, parity: {parity}",
        inputs=", fullScan: false, frameSkipCount: 1, resetSimulationTimeOnStop: true, useSystemTime: true",
        nodes="imu: {type: IsaacReadIMU, inputs: {useLatestData: true}}",
        wires="- tick.tick -> imu.execIn",
    )
    (folder / "a.yaml").write_text(text)
    checked, ran = graph("check", "a.yaml").err, graph("run", "a.yaml", "--updates", "3", "--on-error", "continue").err
    told = [
        {line for line in err.splitlines() if "deprecated" in line or "never-resets" in line} for err in (checked, ran)
    ]
    assert told[0] == told[1]
    codes = {"deprecated-attribute", "frame-skip-deprecated", "system-time-never-resets"}
    codes |= {"full-scan-deprecated"} if parity == "documented" else set()
    assert {line.split(": ")[0].removeprefix("warning ") for line in told[0]} == codes


def test_a_profile_that_is_none_is_reported(warnings):
    assert set(warnings(inputs=", qosProfile: best effort")) == {("qos-profile-unknown", "/World/Graph/cloud")}


def test_quantities_above_the_auxiliary_level_of_a_sensor_are_reported(warnings):
    nodes = "meta: {type: ROS2RtxLidarPointCloudConfig, inputs: {outputHitNormal: true}}"
    wires = "- meta.selectedMetadata -> cloud.selectedMetadata"
    told = warnings(nodes=nodes, wires=wires)
    assert set(told) == {("aux-level-too-low", "/World/Lidar.hitNormals")}
    assert "needs aux_output_level FULL, the prim has NONE" in told["aux-level-too-low", "/World/Lidar.hitNormals"]


CAMERA = """\
tickgraph: 1
scene:
  prims:
    /World/Camera: {{type: Camera}}
{lights}
graphs:
  /World/Graph:
    nodes:
      tick: OnPlaybackTick
      product: {{type: IsaacCreateRenderProduct, inputs: {{cameraPrim: /World/Camera}}}}
      picture: {{type: ROS2CameraHelper, inputs: {{type: {kind}, topicName: picture}}}}
    connections:
      - tick.tick -> product.execIn
      - product.execOut -> picture.execIn
      - product.renderProductPath -> picture.renderProductPath
"""
DARK = {("no-light", "/World/Camera")}
STRANGE = {("light-not-modelled", "/World/Light")}


@pytest.mark.parametrize(
    ("kind", "lights", "codes"),
    [
        ("rgb", "", DARK),
        ("depth", "", set()),  # needs no light
        ("rgb", "/World/Light: {type: DistantLight}", set()),
        ("rgb", "/World/Light: {type: DistantLight, attributes: {visibility: invisible}}", DARK),
        ("rgb", "/World/Light: {type: DomeLight, attributes: {'inputs:intensity': 0.0}}", DARK),
        ("rgb", "/World/Light: {type: GeometryLight}", DARK | STRANGE),
        ("depth", "/World/Light: {type: GeometryLight}", set()),
    ],
)
def test_pictures_without_light_are_told_by_check_as_by_a_run(kind, lights, codes, folder, graph):
    (folder / "a.yaml").write_text(CAMERA.format(kind=kind, lights=f"    {lights}"))
    checked = json.loads(graph("check", "a.yaml", "--json").out)["files"][0]["warnings"]
    assert {(one["code"], one["where"]) for one in checked} == codes
    ran = json.loads(graph("run", "a.yaml", "--updates", "3", "--json").out)["warnings"]
    lit = {"no-light", "light-not-modelled"}
    assert {(one["code"], one["where"], one["message"]) for one in ran if one["code"] in lit} == {
        (one["code"], one["where"], one["message"]) for one in checked
    }
