import math

import numpy as np
import pytest

from graph import ComputeError, compile_graphs
from graph.session.runner import GraphRunner
from graph.spec.file_spec import ConnectionSpec, GraphSpec, NodeSpec
from graph.testing import run_node
from sensors import render_product
from sensors.handles import resolve

BUFFER, FLAT, EXTRACT = (
    "IsaacCreateRTXLidarScanBuffer",
    "IsaacComputeRTXLidarFlatScan",
    "OgnIsaacExtractRTXSensorPointCloud",
)
PRODUCT = "/World/Make.product.outputs:renderProductPath"


@pytest.fixture
def runner():
    """A function that runs a post-render graph of these nodes beside one that makes the product of /World/Lidar."""
    made = []

    def make(app, nodes, connections=(), product=PRODUCT, prim="/World/Lidar"):
        simulation = GraphSpec(
            "/World/Make",
            (
                NodeSpec("tick", "OnPlaybackTick"),
                NodeSpec("product", "IsaacCreateRenderProduct", {"cameraPrim": prim}),
            ),
            (ConnectionSpec("tick.tick", "product.execIn"),),
        )
        first = next(iter(nodes))
        frames = GraphSpec(
            "/World/Frames",
            tuple(NodeSpec(name, kind, inputs) for name, (kind, inputs) in nodes.items()),
            (
                ConnectionSpec(product, f"{first}.renderProductPath"),
                *(ConnectionSpec(source, target) for source, target in connections),
            ),
            pipeline_stage="post_render",
        )
        runner = GraphRunner(app, compile_graphs([simulation, frames]))
        made.append(runner)
        app.play()
        return runner.graphs["/World/Frames"].nodes

    yield make
    for runner in made:
        runner.close()


def array(node, name):
    return resolve(node.get(f"outputs:{name}"))


def test_a_scan_buffer_fires_once_for_every_new_frame(lidar, world, runner):
    lidar()
    app = world(physics_hz=240)
    node = runner(app, {"buffer": (BUFFER, {})})["buffer"]
    app.update(60)
    assert node.computes == 10
    assert array(node, "dataPtr").shape == (node.get("outputs:width"), 3)


FLAGS = {
    "outputAzimuth": ("azimuth", np.float32, 1),
    "outputElevation": ("elevation", np.float32, 1),
    "outputDistance": ("distance", np.float32, 1),
    "outputIntensity": ("intensity", np.float32, 1),
    "outputTimestamp": ("timestamp", np.uint64, 1),
    "outputEmitterId": ("emitterId", np.uint32, 1),
    "outputChannelId": ("channelId", np.uint32, 1),
    "outputTickId": ("tickId", np.uint32, 1),
    "outputHitNormal": ("hitNormal", np.float32, 3),
    "outputVelocity": ("velocity", np.float32, 3),
    "outputEchoId": ("echoId", np.uint8, 1),
    "outputTickState": ("tickState", np.uint8, 1),
}


@pytest.mark.parametrize("flag", FLAGS)
def test_a_buffer_is_filled_only_when_asked_for(stage, lidar, world, runner, flag):
    from pxr import Sdf

    lidar()
    level = stage.GetPrimAtPath("/World/Lidar").CreateAttribute(
        "_replicator:rendervar:GenericModelOutput:channels", Sdf.ValueTypeNames.TokenArray
    )
    level.Set(["FULL"])
    app = world(physics_hz=240, settings={"/app/sensors/nv/lidar/publishNormals": True})
    node = runner(app, {"buffer": (BUFFER, {flag: True})})["buffer"]
    app.update(7)
    name, dtype, width = FLAGS[flag]
    buffer, count = array(node, f"{name}Ptr"), node.get("outputs:width")
    assert buffer.dtype == dtype
    assert buffer.size == width * count > 0
    assert node.get(f"outputs:{name}BufferSize") == buffer.nbytes
    filled = [one for one, *_ in FLAGS.values() if node.get(f"outputs:{one}Ptr")]
    assert filled == [name]


def test_the_first_frame_already_has_what_was_asked_for(lidar, world, runner):
    lidar()
    app = world(physics_hz=240)
    node = runner(app, {"buffer": (BUFFER, {"outputTimestamp": True, "outputIntensity": True})})["buffer"]
    app.update(6)
    assert node.computes == 1
    assert len(array(node, "intensityPtr")) == node.get("outputs:width") > 0


def test_a_buffer_above_the_auxiliary_level_stays_empty_and_one_warning_says_so(lidar, world, runner):
    lidar()
    app = world(physics_hz=240)
    node = runner(app, {"buffer": (BUFFER, {"outputHitNormal": True, "outputVelocity": True})})["buffer"]
    app.update(13)
    assert node.get("outputs:hitNormalPtr") == node.get("outputs:velocityBufferSize") == 0
    codes = [one.code for one in app.warnings]
    assert codes.count("aux-level-too-low") >= 1
    assert [one.count for one in app.warnings if one.code == "node-deprecated"] == [1]


