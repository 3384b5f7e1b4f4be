"""Oracles of jointed bodies: pendulums, a spring drive, a robot on wheels."""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np

from graph.sim.transforms import Floats

from .case import NARROW, NO_GRAVITY, Case, G, Knobs, first_order, world
from .contacts import slope
from .free_bodies import body, jacobi

ARM, INERTIA = 0.5, 1 / 64
"""From a pendulum's axis to its centre of mass [m]; inertia about that centre [kg m2]; the mass is 1 kg."""


def hinge(first: str | None, second: str, place0: list[float], place1: list[float], **more: Any) -> dict[str, Any]:
    """A revolute joint about Y."""
    ends: dict[str, Any] = {"physics:body1": second, "physics:axis": "Y"} | ({"physics:body0": first} if first else {})
    ends |= {"physics:localPos0": place0, "physics:localPos1": place1}
    return {"type": "PhysicsRevoluteJoint", **more, "attributes": {**ends, **more.get("attributes", {})}}


def bob(distance: float) -> dict[str, Any]:
    """A pendulum's body, held out horizontally."""
    return body((INERTIA,) * 3, (0, 0, 0), translate=[distance, 0, 0])


def pendulum(hz: int, knobs: Knobs) -> float:
    """Let go at 90 degrees: sin(x / 2) = k cd(w t, k2), k = sin 45 degrees: error of the angle after 1 s [rad]."""
    prims = {"/Bob": bob(ARM), "/Axle": hinge(None, "/Bob", [0, 0, 0], [-ARM, 0, 0])}
    physics = world(prims, hz, knobs)
    physics.step(hz)
    k = math.sin(math.pi / 4)
    _, cn, dn = jacobi(math.sqrt(G * ARM / (INERTIA + ARM**2)), k * k)
    return abs(hanging(physics.positions[0]) - 2 * math.asin(k * cn / dn))


def hanging(place: Floats) -> float:
    """The angle of a place from straight down, towards +x [rad]."""
    return math.atan2(place[0], -place[2])


