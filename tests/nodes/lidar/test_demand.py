"""A lidar casts only where its scans are read: by a node, a listener, a sink, a tool or a program."""

import pytest

from graph.session.runner import graphs_of
from graph.sim import App
from graph.sim.messages.bus import MemorySink
from sensors.raycast.triangles import TriangleScene
from tests.support.without_wing import needs_wing

POINT_CLOUD = "sensor_msgs/msg/PointCloud2"
FILE = """\
tickgraph: 1
scene:
  prims:
    /World/Wall: {type: Cube, size: 1.0, translate: [3, 0, 0]}
    /World/Lidar: {type: OmniLidar, config: Example_Rotary}
graphs:
  /World/G:
    nodes:
      tick: OnPlaybackTick
      product: {type: IsaacCreateRenderProduct, inputs: {cameraPrim: /World/Lidar}}
      cloud: {type: ROS2RtxLidarHelper, inputs: {type: point_cloud, topicName: points}}
    connections:
      - tick.tick -> product.execIn
      - product.execOut -> cloud.execIn
      - product.renderProductPath -> cloud.renderProductPath
  /World/Scan:
    pipeline_stage: post_render
    nodes:
      extract: OgnIsaacExtractRTXSensorPointCloud
      size: {type: omni.graph.nodes.Add}
      extracted: {type: ROS2PublishPointCloud, inputs: {topicName: extracted}}
      MORE
    connections:
      - /World/G/product.outputs:renderProductPath -> extract.renderProductPath
      - extract.exec -> extracted.execIn
      - extract.dataPtr -> extracted.dataPtr
      - extract.bufferSize -> size.a
      - extract.bufferSize -> size.b
      - size.sum -> extracted.bufferSize
      LINKS
"""
IDLE = FILE.replace("      MORE\n", "").replace("      LINKS\n", "")
COUNTED = FILE.replace("MORE", "counter: omni.graph.action.Counter").replace(
    "LINKS", "- extract.exec -> counter.execIn"
)


@pytest.fixture
def casts(monkeypatch):
    """How many rays each cast had."""
    found, plain = [], TriangleScene.cast

    def counting(self, rays, threads, **options):
        found.append(len(rays))
        return plain(self, rays, threads, **options)

    monkeypatch.setattr(TriangleScene, "cast", counting)
    return found


def opened(tmp_path, text, motion):
    path = tmp_path / "g.yaml"
    path.write_text(text)
    return App.from_file(path, fidelity={"lidar.motion": motion})


def points_of(app):
    [product] = app.rendering.products.values()
    return product.elements


MOTIONS = pytest.mark.parametrize("motion", ["frozen", "update", "continuous"])


@MOTIONS
def test_where_no_topic_has_a_listener_a_lidar_casts_nothing(casts, tmp_path, motion):
    with opened(tmp_path, IDLE, motion) as app:
        app.play()
        app.update(steps=18)
        assert (len(casts), points_of(app)) == (0, 0)


@MOTIONS
@pytest.mark.parametrize("topic", ["/points", "/extracted"])
def test_a_listener_of_one_topic_has_the_lidar_cast_and_one_that_ends_has_it_rest(casts, tmp_path, motion, topic):
    with opened(tmp_path, IDLE, motion) as app:
        app.play()
        app.update(steps=6)
        subscription = app.bus.listen(topic, POINT_CLOUD)
        app.update(steps=12)
        assert casts
        assert subscription.take() is not None
        app.bus.unlisten(subscription)
        app.update(steps=1)
        casts.clear()
        app.update(steps=12)
        assert casts == []


@pytest.mark.parametrize("reader", ["sink", "node", "program", "tool"])
def test_a_sink_a_node_a_program_and_a_tool_each_count_as_a_reader(casts, tmp_path, reader):
    with opened(tmp_path, COUNTED if reader == "node" else IDLE, "frozen") as app:
        graph = graphs_of(app).get("/World/Scan")
        app.play()
        if reader == "sink":
            app.bus.subscribe(MemorySink())
        elif reader == "program":
            assert graph.node("extract").get("outputs:bufferSize") == 0
        elif reader == "tool":
            graph.observe(lambda node, compute: compute)
        app.update(steps=12)
        assert casts
        assert points_of(app) > 0
        if reader == "program":
            assert graph.node("extract").get("outputs:bufferSize") > 0


POLLED = """\
tickgraph: 1
scene:
  prims:
    /World/Ground: {type: Plane}
    /World/Wall: {type: Cube, size: 1.0, translate: [3, 0, 0]}
    /World/Sensor: {type: KIND, attributes: {ATTRIBUTES}}
graphs:
  /World/G:
    nodes:
      tick: OnPlaybackTick
      read: {type: NODE, inputs: {INPUT: [/World/Sensor]}}
      clock: {type: ROS2PublishClock, inputs: {topicName: clock}}
    connections:
      - tick.tick -> read.execIn
      - read.execOut -> clock.execIn
"""


@pytest.mark.parametrize(
    ("kind", "attributes", "node", "name"),
    [
        pytest.param("Lidar", "rotationRate: 0", "IsaacReadLidarPointCloud", "lidarPrim", marks=needs_wing("physx")),
        pytest.param("Lidar", "rotationRate: 0", "IsaacReadLidarBeams", "lidarPrim", marks=needs_wing("physx")),
        pytest.param(
            "IsaacLightBeamSensor", "numRays: 3", "IsaacReadLightBeam", "lightbeamPrim", marks=needs_wing("physx")
        ),
        (
            "IsaacRaycastSensor",
            "numRays: 1, rayDirections: [[1, 0, 0]], rayOrigins: [[0, 0, 0]]",
            "IsaacReadRaycastSensor",
            "raycastSensorPrim",
        ),
    ],
)
def test_a_sensor_that_a_node_polls_casts_only_while_somebody_reads_what_the_node_gives(
    casts, tmp_path, kind, attributes, node, name
):
    text = POLLED.replace("KIND", kind).replace("ATTRIBUTES", attributes).replace("NODE", node).replace("INPUT", name)
    with opened(tmp_path, text, "frozen") as app:
        app.play()
        app.update(steps=3)
        assert casts == []
        subscription = app.bus.listen("/clock", "rosgraph_msgs/msg/Clock")
        app.update(steps=3)
        assert casts
        assert subscription.take() is not None
        app.bus.unlisten(subscription)
        casts.clear()
        app.update(steps=3)
        assert casts == []
