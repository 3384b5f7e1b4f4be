"""Range, velocity and angles as frames give them: Doppler, ambiguity, cells, ghosts. Positive velocity recedes."""

import math

import numpy as np
import pytest

from tests.support.radar_scenes import SCAN, WPM, plate, radar_world, trihedral

FOUR = {f"{WPM}cfarMode": "4D"}
WIDE = {f"{SCAN}maxAzAngDeg": 75.0, f"{SCAN}raysPerDeg": 2.0}
BALL = {"type": "Sphere", "radius": 0.3, "rigid_body": True}


def strongest(product):
    """Range, velocity, azimuth [deg] of the strongest detection."""
    frame = product.frame
    at = int(np.argmax(frame.channel("scalar")))
    return tuple(float(frame.channel(name)[at]) for name in ("distance", "rv_ms", "azimuth"))


def everything(product):
    """Range, velocity, azimuth [deg], RCS [dBsm] of all detections."""
    frame = product.frame
    return np.stack([frame.channel(name) for name in ("distance", "rv_ms", "azimuth", "scalar")], 1).astype(float)


@pytest.mark.parametrize("speed", [-10.0, 7.0, 0.5])
def test_a_target_that_moves_away_has_positive_velocity(speed):
    """The ball is cast after one step of 1/60 s; its velocity is its own, gravity acts across the line of sight."""
    ball = {"/World/Ball": {**BALL, "translate": [20, 0, 0], "velocity": [speed, 0, 0]}}
    with radar_world(ball) as (app, product):
        app.update()
        distance, velocity, _ = strongest(product)
    assert velocity == pytest.approx(speed, abs=0.01)
    assert distance == pytest.approx(20 - 0.3 + speed / 60, abs=5e-3)


def test_nothing_moves_in_a_world_that_stands_still():
    """Not by rounding: every velocity is 0."""
    ground = {"type": "Plane", "translate": [0, 0, -1], "material": "gravel"}
    prims = {**trihedral(0.1, 20.0), "/World/Ground": ground}
    with radar_world(prims, WIDE) as (app, product):
        app.update(steps=2)
        velocities = everything(product)[:, 1]
    assert len(velocities) > 1
    assert not velocities.any()


@pytest.mark.parametrize(
    ("azimuth", "expected"), [(0.0, -10.0), (60.0, -5.0), (70.0, -10 * math.cos(math.radians(70))), (-40.0, -7.66)]
)
def test_a_radar_that_drives_sees_what_stands_come_by_the_cosine(azimuth, expected):
    """10 m/s along x: -10 cos(azimuth) of a static ball in 20 m; a cell has 0.147 m/s, the value lies inside it."""
    place = [20 * math.cos(math.radians(azimuth)), 20 * math.sin(math.radians(azimuth)), 0]
    prims = {
        "/World/Car": {"type": "Cube", "size": 0.1, "rigid_body": True, "velocity": [10, 0, 0]},
        "/World/Ball": {"type": "Sphere", "radius": 0.3, "translate": place},
        "/World/Car/Mount": {"type": "Xform"},
    }
    with radar_world(prims, WIDE, path="/World/Car/Radar", exclude=["/World/Car"]) as (app, product):
        app.update()
        _, velocity, seen = strongest(product)
    # After one step the car is 1/6 m ahead, the ball at another angle.
    beside, ahead = place[1], place[0] - 10 / 60
    assert velocity == pytest.approx(-10 * ahead / math.hypot(beside, ahead), abs=0.02)
    assert velocity == pytest.approx(expected, abs=0.1)
    assert seen == pytest.approx(math.degrees(math.atan2(beside, ahead)), abs=0.3)


