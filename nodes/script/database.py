"""What a script sees of its node: the node's database, and the names that OmniGraph's scripts use besides."""

from __future__ import annotations

import logging
from enum import IntEnum
from types import SimpleNamespace
from typing import Any

from graph.types import TYPES
from graph.values import coerce

LOGGER = logging.getLogger("tickgraph")


class ExecutionAttributeState(IntEnum):
    """What a script may assign to an execution output; only the enabled ones are followed."""

    DISABLED = 0
    ENABLED = 1
    ENABLED_AND_PUSH = 2


OG = SimpleNamespace(ExecutionAttributeState=ExecutionAttributeState)
"""Stands for the module that OmniGraph's scripts call `og`."""


class ScriptOutputs:
    """The outputs of a script node: values are checked against their types, execution outputs fire when enabled."""

    def __init__(self, db: Any) -> None:
        object.__setattr__(self, "_db", db)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._db.outputs, name)

    def __setattr__(self, name: str, value: Any) -> None:
        db = self._db
        if not hasattr(db.outputs, name):
            if name not in db.node.names["outputs"]:
                raise AttributeError(
                    f'the node has no output "{name}"; add it to the attributes of the node in the file'
                )
            if value == ExecutionAttributeState.ENABLED_AND_PUSH:
                db.fire_and_return(name)
            elif value:
                db.fire(name)
            return
        wanted = db.output_type(name)
        if wanted is not None and TYPES[wanted].storage != "bundle":
            try:
                value = coerce(TYPES[wanted], value)
            except ValueError as error:
                raise ValueError(f"output {name}: {error}") from None
        setattr(db.outputs, name, value)


class ScriptDatabase:
    """`db` of a script: inputs, outputs, state, logging, and a place of its own for whatever it keeps.

    `internal_state`, `per_instance_state` and `shared_state` are one object, as a node has one instance; it is made
    afresh with the script. Everything else is that of the node's own database (`graph.db.Database`).
    """

    def __init__(self, db: Any) -> None:
        self._db = db
        self.inputs, self.state = db.inputs, db.state
        self.outputs = ScriptOutputs(db)
        self.internal_state = self.per_instance_state = self.shared_state = SimpleNamespace()

    def __getattr__(self, name: str) -> Any:
        return getattr(self._db, name)

    def log_error(self, message: str) -> None:
        """Reports an error without ending the run."""
        self._db.warn("script-error", message)

    def log_warning(self, message: str) -> None:
        """Reports something that the user should know."""
        self._db.warn("script-warning", message)

    log_warn = log_warning

    def log_info(self, message: str) -> None:
        """Writes to the log."""
        LOGGER.info("%s", message)


def log_print(*values: Any, sep: str = " ", **_: Any) -> None:
    """`print` of a script: to the log, since standard output may hold a report."""
    LOGGER.info("%s", sep.join(map(str, values)))
