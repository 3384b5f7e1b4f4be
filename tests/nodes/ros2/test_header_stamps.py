"""Header stamps of lidar messages: a transform as of the stamp puts every point where it was seen."""

from fractions import Fraction

import numpy as np
import pytest

from tests.support.consumers import columns, placed, seconds, xyz

# A box of 1 kg drifts at 1.1 m/s and turns at 40 deg/s in a room; its lidar sits 0.3 m before its centre.
WORLD = """\
tickgraph: 1
scene:
  prims:
    /World/Physics: {{type: PhysicsScene, attributes: {{"physics:gravityMagnitude": 1e-12}}}}
    /World/East: {{type: Cube, size: 2, scale: [1, 20, 20], translate: [9, 0, 0]}}
    /World/West: {{type: Cube, size: 2, scale: [1, 20, 20], translate: [-9, 0, 0]}}
    /World/North: {{type: Cube, size: 2, scale: [20, 1, 20], translate: [0, 7, 0]}}
    /World/South: {{type: Cube, size: 2, scale: [20, 1, 20], translate: [0, -7, 0]}}
    /World/Robot: {{type: Cube, size: 0.5, translate: [-1, 0, 0], rigid_body: true, mass: 1, velocity: [1.1, 0, 0],
      angular_velocity: [0, 0, 40]}}
    /World/Robot/Lidar:
      type: OmniLidar
      config: RPLIDAR_S2E
      translate: [0.3, 0, 0]
      exclude: [/World/Robot]
      attributes: {{"omni:sensor:tickRate": {rate}, "omni:sensor:Core:scanRateBaseHz": {scan}}}
clock: {{physics_hz: 240, loop_hz: 60}}
fidelity: {{lidar.motion: {motion}}}
settings: {{/tickgraph/lidarHeader: {header}}}
graphs:
  /G:
    nodes:
      tick: OnPlaybackTick
      time: IsaacReadSimulationTime
      tf: {{type: ROS2PublishTransformTree, inputs: {{targetPrims: [/World/Robot/Lidar]}}}}
      product: {{type: IsaacCreateRenderProduct, inputs: {{cameraPrim: /World/Robot/Lidar}}}}
      cloud:
        type: ROS2RtxLidarHelper
        inputs: {{type: {kind}, topicName: lidar, frameId: Lidar{fields}}}
    connections:
      - tick.tick -> [tf.execIn, product.execIn]
      - time.simulationTime -> tf.timeStamp
      - product.execOut -> cloud.execIn
      - product.renderProductPath -> cloud.renderProductPath
  /Frames:
    pipeline_stage: post_render
    nodes:
      time: IsaacReadSimulationTime
      buffer: OgnIsaacExtractRTXSensorPointCloud
      cloud: {{type: ROS2PublishPointCloud, inputs: {{topicName: buffers}}}}
    connections:
      - /G/product.outputs:renderProductPath -> buffer.renderProductPath
      - buffer.exec -> cloud.execIn
      - buffer.dataPtr -> cloud.dataPtr
      - time.simulationTime -> cloud.timeStamp
"""


@pytest.fixture
def drive(tmp_path):
    """A function: runs the world for `updates`; returns the App with its memory sink."""
    from graph.sim import App
    from graph.sim.messages.bus import MemorySink

    opened = []

    def run(rate=10, scan=None, *, motion="frozen", kind="point_cloud", header="frame", time=True, updates=60):
        fields = ", selectedMetadata: [Time]" if time and kind == "point_cloud" else ""
        path = tmp_path / "drive.yaml"
        path.write_text(
            WORLD.format(rate=rate, scan=scan or rate, motion=motion, kind=kind, header=header, fields=fields)
        )
        app = App.from_file(path)
        opened.append(app)
        app.sink = MemorySink()
        app.bus.subscribe(app.sink)
        app.play()
        app.update(updates)
        return app

    yield run
    for app in opened:
        app.close()


def nanoseconds(stamp):
    return stamp.sec * 10**9 + stamp.nanosec


def headers(app, topic="/lidar"):
    return [nanoseconds(one.message.header.stamp) for one in app.sink[topic]]


def off_the_walls(app, *, by_time=False):
    """How far [m] the worst point lies from the walls x = +-8 m, y = +-6 m, put into the world as a consumer does: by
    TF, interpolated at the header's stamp, or (by_time) at each point's own time.
    """
    worst, count = 0.0, 0
    for one in app.sink["/lidar"]:
        data = columns(one.message)
        at = seconds(one.message.header.stamp) + (data["time"].astype(float) if by_time else np.zeros(len(data)))
        world = placed(app.sink, one.message.header, xyz(data), at)
        if world is not None:
            error = np.minimum(np.abs(np.abs(world[:, 0]) - 8), np.abs(np.abs(world[:, 1]) - 6))
            worst, count = max(worst, float(error.max())), count + len(data)
    assert count > 10_000
    return worst


# A scan rate is whole: a lidar ticked at 29.97 Hz gives parts of its scans of 30 Hz.
@pytest.mark.parametrize(("rate", "scan"), [(10, 10), (7, 7), (29.97, 30)])
def test_frozen_clouds_lie_on_the_walls_by_tf_at_their_header_stamp(drive, rate, scan):
    # Linear interpolation of TF at 60 Hz on an arc: v w dt^2 / 8 = 1.1 x 0.7 / (8 x 3600) = 2.7e-5 m at most; the rest
    # is float32 (ranges below 16 m: 1e-6 m) and the 240 Hz steps of the physics, which are TF's own.
    app = drive(rate, scan)
    assert off_the_walls(app) <= 1e-4