def test_a_radar_on_an_arm_moves_as_the_arm_turns():
    """1 rad/s about z with a lever of 2 m along y: it moves at -2 m/s along x, a ball ahead recedes at 2."""
    prims = {
        "/World/Arm": {"type": "Cube", "size": 0.1, "rigid_body": True, "angular_velocity": [0, 0, 57.29578]},
        "/World/Ball": {"type": "Sphere", "radius": 0.3, "translate": [20, 2, 0]},
    }
    options = {"path": "/World/Arm/Radar", "exclude": ["/World/Arm"], "translate": [0, 2, 0]}
    with radar_world(prims, **options) as (app, product):
        app.update()
        _, velocity, _ = strongest(product)
    assert velocity == pytest.approx(2.0, abs=0.01)


def test_a_target_on_a_turning_arm_moves_with_it():
    """2 rad/s about z, 1.5 m to the left of the axis: it comes nearer at 3 m/s. After a step of 1/60 s the arm is
    1/30 rad further: the ball's middle is at 20 - 1.5 sin, 1.5 cos, and its velocity of 3 m/s lies across the arm."""
    arm = {
        "type": "Cube",
        "size": 0.02,
        "rigid_body": True,
        "translate": [20, 0, 0],
        "angular_velocity": [0, 0, 114.59156],
    }
    ball = {"type": "Sphere", "radius": 0.2, "translate": [0, 1.5, 0]}
    with radar_world({"/World/Arm": arm, "/World/Arm/Ball": ball}) as (app, product):
        app.update()
        pose = app.fabric.rigid_matrices(("/World/Arm",))[0]
        linear, angular = np.split(app.fabric.velocities(("/World/Arm",))[0], 2)
        lever = pose[:3, :3] @ [0, 1.5, 0]
        middle = pose[:3, 3] + lever
        towards = middle / np.linalg.norm(middle)
        _, velocity, _ = strongest(product)
    assert np.linalg.norm(angular) == pytest.approx(2.0, rel=0.01)
    assert velocity == pytest.approx((linear + np.cross(angular, lever)) @ towards, abs=0.02)


@pytest.mark.parametrize("speed", [0.3, 7.0, -31.4])
def test_velocities_of_cells_are_their_middles(speed):
    """Cells of 100 / 681 m/s begin at -50: the middle is -50 + (floor((v + 50) / w) + 0.5) w."""
    ball = {"/World/Ball": {**BALL, "translate": [20, 0, 0], "velocity": [speed, 0, 0]}}
    with radar_world(ball, {f"{SCAN}detValFromBinIdx": True}) as (app, product):
        app.update()
        _, velocity, _ = strongest(product)
    width = 100 / math.ceil(100 / 0.147)
    assert velocity == pytest.approx(-50 + (math.floor((speed + 50) / width) + 0.5) * width, abs=1e-4)


@pytest.mark.parametrize(("cycle", "limit", "seen"), [(0, 50.0, 40.0), (1, 55.0, 50.0), (2, 65.0, -60.0)])
def test_a_velocity_beyond_the_limit_is_folded_differently_in_each_cycle(cycle, limit, seen):
    """((v + v_m) mod 2 v_m) - v_m of v = -60 m/s."""
    ball = {"/World/Ball": {**BALL, "translate": [40, 0, 0], "velocity": [-60, 0, 0]}}
    with radar_world(ball, {f"{SCAN}maxVelMpsSequence": [50.0, 55.0, 65.0]}) as (app, product):
        app.update(steps=cycle + 1)
        _, velocity, _ = strongest(product)
        assert product.frame.facts["maxVelMps"] == limit
    assert velocity == pytest.approx(seen, abs=0.03)


@pytest.mark.parametrize("distance", [10.05, 10.21, 17.77, 33.33])
def test_values_of_cells_are_their_middles(distance):
    """Range cells of 0.4 m: the middle is floor(R / 0.4) 0.4 + 0.2."""
    with radar_world(plate(0.2, distance), {f"{SCAN}detValFromBinIdx": True}) as (app, product):
        app.update()
        seen, velocity, _ = strongest(product)
    assert seen == pytest.approx(math.floor(distance / 0.4) * 0.4 + 0.2, abs=1e-5)
    assert abs(velocity) <= 0.147 / 2


