"""Beginning anew without stopping: what is reset, and what goes on."""

from __future__ import annotations

from enum import Flag, auto
from typing import Protocol

from graph.base.errors import RunError, UserError
from graph.sim.scene.editing import Editable, EditStage, Player


class Reset(Flag):
    """What `App.reset` begins anew; combine with `|`.

    TIME: every clock is where it was right after play: the timeline at its start, simulation and external time and the
    count of steps 0, no time carried over, no samples; sensors begin their first scan, waiting messages are gone. The
    monotonic and the loop's clock go on, and so does everything else: bodies keep places and velocities.

    STATE: bodies are where they were at play (those that came later: where they came) with the velocities that the
    stage gives them; joints, drives, grippers and moving surfaces too. What users have placed is back where it was. No
    clock changes.

    SPAWNED: surfaces, colliders, bodies and joints that came while playing go, with what is below them. All other
    bodies keep their state, no clock changes; sensors, render products and writers stay.

    ALL: stop and play (paused if it was paused). Beyond the three that restores the stage to the last bit and nodes'
    state, and removes attributes set in Fabric, and products, writers and prims of any kind that came while playing.
    """

    TIME = auto()
    STATE = auto()
    SPAWNED = auto()
    ALL = TIME | STATE | SPAWNED


def scopes_of(scope: str | Reset) -> Reset:
    """The scopes that a name, or several with `|` between them, stands for. Raises UserError for an unknown one."""
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
    """Whoever plays a world and owns its clocks."""

    @property
    def updating(self) -> bool:
        """Whether an update runs."""

    def restart_time(self) -> None:
        """Sets every clock to where it was right after play."""


def reset(world: Editable, clocks: Clocks, scope: str | Reset) -> None:
    """See `Reset`. While stopped there is nothing to reset. Raises RunError from inside an update."""
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
