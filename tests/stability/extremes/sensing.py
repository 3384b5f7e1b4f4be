"""Sensors: 1000 km out, at the wrap of the azimuth, at the poles, at velocities of zero and beyond the unambiguous."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from graph.cli.extreme_cases import GROUND, OFFSETS, WEIGHTLESS, Case, beams, body, channel, cube, seen, worst
from tests.stability.extremes.worlds import ahead, directions

AREA = "sensors"
FAR = OFFSETS[:3]
"""To 1000 km."""

WPM = "omni:sensor:WpmDmat:"
SCAN = f"{WPM}scan:s001:"
UNAMBIGUOUS = 10.0
"""Velocity [m/s] at which the radar's velocities fold."""
NARROW = {
    f"{WPM}antennaGainMode": "CONSTANT",
    f"{SCAN}maxAzAngDeg": 10.0,
    f"{SCAN}maxElAngDeg": 5.0,
    f"{SCAN}maxVelMpsSequence": [UNAMBIGUOUS],
    "omni:sensor:tickRate": 60,
}
BALL = {"type": "Sphere", "radius": 0.5, "rigid_body": True, "mass": 1.0}


def depth(offset: float) -> float:
    """A camera that looks along x, at a wall [m]."""
    place = np.full(3, offset)
    prims = {"/Wall": cube(100, ahead(place, 55))}
    frame = seen("Camera", prims, "distance_to_image_plane", place, rotate=[90, 0, -90])
    return worst(channel(frame, "distance_to_image_plane"), 5.0)


def echo(prims: Any, place: Any = (0, 0, 0)) -> tuple[float, float]:
    """Range [m] and velocity [m/s] of a radar's strongest detection."""
    frame = seen("OmniRadar", prims, "distance rv_ms scalar", place, attributes=NARROW)
    at = int(np.argmax(channel(frame, "scalar")))
    return float(channel(frame, "distance")[at]), float(channel(frame, "rv_ms")[at])


def far_echo(offset: float) -> float:
    """A ball whose nearest point is 9.5 m away [m]."""
    place = np.full(3, offset)
    distance, _ = echo({**WEIGHTLESS, "/Ball": {**BALL, "translate": ahead(place, 10).tolist()}}, place)
    return abs(distance - 9.5)


def far_speed(offset: float) -> float:
    """The velocity of a wall that comes at 3 m/s, as a lidar has it [m/s]."""
    place = np.full(3, offset)
    prims = {**WEIGHTLESS, "/Wall": body(2, ahead(place, 6), velocity=[-3, 0, 0])}
    frame = seen("OmniLidar", prims, "velocities", place, config=beams([-3.0, 0, 3]))
    return worst(channel(frame, "velocities"), np.array([-3, 0, 0]))


def standing(kind: str) -> float:
    """The largest velocity where nothing moves [m/s]."""
    prims = {**GROUND, "/Wall": cube(2, (6, 0, 0)), "/Box": body(0.5, (4, 0, 0.25))}
    if kind == "radar":
        frame = seen("OmniRadar", {"/Wall": cube(2, (6, 0, 0))}, "rv_ms scalar", attributes=NARROW)
        return worst(channel(frame, "rv_ms"), 0.0)
    prims = {**WEIGHTLESS, **prims}
    frame = seen("OmniLidar", prims, "velocities", (0, 0, 0.3), config=beams(np.linspace(-9.0, 9.0, 19), -1.0))
    return worst(channel(frame, "velocities"), 0.0)


def folded(speed: float) -> float:
    """How far a receding ball's velocity is from v - 2 u round(v / 2 u) [m/s]."""
    ball = {**BALL, "translate": [10, 0, 0], "velocity": [speed, 0, 0]}
    wanted = math.remainder(speed, 2 * UNAMBIGUOUS)
    found = echo({**WEIGHTLESS, "/Ball": ball})[1]
    return abs(math.remainder(found - wanted, 2 * UNAMBIGUOUS))


def wrapped(azimuth: float) -> float:
    """Beams about an azimuth [deg]: how far their points are from the walls around, with angles from -180 to 180."""
    angles = azimuth + np.linspace(-1.0, 1.0, 11)
    frame = seen("OmniLidar", {"/Room": cube(20, (0, 0, 0))}, "xyz azimuth distance", config=beams(angles))
    ways = directions(angles)
    wanted = ways * (10 / np.abs(ways).max(axis=1))[:, None]
    shown = channel(frame, "azimuth")
    outside = float(np.maximum(np.abs(shown) - 180, 0).max())
    return max(outside, worst(channel(frame, "xyz"), wanted))


def polar(elevation: float) -> float:
    """Beams straight up and down in a room, at any azimuth: how far their points are from ceiling or floor [m]."""
    azimuth = np.linspace(-180.0, 180.0, 9)
    frame = seen("OmniLidar", {"/Room": cube(20, (0, 0, 0))}, "xyz", config=beams(azimuth, elevation))
    return worst(channel(frame, "xyz"), np.array([0, 0, math.copysign(10, elevation)]))


CASES = (
    Case(AREA, "a camera's depth, 0 to 1000 km from the origin", 1e-3, "m", "rays are float32 around the camera", depth,
         FAR),
    Case(AREA, "a radar's range, 0 to 1000 km from the origin", 5e-3, "m", "ways are float64; the nearest ray",
         far_echo, FAR),
    Case(AREA, "a lidar's velocities, 0 to 1000 km from the origin", 1e-4, "m/s", "float32 of what physics has",
         far_speed, FAR),
    Case(AREA, "velocities where nothing moves", 0.0, "m/s", "no rounding: nothing is differenced", standing,
         ("lidar", "radar")),
    Case(AREA, "a radar at 0, 1 and 2.5 times its velocity", 0.01, "m/s", "v - 2 u round(v / 2 u), u = 10 m/s", folded,
         (0.0, 9.9, 10.0, 10.1, 25.0)),
    Case(AREA, "beams at azimuths of -540 to 540 deg", 1e-4, "m or deg", "angles are shown from -180 to 180", wrapped,
         (-540.0, -180.0, 0.0, 180.0, 540.0)),
    Case(AREA, "beams at the poles", 1e-5, "m", "cos 90 deg is 6e-17; azimuth does not matter", polar, (-90.0, 90.0)),
)  # fmt: skip
