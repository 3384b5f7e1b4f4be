"""Starts again without stopping: what is reset, and what continues."""

from __future__ import annotations

from enum import Flag, auto
from typing import Protocol

from graph.base.errors import RunError, UserError

from .editing import Editable, EditStage, Player


class Reset(Flag):
    """What `App.reset` resets; combine with `|`.

    TIME: every clock has its value right after play: the timeline at its start, simulation and external time and the
    count of steps 0, no carried time, no samples; sensors begin their first scan, waiting messages are dropped. The
    monotonic clock and the loop's continue, and so does everything else: bodies keep poses and velocities.

    STATE: bodies have their poses of play (later ones: those of their addition) with the authored velocities; joints,
    drives, grippers and moving surfaces too. Prims that users placed are put back. No clock changes.

    SPAWNED: surfaces, colliders, bodies and joints that were added while playing are removed, with everything below
    them. All other bodies keep their state, no clock changes; sensors, render products and writers stay.

    ALL: stop and play (paused if it was paused). Beyond the other three this restores the stage to the last bit and
    nodes' state, and removes attributes set in Fabric, and products, writers and prims of any kind that were added
    while playing.
    """

    TIME = auto()
    STATE = auto()
    SPAWNED = auto()
    ALL = TIME | STATE | SPAWNED


def scopes_of(scope: str | Reset) -> Reset:
    """The scopes that a name, or several joined by `|`, means. Raises UserError for an unknown one."""
    if isinstance(scope, Reset):
        return scope
    out = Reset(0)
    for name in str(scope).split("|"):
        found = Reset.__members__.get(name.strip().upper())
        if found is None:
            known = ", ".join(member.lower() for member in Reset.__members__)
            raise UserError(f"there is no scope {name.strip()!r} to reset; there are {known}")
        out |= found
    return out


class Clocks(Player, Protocol):
    """The interface that plays a world and owns its clocks."""

    @property
    def updating(self) -> bool:
        """Whether an update runs."""

    def restart_time(self) -> None:
        """Sets every clock to its value right after play."""


def reset(world: Editable, clocks: Clocks, scope: str | Reset) -> None:
    """See `Reset`. While stopped it does nothing. Raises RunError from inside an update."""
    scopes = scopes_of(scope)
    if world.live is None:
        return
    if clocks.updating:
        raise RunError("reset() was called from inside an update; call it between updates")
    if scopes == Reset.ALL:
        with EditStage(world, clocks, "restart"):
            return
    if Reset.SPAWNED in scopes:
        world.live.remove_spawned()
    if Reset.STATE in scopes:
        world.live.restore()
    if Reset.TIME in scopes:
        clocks.restart_time()
