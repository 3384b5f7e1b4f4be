"""Listens to edits of the stage that change the poses of prims."""

from __future__ import annotations

import weakref
from collections.abc import Callable
from typing import Any, Protocol

from graph.sim.scene.stage import Warn


class Follower(Protocol):
    """The interface of a reader of transforms of a stage."""

    muted: bool
    follow_stage: bool
    warn: Warn

    def forget(self) -> None:
        """The stage has changed."""

    def stage_moved(self, path: str) -> None:
        """The stage has a new transform for a prim."""


class StageListener:
    """Calls a follower, held weakly, for prims and transforms that change on a stage, until `close`.

    A quaternion that is not of length 1, which USD would take for another rotation, is normalised where it is set.
    """

    def __init__(self, stage: Any, follower: Follower) -> None:
        from graph.sim.scene.stage_faults import ORIENT, make_unit
        from graph.sim.usd import Tf, Usd

        def repair(path: Any, warn: Warn) -> None:
            attribute = stage.GetAttributeAtPath(path)
            if path.name.startswith(ORIENT) and attribute:
                make_unit(attribute, warn)

        self._changed = _teller(weakref.ref(follower), repair)  # USD holds it weakly
        self._notice = Tf.Notice.Register(Usd.Notice.ObjectsChanged, self._changed, stage)

    def close(self) -> None:
        """Stops listening."""
        self._notice.Revoke()


def _teller(follower: Callable[[], Follower | None], repair: Callable[[Any, Warn], None]) -> Callable[[Any, Any], None]:
    def changed(notice: Any, sender: Any) -> None:
        alive = follower()
        if alive is None or alive.muted or not alive.follow_stage:
            return
        ops = [path for path in notice.GetChangedInfoOnlyPaths() if "xformOp" in path.name]
        for path in ops:
            repair(path, alive.warn)
        moved = [path.GetPrimPath() for path in ops]
        if moved or notice.GetResyncedPaths():
            alive.forget()
            for path in dict.fromkeys(moved):
                alive.stage_moved(path.pathString)

    return changed
