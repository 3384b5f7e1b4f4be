"""The Apps that are entered: calls without `app=` mean the one entered last."""

from __future__ import annotations

from typing import Any
from weakref import WeakSet

from graph.base.errors import UserError

_entered: list[Any] = []


living: WeakSet[Any] = WeakSet()
"""Every App, entered or not."""


def of_world(world: Any) -> Any:
    """The App of a world, or None if it is gone."""
    return next((app for app in living if app.world is world), None)


def enter(app: Any) -> None:
    """Makes an App the current one."""
    _entered.append(app)


def leave(app: Any) -> None:
    """Ends its latest entry; does nothing for an App that is not entered."""
    if app in _entered:
        _entered.reverse()
        _entered.remove(app)
        _entered.reverse()


def current() -> Any:
    """The most recently entered App. Raises UserError if there is no such App."""
    if not _entered:
        raise UserError("there is no current App; use `with App(...) as app:` or pass app=")
    return _entered[-1]


def of_stage(stage: Any) -> Any:
    """The most recently entered App with this stage, or None."""
    return next((app for app in reversed(_entered) if app.stage == stage), None)
