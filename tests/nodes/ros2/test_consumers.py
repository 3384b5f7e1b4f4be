"""Messages of radar, camera, IMU and odometry on a body that drifts and tumbles: a consumer that places what they say
by TF, as of their headers, finds three steel balls where they stand.

The body drifts at 1.1 m/s and turns at (8, -5, 40) deg/s, w = 0.717 rad/s, or stands; its sensors are 0.3 m before its
origin. A header that is one update of 1/60 s off displaces a ball 8 m away by (v + w r) / 60 = 0.11 m. Bounds: TF
between its messages is a chord, v w dt^2 / 8 = 3e-5 m, and points are float32: 1e-4 m; a radar places the glint of a
ball to 5 mm.
"""

import numpy as np
import pytest

from tests.support.consumers import columns, placed, poses, seconds, xyz

WORLD = """\
tickgraph: 1
scene:
  prims:
    /World/Physics: {{type: PhysicsScene, attributes: {{"physics:gravityMagnitude": 1e-12}}}}
    /World/A: {{type: Sphere, radius: 0.2, material: steel, semantics: a, translate: [7, 2.5, 0.3]}}
    /World/B: {{type: Sphere, radius: 0.2, material: steel, semantics: b, translate: [8, 5, -0.4]}}
    /World/C: {{type: Sphere, radius: 0.2, material: steel, semantics: c, translate: [5, 4.5, 0.1]}}
    /World/Robot: {{type: Cube, size: 0.1, translate: [-1, 0, 0], rotate: [0, 0, 10]{body}}}
    /World/Robot/Radar:
      type: OmniRadar
      translate: [0.3, 0, 0]
      exclude: [/World/Robot]
      aux_output_level: BASIC
      attributes:
        "omni:sensor:tickRate": {rate}
        "omni:sensor:WpmDmat:antennaGainMode": CONSTANT
        "omni:sensor:WpmDmat:scan:s001:elevMode": FULL_EL
        "omni:sensor:WpmDmat:scan:s001:maxAzAngDeg": 60.0
        "omni:sensor:WpmDmat:scan:s001:maxElAngDeg": 12.0
        "omni:sensor:WpmDmat:scan:s001:raysPerDeg": 2.0
        {reference}
    /World/Robot/Camera:
      type: Camera
      translate: [0.3, 0, 0]
      rotate: [90, 0, -90]
      schemas: [OmniSensorAPI]
      attributes: {{focalLength: 12.0, clippingRange: [0.05, 100], "omni:sensor:tickRate": {rate}}}
clock: {{physics_hz: 240, loop_hz: 60}}
graphs:
  /G:
    nodes:
      tick: OnPlaybackTick
      time: IsaacReadSimulationTime
      targets: {{type: ROS2PublishTransformTree,
        inputs: {{targetPrims: [/World/Robot, /World/Robot/Radar, /World/Robot/Camera]}}}}
      echoes: {{type: IsaacCreateRenderProduct, inputs: {{cameraPrim: /World/Robot/Radar}}}}
      radar: {{type: ROS2RtxRadarHelper, inputs: {{topicName: radar, outputRadialVelocityMS: true, frameId: {frame}}}}}
      pictures: {{type: IsaacCreateRenderProduct, inputs: {{cameraPrim: /World/Robot/Camera, width: 160, height: 60}}}}
      lens: {{type: ROS2CameraInfoHelper, inputs: {{topicName: lens, frameId: Camera}}}}
      depth: {{type: ROS2CameraHelper, inputs: {{type: depth, topicName: depth, frameId: Camera}}}}
      cloud: {{type: ROS2CameraHelper, inputs: {{type: depth_pcl, topicName: cloud, frameId: Camera}}}}
      tight: {{type: ROS2CameraHelper, inputs: {{type: bbox_2d_tight, topicName: flat, frameId: Camera}}}}
      space: {{type: ROS2CameraHelper, inputs: {{type: bbox_3d, topicName: boxes, frameId: Camera}}}}
      odometry: {{type: IsaacComputeOdometry, inputs: {{chassisPrim: /World/Robot}}}}
      odom: {{type: ROS2PublishOdometry, inputs: {{chassisFrameId: Robot}}}}
      inertia: {{type: IsaacReadIMU, inputs: {{imuPrim: /World/Robot/Radar, readGravity: false}}}}
      imu: {{type: ROS2PublishImu, inputs: {{frameId: Radar}}}}
    connections:
      - tick.tick -> [targets.execIn, echoes.execIn, pictures.execIn, odometry.execIn, inertia.execIn]
      - time.simulationTime -> [targets.timeStamp, odom.timeStamp, imu.timeStamp]
      - echoes.execOut -> radar.execIn
      - echoes.renderProductPath -> radar.renderProductPath
      - pictures.execOut -> [lens.execIn, depth.execIn, cloud.execIn, tight.execIn, space.execIn]
      - pictures.renderProductPath -> [lens.renderProductPath, depth.renderProductPath, cloud.renderProductPath]
      - pictures.renderProductPath -> [tight.renderProductPath, space.renderProductPath]
      - odometry.execOut -> odom.execIn
      - odometry.position -> odom.position
      - odometry.orientation -> odom.orientation
      - odometry.linearVelocity -> odom.linearVelocity
      - odometry.angularVelocity -> odom.angularVelocity
      - inertia.execOut -> imu.execIn
      - inertia.orientation -> imu.orientation
      - inertia.linAcc -> imu.linearAcceleration
      - inertia.angVel -> imu.angularVelocity
"""
RESTS = ", rigid_body: true, mass: 1"
MOVES = RESTS + ", velocity: [1.1, 0, 0], angular_velocity: [8, -5, 40]"
BALLS = np.array([[7, 2.5, 0.3], [8, 5, -0.4], [5, 4.5, 0.1]])
RADIUS = 0.2
TRAFO = [0.5, -0.2, 1.5, 0.0, 0.0, 90.0]
CORE = '"omni:sensor:WpmDmat:outputFrameOfReference"'
REFERENCES = {
    "SENSOR": ("", "Radar"),
    "WORLD": (f"{CORE}: WORLD", "world"),
    "CUSTOM": (f'{CORE}: CUSTOM\n        "omni:sensor:WpmDmat:customFrameOfReferenceTrafo": {TRAFO}', "Custom"),
}
RATES = (20, 13)
"""Ticks on updates, and between them."""


