"""Control laws of explicit actuators, limits of motors, and delayed commands: equations of Newton 1.x.

Newton Actuators, https://newton-physics.github.io/newton/latest/concepts/actuators.html. Parameters are numbers, or
arrays of one number per robot (NumPy's or Warp's); robots alike are computed together.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Memory = Any
"""What a stage remembers between steps, which it changes in place; None if it remembers nothing."""


class Joint(NamedTuple):
    """A joint of n robots: (n,) positions and velocities [rad or stage units, per s], those wanted, and efforts."""

    position: Floats
    velocity: Floats
    target_position: Floats
    target_velocity: Floats
    feedforward: Floats


def values(given: Any) -> Floats:
    """A number or an array, also one of Warp, as (1,) or (n,)."""
    return np.atleast_1d(np.asarray(given.numpy() if hasattr(given, "numpy") else given, dtype=np.float64))


def _check(what: object, **given: Any) -> None:
    for name, value in given.items():
        if value is not None and not (values(value) >= 0).all():
            raise ValueError(f"{type(what).__name__}: {name} must be 0 or more, not {value}")


class Controller:
    """Computes the efforts that limits then act on."""

    def memory(self, count: int) -> Memory:
        """What it begins with, for so many robots."""
        return None

    def efforts(self, joint: Joint, memory: Memory, dt: float) -> Floats:
        """(n,) efforts [N m or N]."""
        raise NotImplementedError(f"{type(self).__name__} has no method efforts")


@dataclass(eq=False)
class ControllerPD(Controller):
    """kp (target position - position) + kd (target velocity - velocity) + feedforward + const_effort."""

    kp: Any
    kd: Any
    const_effort: Any = None

    def __post_init__(self) -> None:
        _check(self, kp=self.kp, kd=self.kd)

    def efforts(self, joint: Joint, memory: Memory, dt: float) -> Floats:
        """(n,) efforts [N m or N]."""
        constant = 0.0 if self.const_effort is None else values(self.const_effort)
        error, slip = joint.target_position - joint.position, joint.target_velocity - joint.velocity
        return constant + joint.feedforward + values(self.kp) * error + values(self.kd) * slip


@dataclass(eq=False)
class ControllerPID(Controller):
    """As PD, with ki times the integral of the position's error, which stays within +- integral_max [rad s or m s]."""

    kp: Any
    ki: Any
    kd: Any
    integral_max: Any = math.inf
    const_effort: Any = None

    def __post_init__(self) -> None:
        _check(self, kp=self.kp, ki=self.ki, kd=self.kd, integral_max=self.integral_max)

    def memory(self, count: int) -> Floats:
        """(n,) the integral."""
        return np.zeros(count)

    def efforts(self, joint: Joint, memory: Memory, dt: float) -> Floats:
        """(n,) efforts [N m or N]; adds this step to the integral."""
        most = values(self.integral_max)
        memory[:] = np.clip(memory + (joint.target_position - joint.position) * dt, -most, most)
        integral: Floats = values(self.ki) * memory
        return ControllerPD(self.kp, self.kd, self.const_effort).efforts(joint, None, dt) + integral


class Clamping:
    """Limits efforts."""

    def limited(self, efforts: Floats, joint: Joint) -> Floats:
        """(n,) efforts within what the motor gives [N m or N]."""
        raise NotImplementedError(f"{type(self).__name__} has no method limited")


@dataclass(eq=False)
class ClampingMaxEffort(Clamping):
    """Within +- max_effort."""

    max_effort: Any

    def __post_init__(self) -> None:
        _check(self, max_effort=self.max_effort)

    def limited(self, efforts: Floats, joint: Joint) -> Floats:
        """(n,) efforts within what the motor gives [N m or N]."""
        most = values(self.max_effort)
        return np.clip(efforts, -most, most)


