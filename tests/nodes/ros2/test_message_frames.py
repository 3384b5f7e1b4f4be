"""Every lidar message, by motion, frame of reference and mount: a consumer that puts it into the world by TF as of its
header and by the times of its rays gets the world's points.

The room has its walls at x = +-8 m and y = +-6 m. The mount drifts at 1.1 m/s and turns at 40 deg/s (0.698 rad/s), or
stands; its lidar turns at 10 Hz, 0.3 m before the mount's origin. Bounds [m], for points up to 10.6 m away:

- TF between its messages at 60 Hz is a chord of the arc on which the lidar moves: v w dt^2 / 8 = 2.7e-5; the rest is
  float32 and the physics' own chords at 240 Hz: 1e-4 in all.
- `continuous`: each ray at its own time, which a float32 of seconds holds to 4e-9 s: 1e-4 as well.
- `update`: each ray with the world up to an update later: (v + w r) / 60 = 0.142.
- A mount that stands: float32 alone, 1e-5.
"""

from types import SimpleNamespace

import numpy as np
import pytest

from tests.support.consumers import columns, placed, seconds, xyz

WORLD = """\
tickgraph: 1
scene:
  prims:
    /World/Physics: {{type: PhysicsScene, attributes: {{"physics:gravityMagnitude": 1e-12}}}}
    /World/East: {{type: Cube, size: 2, scale: [1, 20, 20], translate: [9, 0, 0]}}
    /World/West: {{type: Cube, size: 2, scale: [1, 20, 20], translate: [-9, 0, 0]}}
    /World/North: {{type: Cube, size: 2, scale: [20, 1, 20], translate: [0, 7, 0]}}
    /World/South: {{type: Cube, size: 2, scale: [20, 1, 20], translate: [0, -7, 0]}}
    /World/Robot: {{type: Cube, size: 0.5, translate: [-1, 0, 0], rotate: [0, 0, 20]{body}}}
    /World/Robot/Lidar:
      type: OmniLidar
      config: RPLIDAR_S2E
      translate: [0.3, 0, 0]
      exclude: [/World/Robot]
      attributes: {{"omni:sensor:tickRate": 10{attributes}}}
clock: {{physics_hz: 240, loop_hz: 60}}
fidelity: {{lidar.motion: {motion}}}
graphs:
  /G:
    nodes:
      tick: OnPlaybackTick
      time: IsaacReadSimulationTime
      tf: {{type: ROS2PublishTransformTree, inputs: {{targetPrims: [/World/Robot/Lidar]}}}}
      product: {{type: IsaacCreateRenderProduct, inputs: {{cameraPrim: /World/Robot/Lidar}}}}
      lidar: {{type: ROS2RtxLidarHelper, inputs: {{topicName: lidar, {inputs}}}}}
    connections:
      - tick.tick -> [tf.execIn, product.execIn]
      - time.simulationTime -> tf.timeStamp
      - product.execOut -> lidar.execIn
      - product.renderProductPath -> lidar.renderProductPath
"""
MOVES = ", rigid_body: true, mass: 1, velocity: [1.1, 0, 0], angular_velocity: [0, 0, 40]"
CORE = "omni:sensor:Core:"
TRAFO = [0.5, -0.2, 1.5, 0.0, 0.0, 90.0]
SENSOR: dict = {}
IN_WORLD = {"outputFrameOfReference": "WORLD"}
CUSTOM = {"outputFrameOfReference": "CUSTOM", "customFrameOfReferenceTrafo": TRAFO}
COMPENSATED = {"outputMotionCompensationState": "COMPENSATED"}
SECTORS = {
    "whole": {},
    "behind": {"validStartAzimuthDeg": 120, "validEndAzimuthDeg": 240},
    "ahead": {"validStartAzimuthDeg": 300, "validEndAzimuthDeg": 60},  # passed at both ends of a turn
}


@pytest.fixture
def drive(tmp_path):
    """A function: runs the world for a second; returns the App with its memory sink."""
    from graph.sim import App
    from graph.sim.messages.bus import MemorySink

    opened = []

    def run(motion="frozen", attributes=SENSOR, inputs="", *, moves=True, parity="documented"):
        path = tmp_path / "drive.yaml"
        more = "".join(f', "{CORE}{name}": {value}' for name, value in attributes.items())
        text = WORLD.format(motion=motion, attributes=more, inputs=inputs, body=MOVES if moves else "")
        path.write_text(text.replace("loop_hz: 60", f"loop_hz: 60, parity: {parity}"))
        app = App.from_file(path)
        opened.append(app)
        app.sink = MemorySink()
        app.bus.subscribe(app.sink)
        app.play()
        app.update(60)
        return app

    yield run
    for app in opened:
        app.close()


def in_the_world(app, header, points, at):
    """(n, 3) points in the world; the consumer knows the custom frame as a static transform of the sensor's."""
    if header.frame_id == "Custom":
        x, y, z, *_ = TRAFO
        points = np.stack([points[:, 1] - y, x - points[:, 0], points[:, 2] - z], axis=1)  # -90 deg about z
        header = SimpleNamespace(frame_id="Lidar")
    return placed(app.sink, header, points, at)


def off_the_walls(found):
    """How far [m] the worst of points (n, 3) is off the walls."""
    return float(np.minimum(np.abs(np.abs(found[:, 0]) - 8), np.abs(np.abs(found[:, 1]) - 6)).max())


