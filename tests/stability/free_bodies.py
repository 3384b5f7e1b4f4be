"""Oracles of bodies that nothing touches."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from graph.base.errors import RunError
from graph.sim.transforms import Floats

from .case import NARROW, NO_GRAVITY, Case, G, Knobs, first_order, world


def body(inertia: tuple[float, float, float], spin: tuple[float, float, float], **keys: Any) -> dict[str, Any]:
    """A body of 1 kg with these principal inertias [kg m2] along its axes, turning at `spin` [rad/s].

    USD has them as float32, so numbers of few binary places are exact.
    """
    attributes = {"physics:mass": 1.0, "physics:diagonalInertia": list(inertia)}
    return {
        "type": "Cube",
        "size": 0.1,
        "rigid_body": True,
        "collision": False,
        "angular_velocity": [math.degrees(rate) for rate in spin],
        "attributes": attributes,
        **keys,
    }


def projectile(hz: int, knobs: Knobs) -> float:
    """Thrown up with 5 m/s and sideways with 3 m/s, at (3, 0, 5 - g / 2) after 1 s: distance [m]."""
    physics = world({"/Ball": body((1, 1, 1), (0, 0, 0), velocity=[3, 0, 5])}, hz, knobs)
    physics.step(hz)
    return float(np.linalg.norm(physics.positions[0] - [3, 0, 5 - G / 2]))


def top(inertia: tuple[float, float, float], spin: tuple[float, float, float], hz: int, knobs: Knobs) -> Any:
    """The physics of a free body."""
    return world({**NO_GRAVITY, "/Top": body(inertia, spin)}, hz, knobs)


SYMMETRIC, TILTED = (1 / 64, 1 / 64, 3 / 128), (math.radians(120), 0.0, math.radians(576))


def precession(hz: int, knobs: Knobs) -> float:
    """A symmetric top's axis turns about L by |L| / I1, its spin stays: error of the axis after 1 s [rad]."""
    physics = top(SYMMETRIC, TILTED, hz, knobs)
    physics.step(hz)
    momentum = np.array(SYMMETRIC) * TILTED
    size = float(np.linalg.norm(momentum))
    axis = turned(np.array([0.0, 0, 1]), momentum / size, size / SYMMETRIC[0])
    return float(np.linalg.norm(physics.rotations[0][:, 2] - axis))


def turned(vector: Floats, axis: Floats, angle: float) -> Floats:
    """A vector turned about a unit axis (Rodrigues)."""
    out: Floats = (
        vector * math.cos(angle)
        + np.cross(axis, vector) * math.sin(angle)
        + axis * (axis @ vector) * (1 - math.cos(angle))
    )
    return out


ASYMMETRIC, NEAR_MIDDLE = (1 / 128, 1 / 64, 3 / 128), (math.radians(30), math.radians(344), math.radians(60))


def asymmetric(hz: int, knobs: Knobs) -> float:
    """Euler's equations in Jacobi's elliptic functions: error of the rate after 1 s, along the body's axes [rad/s]."""
    physics = top(ASYMMETRIC, NEAR_MIDDLE, hz, knobs)
    physics.step(hz)
    rate = physics.rotations[0].T @ physics.velocities()[0, 3:]
    return float(np.linalg.norm(rate - euler_rates(ASYMMETRIC, NEAR_MIDDLE, 1.0)))


def euler_rates(inertia: tuple[float, float, float], start: tuple[float, float, float], time: float) -> Floats:
    """The rates (w1, w2, w3) of a free body with I1 < I2 < I3 and L2 > 2 E I2 (Landau and Lifshitz, Mechanics, 37).

    Its start is w2 > 0 at a place on the curve; the phase of that place is found by Jacobi's functions themselves.
    """
    (a, b, c), w = inertia, np.array(start)
    energy = float(np.array(inertia) @ w**2)  # twice the energy
    momentum = float((np.array(inertia) * w) @ (np.array(inertia) * w))
    assert momentum > energy * b
    tops = (
        math.sqrt((energy * c - momentum) / (a * (c - a))),
        math.sqrt((energy * c - momentum) / (b * (c - b))),
        math.sqrt((momentum - energy * a) / (c * (c - a))),
    )
    pace = math.sqrt((c - b) * (momentum - energy * a) / (a * b * c))
    m = (b - a) * (energy * c - momentum) / ((c - b) * (momentum - energy * a))
    quarter = math.pi / 2 / agm(1.0, math.sqrt(1 - m))[-1][0]
    low, high = -quarter, quarter  # w1 > 0: cn > 0, where sn rises
    for _ in range(80):
        middle = (low + high) / 2
        low, high = (middle, high) if tops[1] * jacobi(middle, m)[0] < w[1] else (low, middle)
    sn, cn, dn = jacobi(low + pace * time, m)
    return np.array([tops[0] * cn, tops[1] * sn, tops[2] * dn])


