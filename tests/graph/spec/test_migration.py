"""Old ids and attributes: mapped on load, said once."""

import time

import pytest

from graph.node.declaration import Attribute
from graph.node.library import Library
from graph.node.registry import Registry
from graph.spec.file_spec import ConnectionSpec, FileSpec, GraphSpec, NodeSpec
from graph.spec.migration import migrate, migrated_type, upgraded
from tests.support.without_wing import needs_wing

IDS = [
    "isaacsim.ros2.bridge.ROS2PublishClock",
    "isaacsim.core.nodes.IsaacReadSimulationTime",
    "isaacsim.core.nodes.OgnIsaacRunOneSimulationFrame",
    "isaacsim.robot.wheeled_robots.DifferentialController",
    "isaacsim.sensors.rtx.IsaacCreateRTXLidarScanBuffer",
    "isaacsim.sensors.physics.IsaacReadIMU",
    "isaacsim.sensors.physx.IsaacReadLidarBeams",
    "isaacsim.asset.gen.conveyor.IsaacConveyor",
    "isaacsim.ucx.nodes.UCXPublishClock",
    "omni.graph.ui_nodes.PrintText",
    "omni.graph.core.ReadVariable",
]


@pytest.fixture
def registry():
    from graph.node.decorator import declare

    registry = Registry()
    for one in IDS:
        inputs = {"execIn": Attribute("execution", ""), "chassisPrim": Attribute("target", "")}
        declare(one, "", inputs=inputs, registry=registry)
    return registry


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("omni.isaac.ros2_bridge.ROS2PublishClock", "isaacsim.ros2.bridge.ROS2PublishClock"),
        ("omni.isaac.ros_bridge.ROS1PublishClock", "isaacsim.ros2.bridge.ROS2PublishClock"),
        ("isaacsim.ros2.nodes.ROS2PublishClock", "isaacsim.ros2.bridge.ROS2PublishClock"),
        ("omni.isaac.core_nodes.IsaacReadSimulationTime", "isaacsim.core.nodes.IsaacReadSimulationTime"),
        ("omni.isaac.core_nodes.IsaacRunOneSimulationFrame", "isaacsim.core.nodes.OgnIsaacRunOneSimulationFrame"),
        ("omni.isaac.wheeled_robots.DifferentialController", "isaacsim.robot.wheeled_robots.DifferentialController"),
        ("omni.isaac.sensor.IsaacCreateRTXLidarScanBuffer", "isaacsim.sensors.rtx.IsaacCreateRTXLidarScanBuffer"),
        ("omni.isaac.sensor.IsaacReadIMU", "isaacsim.sensors.physics.IsaacReadIMU"),
        ("omni.isaac.isaac_sensor.IsaacReadIMU", "isaacsim.sensors.physics.IsaacReadIMU"),
        ("omni.isaac.sensor.IsaacPrintRTXLidarInfo", "isaacsim.sensors.rtx.IsaacPrintRTXLidarInfo"),
        ("omni.isaac.range_sensor.IsaacReadLidarBeams", "isaacsim.sensors.physx.IsaacReadLidarBeams"),
        ("omni.isaac.conveyor.IsaacConveyor", "isaacsim.asset.gen.conveyor.IsaacConveyor"),
        ("isaacsim.ucx.bridge.UCXPublishClock", "isaacsim.ucx.nodes.UCXPublishClock"),
        ("omni.graph.ui.PrintText", "omni.graph.ui_nodes.PrintText"),
        ("omni.graph.nodes.ReadVariable", "omni.graph.core.ReadVariable"),
    ],
)
def test_an_old_id_has_a_new_one_and_a_sentence(registry, old, new):
    found, sentence = migrated_type(old, registry)
    assert found == new
    assert f'"{old}"' in sentence
    assert f'"{new}"' in sentence


