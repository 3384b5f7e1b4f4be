"""Oracles of contact: friction, restitution, piles."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from graph.sim.transforms import Floats

from .case import CROWDED, GROUND, NARROW, Case, G, Knobs, material, world


def slope(degrees: float) -> dict[str, Any]:
    """Gravity over level ground that is tilted: down the slope is +x."""
    angle = math.radians(degrees)
    down = {"physics:gravityDirection": [math.sin(angle), 0, -math.cos(angle)]}
    return {"/Scene": {"type": "PhysicsScene", "attributes": down}, **GROUND}


BLOCK = {"type": "Cube", "size": 0.2, "translate": [0, 0, 0.1], "rigid_body": True, "mass": 1.0}


def creep(hz: int, knobs: Knobs, degrees: float = 25.0, seconds: int = 10) -> float:
    """How far a box at rest slides on a slope that friction holds (25 < atan 0.5 = 26.6 degrees) [mm]."""
    physics = world({**slope(degrees), "/Box": BLOCK}, hz, knobs)
    physics.step(seconds * hz)
    return float(np.linalg.norm(physics.positions[0, :2])) * 1000


def letting_go(hz: int, knobs: Knobs, degrees: float = 35.0) -> float:
    """a = g (sin - mu cos) on a slope that friction does not hold: relative error."""
    physics = world({**slope(degrees), "/Box": {**BLOCK, "scale": [1, 1, 0.1], "translate": [0, 0, 0.01]}}, hz, knobs)
    speed, angle = gained(physics, hz)[0, 0], math.radians(degrees)
    return abs(speed / (G * (math.sin(angle) - 0.5 * math.cos(angle))) - 1)


def gained(physics: Any, hz: int) -> Floats:
    """(B, 3) accelerations [m/s2] from 0.5 s, when contacts are loaded, to 1.5 s."""
    physics.step(hz // 2)
    before = physics.velocities()[:, :3].copy()
    physics.step(hz)
    out: Floats = physics.velocities()[:, :3] - before
    return out


def stopping(hz: int, knobs: Knobs) -> float:
    """A box at v = 3 m/s stops after v2 / (2 mu g), along a diagonal: relative error."""
    speed = 3.0
    box = {**BLOCK, "scale": [1, 1, 0.1], "translate": [0, 0, 0.01]}
    start = {"velocity": [speed * math.sqrt(0.5), speed * math.sqrt(0.5), 0]}
    physics = world({**GROUND, "/Box": {**box, **start}}, hz, knobs)
    physics.step(hz)
    return abs(float(np.hypot(*physics.positions[0, :2])) / (speed**2 / (2 * 0.5 * G)) - 1)


def rolling_sphere(hz: int, knobs: Knobs) -> float:
    """A solid ball rolls down a slope of 20 degrees with 5/7 g sin, mu > 2/7 tan: relative error of its speed."""
    ball = {"type": "Sphere", "radius": 0.1, "translate": [0, 0, 0.1], "rigid_body": True}
    physics = world({**slope(20), "/Ball": ball}, hz, knobs)
    return abs(gained(physics, hz)[0, 0] / (5 / 7 * G * math.sin(math.radians(20))) - 1)


def box_on_ground_under_balls(hz: int, knobs: Knobs, diagonal: bool = True) -> tuple[float, float]:
    """Accelerations [m/s2] of a box of 10 kg and of the 25 balls of 1 kg that roll on it, pushed with 150 N.

    Friction 0.4 below the box, 0.8 above it (after the rolling test of SimBenchmark).
    """
    binds = {"attributes": {"material:binding:physics": "/Smooth"}}
    prims: dict[str, Any] = {**material("/Smooth", 0.4), **material("/Rough", 1.2)}  # an average of 0.8 with 0.4
    prims["/Ground"] = {"type": "Plane", **binds}
    prims["/Box"] = {"type": "Cube", "size": 1.0, "scale": [8, 8, 0.2], "translate": [0, 0, 0.1], "mass": 10.0}
    prims["/Box"] |= {"rigid_body": True, **binds}
    rough = {"attributes": {"material:binding:physics": "/Rough"}, "rigid_body": True, "mass": 1.0}
    for row in range(5):
        for column in range(5):
            place = [0.5 * row - 1, 0.5 * column - 1, 0.3]
            prims[f"/Ball{row}{column}"] = {"type": "Sphere", "radius": 0.1, "translate": place, **rough}
    physics = world(prims, hz, knobs)
    along = np.array([1, 1, 0]) / math.sqrt(2) if diagonal else np.array([1.0, 0, 0])
    physics.set_forces(["/Box"], np.array([[*(150 * along), 0, 0, 0]]))
    speeds = gained(physics, hz) @ along
    box = physics.body_paths.index("/Box")
    return float(speeds[box]), float(np.delete(speeds, box).mean())


BOX = (150 - 0.4 * 35 * G) / (10 + 25 * 2 / 7)
"""(F - mu (M + 25 m) g) / (M + 25 * 2/7 m) = 0.7385: a ball takes 2/7 of the acceleration below it, here 0.2110."""


def rolling(diagonal: bool) -> Any:
    """The larger relative error of box and balls."""

    def error(hz: int, knobs: Knobs) -> float:
        box, ball = box_on_ground_under_balls(hz, knobs, diagonal)
        return max(abs(box / BOX - 1), abs(ball / (BOX * 2 / 7) - 1))

    return error


def sinking(hz: int, knobs: Knobs) -> float:
    """6 x 6 x 6 balls of 10 kg without friction, a little out of order, fall apart in 1 s: deepest overlap [mm]."""
    radius, random = 0.1, np.random.default_rng(6)
    bare = {"attributes": {"material:binding:physics": "/Bare"}}
    prims: dict[str, Any] = {**material("/Bare", 0.0), "/Ground": {"type": "Plane", **bare}}
    for number, place in enumerate(np.ndindex(6, 6, 6)):
        middle = (np.array(place) * 2 + 1) * radius + random.uniform(-1, 1, 3) * 0.01 * radius
        ball = {"type": "Sphere", "radius": radius, "translate": middle.tolist(), "rigid_body": True, "mass": 10.0}
        prims[f"/Ball{number}"] = {**ball, **bare}
    physics = world(prims, hz, knobs)
    deepest = 0.0
    for _ in range(hz):
        physics.step()
        deepest = min(deepest, float(physics.contacts().distances.min(initial=0.0)))
    return -1000 * deepest


def stack(hz: int, knobs: Knobs) -> float:
    """Ten boxes of 0.2 m stand for 3 s: how far the top one is from its place [mm]."""
    boxes = {f"/Box{n}": {**BLOCK, "translate": [0, 0, 0.2 * n + 0.1]} for n in range(10)}
    physics = world({**GROUND, **boxes}, hz, knobs)
    physics.step(3 * hz)
    top = physics.positions[physics.body_paths.index("/Box9")]
    return float(np.linalg.norm(top - [0, 0, 1.9])) * 1000


def ball_on(restitution: float, height: float) -> dict[str, Any]:
    """A ball whose lowest point is at a height over ground of one material with it."""
    binds = {"attributes": {"material:binding:physics": "/Hard"}}
    ball = {"type": "Sphere", "radius": 0.1, "translate": [0, 0, height + 0.1], "rigid_body": True, **binds}
    return {**material("/Hard", 0.5, restitution), "/Ground": {"type": "Plane", **binds}, "/Ball": ball}


def restitution(hz: int, knobs: Knobs) -> float:
    """Dropped from h = 1 m it leaves the ground with e sqrt(2 g h), e = 0.5: relative error of that speed."""
    physics = world(ball_on(0.5, 1.0), hz, knobs)
    fastest = 0.0
    for _ in range(hz):
        physics.step()
        fastest = max(fastest, float(physics.velocities()[0, 2]))
    return abs(fastest / (0.5 * math.sqrt(2 * G)) - 1)


def bouncing(hz: int, knobs: Knobs) -> float:
    """Dropped from 1 m with e = 0.8, its fifth top is e^10 of that: error of the height [mm]."""
    physics = world(ball_on(0.8, 1.0), hz, knobs)
    tops, before, rising = [], 1.0, False
    for _ in range(5 * hz):
        physics.step()
        now = float(physics.positions[0, 2]) - 0.1
        if rising and now < before:
            tops.append(before)
        rising, before = now > before, now
    return abs(tops[4] - 0.8**10) * 1000 if len(tops) > 4 else math.inf


CASES = (
    Case("sticking ramp", "a box at rest on 25 degrees, mu 0.5, stays (10 s)", "mm", creep, 0.6, rates=NARROW),
    Case("sliding ramp", "a = g (sin - mu cos) on 35 degrees", "", letting_go, 0.06),
    Case("stopping distance", "v2 / (2 mu g) along a diagonal", "", stopping, 0.01),
    Case("rolling ball", "5/7 g sin on 20 degrees", "", rolling_sphere, 0.001),
    Case("rolling, straight", "box 0.7385, balls 0.2110 m/s2", "", rolling(False), 0.2, rates=NARROW),
    Case("rolling, diagonal", "the same", "", rolling(True), 0.2, rates=NARROW),
    Case("666", "no overlap", "mm", sinking, 25.0, rates=CROWDED),
    Case("stack", "ten boxes stand", "mm", stack, 1.5, rates=NARROW),
    Case("restitution", "e sqrt(2 g h)", "", restitution, 0.01),
    Case("bouncing ball", "its fifth top is e^10 h", "mm", bouncing, 5.0),
)
