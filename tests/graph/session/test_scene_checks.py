"""Warnings of `graph check` about what a graph file writes: units, orders, scales, rates, what nothing feeds."""

from dataclasses import replace

import pytest

from graph.cli.check import check
from graph.files import loads
from graph.node import registry
from graph.session.open import build_parts
from nodes.catalog.example import example
from tests.support.without_wing import needs_wing

HEAD = "tickgraph: 1\nscene:\n  prims:\n"
WIRED = """graphs:
  /G:
    nodes:
      tick: OnPlaybackTick
      time: IsaacReadSimulationTime
      made: {type: IsaacCreateRenderProduct, inputs: {cameraPrim: SENSOR}}
      sent: {type: HELPER, inputs: {topicName: points}}
    connections:
      - tick.tick -> made.execIn
      - made.execOut -> sent.execIn
      - made.renderProductPath -> sent.renderProductPath
"""


def warnings_of(folder, text):
    """(code, place without the folder, message) of the warnings of `graph check`."""
    path = folder / "file.yaml"
    path.write_text(text, encoding="utf-8")
    checked = check(str(path))
    assert checked.problems == ()
    return [(code, where.removeprefix(f"{folder}/"), message) for code, where, message in checked.notes]


@pytest.mark.parametrize(
    ("keys", "code", "says"),
    [
        ("color: [255, 128, 0]", "color-above-1", "1, 0.502, 0 if 0 to 255 is meant"),
        ("rotate: [0, 0, 1.57]", "angle-in-radians", "write 0, 0, 90"),
        ("rotate: [-3.14159, 0, 0.785]", "angle-in-radians", "write -180, 0, 45"),
        ("orient: [0, 0, 0, 1]", "orient-order", "write [1, 0, 0, 0]"),
        ("orient: [0, 0, 0.7071, 0.7071]", "orient-order", "write [0.7071, 0, 0, 0.7071]"),
    ],
)
def test_a_value_of_another_unit_or_order_is_named_at_its_place(tmp_path, keys, code, says):
    ((found, where, message),) = warnings_of(tmp_path, f"{HEAD}    /World/Box: {{type: Cube, size: 0.5, {keys}}}\n")
    assert found == code
    assert where.startswith("file.yaml:4:")
    assert message.startswith("/World/Box: ")
    assert says in message


@pytest.mark.parametrize(
    "keys",
    [
        "color: [1, 0.5, 0]",
        "rotate: [0, 0, 90]",
        "rotate: [1, 2, 3]",
        "rotate: [0, 0, 0]",
        "rotate: [35, 1.57, 0]",
        "orient: [0.7071, 0, 0, 0.7071]",  # 90 degrees about z
        "orient: [0, 1, 0, 0]",
        "orient: [1, 0, 0, 0]",
    ],
)
def test_what_can_be_meant_is_not(tmp_path, keys):
    assert warnings_of(tmp_path, f"{HEAD}    /World/Box: {{type: Cube, size: 0.5, {keys}}}\n") == []


def test_the_limit_of_a_hinge_in_radians_is_named_and_that_of_a_slider_is_not(tmp_path):
    def joint(kind):
        return f"    /J: {{type: {kind}, attributes: {{physics:lowerLimit: -1.57, physics:upperLimit: 1.57}}}}\n"

    hinge, slider = (warnings_of(tmp_path, HEAD + joint(f"Physics{kind}Joint")) for kind in ("Revolute", "Prismatic"))
    assert [message[:36] for code, _, message in hinge if code == "angle-in-radians"] == [
        "/J: physics:lowerLimit is in degrees",
        "/J: physics:upperLimit is in degrees",
    ]
    assert [code for code, _, _ in slider if code == "angle-in-radians"] == []


def test_a_sensor_below_a_stretched_box_is_told_where_it_stands(tmp_path):
    """0.3 m above a box scaled by 0.1 along z, which is at 0.12 m, is 0.15 m. `exclude` would leave it there."""
    prims = (
        "    /World/Box: {type: Cube, size: 1.0, scale: [0.4, 0.3, 0.1], translate: [0, 0, 0.12]}\n"
        "    /World/Box/Lidar: {type: OmniLidar, config: OS1, translate: [0, 0, 0.3]}\n"
    )
    wired = WIRED.replace("SENSOR", "/World/Box/Lidar").replace(
        "{type: HELPER, inputs: {", "{type: ROS2RtxLidarHelper, inputs: {type: point_cloud, "
    )
    found = {code: message for code, _, message in warnings_of(tmp_path, HEAD + prims + wired)}
    assert "it stands at (0, 0, 0.15) in the world" in found["sensor-scaled"]
    assert "leave /World/Box without a scale" in found["sensor-scaled"]
    assert "exclude" not in found["sensor-in-solid"]


