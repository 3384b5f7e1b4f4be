"""Edits of the stage, with a choice of what happens if it plays."""

from __future__ import annotations

from collections.abc import Callable, Sequence
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
