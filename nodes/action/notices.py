"""Notices of changes on a stage."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any


class StageWatch:
    """Calls `told(notice)` at every change of a stage, until the watch itself is called."""

    def __init__(self, stage: Any, told: Callable[[Any], None]) -> None:
        from graph.sim.usd import Tf, Usd

        def heard(notice: Any, sender: Any) -> None:
            told(notice)

        # pxr holds the function weakly.
        self._heard = heard
        self._key = Tf.Notice.Register(Usd.Notice.ObjectsChanged, heard, stage)

    def __call__(self) -> None:
        """Ends the watch."""
        self._key.Revoke()
