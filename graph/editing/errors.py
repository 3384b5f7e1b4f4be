"""What the Controller raises."""

from __future__ import annotations

from graph.base.errors import UserError


class OmniGraphError(UserError):
    """An edit, a look-up or an evaluation that cannot be done; carries every problem found, one line each."""


class OmniGraphValueError(OmniGraphError, ValueError):
    """A value that is not of its attribute's type, or not allowed for it."""

    def __str__(self) -> str:
        return Exception.__str__(self)
