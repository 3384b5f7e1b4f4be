"""Scenes of passive chains and closed loops: what they keep is known, whatever their motion."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from .case import NO_GRAVITY, Case, G, Knobs, world


def rods(count: int, length: float = 0.1, mass: float = 0.1, height: float = 0.0, **keys: Any) -> dict[str, Any]:
    """Thin rods in a row on hinges about Y, held out horizontally at one end, at a height."""
    prims: dict[str, Any] = {}
    for n in range(count):
        prims |= rod(f"/Rod{n}", length, mass, translate=[(n + 0.5) * length, 0, height], **keys)
        ends: dict[str, Any] = {"physics:body1": f"/Rod{n}", "physics:axis": "Y"}
        ends |= {"physics:localPos0": [length / 2, 0, 0] if n else [0, 0, height]}
        ends |= {"physics:localPos1": [-length / 2, 0, 0]} | ({"physics:body0": f"/Rod{n - 1}"} if n else {})
        prims[f"/Hinge{n}"] = {"type": "PhysicsRevoluteJoint", "attributes": ends}
    return prims


def rod(path: str, length: float, mass: float, **keys: Any) -> dict[str, Any]:
    """A thin rod along X."""
    across = mass * length**2 / 12
    values = {"physics:mass": mass, "physics:diagonalInertia": [across / 1000, across, across]}
    shape = {"type": "Cube", "size": 0.02 * length, "rigid_body": True, "collision": False, "attributes": values}
    return {path: {**shape, **keys}}


def ring(count: int, radius: float = 1.0) -> dict[str, Any]:
    """Bars of 1 kg in an upright ring, with hinges about Y at all its corners; the first one holds to the world."""
    corners = [radius * np.array([math.cos(a), 0.0, math.sin(a)]) for a in 2 * math.pi * np.arange(count) / count]
    length = 2 * radius * math.sin(math.pi / count)
    start, end = [-length / 2, 0, 0], [length / 2, 0, 0]
    prims: dict[str, Any] = {}
    for n, (a, b) in enumerate(zip(corners, corners[1:] + corners[:1], strict=True)):
        turn = math.degrees(math.atan2(a[2] - b[2], b[0] - a[0]))
        prims |= rod(f"/Bar{n}", length, 1.0, translate=((a + b) / 2).tolist(), rotate=[0, turn, 0])
        ends: dict[str, Any] = {
            "physics:body0": f"/Bar{n}",
            "physics:body1": f"/Bar{(n + 1) % count}",
            "physics:axis": "Y",
        }
        ends |= {"physics:localPos0": end, "physics:localPos1": start}
        prims[f"/Hinge{n}"] = {"type": "PhysicsRevoluteJoint", "attributes": ends}
    hold: dict[str, Any] = {"physics:body1": "/Bar0", "physics:axis": "Y", "physics:localPos0": corners[0].tolist()}
    prims["/Hold"] = {"type": "PhysicsRevoluteJoint", "attributes": {**hold, "physics:localPos1": start}}
    return prims


def widest_gap(physics: Any, count: int, radius: float = 1.0) -> float:
    """How far a corner of the ring is open at most [m]."""
    half = radius * math.sin(math.pi / count)
    rows = [physics.body_paths.index(f"/Bar{n}") for n in range(count)]
    along = half * physics.rotations[rows][:, :, 0]
    ends, starts = physics.positions[rows] + along, physics.positions[rows] - along
    return float(np.linalg.norm(ends - np.roll(starts, -1, axis=0), axis=1).max())


def random_chain(seed: int) -> dict[str, Any]:
    """2 to 15 links of 0.01 to 10 kg on hinges or ball joints, hung or floating, in motion."""
    random = np.random.default_rng(seed)
    count, hung = int(random.integers(2, 16)), bool(random.integers(2))
    prims: dict[str, Any] = {} if hung else dict(NO_GRAVITY)
    for n in range(count):
        mass, size = float(10 ** random.uniform(-2, 1)), float(random.uniform(0.05, 0.3))
        inertia = (mass * size**2 / 12 * random.uniform(0.7, 1.3, 3)).tolist()
        values = {"physics:mass": mass, "physics:diagonalInertia": inertia}
        link = {"type": "Cube", "size": 0.05, "rigid_body": True, "collision": False, "attributes": values}
        prims[f"/Link{n}"] = {**link, "translate": [0.2 * n + 0.1, 0, 0]}
        if not n and not hung:
            prims["/Link0"]["angular_velocity"] = random.uniform(-300, 300, 3).tolist()
            continue
        kind = "PhysicsSphericalJoint" if random.integers(2) else "PhysicsRevoluteJoint"
        ends: dict[str, Any] = {"physics:body1": f"/Link{n}", "physics:axis": "XYZ"[int(random.integers(1, 3))]}
        ends |= {"physics:localPos0": [0.1 if n else 0.0, 0, 0], "physics:localPos1": [-0.1, 0, 0]}
        ends |= {"physics:body0": f"/Link{n - 1}"} if n else {}
        prims[f"/Joint{n}"] = {"type": kind, "attributes": ends}
    return prims


def energy(physics: Any) -> float:
    """Kinetic and potential energy of all bodies, whose origins are their centres [J]."""
    velocities, turns, masses = physics.velocities(), physics.rotations, physics.masses
    spins = np.einsum("bji,bj->bi", turns, velocities[:, 3:])
    moving = masses @ (velocities[:, :3] ** 2).sum(axis=1) + np.einsum("bi,bij,bj->", spins, physics.inertias, spins)
    return float(moving / 2 - masses @ physics.positions @ physics.gravity)


def extremes(physics: Any, steps: int, every: int = 1) -> tuple[float, float]:
    """The most that the energy loses and gains in so many steps [J]."""
    start = energy(physics)
    changes = [0.0]
    for _ in range(0, steps, every):
        physics.step(every)
        changes.append(energy(physics) - start)
    return min(changes), max(changes)


SPIN, RISE = 150.0, 0.1
"""Of the heavy top: spin [rad/s], distance of its centre from its pivot [m]."""
TOP = (0.012, 0.012, 0.002)
"""Its principal inertias about the pivot [kg m2]; its mass is 1 kg."""


def heavy_top(hz: int, knobs: Knobs, tilt: float = math.pi / 6) -> float:
    """A top started in steady precession p: I1 p2 cos t - I3 s p + m g r = 0 keeps its tilt: error after 1 s [rad]."""
    across, _, along = TOP
    root = math.sqrt((along * SPIN) ** 2 - 4 * across * math.cos(tilt) * G * RISE)
    slow = (along * SPIN - root) / (2 * across * math.cos(tilt))
    axis = np.array([math.sin(tilt), 0.0, math.cos(tilt)])
    rate = slow * np.array([0.0, 0, 1]) + (SPIN - slow * math.cos(tilt)) * axis
    center = across - RISE**2  # about the centre, by Steiner
    body = {"type": "Cube", "size": 0.02, "rigid_body": True, "collision": False}
    values = {"physics:mass": 1.0, "physics:diagonalInertia": [center, center, along]}
    top = {**body, "translate": (RISE * axis).tolist(), "rotate": [0, math.degrees(tilt), 0], "attributes": values}
    ends = {"physics:body1": "/Top", "physics:localPos1": [0, 0, -RISE]}
    top |= {"angular_velocity": np.degrees(rate).tolist(), "velocity": np.cross(rate, RISE * axis).tolist()}
    physics = world({"/Top": top, "/Pivot": {"type": "PhysicsSphericalJoint", "attributes": ends}}, hz, knobs)
    worst = 0.0
    for _ in range(hz):
        physics.step()
        worst = max(worst, abs(math.acos(physics.rotations[0][2, 2]) - tilt))
    place = physics.positions[0]
    turned = math.remainder(math.atan2(place[1], place[0]) - slow, 2 * math.pi)
    return max(worst, abs(turned))


CASES = (Case("heavy top", "keeps its tilt and precesses steadily", "rad", heavy_top, 1e-3, hz=60),)