def double_pendulum(hz: int, knobs: Knobs) -> float:
    """Two bars let go horizontally: error of the second one's angle after 0.5 s [rad], against a converged solution."""
    prims = {"/One": bob(ARM), "/Two": bob(3 * ARM), "/A": hinge(None, "/One", [0, 0, 0], [-ARM, 0, 0])}
    prims["/B"] = hinge("/One", "/Two", [ARM, 0, 0], [-ARM, 0, 0])
    physics = world(prims, hz, knobs)
    physics.step(hz // 2)
    one, two = (physics.positions[physics.body_paths.index(path)] for path in ("/One", "/Two"))
    return abs(math.remainder(hanging(two - 2 * one) - two_bars(0.5)[1], 2 * math.pi))


@cache
def two_bars(time: float, steps: int = 4000) -> Floats:
    """(2,) absolute angles of two equal bars let go at 90 degrees, by the classical Runge-Kutta method."""

    def rates(state: Floats) -> Floats:
        (a, b), (p, q) = state[:2], state[2:]
        inertia = INERTIA + ARM**2
        cross = 2 * ARM**2
        mass = np.array([[inertia + 4 * ARM**2, cross * math.cos(a - b)], [cross * math.cos(a - b), inertia]])
        force = [
            -cross * math.sin(a - b) * q * q - 3 * G * ARM * math.sin(a),
            cross * math.sin(a - b) * p * p - G * ARM * math.sin(b),
        ]
        return np.concatenate([state[2:], np.linalg.solve(mass, force)])

    state, h = np.array([math.pi / 2, math.pi / 2, 0.0, 0.0]), time / steps
    for _ in range(steps):
        k1 = rates(state)
        k2 = rates(state + h / 2 * k1)
        k3 = rates(state + h / 2 * k2)
        k4 = rates(state + h * k3)
        state = state + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return state[:2]


RATE, SHARE = 10.0, 0.2
"""Undamped rate [rad/s] and damping ratio of the spring drive."""


def spring(hz: int, knobs: Knobs, share: float = SHARE) -> float:
    """A drive's answer to a step of 1: the largest error in 1 s. share: its damping ratio."""
    gains = {"stiffness": RATE**2, "damping": 2 * share * RATE, "targetPosition": 1.0}
    drive = {f"drive:linear:physics:{name}": value for name, value in gains.items()}
    rail: dict[str, Any] = {"type": "PhysicsPrismaticJoint", "schemas": "PhysicsDriveAPI:linear"}
    rail["attributes"] = {"physics:body1": "/Mass", "physics:axis": "X", **drive}
    physics = world({**NO_GRAVITY, "/Mass": body((1, 1, 1), (0, 0, 0)), "/Rail": rail}, hz, knobs)
    damped, worst = RATE * math.sqrt(1 - share**2), 0.0
    for number in range(1, hz + 1):
        physics.step()
        t = number / hz
        swing = math.cos(damped * t) + share * RATE / damped * math.sin(damped * t)
        worst = max(worst, abs(float(physics.positions[0, 0]) - 1 + math.exp(-share * RATE * t) * swing))
    return worst


def swinging(hz: int, knobs: Knobs) -> float:
    """The same without damping, 1 - cos w t: implicit steps take w^2 dt / 2 of its swing a second, 19 % at 240 Hz."""
    return spring(hz, knobs, 0.0)


WHEEL, MOTOR = 0.1, 5.0
"""Radius of the wheels [m]; damping of their drives [N m s/rad]."""


def robot(degrees: float, speed: float) -> dict[str, Any]:
    """A chassis of 6 kg on four wheels of 0.5 kg, on a slope that falls towards +x; its motors turn at `speed`."""
    prims: dict[str, Any] = {**slope(degrees)}
    prims["/Chassis"] = {"type": "Cube", "size": 0.1, "scale": [4, 2, 1], "translate": [0, 0, 0.15], "mass": 6.0}
    prims["/Chassis"] |= {"rigid_body": True}
    for name, x, y in (("A", 0.15, 0.15), ("B", 0.15, -0.15), ("C", -0.15, 0.15), ("D", -0.15, -0.15)):
        disc = {"type": "Cylinder", "radius": WHEEL, "height": 0.04, "axis": "Y", "rigid_body": True, "mass": 0.5}
        prims[f"/Wheel{name}"] = {**disc, "translate": [x, y, WHEEL]}
        gains = {"damping": math.radians(MOTOR), "targetVelocity": math.degrees(speed)}
        drive = {f"drive:angular:physics:{key}": value for key, value in gains.items()}
        place = [x, y, WHEEL - 0.15]
        axle = hinge("/Chassis", f"/Wheel{name}", place, [0, 0, 0], schemas="PhysicsDriveAPI:angular", attributes=drive)
        prims[f"/Axle{name}"] = axle
    return prims


def climbing(hz: int, knobs: Knobs, degrees: float = 10.0, speed: float = -10.0) -> float:
    """Up 10 degrees each motor carries m g sin r / 4, so it turns by that / damping slower: error of the speed."""
    physics = world(robot(degrees, speed), hz, knobs)
    physics.step(hz)
    chassis = physics.body_paths.index("/Chassis")
    before = float(physics.positions[chassis, 0])
    physics.step(hz)
    lag = 8.0 * G * math.sin(math.radians(degrees)) * WHEEL / 4 / MOTOR
    return abs((float(physics.positions[chassis, 0]) - before) / ((speed + lag) * WHEEL) - 1)


CASES = (
    Case("pendulum", "sin(x / 2) = k cd(w t)", "rad", pendulum, 0.006, orders=first_order()),
    Case("double pendulum", "a converged solution", "rad", double_pendulum, 0.015, orders=first_order()),
    Case("spring drive", "step answer", "", spring, 0.04, orders=first_order()),
    Case("spring drive, no damping", "1 - cos w t", "", swinging, 0.2, orders=first_order()),
    Case("robot on wheels", "(w - m g sin r / 4 c) r up 10 degrees", "", climbing, 0.001, rates=NARROW),
)