def agm(a: float, b: float) -> list[tuple[float, float]]:
    """Pairs (mean, half difference) of the arithmetic-geometric mean, until they agree."""
    out = [(a, 0.0)]
    while abs(a - b) > 1e-15 * a:
        a, b, c = (a + b) / 2, math.sqrt(a * b), (a - b) / 2
        out.append((a, c))
    return out


def jacobi(u: float, m: float) -> tuple[float, float, float]:
    """Jacobi's sn, cn, dn of a parameter m from 0 to 1 (Abramowitz and Stegun 16.4)."""
    means = agm(1.0, math.sqrt(1 - m))
    angle = 2 ** (len(means) - 1) * means[-1][0] * u
    for mean, half in reversed(means[1:]):
        angle = (angle + math.asin(half / mean * math.sin(angle))) / 2
    sn = math.sin(angle)
    return sn, math.cos(angle), math.sqrt(1 - m * sn * sn)


def spinning(rate: float) -> Any:
    """The angular momentum that a free body loses or gains in 10 s as it tumbles about its middle axis: a share."""

    def lost(hz: int, knobs: Knobs) -> float:
        start = (0.01 * rate, rate, 0.01 * rate)
        physics = top(ASYMMETRIC, start, hz, knobs)
        try:
            physics.step(10 * hz)
        except RunError:
            return math.inf
        before = np.array(ASYMMETRIC) * start
        return float(np.linalg.norm(angular_momentum(physics) - before) / np.linalg.norm(before))

    return lost


def drift(hz: int, knobs: Knobs) -> float:
    """Three bodies on two hinges float and fold: change of angular momentum about their centre in 1 s, as a share."""
    link = body((0.02, 0.02, 0.02), (0, 0, 0))
    prims = {f"/Link{n}": {**link, "translate": [0.5 * n, 0, 0]} for n in range(3)}
    prims["/Link0"]["angular_velocity"] = [60, 120, 180]
    for n, axis in enumerate("YZ"):
        ends: dict[str, Any] = {"physics:body0": f"/Link{n}", "physics:body1": f"/Link{n + 1}", "physics:axis": axis}
        ends |= {"physics:localPos0": [0.25, 0, 0], "physics:localPos1": [-0.25, 0, 0]}
        prims[f"/Hinge{n}"] = {"type": "PhysicsRevoluteJoint", "attributes": ends}
    physics = world({**NO_GRAVITY, **prims}, hz, knobs)
    physics.step()
    before = angular_momentum(physics)
    physics.step(hz)
    return float(np.linalg.norm(angular_momentum(physics) - before) / np.linalg.norm(before))


def angular_momentum(physics: Any) -> Floats:
    """(3,) of all bodies about their common centre of mass [kg m2/s]; their origins are their centres."""
    velocities, turns, masses = physics.velocities(), physics.rotations, physics.masses
    tensors = np.einsum("bij,bjk,blk->bil", turns, physics.inertias, turns)
    middle = masses @ physics.positions / masses.sum()
    orbits = np.cross(physics.positions - middle, masses[:, None] * velocities[:, :3])
    out: Floats = np.einsum("bij,bj->i", tensors, velocities[:, 3:]) + orbits.sum(axis=0)
    return out


CASES = (
    Case("projectile", "parabola", "m", projectile, 0.021, orders=first_order(None)),
    Case("precession", "axis about L by L / I1", "rad", precession, 0.005, hz=960, orders=first_order()),
    Case("asymmetric body", "Jacobi's elliptic functions", "rad/s", asymmetric, 0.1, orders=first_order(), floor=1e-10),
    Case("momentum", "kept by three bodies on two hinges", "", drift, 5e-4, hz=2400, orders=first_order()),
    Case("tumbling, 10 rad/s", "L is kept (10 s)", "", spinning(10), 0.03, hz=960, rates=NARROW),
)
