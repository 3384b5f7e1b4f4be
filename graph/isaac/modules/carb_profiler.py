"""`carb.profiler`: zones of a profiler; nothing is measured here, and functions that are decorated stay as they are."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

__all__ = ["profile"]


def profile(func: Callable[..., Any] | None = None, mask: int = 1, zone_name: str | None = None, **_: Any) -> Any:
    """The function itself, or, with options alone, what gives it."""
    return func if func is not None else lambda decorated: decorated
