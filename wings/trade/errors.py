"""The errors of a run against its reference, by metric, up to a horizon."""

from __future__ import annotations

from dataclasses import dataclass

from . import bodies, sights
from .trial import Measured

Errors = dict[str, float | None]


@dataclass(frozen=True, slots=True)
class Horizon:
    """The simulation time [s] up to which errors count, and why it ends there ("": it is the whole run)."""

    time: float
    why: str = ""


def horizon_of(reference: Measured, refined: Measured | None) -> Horizon:
    """The time up to which the reference and its refined run agree on the pose of every body; errors count until then.

    Later the motion depends on more than the reference resolves: after contacts it is chaotic.
    """
    end = reference.ended_at
    if refined is None:
        return Horizon(end)
    both = bodies.pair(refined.bodies, reference.bodies, end)
    if both is None:
        return Horizon(end)
    until, parted = both.agreed_until()
    if parted:
        return Horizon(until, f"beyond, {parted} moves otherwise if the reference is refined")
    if refined.ended:
        return Horizon(until, f"the refined reference ended there: {refined.ended}")
    return Horizon(max(until, end))


def errors_of(run: Measured, reference: Measured, horizon: Horizon) -> Errors:
    """Every metric that both runs give."""
    found: Errors = {}
    both = bodies.pair(run.bodies, reference.bodies, horizon.time)
    if both is not None:
        found |= bodies.values_of(both)
    if run.float32 is not None:
        found |= run.float32.errors(horizon.time)
    found |= sights.values_of(run.sensors, reference.sensors, horizon.time)
    return {name: value for name, value in found.items() if value is not None}