@pytest.mark.parametrize(("second", "count"), [(10.3, 1), (10.9, 2)])
def test_two_targets_are_two_where_their_cells_are(second, count):
    """0.4 m cells begin at 10.0, 10.4, 10.8: 10.1 and 10.3 share one."""
    prims = {}
    for name, distance, side in (("A", 10.1, -0.4), ("B", second, 0.4)):
        box = plate(0.1, distance)["/World/Plate"]
        prims[f"/World/{name}"] = {**box, "translate": [distance, side, 0], "rotate": [0, 0, math.degrees(side / 10)]}
    with radar_world(prims) as (app, product):
        app.update()
        near = everything(product)[:, 0]
    assert len(near) == count


@pytest.mark.parametrize("material", ["calibration_lambertion", "steel"])
def test_a_mirror_makes_ghosts_at_the_ways_of_its_image(material):
    """Radar at 0, a rough or smooth ball at (10, 0), a mirror y = 3: the image is at (10, 6), 11.662 m away at
    30.96 deg. Seen are 10 m at 0, the ways there by one and back by the other, 10.831 m at 0 and at 30.96, and 11.662 m
    at 30.96; all less the ball's radius of 0.05 m on each way."""
    prims = {
        "/World/Mirror": {"type": "Cube", "size": 1.0, "scale": [30, 0.01, 6], "translate": [10, 3.005, 0]},
        "/World/Ball": {
            "type": "Sphere",
            "radius": 0.05,
            "translate": [10, 0, 0],
            "material": material,
        },
    }
    attributes = {**FOUR, f"{SCAN}maxAzAngDeg": 45.0, f"{SCAN}rcsTuningCoefficients": [-200.0, 1.0, 0.0]}
    attributes |= {f"{SCAN}cfarMinVal": 1e-30, f"{SCAN}cfarOffset": 0.0}
    with radar_world(prims, attributes) as (app, product):
        app.update()
        found = everything(product)
    for distance, azimuth in ((10.0, 0.0), (10.831, 0.0), (10.831, 30.96), (11.662, 30.96)):
        near = (np.abs(found[:, 0] - distance) < 0.1) & (np.abs(found[:, 2] - azimuth) < 1.0)
        assert near.any(), (distance, azimuth)


@pytest.mark.parametrize("target", ["calibration_lambertion", "steel"])
def test_ghosts_lose_what_each_mirror_takes(target):
    """The way by a mirror there and straight back meets it once, that by its image twice, at one angle: if a mirror of
    glass, and not of steel, costs the first x dB, it costs the second 2 x. A steel one costs nothing: a smooth ball
    returns pi r^2 x (R - r)^2 / R^2 by its image, R = 11.662 m, -5.71 dBsm for r = 0.3 m."""
    found = {}
    for mirror in ("steel", "clear_glass"):
        prims = {
            "/World/Mirror": {
                "type": "Cube",
                "size": 1.0,
                "scale": [30, 0.01, 6],
                "translate": [10, 3.005, 0],
                "material": mirror,
            },
            "/World/Ball": {"type": "Sphere", "radius": 0.3, "translate": [10, 0, 0], "material": target},
        }
        attributes = {**FOUR, f"{SCAN}maxAzAngDeg": 45.0, f"{SCAN}rcsTuningCoefficients": [-300.0, 1.0, 0.0]}
        attributes |= {f"{SCAN}cfarMinVal": 1e-30, f"{SCAN}cfarOffset": 0.0}
        with radar_world(prims, attributes) as (app, product):
            app.update()
            seen = everything(product)
        for name, distance, azimuth in (("once", 10.542, 0.0), ("twice", 11.362, 30.96)):
            near = (np.abs(seen[:, 0] - distance) < 0.15) & (np.abs(seen[:, 2] - azimuth) < 2.0)
            found[mirror, name] = 10 * math.log10((10 ** (seen[near, 3] / 10)).sum())
    once, twice = (found["clear_glass", name] - found["steel", name] for name in ("once", "twice"))
    assert once < -2
    assert twice == pytest.approx(2 * once, abs=0.3)
    if target == "steel":
        assert found["steel", "twice"] == pytest.approx(-5.71, abs=0.5)


