"""Wrong arguments to a sensor: both the user's mistake (exit code 2) and Python's ValueError."""

from __future__ import annotations

from graph.base.errors import UserError


class SensorValueError(UserError, ValueError):
    """An argument that no sensor can have. Says what, where, and what to do."""
