"""Reports prims at the moment they are removed from a stage."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from graph.sim.usd import Sdf, Tf, Usd


class Deletions:
    """Calls `on_deleted(path)` for each prim that is removed, renamed or deactivated; not for its descendants."""

    def __init__(self, stage: Any, on_deleted: Callable[[str], object]) -> None:
        self._stage = stage
        self._on_deleted = on_deleted
        self._known = {str(prim.GetPath()) for prim in self._prims(stage.GetPseudoRoot())}
        self._callback: Callable[[Any, Any], None] | None = self._changed  # USD holds it weakly
        self._listener = Tf.Notice.Register(Usd.Notice.ObjectsChanged, self._callback, stage)

    def close(self) -> None:
        """Stops listening."""
        self._listener.Revoke()
        self._callback = None

    def _changed(self, notice: Any, sender: Any) -> None:
        gone: list[str] = []
        for path in notice.GetResyncedPaths():
            if path.IsAbsoluteRootOrPrimPath():
                gone += self._resynced(path)
        for name in gone:
            self._on_deleted(name)

    def _resynced(self, path: Any) -> list[str]:
        """The topmost of the known prims at and below a path that no longer exist."""
        name = str(path)
        prim = self._stage.GetPrimAtPath(path)
        there = {str(each.GetPath()) for each in self._prims(prim)} if prim else set()
        if name not in self._known and path != Sdf.Path.absoluteRootPath:
            self._known |= there
            return []
        below = name.rstrip("/") + "/"
        lost = {known for known in self._known if known == name or known.startswith(below)} - there
        self._known -= lost
        self._known |= there
        return sorted(each for each in lost if each.rpartition("/")[0] not in lost)

    @staticmethod
    def _prims(prim: Any) -> Any:
        return (each for each in Usd.PrimRange(prim, Usd.PrimAllPrimsPredicate) if not each.IsPseudoRoot())