def test_no_twin_is_reported_to_run_that_is_not_there(registry):
    class WithoutCameras(Library):
        """The shipped library, as if it said why there is no camera helper."""

        def why_absent(self, name: str) -> str | None:
            return "no cameras here" if name == "isaacsim.ros2.bridge.ROS2CameraHelper" else super().why_absent(name)

    bare = Registry(library=WithoutCameras("nodes"))
    for one in ("omni.isaac.ros_bridge.ROS1RosMaster", "omni.isaac.ros_bridge.ROS1PublishClock"):
        assert migrated_type(one, bare) == (one, None)
    found, sentence = migrated_type("omni.isaac.ros_bridge.ROS1CameraHelper", bare)
    assert found == "isaacsim.ros2.bridge.ROS2CameraHelper"
    assert sentence is not None
    assert sentence.endswith('its ROS 2 twin is "isaacsim.ros2.bridge.ROS2CameraHelper"')
    assert migrated_type("omni.isaac.ros_bridge.ROS1RosMaster", registry)[1] is None


def test_a_registered_id_and_an_unknown_one_stay(registry):
    assert migrated_type(IDS[0], registry) == (IDS[0], None)
    assert migrated_type("my.own.Thing", registry) == ("my.own.Thing", None)
    assert migrated_type("ROS2PublishClock", registry) == ("ROS2PublishClock", None)


def test_attributes_are_renamed_and_removed_with_their_connections(registry):
    from graph.node.decorator import declare

    declare(
        "isaacsim.core.nodes.IsaacComputeOdometry",
        "",
        inputs={"chassisPrim": Attribute("target", "")},
        registry=registry,
    )
    nodes = (
        NodeSpec("time", IDS[1], {"swhFrameNumber": 3}),
        NodeSpec("odometry", "isaacsim.core.nodes.IsaacComputeOdometry", {"robotPrim": "/Robot"}),
    )
    connections = (
        ConnectionSpec("x.y", "time.swhFrameNumber"),
        ConnectionSpec("x.y", "odometry.robotPrim"),
        ConnectionSpec("x.y", "time.execIn"),
    )
    spec = migrate(FileSpec(graphs=(GraphSpec("/G", nodes, connections),)), registry)
    [graph] = spec.graphs
    assert [dict(node.inputs) for node in graph.nodes] == [{}, {"chassisPrim": "/Robot"}]
    assert [one.target for one in graph.connections] == ["odometry.inputs:chassisPrim", "time.execIn"]
    assert [(code, where) for code, where, _ in spec.notes] == [
        ("attribute-removed", "/G/time"),
        ("attribute-renamed", "/G/odometry"),
    ]


OLD_CLOUD = """\
tickgraph: 1
graphs:
  /World/G:
    nodes:
      tick: OnPlaybackTick
      time: IsaacReadSimulationTime
      lidar: omni.isaac.range_sensor.IsaacReadLidarPointCloud
      cloud: omni.isaac.ros2_bridge.ROS2PublishPointCloud
      drive: {type: omni.isaac.wheeled_robots.DifferentialController, inputs: {wheelRadius: 1, wheelDistance: 1}}
      joints: omni.isaac.core_nodes.IsaacArticulationController
    connections:
      - tick.tick -> [lidar.execIn, drive.execIn, joints.execIn]
      - lidar.execOut -> cloud.execIn
      - time.simulationTime -> cloud.timeStamp
      - lidar.outputs:pointCloudData -> cloud.inputs:pointCloudData
      - drive.positionCommand -> joints.positionCommand
      - drive.velocityCommand -> joints.velocityCommand
      - drive.outputs:effortCommand -> joints.effortCommand
"""


