"""Listens to edits of the stage that change the poses of prims."""

from __future__ import annotations

import weakref
from collections.abc import Callable
from typing import Any, Protocol


class Follower(Protocol):
    """The interface of a reader of transforms of a stage."""

    muted: bool
    follow_stage: bool

    def forget(self) -> None:
        """The stage has changed."""

    def stage_moved(self, path: str) -> None:
        """The stage has a new transform for a prim."""


class StageListener:
    """Calls a follower, held weakly, for prims and transforms that change on a stage, until `close`."""

    def __init__(self, stage: Any, follower: Follower) -> None:
        from graph.sim.usd import Tf, Usd

        self._changed = _teller(weakref.ref(follower))  # USD holds it weakly
        self._notice = Tf.Notice.Register(Usd.Notice.ObjectsChanged, self._changed, stage)

    def close(self) -> None:
        """Stops listening."""
        self._notice.Revoke()


def _teller(follower: Callable[[], Follower | None]) -> Callable[[Any, Any], None]:
    def changed(notice: Any, sender: Any) -> None:
        alive = follower()
        if alive is None or alive.muted or not alive.follow_stage:
            return
        moved = [path.GetPrimPath() for path in notice.GetChangedInfoOnlyPaths() if "xformOp" in path.name]
        if moved or notice.GetResyncedPaths():
            alive.forget()
            for path in dict.fromkeys(moved):
                alive.stage_moved(path.pathString)

    return changed
