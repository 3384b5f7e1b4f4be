"""Errors of bodies: one trajectory against another, at common times, up to a horizon."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from graph.sim.transforms import rotation_matrices, slerp

from .states import Floats, Trajectory

AGREED_M, AGREED_RAD, AGREED_SHARE = 0.02, 0.1, 0.02
"""Two runs agree on a body while its positions differ by less than 2 cm and 2 % of its path so far, its orientations by
less than 0.1 rad and 2 % of its turns. Runs that part by chaos soon part by far more."""

SLOW_MPS = 0.1
"""A free body that touches something and is slower than this on average over the second half of the reference rests."""


class BodyPair:
    """A run and its reference, at the times of the coarser one of them, up to `horizon` [s].

    The other one is interpolated where it has no state at such a time: positions by the cubic through both states and
    their velocities, orientations along the shortest turn.
    """

    def __init__(self, run: Trajectory, reference: Trajectory, horizon: float) -> None:
        if run.paths != reference.paths:
            rows = {path: row for row, path in enumerate(run.paths)}
            shared = [row for row, path in enumerate(reference.paths) if path in rows]
            run = _only(run, [rows[reference.paths[row]] for row in shared])
            reference = _only(reference, shared)
        coarser = min((run, reference), key=lambda one: len(one.times))
        end = min(horizon, run.times[-1], reference.times[-1]) + 1e-9
        self.times: Floats = coarser.times[coarser.times <= end]
        self.run, self.reference = _at(run, self.times), _at(reference, self.times)

    @cached_property
    def distance(self) -> Floats:
        """(n, B) between the positions [m]."""
        difference: Floats = np.linalg.norm(self.run.positions - self.reference.positions, axis=2)
        return difference

    @cached_property
    def angle(self) -> Floats:
        """(n, B) between the orientations [rad]."""
        return _angles(self.run.orientations, self.reference.orientations)

    @cached_property
    def energies(self) -> tuple[Floats, Floats]:
        """(n,) kinetic and potential energy of all bodies together, of the run and of the reference [J]."""
        return _energy(self.run), _energy(self.reference)

    @cached_property
    def moves(self) -> bool:
        """Whether any body of the reference is ever faster than `SLOW_MPS`, by its kinetic energy.

        While bodies settle their energy is nearly 0: a drift would be a share of nothing.
        """
        _, speeds, rotations = _motion(self.reference)
        turning = (_spin(self.reference, rotations) * self.reference.velocities[..., 3:]).sum(axis=2)
        masses = self.reference.masses
        return bool((masses * (speeds**2).sum(axis=2) + turning > masses * SLOW_MPS**2).any())

    def energy_drift(self) -> float:
        """Largest difference of the energies, as a share of the reference's largest kinetic energy."""
        run, reference = self.energies
        return _share(np.abs(run - reference), _kinetic(self.reference))

    def momentum_drift(self) -> float:
        """Largest difference of the momenta, as a share of the largest sum of the reference's momentum magnitudes."""
        run, reference = _momenta(self.run), _momenta(self.reference)
        difference = np.linalg.norm((run - reference).sum(axis=1), axis=1)
        return _share(difference, np.linalg.norm(reference, axis=2).sum(axis=1))

    def spin_drift(self) -> float:
        """As `momentum_drift`, for angular momenta about the first centre of mass of all bodies."""
        about = _centre(self.reference)
        run, reference = _spins(self.run, about), _spins(self.reference, about)
        difference = np.linalg.norm((run - reference).sum(axis=1), axis=1)
        return _share(difference, np.linalg.norm(reference, axis=2).sum(axis=1))

    def penetration(self) -> float:
        """Deepest contact of the run [m]; not a difference: bodies should not overlap at all."""
        return float(self.run.depths.max(initial=0.0))

    def creep(self) -> float | None:
        """Speed at which bodies that rest in the reference move in the run [m/s]; None if none rests.

        It is the way over the second half of the time, divided by that time.
        """
        half = int(np.searchsorted(self.times, self.times[-1] / 2))
        span = self.times[-1] - self.times[half]
        if span <= 0:
            return None
        slow = np.linalg.norm(self.reference.positions[-1] - self.reference.positions[half], axis=1) / span < SLOW_MPS
        rests = self.reference.free & slow & self.reference.touching[half:].all(axis=0)
        if not rests.any():
            return None
        way = np.linalg.norm(self.run.positions[-1] - self.run.positions[half], axis=1) / span
        return float(way[rests].max())

    def agreed_until(self) -> tuple[float, str]:
        """The last time up to which both agree on every body [s], and the first body on which they do not ("": all)."""
        path = np.cumsum(_steps(self.reference.positions), axis=0)
        turn = np.cumsum(_angles(self.reference.orientations[1:], self.reference.orientations[:-1]), axis=0)
        turned = np.concatenate([np.zeros((1, turn.shape[1])), turn])
        parted = self.distance > AGREED_M + AGREED_SHARE * path
        parted |= self.angle > AGREED_RAD + AGREED_SHARE * turned
        rows = np.flatnonzero(parted.any(axis=1))
        if not len(rows):
            return float(self.times[-1]), ""
        first = rows[0]
        return float(self.times[max(0, first - 1)]), self.reference.paths[int(np.argmax(parted[first]))]


def pair(run: Trajectory | None, reference: Trajectory | None, horizon: float) -> BodyPair | None:
    """Pairs two runs. Returns None if nothing moves, or if they share no body or no time after the first."""
    if run is None or reference is None or not set(run.paths) & set(reference.paths):
        return None
    found = BodyPair(run, reference, horizon)
    return found if len(found.times) > 1 else None