@pytest.fixture(scope="module")
def driven(tmp_path_factory):
    """A function: the messages of a second of the world, run once for each setting."""
    from graph.sim import App
    from graph.sim.messages.bus import MemorySink

    sinks = {}

    def run(moves=True, rate=20, reference="SENSOR"):
        if (moves, rate, reference) not in sinks:
            path = tmp_path_factory.mktemp("drive") / "drive.yaml"
            authored, frame = REFERENCES[reference]
            path.write_text(WORLD.format(body=MOVES if moves else RESTS, rate=rate, reference=authored, frame=frame))
            with App.from_file(path) as app:
                sinks[moves, rate, reference] = sink = MemorySink()
                app.bus.subscribe(sink)
                app.play()
                app.update(60)
        return sinks[moves, rate, reference]

    return run


def at(header, count=1):
    return np.full(count, seconds(header.stamp))


def to_balls(points):
    """(n,) distances of points (n, 3) from the centre of the nearest ball, and its number."""
    apart = np.linalg.norm(points[:, None] - BALLS, axis=2)
    return apart.min(axis=1), apart.argmin(axis=1)


def velocity(sink, frame, time):
    """(3,) the velocity of a frame in the world, from TF half an update before and after."""
    _, before = poses(sink, frame, np.array([time - 1 / 120]))
    _, after = poses(sink, frame, np.array([time + 1 / 120]))
    return None if before is None or after is None else (after[0] - before[0]) * 60


