"""What a lidar measures against closed forms, from the origin to 1000 km away from it.

Tolerances. Rays and vertices are float32 about an anchor on a 1 km grid, so that a coordinate of at most 1024 m is off
by half a unit in the last place, 2**-15 m = 3.1e-5 m; a range to a plane is off by at most the sum over ray and plane
along the normal, divided by the cosine of incidence: PLACE below, for the incidences used here. On top come float32
directions (6e-8 rad: 1.2e-6 m at 20 m).
"""

from fractions import Fraction
from math import ceil

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from pxr import Gf, UsdGeom

from sensors.lidar.config import EmitterState
from tests.support.lidar_worlds import EVERYTHING, add_box, add_lidar, bind, frames_of, rotary, stare, weightless

OFFSETS = [0.0, 1e3, 1e4, 1e5, 1e6]
PLACE = 4 * 2.0**-15


def cross(a, b):
    return np.cross(np.asarray(a, np.float64), np.asarray(b, np.float64))


@pytest.mark.parametrize("offset", OFFSETS)
def test_velocities_of_target_and_sensor_both_moving_and_turning(offset):
    """d/dt of a point of the wall in the sensor's axes: R^T (v + w x (p - c) - u - q x (p - s)).

    A place off by PLACE changes it by the angular velocities times that.
    """
    v, spin, u, turn = np.array([3.0, 0.5, -0.25]), (0.0, 0.0, 90.0), np.array([1.0, -2.0, 0.5]), (0.0, 0.0, -60.0)
    w, q = np.deg2rad(spin), np.deg2rad(turn)
    with weightless() as app:
        add_box(app, "/World/Wall", 4.0, (offset + 10, offset, offset), velocity=tuple(v), spin=spin)
        add_box(app, "/World/Fixed", 6.0, (offset - 10, offset, offset))
        add_box(app, "/World/Cart", 0.1, (offset, offset, offset - 5), velocity=tuple(u), spin=turn)
        config = rotary(180, elevations=(-3.0, 0.0, 3.0))
        product = add_lidar(app, "/World/Cart/Lidar", (0, 0, 5), config, channels={"xyz", "velocities"})
        [frame] = frames_of(app, product, 6)

    pose = frame.end.world_sensor
    points = frame.xyz.astype(np.float64) @ pose[:3, :3].T + pose[:3, 3]
    there = np.array([offset] * 3)
    centre = there + [10, 0, 0] + 0.1 * v
    cart = there + [0, 0, -5] + 0.1 * u
    wall = points[:, 0] > offset + 5
    expected = -u - cross(q, points - cart)
    expected[wall] += v + cross(w, points - centre)[wall]
    assert 10 < wall.sum() < len(wall) - 10
    np.testing.assert_allclose(frame.channel("velocities"), expected @ pose[:3, :3], atol=(w[2] - q[2]) * PLACE + 1e-5)


@pytest.mark.parametrize("offset", OFFSETS)
def test_light_falls_off_with_range_squared_and_the_cosine_of_incidence(offset):
    """RAW: 0.85 (snow) cos(a) (near / R)^2 with R = D / cos(a). An error PLACE of R counts twice over R."""
    angles, distance, near = np.array([0.0, 20.0, 40.0, 60.0]), 8.0, 0.5
    with weightless() as app:
        bind(app, add_box(app, "/World/Wall", 80.0, (offset + distance + 40, offset, offset)), "snow")
        fields = {"intensity_processing": "RAW", "near_range_m": near}
        config = stare(np.zeros(4), angles, **fields)
        [frame] = frames_of(app, add_lidar(app, position=(offset,) * 3, config=config), 6)

    cosine = np.cos(np.deg2rad(angles))
    expected = 0.85 * cosine * (near * cosine / distance) ** 2
    np.testing.assert_allclose(frame.channel("scalar"), expected, rtol=2 * PLACE / distance + 1e-6)


