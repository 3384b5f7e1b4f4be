"""The exceptions of the Controller."""

from __future__ import annotations

from graph.base.errors import UserError


class OmniGraphError(UserError):
    """An edit, a look-up or an evaluation that is not possible; carries every problem found, one line each."""


class OmniGraphValueError(OmniGraphError, ValueError):
    """A value that does not fit its attribute's type, or is not allowed for it."""

    def __str__(self) -> str:
        return Exception.__str__(self)
