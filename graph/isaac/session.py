"""The App that Isaac Sim's modules act on, what belongs to it, and the end of a script."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import TYPE_CHECKING, Any, NoReturn

from graph.base.errors import RunError, UserError
from graph.sim import entered

if TYPE_CHECKING:
    from .kit import Kit
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
        from .kit import kit_of

        kit_of(self.app)
        from .mirror import Mirror

        self.mirror = Mirror(self.app)
        self.opened(self.app)
        self._opened = True
        return self.app

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
_NODE_APP: ContextVar[Any] = ContextVar("node_app", default=None)


@contextmanager
def app_of_node(app: Any) -> Iterator[None]:
    """Makes this App, if it is one, the one that Isaac Sim's modules act on, within a `with` block."""
    token = _NODE_APP.set(app)
    try:
        yield
    finally:
        _NODE_APP.reset(token)


def app_or_none() -> App | None:
    """The App of the node that computes, else that of the script, else the one entered last; None without any."""
    if (app := _NODE_APP.get()) is not None:
        return app  # type: ignore[no-any-return]
    run = RUN.get()
    if run is not None:
        if run.ended:
            raise ScriptEnd(run.code or 0)
        return run.app
    try:
        return entered.current()  # type: ignore[no-any-return]
    except UserError:
        return None


def app() -> App:
    """The App that Isaac Sim's modules act on. Raises UserError without one."""
    found = app_or_none()
    if found is None:
        raise UserError("there is no application yet; make SimulationApp(...) first, or enter an App")
    return found


def kit() -> Kit:
    """What Kit has beside the App: event streams, the asyncio loop, singletons."""
    from .kit import kit_of

    return kit_of(app())


def mirror() -> Mirror | None:
    """The prims of the graphs of the script's App; None outside a script."""
    run = RUN.get()
    if run is None or run.app is None or run.ended:
        return None
    return run.mirror


def warn(code: str, where: str, message: str) -> None:
    """Gives a warning of the App; before there is one, of the run."""
    run, found = RUN.get(), app_or_none()
    if found is not None:
        found.warn(code, where, message)
    elif run is not None:
        run.notes(code, where, message)


def strict() -> bool:
    """Whether names that do nothing are refused."""
    run = RUN.get()
    return run is not None and run.strict