@pytest.mark.parametrize("offset", OFFSETS)
def test_times_and_angles_of_every_beam_are_those_of_the_formula(offset):
    """Tick i at i / 3600 s, clockwise 1 deg each; emitters 7 and 11 us later, 2 deg to either side, at -5 and 5 deg."""
    state = EmitterState(azimuth_deg=[2.0, -2.0], elevation_deg=[-5.0, 5.0], fire_time_ns=[7000, 11000])
    config = rotary(360, emitter_states=(state,), start_azimuth_offset_deg=30.0)
    with weightless() as app:
        add_box(app, "/World/Room", 20.0, (offset,) * 3)
        frames = frames_of(app, add_lidar(app, position=(offset,) * 3, config=config), 12)

    tick = np.arange(360)
    azimuth = (30.0 - tick[:, None] + [2.0, -2.0]).ravel()
    time = (tick[:, None] * Fraction(10**9, 3600) + [7000, 11000]).ravel()
    for number, frame in enumerate(frames):
        assert frame.timestamp_ns == number * 100_000_000
        assert frame.channel("timeOffsetNs").tolist() == [round(t) for t in time]
        np.testing.assert_allclose(
            (frame.channel("azimuth") - azimuth + 180.0) % 360.0 - 180.0, 0.0, atol=2e-5
        )  # float32 at 180
        assert frame.channel("elevation").tolist() == [-5.0, 5.0] * 360
        beam = np.deg2rad(azimuth), np.deg2rad(np.tile([-5.0, 5.0], 360))
        level = np.cos(beam[1])
        exact = np.stack([level * np.cos(beam[0]), level * np.sin(beam[0]), np.sin(beam[1])], 1)
        np.testing.assert_allclose(frame.xyz, exact * frame.channel("distance")[:, None], atol=4e-6)


@pytest.mark.parametrize("offset", OFFSETS)
@pytest.mark.parametrize(("motion", "error"), [("frozen", 1.0), ("update", 1 / 6), ("continuous", 1 / 32)])
def test_each_motion_is_off_by_what_it_says_wherever_it_is(offset, motion, error):
    """Sensor at 5, wall at -4 m/s, closing at 9 m/s, one turn T = 0.1 s of 6 updates, 16 bins, second scan.

    frozen: exactly 9 (T - t), at most 9 T; update: 9 T / 6; continuous: only the wall's 4 T / 32.
    """
    times, period = np.linspace(0.0, 0.099, 40), 0.1
    with weightless(lidar_motion=motion, lidar_bins=16) as app:
        add_box(app, "/World/Wall", 4.0, (offset + 10, offset, offset), velocity=(-4.0, 0, 0))
        add_box(app, "/World/Cart", 0.1, (offset, offset, offset - 5), velocity=(5.0, 0, 0))
        product = add_lidar(app, "/World/Cart/Lidar", (0, 0, 5), stare(times))
        found = frames_of(app, product, 12)[1].channel("distance").astype(np.float64)

    off = found - (8.0 - 9.0 * (period + times))
    speed = 4.0 if motion == "continuous" else 9.0
    assert np.abs(off).max() <= speed * period * error + PLACE
    assert np.abs(off).max() >= 0.5 * speed * period * error - PLACE
    if motion == "frozen":
        np.testing.assert_allclose(off, -9.0 * (period - times), atol=PLACE)


