"""Frozen, update and continuous scans of a moving world against what was where when each ray was fired."""

import dataclasses

import numpy as np
import pytest
from pxr import UsdPhysics

from graph.sim import App
from graph.sim.geometry.surfaces import Mesh
from sensors.lidar.config import EmitterState
from sensors.lidar.pattern import firing_pattern
from sensors.lidar.returns import Shot, Targets
from sensors.lidar.scan import Scanner
from sensors.motion.history import Trajectory
from sensors.raycast.triangles import TriangleScene
from sensors.raycast.world import CastWorld
from tests.support.lidar_worlds import add_box, add_lidar, frames_of, rotary, stare, weightless

TIMES = np.linspace(0.0, 0.099, 40)
PERIOD = 0.1
MOTIONS = ("frozen", "update", "continuous")


def ranges(motion, target=0.0, sensor=0.0, bins=16, loop_hz=60):
    """Ranges straight ahead of a lidar at x = 0 to a wall at x = 8, each with a speed along x [m/s]; second scan."""
    with weightless(lidar_motion=motion, lidar_bins=bins, loop_hz=loop_hz) as app:
        add_box(app, "/World/Wall", 4.0, (10, 0, 0), velocity=(target, 0, 0) if target else None)
        add_box(app, "/World/Cart", 0.1, (0, 0, -5), velocity=(sensor, 0, 0))
        product = add_lidar(app, "/World/Cart/Lidar", (0, 0, 5), stare(TIMES))
        return frames_of(app, product, loop_hz // 5)[1].channel("distance").astype(np.float64)


@pytest.mark.parametrize(("target", "sensor"), [(3.0, 0.0), (0.0, 5.0), (-4.0, 5.0), (6.0, 6.0)])
def test_a_frozen_scan_is_off_by_the_distance_covered_since_each_firing(target, sensor):
    closing = sensor - target
    exact = 8.0 - closing * (PERIOD + TIMES)

    error = ranges("frozen", target, sensor) - exact

    np.testing.assert_allclose(error, -closing * (PERIOD - TIMES), atol=1e-4)
    assert np.abs(error).max() == pytest.approx(abs(closing) * PERIOD, abs=1e-4)  # v T, at the first firing


@pytest.mark.parametrize(("target", "sensor"), [(3.0, 0.0), (0.0, 5.0), (-4.0, 5.0)])
def test_an_update_scan_is_off_by_less_than_an_update(target, sensor):
    closing = sensor - target

    error = ranges("update", target, sensor) - (8.0 - closing * (PERIOD + TIMES))

    assert 0.3 * abs(closing) / 60 < np.abs(error).max() <= abs(closing) / 60 + 1e-4


@pytest.mark.parametrize("bins", [1, 4, 16, 100])
@pytest.mark.parametrize("target", [3.0, -20.0])
def test_a_continuous_scan_is_off_by_half_a_bin_of_the_targets_motion_and_no_more(bins, target):
    error = ranges("continuous", target, bins=bins) - (8.0 + target * (PERIOD + TIMES))

    bound = abs(target) * PERIOD / (2 * bins)
    assert np.abs(error).max() <= bound + 1e-5
    if bins <= 16:
        assert np.abs(error).max() >= 0.5 * bound  # at least half of the bound is reached


def test_a_continuous_scan_from_a_moving_sensor_is_exact_before_a_wall_that_stands():
    error = ranges("continuous", sensor=5.0, bins=1) - (8.0 - 5.0 * (PERIOD + TIMES))

    assert np.abs(error).max() <= 1e-5


def test_a_continuous_scan_of_sensor_and_target_in_motion_stays_under_the_targets_bound():
    error = ranges("continuous", target=-4.0, sensor=5.0) - (8.0 - 9.0 * (PERIOD + TIMES))

    assert np.abs(error).max() <= 4.0 * PERIOD / 32 + 1e-5


def turning_ranges(motion, sensor=0.0, target=0.0, bins=16, physics_hz=240):
    """Ranges ahead to the wall of a room 20 m wide, lidar and room turning about z [deg/s]; second scan."""
    with weightless(lidar_motion=motion, lidar_bins=bins, physics_hz=physics_hz) as app:
        add_box(app, "/World/Room", 20.0, (0, 0, 0), spin=(0, 0, target) if target else None)
        mount = "/World"
        if sensor:
            add_box(app, mount := "/World/Cart", 0.1, (0, 0, 0), spin=(0, 0, sensor))
        product = add_lidar(app, f"{mount}/Lidar", (0, 0, 0.5), config=stare(TIMES))
        return frames_of(app, product, 12)[1].channel("distance").astype(np.float64)


def test_rotation_of_the_sensor_frozen_is_off_by_the_angle_turned_and_continuous_is_exact():
    rate = 200.0  # deg/s: 20 deg in the first scan, up to 40 in the second
    exact = 10.0 / np.cos(np.deg2rad(rate * (PERIOD + TIMES)))

    np.testing.assert_allclose(turning_ranges("continuous", rate), exact, atol=5e-5)
    np.testing.assert_allclose(turning_ranges("frozen", rate), 10.0 / np.cos(np.deg2rad(rate * 0.2)), atol=5e-5)


def test_rotation_between_few_physics_states_follows_the_great_circle():
    rate = 200.0
    exact = 10.0 / np.cos(np.deg2rad(rate * (PERIOD + TIMES)))

    np.testing.assert_allclose(turning_ranges("continuous", rate, physics_hz=30), exact, atol=5e-5)


@pytest.mark.parametrize("bins", [2, 16])
def test_rotation_of_the_target_stays_under_the_bound_of_its_bins(bins):
    rate = 200.0
    turned = np.deg2rad(rate * (PERIOD + TIMES))

    found = turning_ranges("continuous", target=rate, bins=bins)

    half = np.deg2rad(rate) * PERIOD / (2 * bins)  # what the room turns in half a bin
    assert np.all(found <= 10.0 / np.cos(turned + half) + 1e-4)
    assert np.all(found >= 10.0 / np.cos(turned - half) - 1e-4)


@pytest.mark.parametrize("offset", [0.0, 1e3, 1e6])
def test_a_continuous_scan_is_as_exact_far_from_the_origin(offset):
    with weightless(lidar_motion="continuous") as app:
        add_box(app, "/World/Wall", 4.0, (offset + 10, 0, 0))
        add_box(app, "/World/Cart", 0.1, (offset, 0, -5), velocity=(5.0, 0, 0))
        product = add_lidar(app, "/World/Cart/Lidar", (0, 0, 5), stare(TIMES))
        [frame] = frames_of(app, product, 6)

    np.testing.assert_allclose(frame.channel("distance"), 8.0 - 5.0 * TIMES, atol=1e-4)


@pytest.mark.parametrize("motion", ["continuous", "update"])
@pytest.mark.parametrize(("physics_hz", "loop_hz"), [(70, 60), (240, 7), (240, 45)])
def test_the_poses_of_a_frame_are_those_at_both_ends_of_the_scan(motion, physics_hz, loop_hz):
    """5 m/s and 90 deg/s: at k / 10 s it is at k / 2 m, turned by 9 k deg; wherever updates and steps fall."""
    with weightless(lidar_motion=motion, physics_hz=physics_hz, loop_hz=loop_hz) as app:
        add_box(app, "/World/Cart", 0.1, (0, 0, 0), velocity=(5.0, 0, 0), spin=(0, 0, 90))
        product = add_lidar(app, "/World/Cart/Lidar", config=stare(TIMES))
        frames = frames_of(app, product, 1 + loop_hz // 2)

    assert frames
    for frame in frames:
        for pose, time in ((frame.start, frame.timestamp_ns * 1e-9), (frame.end, frame.timestamp_ns * 1e-9 + PERIOD)):
            assert pose.timestamp_ns == round(time * 1e9)
            np.testing.assert_allclose(pose.position_m, [5.0 * time, 0, 0], atol=1e-6)
            half = np.deg2rad(90 * time / 2)
            np.testing.assert_allclose(pose.orientation, [np.cos(half), 0, 0, np.sin(half)], atol=1e-6)


@pytest.mark.parametrize("motion", ["continuous", "update"])
def test_the_poses_of_a_partial_frame_are_those_of_the_last_output_and_of_now(motion):
    with weightless(lidar_motion=motion) as app:
        add_box(app, "/World/Cart", 0.1, (0, 0, 0), velocity=(6.0, 0, 0))
        product = add_lidar(app, "/World/Cart/Lidar", config=stare(TIMES), tick_rate=0)
        frames = frames_of(app, product, 5)

    assert [frame.start.position_m[0] for frame in frames] == pytest.approx([0.0, 0.1, 0.2, 0.3, 0.4], abs=1e-6)
    assert [frame.end.position_m[0] for frame in frames] == pytest.approx([0.1, 0.2, 0.3, 0.4, 0.5], abs=1e-6)


@pytest.mark.parametrize("physics_hz", [60, 240])
def test_between_states_of_a_falling_sensor_the_error_is_the_chords(physics_hz):
    """Semi-implicit steps: z_n = 5 - g dt^2 n (n + 1) / 2. Between them the sensor is on the chord, which is g dt^2 / 8
    off the parabola in its middle, and no more.
    """
    g, dt = 9.81, 1 / physics_hz
    config = dataclasses.replace(
        stare(TIMES), emitter_states=(EmitterState(0 * TIMES, 0 * TIMES - 90.0, np.round(TIMES * 1e9)),)
    )
    with weightless(lidar_motion="continuous", physics_hz=physics_hz) as app:
        UsdPhysics.Scene.Get(app.stage, "/World/Physics").GetGravityMagnitudeAttr().Set(g)
        add_box(app, "/World/Floor", 40.0, (0, 0, -20))
        add_box(app, "/World/Cart", 0.1, (3, 0, 5), velocity=(0, 0, 0))
        found = frames_of(app, add_lidar(app, "/World/Cart/Lidar", (-3, 0, 0), config), 6)[0].channel("distance")

    def parabola(steps):
        return 5.0 - g * dt**2 * steps * (steps + 1) / 2

    steps = TIMES / dt
    chord = parabola(np.floor(steps)) + (steps % 1) * (parabola(np.floor(steps) + 1) - parabola(np.floor(steps)))
    np.testing.assert_allclose(found, chord, atol=3e-6)
    off = np.abs(found - parabola(steps))
    assert 0.9 * g * dt**2 / 8 < off.max() <= g * dt**2 / 8 + 3e-6


GRAPH_MADE = """
tickgraph: 1
scene:
  prims:
    /World/Room: {type: Cube, size: 40, collision: false}
    /World/Cart: {type: Cube, size: 0.1, rigid_body: true, mass: 1, velocity: [6, 0, 0]}
    /World/Cart/Lidar: {type: OmniLidar, config: RPLIDAR_S2E, exclude: [/World/Cart]}
clock: {physics_hz: 240, loop_hz: 60}
fidelity: {lidar.motion: MOTION}
graphs:
  /World/Graph:
    nodes:
      tick: OnPlaybackTick
      product: {type: IsaacCreateRenderProduct, inputs: {cameraPrim: /World/Cart/Lidar}}
    connections:
      - tick.tick -> product.execIn
"""


@pytest.mark.parametrize("motion", ["continuous", "update"])
def test_a_lidar_made_by_a_graph_knows_the_update_in_which_it_was_made(motion, tmp_path):
    """Its first scan begins at 0, before the steps of the update whose graph makes it."""
    path = tmp_path / "made.yaml"
    path.write_text(GRAPH_MADE.replace("MOTION", motion))
    with App.from_file(path) as app:
        app.play()
        app.update()
        [product] = app.rendering.products.values()
        product.sensor.require("test", {"distance"})
        app.update(steps=5)
        frame = product.frame

    assert (frame.start.position_m[0], frame.end.position_m[0]) == pytest.approx((0.0, 0.6), abs=1e-6)
    if motion == "continuous":  # ahead, at time 0: the wall 20 m away
        assert frame.channel("distance")[0] == pytest.approx(20.0, abs=1e-5)


def test_both_poses_of_a_frozen_frame_are_the_one_it_was_cast_from():
    with weightless(physics_hz=60, loop_hz=7) as app:  # the first update ends at step 8; the tick at 0.1 s is step 6
        add_box(app, "/World/Cart", 0.1, (0, 0, 0), velocity=(5.0, 0, 0))
        [frame] = frames_of(app, add_lidar(app, "/World/Cart/Lidar", config=stare(TIMES)), 1)

    assert frame.start.position_m[0] == frame.end.position_m[0] == pytest.approx(0.5, abs=1e-6)
    assert (frame.start.timestamp_ns, frame.end.timestamp_ns) == (0, 100_000_000)


@pytest.mark.parametrize("tick_rate", [10, 0])
def test_in_a_world_at_rest_continuous_gives_the_bytes_of_frozen(tick_rate):
    def scans(motion):
        with weightless(lidar_motion=motion) as app:
            add_box(app, "/World/Room", 20.0, (1, 2, 0))
            product = add_lidar(app, config=rotary(90, elevations=(0.0, 3.0)), tick_rate=tick_rate)
            return [
                {name: array.tobytes() for name, array in sorted(frame.arrays.items())}
                for frame in frames_of(app, product, 30)
            ]

    assert scans("continuous") == scans("frozen")


def test_world_points_of_a_moving_sensor_lie_on_the_wall():
    with weightless(lidar_motion="continuous") as app:
        add_box(app, "/World/Room", 20.0, (0, 0, 0))
        add_box(app, "/World/Cart", 0.1, (0, 0, -5), velocity=(3.0, 2.0, 0), spin=(0, 0, 150))
        config = rotary(180, output_frame_of_reference="WORLD")
        product = add_lidar(app, "/World/Cart/Lidar", (0.5, 0, 5), config)
        frame = frames_of(app, product, 12)[-1]

    points = frame.xyz.astype(np.float64)
    np.testing.assert_allclose(np.abs(points[:, :2]).max(axis=1), 10.0, atol=2e-5)
    inwards = np.einsum("ij,ij->i", frame.channel("hitNormals")[:, :2], points[:, :2])
    np.testing.assert_allclose(inwards, -10.0, atol=1e-4)


def test_velocities_in_a_continuous_scan_are_those_at_the_firing_not_at_the_tick():
    with weightless(lidar_motion="continuous") as app:
        add_box(app, "/World/Room", 20.0, (0, 0, 0))
        add_box(app, "/World/Cart", 0.1, (0, 0, -5), velocity=(3.0, 0, 0))
        product = add_lidar(app, "/World/Cart/Lidar", (0, 0, 5), stare(TIMES, np.linspace(0, 90, 40)))
        frame = frames_of(app, product, 6)[0]

    np.testing.assert_allclose(frame.channel("velocities"), np.tile([-3.0, 0, 0], (40, 1)), atol=1e-5)


def test_velocities_of_a_turning_sensor_take_its_motion_at_each_firing():
    # v = (3, 0, 0) m/s and w = 150 deg/s about z, of the cart's origin and so of the sensor 5 m above it: a point r of
    # a wall that stands has, in the sensor frame at time t, the velocity -(Rz(-w t) v + w z x r).
    with weightless(lidar_motion="continuous") as app:
        add_box(app, "/World/Room", 20.0, (0, 0, 0))
        add_box(app, "/World/Cart", 0.1, (0, 0, -5), velocity=(3.0, 0, 0), spin=(0, 0, 150))
        product = add_lidar(app, "/World/Cart/Lidar", (0, 0, 5), rotary(180))
        frame = frames_of(app, product, 12)[-1]

    w, time = np.deg2rad(150), (frame.timestamp_ns + frame.channel("timeOffsetNs").astype(np.int64)) * 1e-9
    points = frame.xyz.astype(np.float64)
    expected = np.zeros_like(points)
    expected[:, 0] = -(3 * np.cos(w * time) - w * points[:, 1])
    expected[:, 1] = -(-3 * np.sin(w * time) + w * points[:, 0])
    np.testing.assert_allclose(frame.channel("velocities"), expected, atol=5e-4)  # interpolated over steps of 1/240 s


def test_partial_scans_make_up_the_whole_scan_of_a_moving_sensor():
    def scans(tick_rate):
        with weightless(lidar_motion="continuous") as app:
            add_box(app, "/World/Room", 20.0, (1, 2, 0))
            add_box(app, "/World/Cart", 0.1, (0, 0, -5), velocity=(3.0, 1.0, 0), spin=(0, 0, 90))
            product = add_lidar(app, "/World/Cart/Lidar", (0, 0, 5), rotary(90), tick_rate=tick_rate)
            return frames_of(app, product, 12)

    whole, partial = scans(10), scans(0)

    for name in ("tickId", "azimuth"):
        np.testing.assert_array_equal(*(np.concatenate([f.channel(name) for f in fs]) for fs in (whole, partial)))
    np.testing.assert_allclose(
        *(np.concatenate([f.channel("distance") for f in fs]) for fs in (whole, partial)), atol=1e-5
    )


def test_stop_and_play_give_the_bytes_of_the_first_play():
    with weightless(lidar_motion="continuous") as app:
        add_box(app, "/World/Room", 20.0, (1, 2, 0))
        add_box(app, "/World/Body", 1.0, (4, 0, 0), velocity=(1, 0.5, 0), spin=(50, 60, 70))
        product = add_lidar(app)
        first = [frame.xyz.tobytes() for frame in frames_of(app, product, 12)]
        app.stop()
        again = [frame.xyz.tobytes() for frame in frames_of(app, product, 12)]

    assert len(first) == 2
    assert first == again


def test_a_trajectory_is_constant_outside_what_is_known_and_takes_half_turns():
    poses = np.stack([np.eye(4), np.diag([-1.0, -1.0, 1.0, 1.0])])
    poses[1, 0, 3] = 2.0
    track = Trajectory(np.array([0.0, 1.0]), poses)

    np.testing.assert_allclose(track.positions(np.array([-1.0, 0.25, 3.0]))[:, 0], [0.0, 0.5, 2.0])
    half = track.rotations(np.array([0.5]))[0]
    np.testing.assert_allclose(np.abs(half[:2, :2]), [[0, 1], [1, 0]], atol=1e-12)


def test_a_lidar_whose_mount_trembles_is_cast_at_what_stands_still_twice_and_no_more(monkeypatch):
    """A direction that turns by 1e-12 rad does not change: float32 is exact to 6e-8 near 1."""
    cast, casts = TriangleScene.cast, []
    monkeypatch.setattr(TriangleScene, "cast", lambda *args, **options: casts.append(1) or cast(*args, **options))
    corners = np.array([[5.0, -9.0, -9.0], [5.0, 9.0, -9.0], [5.0, 0.0, 9.0]])
    world = CastWorld([Mesh("/World/Wall", None, corners, np.array([[0, 1, 2]], np.uint32))])
    scanner, ranges = Scanner(firing_pattern(stare(TIMES)), stare(TIMES)), []
    targets = Targets(frozenset({"distance"}), world)
    for angle in 0.3 + 1e-12 * np.arange(5.0):
        pose = np.eye(4)
        pose[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
        ranges.append(scanner.scan(Shot(slice(0, len(TIMES)), pose), targets)["distance"])

    assert len(casts) == 2
    np.testing.assert_allclose(ranges, 5.0 / np.cos(0.3), rtol=1e-6)