@pytest.mark.parametrize(("rate", "warned"), [("", True), ("attributes: {omni:sensor:tickRate: 15}", False)])
def test_a_camera_that_renders_more_often_than_the_real_one_is_named(tmp_path, rate, warned):
    """The RealSense D455 gives 30 pictures a second, an update comes 60 times."""
    more = f", {rate}" if rate else ""
    prims = f"    /World/Camera: {{type: Camera, config: Realsense D455, translate: [0, 0, 1]{more}}}\n"
    wired = WIRED.replace("SENSOR", "/World/Camera").replace("HELPER", "ROS2CameraHelper")
    notes = warnings_of(tmp_path, HEAD + prims + wired)
    assert [code for code, _, _ in notes if code == "camera-faster-than-real"] == ["camera-faster-than-real"] * warned


def published(*nodes, wires=""):
    lines = "".join(f"      {line}\n" for line in nodes)
    names = ", ".join(f"{line.partition(':')[0]}.execIn" for line in nodes)
    stamps = ", ".join(f"{line.partition(':')[0]}.timeStamp" for line in nodes)
    return (
        "tickgraph: 1\ngraphs:\n  /G:\n    nodes:\n      tick: OnPlaybackTick\n      time: IsaacReadSimulationTime\n"
        f"{lines}    connections:\n      - tick.tick -> [{names}]\n      - time.simulationTime -> [{stamps}]\n{wires}"
    )


@pytest.mark.parametrize("kind", ["ROS2PublishOdometry", "ROS2PublishImu", "ROS2PublishAckermannDrive"])
def test_a_publisher_that_nothing_feeds_is_named(tmp_path, kind):
    ((code, where, message),) = warnings_of(tmp_path, published(f"sent: {kind}"))
    assert (code, where) == ("input-unfed", "file.yaml:7:7")
    assert message.startswith("/G/sent: nothing feeds ")
    assert "its messages hold nothing but defaults" in message


def test_a_publisher_with_one_written_value_is_not(tmp_path):
    fed = "sent: {type: ROS2PublishAckermannDrive, inputs: {speed: 0.0}}"
    assert warnings_of(tmp_path, published(fed)) == []


def test_two_publishers_of_one_topic_are_named_but_of_tf(tmp_path):
    ((code, where, message),) = warnings_of(tmp_path, published("one: ROS2PublishClock", "two: ROS2PublishClock"))
    assert (code, where) == ("topic-shared", "/clock")
    assert message.startswith("/G/one, /G/two publish on it")


ARM = """\
    /Arm: {schemas: PhysicsArticulationRootAPI}
    /Arm/base: {type: Cube, size: 0.2, rigid_body: true}
    /Arm/link: {type: Cube, size: 0.2, rigid_body: true, translate: [0, 0, 1]}
    /Arm/bend: {type: PhysicsRevoluteJoint, SCHEMAS attributes: {physics:body0: /Arm/base, physics:body1: /Arm/link}}
graphs:
  /G:
    nodes:
      tick: OnPlaybackTick
      motors: {type: IsaacArticulationController, inputs: {targetPrim: /Arm, jointNames: [bend], velocityCommand: [1]}}
    connections: [tick.tick -> motors.execIn]
"""


@pytest.mark.parametrize("driven", [False, True])
def test_a_commanded_joint_without_a_drive_is_named_before_the_run(tmp_path, driven):
    schemas = 'schemas: ["PhysicsDriveAPI:angular"],' if driven else ""
    found = warnings_of(tmp_path, HEAD + ARM.replace("SCHEMAS", schemas))
    codes = [(code, where) for code, where, _ in found if code == "joint-without-drive"]
    assert codes == ([] if driven else [("joint-without-drive", "/G/motors")])


@needs_wing("actuators")
def test_actuators_that_no_node_steps_are_told_once(tmp_path):
    spec = loads(example(registry.get("ArticulationActuators")), folder=tmp_path)
    assert not [note for note in build_parts(spec).warnings if note[0] == "actuators-idle"]
    without = replace(spec, graphs=())
    ((_, where, message),) = [note for note in build_parts(without).warnings if note[0] == "actuators-idle"]
    assert where == "/World/Robot/Actuators/joint"
    assert message.startswith("no node ArticulationActuators steps the actuators")