def worst_of_clouds(app, *, by_time):
    """Of all clouds; by_time: points are placed as of header + time, else as of the header."""
    worst, count = 0.0, 0
    for one in app.sink["/lidar"]:
        cloud = one.message
        data = columns(cloud)
        points = xyz(data)
        at = np.full(len(data), seconds(cloud.header.stamp)) + (data["time"].astype(float) if by_time else 0.0)
        found = in_the_world(app, cloud.header, points, at)
        if found is not None:
            worst, count = max(worst, off_the_walls(found)), count + len(found)
    assert count > 3000
    return worst


def worst_of_scans(app):
    """Of all laser scans, beam i as of header + i x time_increment."""
    worst, count = 0.0, 0
    for one in app.sink["/lidar"]:
        scan = one.message
        hit = np.flatnonzero(np.isfinite(scan.ranges))
        angle, ranges = scan.angle_min + hit * scan.angle_increment, scan.ranges[hit].astype(float)
        points = np.stack([ranges * np.cos(angle), ranges * np.sin(angle), 0 * angle], axis=1)
        found = in_the_world(app, scan.header, points, seconds(scan.header.stamp) + hit * scan.time_increment)
        if found is not None:
            worst, count = max(worst, off_the_walls(found)), count + len(found)
    assert count > 3000
    return worst


BOUND = {"frozen": 1e-4, "continuous": 1e-4, "update": 0.142}


@pytest.mark.parametrize("moves", [True, False])
@pytest.mark.parametrize("motion", BOUND)
@pytest.mark.parametrize(
    ("attributes", "frame_id"),
    [(SENSOR, "Lidar"), (IN_WORLD, "Lidar"), (IN_WORLD, "world"), (CUSTOM, "Custom"), (COMPENSATED, "Lidar")],
    ids=["sensor", "world", "fixed", "custom", "compensated"],
)
def test_clouds_lie_on_the_walls(drive, motion, attributes, frame_id, moves):
    time = motion != "frozen" or attributes is COMPENSATED
    metadata = ", selectedMetadata: [Time]" if time else ""
    app = drive(motion, attributes, f"type: point_cloud, frameId: {frame_id}{metadata}", moves=moves)
    assert worst_of_clouds(app, by_time=time) <= (BOUND[motion] if moves else 1e-5)


@pytest.mark.parametrize("attributes", [SENSOR, COMPENSATED], ids=["sensor", "compensated"])
def test_clouds_of_a_driver_lie_on_the_walls(drive, attributes):
    """Stamped with the start of the scan, from which their times count."""
    app = drive("continuous", attributes, "type: point_cloud, frameId: Lidar, fields: velodyne")
    assert worst_of_clouds(app, by_time=True) <= 1e-4


@pytest.mark.parametrize("moves", [True, False])
@pytest.mark.parametrize("sector", SECTORS)
@pytest.mark.parametrize("motion", BOUND)
def test_laser_scans_lie_on_the_walls(drive, motion, sector, moves):
    """The header is the time of the first cell: a sector's, not the start of the turn, which is up to v T / 3 off."""
    app = drive(motion, SECTORS[sector], "frameId: Lidar", moves=moves)
    assert worst_of_scans(app) <= (BOUND[motion] if moves else 1e-5)


@pytest.mark.parametrize("motion", ["frozen", "continuous"])
@pytest.mark.parametrize("attributes", [IN_WORLD, CUSTOM, COMPENSATED], ids=["world", "custom", "compensated"])
def test_laser_scans_are_in_the_sensors_frame_in_whatever_frame_it_gives_points(drive, motion, attributes):
    assert worst_of_scans(drive(motion, attributes, "frameId: Lidar")) <= 1e-4


def test_the_times_of_compensated_points_are_those_of_their_common_pose(drive):
    """The header of a scan over time is its end, as the pose to which its points are moved."""
    app = drive("continuous", COMPENSATED, "type: point_cloud, frameId: Lidar, selectedMetadata: [Time]")
    data = np.frombuffer(app.sink["/lidar"][3].message.data.tobytes(), "<f4").reshape(-1, 4)
    assert np.unique(data[:, 3]).tolist() == [0.0]


@pytest.mark.parametrize(
    ("attributes", "frame_id", "header", "codes"),
    [
        (IN_WORLD, "Lidar", "world", ["frame-id-not-world"]),
        (IN_WORLD, "Robot", "world", ["frame-id-not-world"]),
        (IN_WORLD, "sim_lidar", "world", ["frame-id-not-world"]),
        (IN_WORLD, "site", "site", ["frame-id-not-world"]),
        (IN_WORLD, "map", "map", []),
        (CUSTOM, "Lidar", "Lidar", ["frame-id-not-custom"]),
        (CUSTOM, "base_link", "base_link", []),
        (SENSOR, "anything", "anything", []),
    ],
)
def test_the_header_names_the_frame_of_its_points_and_a_wrong_id_is_reported(
    drive, attributes, frame_id, header, codes
):
    app = drive("frozen", attributes, f"type: point_cloud, frameId: {frame_id}", moves=False)
    assert {one.message.header.frame_id for one in app.sink["/lidar"]} == {header}
    assert [one.code for one in app.warnings] == codes


def test_the_products_profile_takes_the_id_as_it_is(drive):
    app = drive("frozen", IN_WORLD, "type: point_cloud, frameId: Lidar", moves=False, parity="isaacsim-6.0.1")
    assert {one.message.header.frame_id for one in app.sink["/lidar"]} == {"Lidar"}
    assert not [one for one in app.warnings if one.code.startswith("frame-id")]