@needs_wing("physx")
def test_the_outputs_of_old_nodes_are_renamed_or_left_out_with_their_connections(tmp_path):
    """A lidar's points and a drive's commands as Isaac Sim 2022 called them."""
    from graph import load_graph

    file = tmp_path / "old.yaml"
    file.write_text(OLD_CLOUD)
    spec = load_graph(file).spec
    data = [f"{one.source} -> {one.target}" for one in spec.graphs[0].connections[5:]]
    assert data == ["lidar.outputs:data -> cloud.inputs:data", "drive.velocityCommand -> joints.velocityCommand"]
    said = [message for code, _, message in spec.notes if code.startswith("attribute-")]
    assert said == [
        "IsaacReadLidarPointCloud: outputs:pointCloudData is now called outputs:data; the new name is used",
        "ROS2PublishPointCloud: inputs:pointCloudData is now called inputs:data; the new name is used",
        "DifferentialController: outputs:positionCommand is gone and is left out; remove it",
        "DifferentialController: outputs:effortCommand is gone and is left out; remove it",
    ]


@needs_wing("physx")
def test_a_script_connects_old_outputs_under_their_present_names():
    from graph import Controller

    keys = Controller.Keys
    told = []
    controller = Controller()
    controller.graphs.context.warn = lambda *warning: told.append(warning)
    controller.edit(
        "/World/G",
        {
            keys.CREATE_NODES: [
                ("lidar", "omni.isaac.range_sensor.IsaacReadLidarPointCloud"),
                ("cloud", "omni.isaac.ros2_bridge.ROS2PublishPointCloud"),
                ("drive", "omni.isaac.wheeled_robots.DifferentialController"),
                ("joints", "omni.isaac.core_nodes.IsaacArticulationController"),
            ],
            keys.CONNECT: [
                ("lidar.outputs:pointCloudData", "cloud.inputs:pointCloudData"),
                ("drive.outputs:effortCommand", "joints.inputs:effortCommand"),
            ],
        },
    )
    connections = controller.graphs.graphs["/World/G"].spec.connections
    assert [(one.source, one.target) for one in connections] == [("lidar.outputs:data", "cloud.inputs:data")]
    assert [code for code, _, _ in told if code.startswith("attribute-")] == [
        "attribute-renamed",
        "attribute-renamed",
        "attribute-removed",
    ]


def test_many_old_types_are_one_warning_and_those_of_ros_1_another(registry):
    types = ("core_nodes.IsaacReadSimulationTime", "sensor.IsaacReadIMU", "sensor.IsaacReadIMU")
    types += ("ros_bridge.ROS1PublishClock", "ros_bridge.ROS1PublishClock")
    nodes = tuple(NodeSpec(f"n{number}", f"omni.isaac.{one}") for number, one in enumerate(types))
    spec = migrate(FileSpec(graphs=(GraphSpec("/G", nodes),)), registry)
    assert spec.notes == (
        (
            "type-renamed",
            "/G/n0",
            "3 nodes of 2 types have names of older versions; the new names are used, such as "
            '"isaacsim.core.nodes.IsaacReadSimulationTime" for "omni.isaac.core_nodes.IsaacReadSimulationTime"',
        ),
        (
            "type-renamed",
            "/G/n3",
            'the ROS 1 node type "omni.isaac.ros_bridge.ROS1PublishClock" is gone; its ROS 2 twin '
            '"isaacsim.ros2.bridge.ROS2PublishClock" runs instead (and 1 more)',
        ),
    )


def test_an_old_prefix_before_a_name_that_never_was_stays_as_it_is_written(registry):
    name = "omni.isaac.core_nodes.IsaacDifferentialController"
    assert migrated_type(name, registry) == (name, None)


def test_migrating_twice_says_nothing_more(registry):
    spec = FileSpec(graphs=(GraphSpec("/G", (NodeSpec("c", "omni.isaac.ros2_bridge.ROS2PublishClock"),)),))
    once = migrate(spec, registry)
    assert len(once.notes) == 1
    assert migrate(once, registry) is once