def test_data_and_distance_are_in_stage_units(stage, lidar, world, runner):
    from pxr import UsdGeom

    UsdGeom.SetStageMetersPerUnit(stage, 0.5)
    lidar()
    app = world(physics_hz=240)
    node = runner(app, {"buffer": (BUFFER, {"outputDistance": True})})["buffer"]
    app.update(7)
    points, distance = array(node, "dataPtr"), array(node, "distancePtr")
    ahead = (np.abs(points[:, 1]) < 0.1) & (points[:, 0] > 0)
    assert points[ahead, 0] == pytest.approx(np.full(ahead.sum(), 4.0), abs=1e-3)
    assert distance == pytest.approx(np.linalg.norm(points, axis=1), rel=1e-5)


def test_the_transform_is_the_sensors_pose_with_row_vectors(stage, lidar, world, runner):
    from pxr import UsdGeom

    lidar()
    UsdGeom.Xformable(stage.GetPrimAtPath("/World/Lidar")).AddTranslateOp().Set((0.25, 0, 0))
    app = world(physics_hz=240)
    node = runner(app, {"cloud": (EXTRACT, {})})["cloud"]
    app.update(7)
    assert node.get("outputs:transform")[3].tolist() == pytest.approx([0.25, 0, 0, 1])
    assert (node.get("outputs:width"), node.get("outputs:height")) == (len(array(node, "dataPtr")), 1)


def test_extract_feeds_a_point_cloud_publisher(lidar, world, runner):
    lidar()
    app = world(physics_hz=240)
    runner(
        app,
        {
            "cloud": (EXTRACT, {}),
            "publish": ("ROS2PublishPointCloud", {"outputIntensity": True, "timeStamp": 1.25}),
        },
        [
            ("cloud.outputs:exec", "publish.execIn"),
            ("cloud.dataPtr", "publish.dataPtr"),
            ("cloud.intensityPtr", "publish.intensityPtr"),
        ],
    )
    app.update(13)
    clouds = app.sink["/point_cloud"]
    assert len(clouds) == 2
    message = clouds[0].message
    assert [field.name for field in message.fields] == ["x", "y", "z", "intensity"]
    assert (message.header.stamp.sec, message.header.stamp.nanosec) == (1, 250_000_000)
    assert message.width > 100


def test_a_flat_scan_has_minus_1_for_empty_beams_and_feeds_a_laser_scan(lidar, world, runner):
    lidar()
    app = world(physics_hz=240)
    names = (
        *("horizontalFov", "horizontalResolution", "depthRange", "rotationRate", "linearDepthData"),
        *("intensitiesData", "numRows", "numCols", "azimuthRange"),
    )
    nodes = runner(
        app,
        {"flat": (FLAT, {}), "publish": ("ROS2PublishLaserScan", {})},
        [("flat.outputs:exec", "publish.execIn"), *((f"flat.{name}", f"publish.{name}") for name in names)],
    )
    app.update(7)
    flat = nodes["flat"]
    depths = flat.get("outputs:linearDepthData")
    assert (flat.get("outputs:numRows"), flat.get("outputs:numCols"), len(depths)) == (1, 3600, 3600)
    assert flat.get("outputs:horizontalFov") == 360
    assert flat.get("outputs:horizontalResolution") == pytest.approx(0.1)
    assert np.asarray(flat.get("outputs:azimuthRange")) == pytest.approx([-180, 179.9])
    assert flat.get("outputs:rotationRate") == 10
    assert depths[0] == -1
    assert depths[1800] == pytest.approx(4.0, abs=1e-3)
    [message] = app.sink["/scan"]
    assert message.message.ranges[0] == math.inf
    assert message.message.ranges[1800] == pytest.approx(4.0, abs=1e-3)


def test_a_flat_scan_of_a_lidar_with_elevations_names_an_emitter_and_its_elevation(lidar, world, runner):
    lidar("Example_Rotary")
    app = world(physics_hz=240)
    runner(app, {"flat": (FLAT, {})})
    with pytest.raises(ComputeError, match=r"needs a 2D lidar, but emitter 0 points -15 deg up"):
        app.update(7)


def test_in_a_simulation_graph_they_see_the_last_delivered_frame(lidar, world):
    lidar()
    app = world(physics_hz=240)
    path = render_product(app, "/World/Lidar").path
    inputs = {"renderProductPath": path, "outputDistance": True}
    trace = run_node(BUFFER, inputs=inputs, pulses={"exec": range(13)}, updates=13, app=app)
    # Frames are delivered after the simulation graphs of updates 5 and 11.
    assert trace.fired("exec") == list(range(6, 13))


@pytest.fixture
def radar(stage, lidar):
    """A radar at level BASIC at the origin, before the walls of `lidar`."""
    from sensors.prim import write_aux_level

    write_aux_level(stage.DefinePrim("/World/Radar", "OmniRadar"), "BASIC")
    return "/World/Radar"


