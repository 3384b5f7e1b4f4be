"""Joints with up to six free axes (D6), as a chain of joints with one axis each.

The second frame follows from the first by translations along the first frame's axes, then by rotations about Z, Y and
X, each about the axis as rotated before; the rotation about X is the twist. If all three rotations are free, the chain
has a singularity where the second one is 90 degrees.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from graph.base.records import dataclass, field
from graph.sim import transforms
from graph.sim.scene.physics_settings import AXES
from graph.sim.scene.scan import Scan
from graph.sim.transforms import Floats

from .world_model import FREE, Drive, Joint

ORDER = (0, 1, 2, 5, 4, 3)


@dataclass(frozen=True)
class Axis:
    """A free axis: its number in `AXES`, its limits [m or rad], its drive, and the joint's own effects on it."""

    number: int
    lower: float = -FREE
    upper: float = FREE
    drive: Drive | None = None
    efforts: dict[str, Any] = field(default_factory=dict)

    @property
    def limited(self) -> bool:
        """Whether it has a limit."""
        return math.isfinite(self.lower) or math.isfinite(self.upper)


def single_joints(scan: Scan, joint: Joint, axes: Sequence[Axis], order: Sequence[int] = ORDER) -> tuple[Joint, ...]:
    """The free axes of a joint as joints with one axis each, at the positions of its bodies in the scene."""
    first, second = (
        frame if body is None else scan.body_pose(body) @ frame
        for frame, body in zip(joint.frames, joint.bodies, strict=True)
    )
    free = {axis.number: axis for axis in axes}
    chain = [number for number in order if number in free]
    shift = first[:3, :3].T @ (second[:3, 3] - first[:3, 3])
    angles = _angles(first[:3, :3].T @ second[:3, :3], [number - 3 for number in chain if number >= 3])
    starts = {number: float(shift[number] if number < 3 else angles[number - 3]) for number in chain}
    steps = [step(number >= 3, number % 3, starts[number]) for number in chain]
    back = transforms.inverse_rigid(moved(steps))
    before = np.eye(4)
    out = []
    for number, each in zip(chain, steps, strict=True):
        axis, after = free[number], before @ each
        if number >= 3:
            before[:3, 3] = after[:3, 3]
        out.append(
            Joint(
                path=f"{joint.path}:{AXES[number]}",
                kind="prismatic" if number < 3 else "revolute",
                bodies=joint.bodies,
                frames=(joint.frames[0] @ before, joint.frames[1] @ back @ after),
                axis=number % 3,
                lower=axis.lower,
                upper=axis.upper,
                start=starts[number],
                drive=axis.drive,
                collide=joint.collide,
                in_tree=joint.in_tree,
                label=joint.label and f"{joint.label}:{AXES[number]}",
                **axis.efforts,
            )
        )
        before = after
    return tuple(out)


def step(angular: bool, axis: int, amount: float) -> Floats:
    """(4, 4) of a rotation about an axis, or of a translation along it."""
    out = np.eye(4)
    if angular:
        out[:3, :3] = turn(axis, amount)
    else:
        out[axis, 3] = amount
    return out


def moved(steps: Sequence[Floats]) -> Floats:
    """(4, 4) of several steps in order."""
    out = np.eye(4)
    for each in steps:
        out = out @ each
    return out


def turn(axis: int, angle: float) -> Floats:
    """(3, 3) rotation about X, Y or Z."""
    half = np.zeros(4)
    half[0], half[1 + axis] = math.cos(angle / 2), math.sin(angle / 2)
    return transforms.rotation_matrices(half)


def _angles(rotation: Floats, turns: Sequence[int]) -> dict[int, float]:
    """The angles of successive rotations about the given axes that give a rotation (as closely as possible)."""
    if len(turns) == 3:
        # R = A_i(a) A_j(b) A_k(c); s = 1 where i, j, k are cyclic
        i, j, k = turns
        s = 1.0 if (j - i) % 3 == 1 else -1.0
        b = math.asin(max(-1.0, min(1.0, s * float(rotation[i, k]))))
        a = math.atan2(-s * float(rotation[j, k]), float(rotation[k, k]))
        c = math.atan2(-s * float(rotation[i, j]), float(rotation[i, i]))
        return {i: a, j: b, k: c}
    if len(turns) == 2:
        i, j = turns
        k = 3 - i - j
        s = 1.0 if (j - i) % 3 == 1 else -1.0
        # the third column is A_i(a) applied to A_j(b)'s; the first row is A_j(b)'s
        return {
            i: math.atan2(s * float(rotation[k, j]), float(rotation[j, j])),
            j: math.atan2(s * float(rotation[i, k]), float(rotation[i, i])),
        }
    if len(turns) == 1:
        w, *vector = transforms.quaternion(rotation)
        return {turns[0]: math.remainder(2 * math.atan2(float(vector[turns[0]]), float(w)), 2 * math.pi)}
    return {}
