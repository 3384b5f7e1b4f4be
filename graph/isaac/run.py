"""One run of a script: its App, its limits, and its end."""

from __future__ import annotations

import sys
from collections.abc import Callable
from contextvars import ContextVar
from typing import TYPE_CHECKING, Any, NoReturn

from graph.base.errors import RunError

if TYPE_CHECKING:
    from .managers.app import App
    from .mirror import Mirror

GRACE = 5
"""Updates that a script may still make after the limit, to end its loop by itself."""
MOST_ENDS = 20
"""How often a script may catch its end."""


class ScriptEnd(BaseException):
    """Ends a script: Kit ends its process here, so that no `except Exception` and no `finally` of a script runs."""

    def __init__(self, code: int = 0) -> None:
        super().__init__(code)
        self.code = code


class Run:
    """One run of a script: how its App is made, its limits, and what happens at its end.

    make: makes the App from options of `App`. opened, closing: called with the App when it is there, and before it is
    closed. stuck: ends the process of a script that catches its end again and again. updates: after so many,
    `is_running()` is False; a few later the script is ended. strict: refuses names that do nothing.
    play: plays the timeline after the last line of a snippet.
    """

    def __init__(
        self,
        make: Callable[..., App],
        *,
        updates: int | None = None,
        strict: bool = False,
        opened: Callable[[App], None] = lambda app: None,
        closing: Callable[[App], None] = lambda app: None,
        each_update: Callable[[], None] = lambda: None,
        notes: Callable[[str, str, str], None] = lambda code, where, message: None,
        stuck: Callable[[int], None] = lambda code: None,
        rclpy: bool = False,
        play: bool = False,
    ) -> None:
        self.make, self.updates, self.strict = make, updates, strict
        self.opened, self.closing, self.each_update, self.notes = opened, closing, each_update, notes
        self.stuck, self.rclpy, self.play = stuck, rclpy, play
        self._ends = 0
        self.app: App | None = None
        self.mirror: Mirror | None = None
        """The prims of the App's graphs."""
        self.missing: dict[str, str] = {}
        """Prims that stay empty, and the names of their missing assets."""
        self.code: int | None = None
        """The exit code once the script asked for its end."""
        self.ended = False
        self._opened = False
        self._warp_before = "warp" in sys.modules
        self.names_warp = False
        """Whether the script's own text imports Warp."""
        self.from_editor = False
        """Whether it is a snippet of the Script Editor: the App is there before it begins."""

    @property
    def uses_warp(self) -> bool:
        """Whether the script, or a module of its own, imported Warp: results are then Warp's arrays.

        An engine that computes on a device imports it for itself.
        """
        from graph.sim.devices import warp

        return self.names_warp or not (self._warp_before or warp.cache_info().currsize)

    def begin(self, **options: Any) -> App:
        """Makes and enters the App. Raises RunError if there is one: Kit runs one in a process."""
        if self.app is not None:
            raise RunError("there is a SimulationApp already; a process runs one")
        self.app = self.make(**options)
        self.app.__enter__()
        return self.app

    def complete(self, app: App, mirror: Mirror) -> None:
        """The App has all that belongs to it: its graphs' prims last."""
        self.mirror = mirror
        self.opened(app)
        self._opened = True

    def close(self) -> None:
        """Ends the App: what it leaves behind is written first. A second call does nothing."""
        if self.app is None or self.ended:
            self.ended = True
            return
        self.ended = True
        try:
            if self._opened:
                self.closing(self.app)
        finally:
            self.app.__exit__(None, None, None)

    def over(self) -> bool:
        """Whether the limit of updates is reached, or the script asked for its end."""
        if self.code is not None or self.ended:
            return True
        return self.updates is not None and self.app is not None and self.app.update_index >= self.updates

    def check(self) -> None:
        """Called before each update. Raises ScriptEnd after the end, and when the limit is far behind."""
        if self.ended:
            self._end()
        self.each_update()
        if self.app is None:
            return
        late = self.updates is not None and self.app.update_index >= self.updates + GRACE
        if late or self.app.exit_requested:
            self._end()

    def _end(self) -> NoReturn:
        """Ends the script; one that goes on in spite of it, by a bare `except:`, is left with its process."""
        self._ends += 1
        if self._ends > MOST_ENDS:
            self.close()
            self.stuck(self.code or 0)
        raise ScriptEnd(self.code or 0)


RUN: ContextVar[Run | None] = ContextVar("run", default=None)
"""The run of a script that is going on."""