@pytest.mark.parametrize("material", ["calibration_lambertion", "steel"])
def test_a_moving_target_moves_its_ghosts_by_half_the_rate_of_their_ways(material):
    """The ball moves at +5 m/s along x: 5, (5 + 5 cos 30.96) / 2 = 4.644, 5 cos 30.96 = 4.287."""
    prims = {
        "/World/Mirror": {"type": "Cube", "size": 1.0, "scale": [30, 0.01, 6], "translate": [10, 3.005, 0]},
        "/World/Ball": {
            **BALL,
            **{"radius": 0.05, "translate": [10 - 5 / 60, 0, 0], "velocity": [5, 0, 0]},
            "material": material,
        },
    }
    attributes = {**FOUR, f"{SCAN}maxAzAngDeg": 45.0, f"{SCAN}rcsTuningCoefficients": [-200.0, 1.0, 0.0]}
    attributes |= {f"{SCAN}cfarMinVal": 1e-30, f"{SCAN}cfarOffset": 0.0}
    with radar_world(prims, attributes) as (app, product):
        app.update()
        found = everything(product)
    for distance, azimuth, velocity in (
        (10.0, 0.0, 5.0),
        (10.831, 0.0, 4.644),
        (10.831, 30.96, 4.644),
        (11.662, 30.96, 4.287),
    ):
        near = (np.abs(found[:, 0] - distance) < 0.1) & (np.abs(found[:, 2] - azimuth) < 1.0)
        assert near.any(), (distance, azimuth)
        best = found[near][np.argmax(found[near, 3])]
        assert best[1] == pytest.approx(velocity, abs=0.05)


@pytest.mark.parametrize(("distance", "kept"), [(102.0, True), (102.6, False)])
def test_the_least_power_ends_the_range_of_a_target_of_one_square_metre(distance, kept):
    """P lambda^2 / ((4 pi)^3 R^4) = 7e-17 W at R = 102.294 m; 4 pi A^2 / lambda^2 = 1 m^2 for a plate of this side."""
    side = math.sqrt(3.9e-3 / math.sqrt(4 * math.pi))
    attributes = {f"{SCAN}maxRangeM": 120.0, f"{SCAN}rcsTuningCoefficients": [-12.0, 1.0, 0.0]}
    with radar_world(plate(side, distance), attributes) as (app, product):
        app.update()
        assert (product.frame.count == 1) is kept


def test_cloth_is_seen_where_and_as_fast_as_it_flies():
    """A sheet of 2 x 2 m, still at 9 m when play begins, flies at 10 m/s along the line of sight: after six updates it
    is 1 m nearer. Its shape gives no flat face, so each ray returns by itself."""
    points = [(9.0, y, z) for y in np.linspace(-1, 1, 5) for z in np.linspace(-1, 1, 5)]
    faces = [(5 * i + j, 5 * i + j + 5, 5 * i + j + 6, 5 * i + j + 1) for i in range(4) for j in range(4)]
    text = f"""
def Mesh "Cloth" (prepend apiSchemas = ["PhysxDeformableSurfaceAPI"])
{{
    point3f[] points = {[tuple(map(float, point)) for point in points]}
    int[] faceVertexCounts = {[4] * 16}
    int[] faceVertexIndices = {[corner for face in faces for corner in face]}
    vector3f physics:velocity = (-10, 0, 0)
}}
"""
    with radar_world({}, {f"{SCAN}rcsTuningCoefficients": [-60.0, 1.0, 0.0]}) as (app, product):
        app.stop()
        app.stage.GetRootLayer().ImportFromString(app.stage.GetRootLayer().ExportToString() + text)
        app.play()
        app.update(steps=6)
        distance, velocity, _ = strongest(product)
        assert distance == pytest.approx(8.0, abs=0.1)
        assert velocity == pytest.approx(-10.0, abs=0.05)  # gravity, -0.98 m/s by then, acts across