def test_values_that_meant_nothing_in_an_old_version_are_left_out():
    kind = "omni.graph.nodes.ReadPrimAttribute"
    assert upgraded(kind, 1, {"usdTimecode": -1, "name": "x"}) == {"name": "x"}
    assert upgraded(kind, 1, {"usdTimecode": 5}) == {"usdTimecode": 5}
    assert upgraded(kind, 3, {"usdTimecode": -1}) == {"usdTimecode": -1}


def test_many_nodes_of_a_renamed_type_are_migrated_in_one_pass(registry):
    def seconds(count):
        nodes = tuple(NodeSpec(f"n{i}", "omni.isaac.core_nodes.IsaacReadSimulationTime") for i in range(count))
        feeds = tuple(ConnectionSpec("t.y", f"n{i}.execIn") for i in range(count))
        spec = FileSpec(graphs=(GraphSpec("/G", nodes, feeds),))
        began = time.process_time()
        assert len(migrate(spec, registry).graphs[0].nodes) == count
        return time.process_time() - began

    seconds(100)
    large, small = (min(seconds(count) for _ in range(3)) for count in (20_000, 2_000))
    assert large < 40 * max(small, 0.01)


@needs_wing("robots")
def test_the_old_inputs_of_a_surface_gripper_are_left_out_in_files_and_scripts(tmp_path):
    """A public script's edit: the node of Isaac Sim 4.5 with the inputs that it had then."""
    from graph import Controller, load_graph

    old = {"GripPosition": "/World/Point", "ParentRigidBody": "/World/Arm", "Stiffness": 10.0, "RetryClose": True}
    told = []
    keys = Controller.Keys
    controller = Controller()
    controller.graphs.context.warn = lambda *warning: told.append(warning)
    controller.edit(
        "/World/Grip",
        {
            keys.CREATE_NODES: [("grip", "omni.isaac.surface_gripper.SurfaceGripper"), ("go", "OnImpulseEvent")],
            keys.SET_VALUES: [(f"grip.inputs:{name}", value) for name, value in old.items()],
            keys.CONNECT: [("go.outputs:execOut", "grip.inputs:onStep")],
        },
    )
    text = "".join(f"{name}: {str(value).lower() if value is True else value}, " for name, value in old.items())
    file = tmp_path / "grip.yaml"
    file.write_text(
        "tickgraph: 1\ngraphs:\n  /World/Grip:\n    nodes:\n"
        f"      grip: {{type: omni.isaac.surface_gripper.SurfaceGripper, inputs: {{{text}}}}}\n"
        "      go: OnImpulseEvent\n    connections: [go.execOut -> grip.onStep]\n"
    )
    notes = load_graph(file).spec.notes
    for found in (told, notes):
        assert [code for code, _, _ in found].count("attribute-removed") == len(old) + 1
        assert any("name it in SurfaceGripper" in message for _, _, message in found)


def test_a_value_that_is_a_type_of_its_own_now_gives_that_type_and_keeps_the_inputs_it_has():
    """Up to Isaac Sim 4.x a camera helper of type camera_info published the lens."""
    inputs = {"type": "camera_info", "topicName": "info", "frameId": "camera", "enableSemanticLabels": True}
    nodes = (
        NodeSpec("info", "omni.isaac.ros_bridge.ROS1CameraHelper", inputs),
        NodeSpec("rgb", "omni.isaac.ros2_bridge.ROS2CameraHelper", {"inputs:type": "rgb"}),
    )
    links = (ConnectionSpec("tick.tick", "info.execIn"), ConnectionSpec("x.y", "info.semanticLabelsTopicName"))
    spec = migrate(FileSpec(graphs=(GraphSpec("/G", nodes, links),)))
    [graph] = spec.graphs
    assert [node.type.rpartition(".")[2] for node in graph.nodes] == ["ROS2CameraInfoHelper", "ROS2CameraHelper"]
    assert dict(graph.nodes[0].inputs) == {"topicName": "info", "frameId": "camera"}
    assert [one.target for one in graph.connections] == ["info.execIn"]
    assert any("with type camera_info is now a node type" in message for _, _, message in spec.notes)
