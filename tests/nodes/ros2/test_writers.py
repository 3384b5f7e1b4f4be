"""Writers of Replicator that publish: by the product's names, with the options of its scripts."""

import json

import numpy as np
import pytest

import sensors.replicator as rep
from graph.sim import App
from graph.sim.messages.bus import MemorySink
from sensors.configs.catalog import find
from sensors.errors import SensorValueError
from sensors.lidar.prim import write_config

PRIMS = {
    "/World/Wall": {"type": "Cube", "size": 2.0, "translate": [6, 0, 0], "semantics": {"class": "wall"}},
    "/World/Radar": {"type": "OmniRadar", "attributes": {"omni:sensor:tickRate": 10}},
    "/World/Camera": {"type": "Camera", "rotate": [90, 0, -90]},
}
STABLE_IDS = "/rtx-transient/stableIds/enabled"


@pytest.fixture
def app():
    with App(None, physics_hz=60, loop_hz=60, settings={STABLE_IDS: True}) as app:
        app.add_prims(PRIMS)
        write_config(app.stage.DefinePrim("/World/Lidar", "OmniLidar"), find("RPLIDAR_S2E"))
        app.sink = MemorySink()
        app.bus.subscribe(app.sink)
        yield app


def publish(app, name, prim, updates=7, topic="found", **options):
    """The messages of a writer on its topic."""
    product = rep.create.render_product(prim, (64, 48))
    writer = rep.writers.get(name)
    writer.initialize(topicName=topic, **options)
    writer.attach([product])
    app.play()
    app.update(updates)
    return [one.message for one in app.sink[f"/{topic}"]]


@pytest.mark.parametrize("name", ["RtxLidarROS2PublishPointCloud", "RtxLidarROS2PublishPointCloudBuffer"])
def test_a_cloud_has_the_fields_that_are_asked_for(app, name):
    [cloud] = publish(app, name, "/World/Lidar", frameId="base_scan", outputIntensity=True, outputObjectId=True)
    assert [one.name for one in cloud.fields][:4] == ["x", "y", "z", "intensity"]
    assert (cloud.header.frame_id, cloud.header.stamp.nanosec) == ("base_scan", 100_000_000)
    assert cloud.width > 100


def test_a_laser_scan_has_its_beams(app):
    [scan] = publish(app, "RtxLidarROS2PublishLaserScan", "/World/Lidar", frameId="scan")
    assert len(scan.ranges) == 3200
    assert scan.ranges[0] == pytest.approx(5.0, abs=1e-5)


def test_a_laser_scan_has_the_columns_that_a_script_gives(app):
    """The wall's face is at x = 5 m: 5 m ahead, in column (0 + 180) / 1 of 360, and 5 / cos(10 deg) at 10 deg."""
    geometry = {"horizontalFov": 360.0, "horizontalResolution": 1.0, "azimuthRange": [-180.0, 180.0]}
    more = {"depthRange": [0.5, 20.0], "rotationRate": 10.0}
    [scan] = publish(app, "RtxLidarROS2PublishLaserScan", "/World/Lidar", frameId="scan", **geometry, **more)
    assert len(scan.ranges) == len(scan.intensities) == 360
    assert (scan.angle_min, scan.angle_increment) == pytest.approx((-np.pi, np.pi / 180))
    assert (scan.range_min, scan.range_max) == (0.5, 20.0)
    assert scan.scan_time == pytest.approx(0.1)
    assert scan.ranges[180] == pytest.approx(5.0, abs=1e-3)
    assert 5 / np.cos(np.radians(10)) <= scan.ranges[190] <= 5 / np.cos(np.radians(11))
    assert np.isinf(scan.ranges[0])


def test_a_radar_publishes_its_detections(app):
    [cloud] = publish(app, "RtxRadarROS2PublishPointCloud", "/World/Radar", outputIntensity=True)
    assert [one.name for one in cloud.fields] == ["x", "y", "z", "intensity"]
    assert cloud.width > 0


@pytest.mark.parametrize(
    ("name", "encoding"),
    [
        ("LdrColorROS2PublishImage", "rgb8"),
        ("DistanceToImagePlaneSDROS2PublishImage", "32FC1"),
        ("ROS2PublishSemanticSegmentation", "32SC1"),
        ("ROS2PublishInstanceSegmentation", "32SC1"),
    ],
)
def test_images_of_a_camera(app, name, encoding):
    images = publish(app, name, "/World/Camera", 2, frameId="camera")
    assert [(one.encoding, one.width, one.height, one.header.frame_id) for one in images] == [
        (encoding, 64, 48, "camera")
    ] * 2