@dataclass(eq=False)
class ClampingDCMotor(Clamping):
    """The line of effort against speed of a DC motor, in all four quadrants.

    At speed v from saturation_effort (-1 - v / velocity_limit) to saturation_effort (1 - v / velocity_limit), and
    within +- max_motor_effort.
    """

    saturation_effort: Any
    velocity_limit: Any
    max_motor_effort: Any = math.inf

    def __post_init__(self) -> None:
        _check(self, max_motor_effort=self.max_motor_effort)
        if not (values(self.velocity_limit) > 0).all():
            raise ValueError(f"ClampingDCMotor: velocity_limit must be above 0, not {self.velocity_limit}")
        stall = values(self.saturation_effort)
        if not ((stall > 0) & np.isfinite(stall)).all():
            raise ValueError(
                f"ClampingDCMotor: saturation_effort must be above 0 and finite, not {self.saturation_effort}"
            )

    def limited(self, efforts: Floats, joint: Joint) -> Floats:
        """(n,) efforts within what the motor gives [N m or N]."""
        stall, most = values(self.saturation_effort), values(self.max_motor_effort)
        share = joint.velocity / values(self.velocity_limit)
        lowest = np.maximum(stall * (-1.0 - share), -most)
        return np.minimum(np.maximum(efforts, lowest), np.minimum(stall * (1.0 - share), most))


@dataclass(eq=False)
class ClampingPositionBased(Clamping):
    """Within +- the effort of a table at the joint's position, interpolated; that of its ends outside of it.

    The table is given as positions and efforts, or as a text file with both in each line.
    """

    lookup_table_path: str | Path | None = None
    lookup_positions: Any = None
    lookup_efforts: Any = None

    def __post_init__(self) -> None:
        if self.lookup_table_path is not None:
            self.lookup_positions, self.lookup_efforts = _read_table(self.lookup_table_path)
        if self.lookup_positions is None or self.lookup_efforts is None:
            raise ValueError("ClampingPositionBased needs lookup_positions and lookup_efforts, or lookup_table_path")
        places, most = np.asarray(self.lookup_positions, np.float64), np.asarray(self.lookup_efforts, np.float64)
        if not len(places) or len(places) != len(most):
            raise ValueError(
                f"ClampingPositionBased has {len(places)} lookup_positions and {len(most)} lookup_efforts; "
                "give one effort for each position, and at least one"
            )
        if (np.diff(places) < 0).any() or not (most >= 0).all():
            raise ValueError("ClampingPositionBased: lookup_positions must not fall, lookup_efforts be 0 or more")
        self._places, self._most = places, most

    def limited(self, efforts: Floats, joint: Joint) -> Floats:
        """(n,) efforts within what the motor gives [N m or N]."""
        most = np.interp(joint.position, self._places, self._most)
        return np.clip(efforts, -most, most)


def _read_table(path: str | Path) -> tuple[list[float], list[float]]:
    from graph.base.inputs import read_text

    lines = (line.partition("#")[0].replace(",", " ").split() for line in read_text(path, "file.yaml").splitlines())
    rows = [line for line in lines if line]
    try:
        return [float(position) for position, _ in rows], [float(effort) for _, effort in rows]
    except ValueError:
        raise ValueError(f"{path}: each line must have a position and an effort") from None


class Delay:
    """Passes targets and feedforward on `delay_steps` steps later, of each robot; meanwhile the oldest there are."""

    def __init__(self, delay_steps: Any, max_delay: int | None = None) -> None:
        _check(self, delay_steps=delay_steps)
        self.delay_steps = delay_steps
        self.buf_depth = int(values(delay_steps).max(initial=0)) if max_delay is None else int(max_delay)

    def memory(self, count: int) -> deque[Floats]:
        """Commands of the steps before, the newest last."""
        return deque(maxlen=self.buf_depth)

    def delayed(self, joint: Joint, memory: deque[Floats]) -> Joint:
        """The joint with the commands that arrive now."""
        past = np.array([*memory, joint[2:]])
        lag = np.minimum(values(self.delay_steps).astype(int), len(memory))
        rows = np.broadcast_to(len(memory) - lag, joint.position.shape)
        memory.append(past[-1])
        return Joint(joint.position, joint.velocity, *past[rows, :, np.arange(len(rows))].T)