def test_a_scan_buffer_of_a_radar_has_radial_velocities_and_nothing_of_a_lidar(radar, world, runner):
    app = world(physics_hz=60)
    flags = dict.fromkeys((*FLAGS, "outputRadialVelocityMS"), True)
    node = runner(app, {"buffer": (BUFFER, flags)}, prim=radar)["buffer"]
    app.update(2)
    count = node.get("outputs:width")
    assert array(node, "radialVelocityMSPtr").tolist() == [0.0] * count != []
    assert array(node, "distancePtr").shape == array(node, "intensityPtr").shape == (count,)
    assert node.get("outputs:emitterIdPtr") == node.get("outputs:hitNormalPtr") == 0


def test_a_cloud_of_a_radar_is_published_with_its_radial_velocities(radar, world, runner):
    """Nothing else asks for them: the connection does, as in the documented graph that gates a radar."""
    app = world(physics_hz=60)
    publisher = ("ROS2PublishPointCloud", {"outputRadialVelocityMS": True})
    links = [
        ("cloud.exec", "publish.execIn"),
        ("cloud.dataPtr", "publish.dataPtr"),
        ("cloud.radialVelocityMSPtr", "publish.radialVelocityMSPtr"),
    ]
    runner(app, {"cloud": (EXTRACT, {}), "publish": publisher}, links, prim=radar)
    app.update(2)
    fields = [field.name for field in app.sink["/point_cloud"][-1].message.fields]
    assert fields == ["x", "y", "z", "radial_velocity_ms"]


@pytest.mark.parametrize("kind", [FLAT])
def test_what_reads_lidars_alone_names_a_radar_and_the_node(stage, lidar, world, kind):
    lidar()
    app = world(physics_hz=240)
    stage.DefinePrim("/World/Radar", "OmniRadar")
    product = render_product(app, "/World/Lidar")
    product.camera_path = "/World/Radar"
    inputs = {"renderProductPath": product.path}
    with pytest.raises(ComputeError, match="/World/Radar is OmniRadar; it reads OmniLidar only") as caught:
        run_node(kind, inputs=inputs, pulses={"exec": [0]}, updates=1, app=app)
    assert "/test/node" in str(caught.value)


def test_an_annotator_without_product_or_frame_is_an_error(lidar, world):
    lidar()
    for inputs, message in (
        ({}, "no frame to read; connect renderProductPath"),
        ({"renderProductPath": "/Render/Gone"}, "there is no render product /Render/Gone"),
        ({"dataPtr": 2**60}, "input dataPtr is not a handle of a frame"),
        ({"cudaDeviceIndex": 0}, "frames are in host memory"),
    ):
        with pytest.raises(ComputeError, match=message):
            run_node(FLAT, inputs=inputs, pulses={"exec": [0]}, app=world())


def test_demand_and_handles_end_with_a_stop(lidar, world, runner):
    lidar()
    app = world(physics_hz=240)
    product = render_product(app, "/World/Lidar")
    node = runner(app, {"buffer": (BUFFER, {"outputDistance": True})})["buffer"]
    app.update(7)
    handle = node.get("outputs:distancePtr")
    assert resolve(handle) is not None
    assert {"xyz", "distance"} <= product.sensor.channels()
    app.stop()
    assert resolve(handle) is None
    assert product.sensor.channels() == frozenset()


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"horizontalFov": 0}, "horizontalFov is 0 deg"),
        ({"horizontalResolution": -1}, "horizontalResolution is -1 deg"),
        ({"numRows": 2}, "numRows is 2; a laser scan has 1 row"),
        ({"numCols": 3}, "linearDepthData has 2 values for 3 columns"),
        ({"intensitiesData": [1]}, "intensitiesData has 1 values for 2 beams"),
    ],
)
def test_a_row_that_is_not_a_scan_is_refused(world, changes, message):
    row = {"horizontalFov": 90, "horizontalResolution": 45, "numRows": 1, "numCols": 2, "linearDepthData": [1.0, -1.0]}
    with pytest.raises(ComputeError, match=message):
        run_node("ROS2PublishLaserScan", inputs=row | changes, pulses={"execIn": [0]}, app=world())


def test_a_row_without_intensities_has_255_where_there_is_a_range(world):
    app = world()
    row = {"horizontalFov": 90, "horizontalResolution": 45, "numRows": 1, "numCols": 2, "linearDepthData": [1.0, -1.0]}
    run_node("ROS2PublishLaserScan", inputs=row, pulses={"execIn": [0]}, app=app)
    message = app.sink["/scan"][0].message
    assert message.intensities.tolist() == [255, 0]
    assert message.ranges.tolist() == [1, math.inf]


def test_points_can_be_given_as_an_array(world):
    app = world()
    run_node("ROS2PublishPointCloud", inputs={"data": [[1.0, 2.0, 3.0]]}, pulses={"execIn": [0]}, app=app)
    message = app.sink["/point_cloud"][0].message
    assert np.frombuffer(message.data.tobytes(), "<f4").tolist() == [1, 2, 3]