def test_a_depth_cloud_of_a_camera(app):
    cloud, _ = publish(app, "DistanceToImagePlaneSDROS2PublishPointCloud", "/World/Camera", 2)
    points = np.frombuffer(cloud.data.tobytes(), "<f4").reshape(48, 64, 3)
    assert points[24, 32, 2] == pytest.approx(5.0, abs=1e-5)


@pytest.mark.parametrize("name", ["BoundingBox2DTight", "BoundingBox2DLoose", "BoundingBox3D"])
def test_boxes_of_a_camera_and_their_labels(app, name):
    boxes, _ = publish(app, f"ROS2Publish{name}", "/World/Camera", 2)
    assert len(boxes.detections) == 1
    app.stop()
    labels = publish(app, f"{name}SDROS2PublishSemanticLabels", "/World/Camera", 1, "labels")[-1]
    assert json.loads(labels.data)["0"] == {"class": "wall"}


def test_the_lens_of_a_camera_or_what_a_script_gives(app):
    info, _ = publish(app, "ROS2PublishCameraInfo", "/World/Camera", 2, frameId="camera")
    assert info.k[0] == pytest.approx(64 * 50 / 20.955, rel=1e-6)
    app.stop()
    given = [100.0, 0, 32, 0, 110, 24, 0, 0, 1]
    options = {"width": 64, "height": 48, "k": given, "physicalDistortionCoefficients": [0.1, 0, 0, 0, 0]}
    info = publish(app, "ROS2PublishCameraInfo", "/World/Camera", 1, **options)[-1]
    assert (info.k.tolist(), info.d.tolist()) == (given, [0.1, 0, 0, 0, 0])
    assert info.p.tolist() == [100, 0, 32, 0, 0, 110, 24, 0, 0, 0, 1, 0]


def test_the_map_of_object_ids(app):
    [found] = publish(app, "ROS2PublishObjectIdMap", "/World/Lidar")
    assert "/World/Wall" in json.loads(found.data)["id_to_labels"].values()


def test_system_time_stamps_with_the_wall_clock(app):
    image, _ = publish(app, "LdrColorROS2SystemTimePublishImage", "/World/Camera", 2)
    assert image.header.stamp.sec != 0 or image.header.stamp.nanosec != 16_666_667


def test_a_detached_writer_publishes_no_more_and_can_be_attached_again(app):
    product = rep.create.render_product("/World/Camera", (64, 48))
    writer = rep.writers.get("LdrColorROS2PublishImage", {"topicName": "found"}).attach([product])
    app.play()
    app.update(2)
    writer.detach()
    app.update(2)
    assert len(app.sink["/found"]) == 2
    assert not product.writers
    writer.attach([product])
    app.update(1)
    assert len(app.sink["/found"]) == 3


@pytest.mark.parametrize(
    ("name", "prim", "options", "said"),
    [
        ("RtxLidarROS2PublishPointCloud", "/World/Camera", {}, "it is of another type"),
        ("LdrColorROS2PublishImage", "/World/Lidar", {}, "it is of another type"),
        ("RtxLidarROS2PublishPointCloud", "/World/Lidar", {"outputIntesity": True}, 'did you mean "outputIntensity"'),
        ("RtxLidarROS2PublishPointCloud", "/World/Lidar", {"topicName": "1 2"}, "is not a ROS 2 topic name"),
        ("RtxLidarROS2PublishLaserScan", "/World/Lidar", {"horizontalFov": 90.0}, "horizontalResolution is 0 deg"),
        (
            "RtxLidarROS2PublishLaserScan",
            "/World/Lidar",
            {"horizontalFov": 9.0, "horizontalResolution": 1e-9},
            "at most",
        ),
        ("ROS2PublishCameraInfo", "/World/Camera", {"k": [1.0]}, "k has 1 values; it needs 9"),
    ],
)
def test_mistakes_are_one_line(app, name, prim, options, said):
    product = rep.create.render_product(prim, (64, 48))
    with pytest.raises(SensorValueError, match=said):
        rep.writers.get(name, options).attach([product])
    assert not product.writers


def test_all_are_listed():
    names = {"RtxLidarROS2PublishPointCloud", "ROS2PublishObjectIdMap", "BoundingBox3DSDROS2PublishSemanticLabels"}
    assert names <= set(rep.WriterRegistry.get_writers())
    with pytest.raises(SensorValueError, match='did you mean "RtxLidarROS2PublishLaserScan"'):
        rep.writers.get("RtxLidarROS2PublishLaserscan")
