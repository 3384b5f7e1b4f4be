"""What OmniGraph's Python nodes and scripts see of their node: our database under the names that they use."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from enum import IntEnum
from types import SimpleNamespace
from typing import Any

from graph.db import NodeError
from graph.types import TYPES
from graph.values import coerce

LOGGER = logging.getLogger("tickgraph")


class ExecutionAttributeState(IntEnum):
    """What may be assigned to an execution output; only the enabled ones are followed."""

    DISABLED = 0
    ENABLED = 1
    ENABLED_AND_PUSH = 2


OG = SimpleNamespace(ExecutionAttributeState=ExecutionAttributeState)
"""Stands for the module that OmniGraph's scripts call `og`."""


class CheckedOutputs:
    """A node's outputs: values are checked against their types, execution outputs fire when they are enabled."""

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


class OgnDatabase:
    """`db` as OmniGraph's Python nodes know it: inputs, outputs, state, tokens, logging, and a place of its own.

    `internal_state`, `per_instance_state` and `shared_state` are the node's one memory, made afresh after every stop.
    Everything else is that of the node's own database (`graph.db.Database`).
    """

    def __init__(self, db: Any, tokens: Mapping[str, str] | None = None) -> None:
        self._db = db
        self.inputs, self.state = db.inputs, db.state
        self.outputs = CheckedOutputs(db)
        self.tokens = SimpleNamespace(**(tokens or {}))
        self._own = SimpleNamespace()

    def __getattr__(self, name: str) -> Any:
        return getattr(self._db, name)

    @property
    def internal_state(self) -> Any:
        """Whatever the node keeps between computes."""
        if self._db.memory is None:
            raise NodeError("its class keeps no state; give it a static internal_state() that makes one")
        return self._db.memory

    @property
    def per_instance_state(self) -> Any:
        """The same: a node has one instance."""
        return self.internal_state

    @property
    def shared_state(self) -> Any:
        """The same: a node has one instance."""
        return self.internal_state

    def log_error(self, message: str) -> None:
        """Reports an error without ending the run."""
        self._db.warn("node-error", message)

    def log_warning(self, message: str) -> None:
        """Reports something that the user should know."""
        self._db.warn("node-warning", message)

    log_warn = log_warning

    def log_info(self, message: str) -> None:
        """Writes to the log."""
        LOGGER.info("%s", message)


def log_print(*values: Any, sep: str = " ", **_: Any) -> None:
    """`print` of a script: to the log, since standard output may hold a report."""
    LOGGER.info("%s", sep.join(map(str, values)))
