"""Refuses what cannot be called where a function is meant."""

from __future__ import annotations

from .errors import UserError


class CallableError(UserError, TypeError):
    """Something that cannot be called is given as a callback."""


def check_callable(given: object, where: str) -> None:
    """Raises CallableError, one line, if what is given as a callback cannot be called."""
    if not callable(given):
        kind = type(given).__name__
        article = "an" if kind[0] in "aeiou" else "a"
        raise CallableError(f"{where} takes a function to call, but {article} {kind} is given")
