"""What to expect of a playing world's accuracy: its options, the errors that follow from them, and better settings.

The laws are those that `tests/stability` measures.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from graph.sim.physics.solver import CHOICES

from .chains import chains_of
from .library import mujoco
from .step_size import EULER, RK4, holds

if TYPE_CHECKING:
    from .engine import MujocoEngine

_ENUMS = {"integrator": "Integrator", "solver": "Solver", "cone": "Cone"}

TILTED = math.radians(3)
"""A contact steeper than this is one with a slope."""

HELD = 0.6
"""Up to this share of the slope that friction can hold, creep follows its law; near the limit it is larger."""

SHOWN_CREEP = 1e-5
"""Creep [m/s] that is worth a line."""


def facts(engine: MujocoEngine) -> dict[str, Any]:
    """Counts and options of a world, as `PhysicsEngine.facts` says."""
    option = engine.model.opt
    chosen = {name: _word(name, int(getattr(option, name))) for name in _ENUMS}
    return {
        "engine": engine.name,
        "bodies": len(engine.body_paths),
        "joints": len(engine.joints),
        "drives": len(engine.drives.joints),
        **chosen,
        "iterations": int(option.iterations),
        "impratio": float(option.impratio),
        "advice": [*_advice(engine)],
    }


def _word(name: str, value: int) -> str:
    kinds = getattr(mujoco, f"mjt{_ENUMS[name]}")
    return next(word for word, constant in CHOICES[name].items() if int(getattr(kinds, constant)) == value)


def _advice(engine: MujocoEngine) -> Iterator[str]:
    yield from _of_motion(engine)
    yield from _of_drives(engine)
    yield from _of_contacts(engine)


def _of_motion(engine: MujocoEngine) -> Iterator[str]:
    model, dt = engine.model, float(engine.dt)
    chains = _chains(engine)
    if len(engine.chains):
        begins = engine.body_name(int(model.tree_bodyadr[engine.chains[0]]))
        several = f"{begins} and {len(chains) - 1} more" if len(chains) > 1 else begins
        yield (
            f"joints without drives below {several} swing: they keep their energy (rk4, up to 64 parts of a step), but "
            "their course after about a second depends on the smallest change; what rolls on the ground, as a caster "
            "does, is not concerned"
        )
    elif len(chains) and engine.compiled.own:
        yield "joints without drives can gain energy in long steps; leave physics.integrator out"
    if model.opt.integrator == RK4 or len(chains) == model.ntree:
        return
    ahead = float(np.linalg.norm(engine.gravity)) * dt / 2 * 1000
    if not ahead:
        return
    line = f"what falls or swings is ahead by half a step: a falling body by {ahead:.3g} mm after 1 s"
    alone = not len(chains) and not (model.geom_contype | model.geom_conaffinity).any()
    yield f"{line}; nothing collides, so physics.integrator=rk4 is exact at 2 to 4 times the cost" if alone else line


def _chains(engine: MujocoEngine) -> Sequence[int]:
    """The trees that are passive chains, whether they are stepped as such or not."""
    return [int(tree) for tree in chains_of(engine.model, engine.drives.driven)]


def _of_drives(engine: MujocoEngine) -> Iterator[str]:
    drives, dt = engine.drives, float(engine.dt)
    if engine.model.opt.integrator == RK4 or not drives.joints:
        return
    gains = [*zip(*drives.gains_per_inertia, strict=True)]
    rates = [math.sqrt(stiffness) for stiffness, _ in gains]
    worst = max((number for number, rate in enumerate(rates) if rate * dt < 1), key=lambda n: rates[n], default=None)
    if worst is None or rates[worst] * dt < 0.01:
        return
    path, taken = drives.joints[worst].path, rates[worst] ** 2 * dt / 2
    share = gains[worst][1] / (2 * rates[worst])
    line = f"{path}: its spring answers a step with an error of {step_error(share) * rates[worst] * dt:.1%}"
    if engine.model.opt.integrator != EULER and gains[worst][1] < 2 * taken:  # more than its own damping does
        line = f"{path}: its spring has little damping, and loses {-math.expm1(-taken):.0%} of its swing a second"
    if not _chains(engine) and all(
        holds(RK4, dt, stiffness=stiffness, damping=damping) for stiffness, damping in gains
    ):
        yield f"{line}; physics.integrator=rk4 takes that away where nothing touches, at 2 to 4 times the cost"
    else:
        yield f"{line}; it is proportional to the step: raise physics.hz"


def step_error(share: float) -> float:
    """The largest error of a spring drive's answer to a step, in units of its rate times dt; share: its damping ratio.

    An implicit step turns each rate s of the motion into s + s2 dt / 2, so the answer x(t) errs by t x'' dt / 2. With
    time in units of 1 / rate, x'' = exp(-z t) (cos d t - z / d sin d t), d2 = 1 - z2 (z: the damping ratio). Only the
    first four swings are looked at: a swing without damping is lost, not late.
    """
    times = np.linspace(0.0, 8 * math.pi, 2001)
    root = np.emath.sqrt(1 - min(share, 10.0) ** 2 + 1e-9)
    answer = np.exp(-share * times) * (np.cos(root * times) - share / root * np.sin(root * times))
    return float(np.abs(times * np.real(answer)).max() / 2)


def _of_contacts(engine: MujocoEngine) -> Iterator[str]:
    option, data = engine.model.opt, engine.data
    if option.cone != mujoco.mjtCone.mjCONE_ELLIPTIC:
        if data.ncon:
            yield "pyramidal cones: bodies slide farther along diagonals, up to 1.4 times; physics.cone=elliptic"
        return
    down = engine.gravity
    strength = float(np.linalg.norm(down))
    if not data.ncon or not strength:
        return
    contact = data.contact
    normals = contact.frame[:, :3]
    sine = np.linalg.norm(np.cross(normals, down / strength), axis=1)
    friction = contact.friction[:, 0]
    rests = (contact.efc_address >= 0) & (sine > math.sin(TILTED)) & (sine < friction / np.hypot(1, friction))
    if not rests.any():
        return
    geoms = contact.geom
    steepest = int(np.flatnonzero(rests)[np.argmax(sine[rests])])
    together = int((rests & (geoms == geoms[steepest]).all(axis=1)).sum())
    impedance = float(contact.solimp[steepest, 0])
    time = max(float(contact.solref[steepest, 0]), 2 * float(option.timestep))
    speed = (1 / impedance - 1) * strength * float(sine[steepest]) * time / 2 / float(option.impratio) / together
    if speed > SHOWN_CREEP:
        sides = [
            collider for collider, body in (engine.colliders[geom] for geom in geoms[steepest] if geom >= 0) if body
        ]
        angle = math.asin(sine[steepest])
        line = f"{sides[0] if sides else 'a deformable'}: on a slope of {math.degrees(angle):.0f} degrees it creeps"
        if math.tan(angle) < HELD * friction[steepest]:
            better = "in proportion to 1 / physics.impratio and to physics.contact_softness"
            yield f"{line} about {speed * 1000:.2g} mm/s; {better}"
        else:
            yield f"{line} at least {speed * 1000:.2g} mm/s, near what friction can hold; raise physics.hz"