def turn_rate(sink, frame, time):
    """(3,) the turn rate of a frame about its own axes [rad/s], from TF an update before and after."""
    before, _ = poses(sink, frame, np.array([time - 1 / 60]))
    after, _ = poses(sink, frame, np.array([time + 1 / 60]))
    if before is None or after is None:
        return None
    turn = before[0].T @ after[0]
    return np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]]) / 2 * 30


@pytest.mark.parametrize("moves", [True, False], ids=["moves", "stands"])
@pytest.mark.parametrize("rate", RATES)
@pytest.mark.parametrize("reference", REFERENCES)
def test_detections_of_a_radar_are_at_the_balls_with_their_velocity(driven, moves, rate, reference):
    """A detection is the glint of a ball, its radius before the centre; what stands comes nearer by the radar's own
    velocity along the beam."""
    sink = driven(moves, rate, reference)
    found = []
    for one in sink["/radar"]:
        header, data = one.message.header, columns(one.message)
        points = xyz(data)
        assert header.frame_id == REFERENCES[reference][1]
        if reference == "CUSTOM":  # which the consumer knows as a static transform of the radar's
            x, y, z, *_ = TRAFO
            points = np.stack([points[:, 1] - y, x - points[:, 0], points[:, 2] - z], axis=1)  # -90 deg about z
            header.frame_id = "Radar"
        world = placed(sink, header, points, at(header, len(points)))
        moving = velocity(sink, "Radar", seconds(header.stamp))
        if world is None or moving is None:
            continue
        _, (origin,) = poses(sink, "Radar", at(header))
        _, ball = to_balls(world)
        beams = BALLS[ball] - origin
        ways = np.linalg.norm(beams, axis=1)
        assert np.linalg.norm(world - (BALLS[ball] - RADIUS * beams / ways[:, None]), axis=1).max() < 0.005
        assert np.abs(data["radial_velocity_ms"] + (beams / ways[:, None]) @ moving).max() < 0.02
        found += ball.tolist()
    assert set(found) == {0, 1, 2}
    assert len(found) > 2.5 * (rate - 3)


@pytest.mark.parametrize("moves", [True, False], ids=["moves", "stands"])
@pytest.mark.parametrize("rate", RATES)
def test_depths_of_a_camera_are_on_the_balls(driven, moves, rate):
    """As a cloud, and as an image with the lens of its CameraInfo: x = (u + 1/2 - c_x) z / f_x."""
    sink = driven(moves, rate)
    lenses = {seconds(one.message.header.stamp): one.message for one in sink["/lens"]}
    images = {seconds(one.message.header.stamp): one.message for one in sink["/depth"]}
    count = 0
    for one in sink["/cloud"]:
        cloud = one.message
        points = xyz(columns(cloud))
        seen = np.isfinite(points[:, 2])
        lens, image = lenses[seconds(cloud.header.stamp)], images[seconds(cloud.header.stamp)]
        assert cloud.header == lens.header == image.header
        depth = np.frombuffer(image.data.tobytes(), "<f4").astype(float)
        rows, across = np.divmod(np.arange(len(depth)), image.width)
        f_x, c_x, f_y, c_y = lens.k[[0, 2, 4, 5]]
        of_image = np.stack([(across + 0.5 - c_x) / f_x, (rows + 0.5 - c_y) / f_y, np.ones(len(depth))], axis=1)
        np.testing.assert_allclose(of_image[seen] * depth[seen, None], points[seen], atol=1e-5)
        world = placed(sink, cloud.header, points[seen], at(cloud.header, int(seen.sum())))
        if world is not None:
            assert np.abs(to_balls(world)[0] - RADIUS).max() < 1e-4
            count += len(world)
    assert count > 30 * (rate - 2)


