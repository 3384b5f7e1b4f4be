"""Changing the world: edits of the stage that say what is to happen if it plays."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Literal

from graph.base.errors import RunError, UserError

if TYPE_CHECKING:
    from contextlib import AbstractContextManager
    from types import TracebackType

    from graph.sim.app import App

WhenPlaying = Literal["refuse", "restart", "recompile"]
CHOICES: tuple[WhenPlaying, ...] = ("refuse", "restart", "recompile")


def checked_choice(value: str) -> WhenPlaying:
    """One of `CHOICES`. Raises UserError for any other."""
    for choice in CHOICES:
        if value == choice:
            return choice
    raise UserError(f"when_playing {value!r} is not one of {', '.join(CHOICES)}")


class EditStage:
    """`with` this the stage can be edited; while stopped it is just that.

    While playing or paused, `refuse` raises RunError before anything is edited. `restart` stops, has the stage edited
    and plays again (paused if it was paused): clocks, nodes and bodies begin anew, the edit outlives the next stop.
    `recompile` edits the playing stage and compiles physics anew in place: clocks go on, bodies keep their state, and
    the edit is gone with the next stop, which restores the stage of play.
    """

    def __init__(self, app: App, when_playing: WhenPlaying) -> None:
        self._app, self._when_playing = app, when_playing
        self._inner: AbstractContextManager[Any] | None = None
        self._resume: Literal["play", "pause", "build"] | None = None

    def __enter__(self) -> Any:
        app = self._app
        if app.live is None:
            return app.stage
        if self._when_playing == "recompile":
            self._inner = app.live.edit()
            return self._inner.__enter__()
        if self._when_playing == "restart":
            if app.timeline.is_stopped():  # the world was built by hand
                self._resume = "build"
                app.simulation.invalidate_physics()
            else:
                self._resume = "play" if app.timeline.is_playing() else "pause"
                app.stop()
            return app.stage
        raise RunError(
            'the world cannot be edited while it plays; stop first, or say app.edit(when_playing="restart") to begin '
            'anew or app.edit(when_playing="recompile") to have it compiled in place'
        )

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> bool | None:
        if self._inner is not None:
            return self._inner.__exit__(kind, error, traceback)
        if self._resume == "build" and error is None:
            self._app.simulation.initialize_physics()
        elif self._resume is not None and error is None:
            self._app.play()
            if self._resume == "pause":
                self._app.pause()
        return None


def remove_prims(stage: Any, paths: Sequence[str]) -> None:
    """Remove prims from a stage, what lies below included. Raises UserError for one that is not there.

    One that the scene's own file brings in is made inactive instead, which leaves the file alone.
    """
    from graph.sim.usd import Sdf

    for path in paths:
        valid = Sdf.Path.IsValidPathString(path) and path.startswith("/") and path != "/"
        if not valid or not stage.GetPrimAtPath(path):
            raise UserError(f"{path}: no such prim on the stage.")
    for path in paths:
        for layer in stage.GetLayerStack():
            spec = layer.GetPrimAtPath(path)
            if spec and layer.anonymous:
                del spec.realNameParent.nameChildren[spec.name]
        left = stage.GetPrimAtPath(path)
        if left:
            left.SetActive(False)
