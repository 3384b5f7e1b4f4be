"""Edits of the playing stage, and starting again without stopping: what happens to the rest."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from enum import Flag, auto
from typing import TYPE_CHECKING, Any, Protocol

from graph.base.errors import RunError, UserError
from graph.sim.scene.prim_paths import is_path
from graph.sim.state.playing_world import WhenPlaying

if TYPE_CHECKING:
    from contextlib import AbstractContextManager
    from types import TracebackType

    from .live_stage import LiveStage


class Editable(Protocol):
    """A world whose stage can be edited."""

    stage: Any

    @property
    def live(self) -> LiveStage | None:
        """Keeps the playing world and its stage consistent; None while stopped."""


class Player(Protocol):
    """The interface that plays a world."""

    def halt(self) -> Callable[[], None]:
        """Stops; returns a function that restores playing or pause."""


class EditStage:
    """A context manager in which the stage can be edited; while stopped there are no further effects.

    While playing or paused, `refuse` raises RunError before any edit. `restart` stops, lets the stage be edited and
    plays again (paused if it was paused): clocks, nodes and bodies start again, and the edit outlives the next stop.
    `recompile` edits the playing stage and compiles physics again in place: clocks continue, bodies keep their state,
    and the edit is gone after the next stop, which restores the stage of play.
    """

    def __init__(self, world: Editable, player: Player, when_playing: WhenPlaying) -> None:
        self._world, self._player, self._when_playing = world, player, when_playing
        self._inner: AbstractContextManager[Any] | None = None
        self._resume: Callable[[], None] | None = None

    def __enter__(self) -> Any:
        live, stage = self._world.live, self._world.stage
        if live is None:
            return stage
        if self._when_playing == "recompile":
            self._inner = live.edit()
            return self._inner.__enter__()
        if self._when_playing == "restart":
            self._resume = self._player.halt()
            return stage
        raise RunError(
            'the world cannot be edited while it plays; stop first, or say app.edit(when_playing="restart") to begin '
            'again or app.edit(when_playing="recompile") to have it compiled in place'
        )

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> bool | None:
        if self._inner is not None:
            return self._inner.__exit__(kind, error, traceback)
        if self._resume is not None and error is None:
            self._resume()
        return None


def remove_prims(stage: Any, paths: Sequence[str]) -> None:
    """Removes prims from a stage, with everything below them. Raises UserError for a missing prim.

    A prim from the scene's own file is made inactive instead, so the file stays unchanged.
    """

    for path in paths:
        valid = is_path(path) and path.startswith("/") and path != "/"
        if not valid or not stage.GetPrimAtPath(path):
            raise UserError(f"{path}: no such prim on the stage")
    for path in paths:
        for layer in stage.GetLayerStack():
            spec = layer.GetPrimAtPath(path)
            if spec and layer.anonymous:
                del spec.realNameParent.nameChildren[spec.name]
        left = stage.GetPrimAtPath(path)
        if left:
            left.SetActive(False)


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