@pytest.mark.parametrize("moves", [True, False], ids=["moves", "stands"])
@pytest.mark.parametrize("rate", RATES)
def test_boxes_of_a_camera_are_around_the_balls(driven, moves, rate):
    """In space at the centre; in the image from the first to the last pixel whose middle is between the planes through
    the eye that touch the ball, at angles of atan2(x, z) -+ asin(r / hypot(x, z)) in x and z of the camera. No middle
    need be in the outermost pixel."""
    sink = driven(moves, rate)
    lenses = {seconds(one.message.header.stamp): one.message for one in sink["/lens"]}
    flat = {seconds(one.message.header.stamp): one.message for one in sink["/flat"]}
    count = 0
    for one in sink["/boxes"]:
        header, boxes = one.message.header, one.message.detections
        centres = [box.bbox.center.position for box in boxes]
        centres = np.array([[one.x, one.y, one.z] for one in centres])
        world = placed(sink, header, centres, at(header, len(centres)))
        if world is None:
            continue
        assert to_balls(world)[0].max() < 1e-4
        assert all(
            (box.bbox.size.x, box.bbox.size.y, box.bbox.size.z) == pytest.approx((0.4, 0.4, 0.4)) for box in boxes
        )
        ids = [box.results[0].hypothesis.class_id for box in boxes]
        lens = lenses[seconds(header.stamp)]
        for box in flat[seconds(header.stamp)].detections:
            x, y, z = centres[ids.index(box.results[0].hypothesis.class_id)]
            middle, size = box.bbox.center.position, (box.bbox.size_x, box.bbox.size_y)
            for side, where, extent, focal, centre, most in (
                (x, middle.x, size[0], lens.k[0], lens.k[2], lens.width),
                (y, middle.y, size[1], lens.k[4], lens.k[5], lens.height),
            ):
                angle, half = np.arctan2(side, z), np.arcsin(RADIUS / np.hypot(side, z))
                low, high = (focal * np.tan(angle + turn) + centre - 0.5 for turn in (-half, half))
                assert where - extent / 2 == pytest.approx(np.clip(np.ceil(low), 0, most - 1), abs=1)
                assert where + extent / 2 == pytest.approx(np.clip(np.floor(high), 0, most - 1), abs=1)
            count += 1
    assert count > rate - 2


@pytest.mark.parametrize("moves", [True, False], ids=["moves", "stands"])
def test_odometry_is_the_way_since_its_first_message_and_its_twist_in_the_childs_axes(driven, moves):
    sink = driven(moves)
    sent = [one.message for one in sink["/odom"]]
    (start,), (origin,) = poses(sink, "Robot", at(sent[0].header))
    for message in sent[2:-2]:
        assert message.child_frame_id == "Robot"
        (turn,), (place,) = poses(sink, "Robot", at(message.header))
        position, twist = message.pose.pose.position, message.twist.twist
        np.testing.assert_allclose([position.x, position.y, position.z], start.T @ (place - origin), atol=1e-6)
        linear, angular = ([one.x, one.y, one.z] for one in (twist.linear, twist.angular))
        np.testing.assert_allclose(turn @ linear, velocity(sink, "Robot", seconds(message.header.stamp)), atol=1e-4)
        np.testing.assert_allclose(angular, turn_rate(sink, "Robot", seconds(message.header.stamp)), atol=1e-3)


def test_an_imu_feels_the_turn_and_the_pull_of_its_lever_about_its_own_axes(driven):
    """Without gravity: w x (w x r) of a lever r = (0.3, 0, 0) of the body, whose axes are the sensor's; backward over a
    physics step, so half a step old: w^3 r / 480 = 2e-4."""
    sink = driven()
    for one in sink["/imu"][2:-2]:
        message = one.message
        rate = turn_rate(sink, message.header.frame_id, seconds(message.header.stamp))
        angular, linear = ([one.x, one.y, one.z] for one in (message.angular_velocity, message.linear_acceleration))
        np.testing.assert_allclose(angular, rate, atol=1e-3)
        np.testing.assert_allclose(linear, np.cross(rate, np.cross(rate, [0.3, 0, 0])), atol=2e-3)
