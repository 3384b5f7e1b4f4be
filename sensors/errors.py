"""Wrong arguments of sensors: both a mistake of the user (exit code 2) and Python's ValueError."""

from __future__ import annotations

from graph.base.errors import UserError


class SensorValueError(UserError, ValueError):
    """An argument that is not valid for a sensor. Says what, where, and what to do."""