@pytest.mark.parametrize("frame_of_reference", ["SENSOR", "WORLD", "CUSTOM"])
def test_velocities_and_normals_are_along_the_axes_that_points_are_given_in(frame_of_reference):
    """A cart at 2 m/s along x, turned by 90 deg to the left, before a wall at rest: seen from it the wall comes nearer
    along its right, -(-y); the world sees no motion; the custom frame has the sensor rolled by 90 deg: y becomes z.
    """
    config = rotary(
        4, output_frame_of_reference=frame_of_reference, custom_frame_of_reference_trafo=(0, 0, 0, 90, 0, 0)
    )
    with weightless() as app:
        add_box(app, "/World/Room", 20.0, (0, 0, 0))
        add_box(app, "/World/Cart", 0.1, (0, 0, -5), velocity=(2.0, 0, 0))
        product = add_lidar(app, "/World/Cart/Lidar", (0, 0, 5), config)
        UsdGeom.XformCommonAPI(app.stage.GetPrimAtPath("/World/Cart/Lidar")).SetRotate(Gf.Vec3f(0, 0, 90))
        [frame] = frames_of(app, product, 6)

    x = 0.2  # where the cart is after 0.1 s; forward is +y, the first beam right of it (clockwise) +x
    points = {
        "SENSOR": [[10, 0, 0], [0, -10 + x, 0], [-10, 0, 0], [0, 10 + x, 0]],
        "WORLD": [[x, 10, 0], [10, 0, 0], [x, -10, 0], [-10, 0, 0]],
        "CUSTOM": [[10, 0, 0], [0, 0, -10 + x], [-10, 0, 0], [0, 0, 10 + x]],
    }[frame_of_reference]
    normals = {
        "SENSOR": [[-1, 0, 0], [0, 1, 0], [1, 0, 0], [0, -1, 0]],
        "WORLD": [[0, -1, 0], [-1, 0, 0], [0, 1, 0], [1, 0, 0]],
        "CUSTOM": [[-1, 0, 0], [0, 0, 1], [1, 0, 0], [0, 0, -1]],
    }[frame_of_reference]
    seen = {"SENSOR": [0, 2, 0], "WORLD": [0, 0, 0], "CUSTOM": [0, 0, 2]}[frame_of_reference]
    np.testing.assert_allclose(frame.xyz, points, atol=1e-5)
    np.testing.assert_allclose(frame.channel("hitNormals"), normals, atol=1e-6)
    np.testing.assert_allclose(frame.channel("velocities"), [seen] * 4, atol=1e-5)


# -- turns and slices ------------------------------------------------------------------------------------------------

RATES = st.sampled_from([7, 24, 30, 50, 60, 75, 90, 120, 144, 240, Fraction(60000, 1001)])


def scans(config, tick_rate, physics_hz, loop_hz, seconds, motion="frozen"):
    with weightless(physics_hz=physics_hz, loop_hz=loop_hz, lidar_motion=motion) as app:
        add_box(app, "/World/Room", 20.0, (1, 2, 0))
        product = add_lidar(app, config=config, tick_rate=tick_rate, channels={"tickId", "emitterId", "azimuth"})
        return frames_of(app, product, ceil(seconds * loop_hz) + 1)


@settings(max_examples=25, deadline=None)
@given(
    physics=RATES,
    loop=RATES,
    scan=st.sampled_from([5, 7, 10, 12, Fraction(25, 2), 15, Fraction(333, 10)]),
    ticks=st.integers(1, 40),
    motion=st.sampled_from(["frozen", "update", "continuous"]),
)
def test_a_whole_turn_holds_every_firing_once_for_any_ratio_of_rates(physics, loop, scan, ticks, motion):
    state = EmitterState(azimuth_deg=[0.0, 0.0], elevation_deg=[0.0, 1.0], fire_time_ns=[0, 1000])
    config = rotary(ticks, scan_hz=Fraction(scan), emitter_states=(state,))

    frames = scans(config, None, physics, loop, 0.5, motion)

    assert len({frame.timestamp_ns for frame in frames}) == len(frames) > 0
    for frame in frames:
        assert frame.scan_complete
        assert frame.channel("tickId").tolist() == np.repeat(np.arange(ticks), 2).tolist()
        assert frame.channel("emitterId").tolist() == [0, 1] * ticks
        azimuth = frame.channel("azimuth")[::2]
        assert len(np.unique(azimuth)) == ticks
        expected = (180.0 - 360.0 * np.arange(ticks) / ticks) % 360.0 - 180.0
        np.testing.assert_allclose(np.abs(azimuth - expected) % 360.0, 0.0, atol=4e-5)


