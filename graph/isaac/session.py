"""The App that Isaac Sim's modules act on, and what belongs to it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import TYPE_CHECKING, Any

from graph.base.errors import UserError
from graph.sim import entered

from .run import RUN, Run, ScriptEnd

if TYPE_CHECKING:
    from .kit import Kit
    from .managers.app import App
    from .mirror import Mirror


def begin(run: Run, **options: Any) -> App:
    """Makes and enters the App of a run, with its Kit and mirror. Raises RunError if the run has one."""
    from .kit import kit_of
    from .mirror import Mirror

    made = run.begin(**options)
    kit_of(made)
    run.complete(made, Mirror(made))
    return made


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