@pytest.mark.parametrize(("rate", "scan"), [(10, 10), (7, 7), (29.97, 30)])
def test_continuous_clouds_lie_on_the_walls_by_tf_at_header_plus_time(drive, rate, scan):
    app = drive(rate, scan, motion="continuous")
    assert off_the_walls(app, by_time=True) <= 1e-3
    # By the header alone the far end of a turn is off by (v + w r) T.
    assert off_the_walls(app) > 0.01


def test_a_frozen_header_is_the_time_of_the_first_state_at_or_after_the_tick(drive):
    # Tick k of 7 Hz falls due at k/7 s; the first step of 240 Hz there is ceil(240 k / 7): 35, 69, 103, 138, 172, 206.
    app = drive(7)
    steps = [35, 69, 103, 138, 172, 206, 240]
    assert headers(app) == [round(Fraction(step * 10**9, 240)) for step in steps]


@pytest.mark.parametrize("motion", ["update", "continuous"])
def test_a_scan_over_time_carries_its_end_and_points_lie_before_it(drive, motion):
    app = drive(10, motion=motion)
    assert headers(app) == [k * 100_000_000 for k in range(1, 11)]
    data = np.frombuffer(app.sink["/lidar"][3].message.data.tobytes(), "<f4").reshape(-1, 4)
    assert -0.1 - 1e-6 <= data[:, 3].min() < data[:, 3].max() < 0


def test_parts_of_scans_carry_the_time_of_their_update(drive):
    assert headers(drive(0, 10, updates=5)) == [round(Fraction(k * 10**9, 60)) for k in range(1, 6)]


@pytest.mark.parametrize(("header", "first"), [("frame", 145_833_333), ("scanStart", 1), ("update", 150_000_000)])
def test_the_setting_lidarHeader_chooses_the_stamp(drive, header, first):
    # 1 ns stands for 0, by which tf2 means the latest transform.
    # The first tick of 7 Hz, 0.142857 s: the state is step 35 of 240 Hz, the update the ninth of 60 Hz.
    app = drive(7, header=header, updates=12)
    assert headers(app) == [first]


@pytest.mark.parametrize("header", ["frame", "scanStart", "update"])
def test_helper_and_buffer_of_one_scan_carry_one_stamp(drive, header):
    app = drive(7, header=header)
    assert len(headers(app)) == 7
    assert [max(1, stamp) for stamp in headers(app, "/buffers")] == headers(app)


@pytest.mark.parametrize(("motion", "header"), [("frozen", 145_833_333), ("continuous", 1)])
def test_a_laser_scan_carries_the_time_of_its_first_ray(drive, motion, header):
    app = drive(7, motion=motion, kind="laser_scan", updates=12)
    assert headers(app) == [header]
    [scan] = [one.message for one in app.sink["/lidar"]]
    assert (scan.time_increment == 0) == (motion == "frozen")


@pytest.mark.parametrize(
    ("motion", "time", "codes"),
    [("frozen", True, ["frozen-times-nominal"]), ("frozen", False, []), ("continuous", True, [])],
)
def test_times_of_a_frozen_lidar_that_moves_are_reported_to_be_nominal(drive, motion, time, codes):
    app = drive(10, motion=motion, time=time, updates=3)
    assert [one.code for one in app.warnings if one.code == "frozen-times-nominal"] == codes


READINGS = """\
nodes:
  tick: OnPlaybackTick
  imu: {{type: IsaacReadIMU, inputs: {{imuPrim: /World/Box/Imu}}}}
  felt: {{type: ROS2PublishImu, inputs: {{frameId: imu}}}}
  joints: {{type: IsaacReadJointState, inputs: {{prim: /World/Arm}}}}
  states: ROS2PublishJointState
connections:
  - tick.tick -> [imu.execIn, joints.execIn]
  - imu.execOut -> felt.execIn
  - imu.sensorTime -> felt.timeStamp
  - joints.execOut -> states.execIn
  - joints.jointNames -> states.jointNames
  - joints.sensorTime -> states.{input}
"""
BODIES = """\
tickgraph: 1
scene:
  prims:
    /World/Box: {type: Cube, size: 1, rigid_body: true, mass: 1}
    /World/Box/Imu: {type: IsaacImuSensor}
    /World/Arm: {schemas: PhysicsArticulationRootAPI}
    /World/Arm/Link: {type: Cube, size: 1, translate: [9, 0, 0], rigid_body: true, mass: 1}
    /World/Arm/joint: {type: PhysicsRevoluteJoint, attributes: {physics:body1: /World/Arm/Link}}
clock: {physics_hz: 60, loop_hz: 60}
graphs:
  /G:
"""


@pytest.mark.parametrize("stamp", ["sensorTime", "timeStamp"])
def test_the_time_of_a_reading_stamps_to_the_nanosecond_though_it_is_a_float32(tmp_path, stamp):
    """1/30 s is 33,333,333 ns; its float32 is 33,333,335.07 ns."""
    from graph.sim import App
    from graph.sim.messages.bus import MemorySink

    path = tmp_path / "graph.yaml"
    lines = READINGS.format(input=stamp).splitlines()
    path.write_text(BODIES + "".join(f"    {line}\n" for line in lines))
    sink = MemorySink()
    with App.from_file(path) as app:
        assert [warning.code for warning in app.warnings] == []
        app.bus.subscribe(sink)
        app.play()
        app.update(3)
    assert [one.message.header.stamp.nanosec for one in sink["/imu"]] == [33_333_333, 50_000_000]
    assert [one.message.header.stamp.nanosec for one in sink["/joint_states"]] == [16_666_667, 33_333_333, 50_000_000]