def _only(one: Trajectory, rows: list[int]) -> Trajectory:
    return replace(
        one,
        paths=tuple(one.paths[row] for row in rows),
        positions=one.positions[:, rows],
        orientations=one.orientations[:, rows],
        velocities=one.velocities[:, rows],
        masses=one.masses[rows],
        inertias=one.inertias[rows],
        centres=one.centres[rows],
        free=one.free[rows],
        touching=one.touching[:, rows],
    )


def _at(one: Trajectory, times: Floats) -> Trajectory:
    """The trajectory at other times, none of them outside its own."""
    after = np.clip(np.searchsorted(one.times, times - 1e-9), 1, len(one.times) - 1)
    before = after - 1
    step = one.times[after] - one.times[before]
    share = np.clip((times - one.times[before]) / step, 0.0, 1.0)
    near = np.where(share > 0.5, after, before)
    exact = np.abs(one.times[near] - times) < 1e-9
    share = np.where(exact, np.round(share), share)
    s, h = share[:, None, None], step[:, None, None]
    x0, x1 = one.positions[before], one.positions[after]
    v0, v1 = one.velocities[before], one.velocities[after]
    between = (
        (1 + 2 * s) * (1 - s) ** 2 * x0
        + s * (1 - s) ** 2 * h * v0[..., :3]
        + s**2 * (3 - 2 * s) * x1
        + s**2 * (s - 1) * h * v1[..., :3]
    )
    e = exact[:, None, None]
    turns = slerp(one.orientations[before], one.orientations[after], share[:, None])
    return replace(
        one,
        times=times,
        positions=np.where(e, one.positions[near], between),
        orientations=np.where(e, one.orientations[near], turns),
        velocities=np.where(e, one.velocities[near], v0 + s * (v1 - v0)),
        depths=np.where(exact, one.depths[near], np.maximum(one.depths[before], one.depths[after])),
        touching=one.touching[near],
    )


def _angles(first: Floats, second: Floats) -> Floats:
    """The angles between orientations (..., 4) [rad], precise near 0."""
    apart = np.minimum(np.linalg.norm(first - second, axis=-1), np.linalg.norm(first + second, axis=-1))
    angles: Floats = 4 * np.arcsin(np.minimum(apart / 2, 1.0))
    return angles


def _steps(positions: Floats) -> Floats:
    steps: Floats = np.linalg.norm(np.diff(positions, axis=0, prepend=positions[:1]), axis=2)
    return steps


def _motion(one: Trajectory) -> tuple[Floats, Floats, Floats]:
    """Centres of mass (n, B, 3), their velocities (n, B, 3), and rotations (n, B, 3, 3)."""
    rotations = rotation_matrices(one.orientations)
    arms = np.einsum("nbij,bj->nbi", rotations, one.centres)
    return one.positions + arms, one.velocities[..., :3] + np.cross(one.velocities[..., 3:], arms), rotations


def _spin(one: Trajectory, rotations: Floats) -> Floats:
    """(n, B, 3) angular momenta about the bodies' own centres of mass."""
    local = np.einsum("nbji,nbj->nbi", rotations, one.velocities[..., 3:])
    own: Floats = np.einsum("nbij,bjk,nbk->nbi", rotations, one.inertias, local)
    return own


def _kinetic(one: Trajectory) -> Floats:
    _, speeds, rotations = _motion(one)
    straight = (one.masses * (speeds**2).sum(axis=2)).sum(axis=1)
    turning = (_spin(one, rotations) * one.velocities[..., 3:]).sum(axis=(1, 2))
    energy: Floats = (straight + turning) / 2
    return energy


def _energy(one: Trajectory) -> Floats:
    centres, _, _ = _motion(one)
    height: Floats = -(one.masses * (centres @ one.gravity)).sum(axis=1)
    return _kinetic(one) + height


def _momenta(one: Trajectory) -> Floats:
    momenta: Floats = one.masses[:, None] * _motion(one)[1]
    return momenta


def _centre(one: Trajectory) -> Floats:
    centres, _, _ = _motion(one)
    total = one.masses.sum()
    about: Floats = one.masses @ centres[0] / total if total > 0 else np.zeros(3)
    return about


def _spins(one: Trajectory, about: Floats) -> Floats:
    centres, speeds, rotations = _motion(one)
    spins: Floats = one.masses[:, None] * np.cross(centres - about, speeds) + _spin(one, rotations)
    return spins


def _share(difference: NDArray[np.float64], scale: NDArray[np.float64]) -> float:
    """The largest difference as a share of the largest scale; 0 without values."""
    most, whole = float(difference.max(initial=0.0)), float(scale.max(initial=0.0))
    return most / whole if whole > 0 else (0.0 if most == 0 else float("inf"))


def values_of(found: BodyPair) -> Mapping[str, float | None]:
    """Every metric of bodies and contacts."""
    distance, angle = found.distance, found.angle
    return {
        "body.position_max": float(distance.max()),
        "body.position_rms": float(np.sqrt((distance**2).mean())),
        "body.position_final": float(distance[-1].max()),
        "body.orientation_max": float(angle.max()),
        "body.orientation_rms": float(np.sqrt((angle**2).mean())),
        "body.orientation_final": float(angle[-1].max()),
        "body.energy_drift": found.energy_drift() if found.moves else None,
        "body.momentum_drift": found.momentum_drift() if found.moves else None,
        "body.spin_drift": found.spin_drift() if found.moves else None,
        "contact.penetration_max": found.penetration(),
        "contact.creep_max": found.creep(),
    }