@settings(max_examples=25, deadline=None)
@given(
    physics=RATES,
    loop=st.sampled_from([24, 30, 50, 60, 75, 120, Fraction(60000, 1001)]),
    scan=st.sampled_from([5, 7, 10, Fraction(25, 2), 20]),
    tick_rate=st.sampled_from([0, 1, 3, 11, 40]),
    ticks=st.integers(1, 40),
)
def test_partial_scans_of_any_ratio_hold_every_firing_once_in_order(physics, loop, scan, tick_rate, ticks):
    assume(Fraction(ceil(Fraction(physics) / Fraction(loop))) / physics <= 1 / Fraction(scan))  # longer: its last turn
    config = rotary(ticks, scan_hz=Fraction(scan), elevations=(0.0, 1.0))

    frames = scans(config, tick_rate, physics, loop, 0.5)

    fired = np.concatenate([frame.channel("tickId") * 2 + frame.channel("emitterId") for frame in frames])
    assert not any(frame.scan_complete for frame in frames)
    assert len(fired) > ticks
    assert fired.tolist() == (np.arange(len(fired)) % (2 * ticks)).tolist()


ALL = EVERYTHING | {"matId", "objId"}
IDS = {"/rtx-transient/stableIds/enabled": True}


def contents(tick_rate, motion="frozen", moving=False, updates=30, knobs=None, bodies=True, **fields):
    """Every channel of half a second, as bytes; element times on the simulation clock."""
    with weightless(lidar_motion=motion, settings=IDS, **(knobs or {})) as app:
        bind(app, add_box(app, "/World/Room", 20.0, (1, 2, 0)), "brick")
        mount = "/World"
        if moving:
            add_box(app, mount := "/World/Cart", 0.1, (0, 0, -5), velocity=(3.0, 1.0, 0), spin=(0, 0, 90))
            if bodies:
                add_box(app, "/World/Body", 2.0, (5, 0, 0), velocity=(1.0, 0.5, 0), spin=(20, 30, 40))
        config = rotary(90, elevations=(0.0, 3.0), **fields)
        product = add_lidar(app, f"{mount}/Lidar", (0, 0, 5 * moving), config, channels=ALL, tick_rate=tick_rate)
        frames = frames_of(app, product, updates)
        times = [frame.channel("timeOffsetNs") + np.uint64(frame.timestamp_ns) for frame in frames]
        joined = {name: np.concatenate([frame.channel(name) for frame in frames]) for name in ALL - {"timeOffsetNs"}}
        return {name: array.tobytes() for name, array in joined.items()} | {"time": np.concatenate(times).tobytes()}


@pytest.mark.parametrize("fields", [{}, {"accumulate_outputs": False}])
@pytest.mark.parametrize("tick_rate", [0, 5, 10, 20])
def test_partial_scans_are_the_bytes_of_whole_ones_in_every_channel(tick_rate, fields):
    whole = contents(10)

    assert len(whole["xyz"]) == 5 * 180 * 12
    assert contents(tick_rate, **fields) == whole


@pytest.mark.parametrize("motion", ["frozen", "update", "continuous"])
@pytest.mark.parametrize(
    "knobs", [{"lidar_noise": "on"}, {"lidar_subrays": 4}, {"lidar_noise": "on", "lidar_subrays": 2}]
)
def test_noise_and_sub_rays_do_not_see_how_a_turn_is_cut(motion, knobs):
    errors = {"azimuth_error_std": 0.1, "elevation_error_std": 0.1, "origin_error_std": (0.01,) * 3}

    whole = contents(10, motion, knobs=knobs, **errors)

    assert contents(0, motion, knobs=knobs, **errors) == whole
    assert contents(10, "frozen", knobs=knobs, **errors) == whole


@pytest.mark.parametrize("tick_rate", [0, 20])
def test_slices_of_a_moving_world_are_the_bytes_that_update_puts_together(tick_rate):
    assert contents(tick_rate, "update", moving=True) == contents(10, "update", moving=True)


@pytest.mark.parametrize("tick_rate", [0, 7, 20])
def test_slices_of_a_continuous_turn_are_its_bytes_where_only_the_sensor_moves(tick_rate):
    whole = contents(10, "continuous", moving=True, bodies=False)

    assert len(whole["velocities"]) == 5 * 180 * 12
    assert contents(tick_rate, "continuous", moving=True, bodies=False) == whole
