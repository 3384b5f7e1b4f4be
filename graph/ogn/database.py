"""The `db` of OmniGraph's Python nodes and scripts: our database under OmniGraph's names."""

from __future__ import annotations

import logging
import math
from collections.abc import Mapping
from types import SimpleNamespace
from typing import Any

from graph.node.database import Database, NodeError
from graph.values.coercion import coerce, dtype_of, shown
from graph.values.types import TYPES, Type

ENABLED_AND_PUSH = 2
"""`og.ExecutionAttributeState.ENABLED_AND_PUSH`: follow the output to its end, then compute again."""
LOGGER = logging.getLogger("tickgraph")


class CheckedOutputs:
    """A node's outputs: values are checked against their types, execution outputs fire when they are set to enabled.

    `NAME_size = n` makes the array output NAME n elements long, new elements zero; it may be written in place until the
    compute ends.
    """

    def __init__(self, db: Database) -> None:
        object.__setattr__(self, "_db", db)
        object.__setattr__(self, "_open", [])

    def __getattr__(self, name: str) -> Any:
        outputs = self._db.outputs
        if not hasattr(outputs, name) and self._sized(name) is not None:
            return len(getattr(outputs, name.removesuffix("_size")))
        return getattr(outputs, name)

    def __setattr__(self, name: str, value: Any) -> None:
        db = self._db
        if not hasattr(db.outputs, name):
            if name in db.node.names["outputs"]:
                if value == ENABLED_AND_PUSH:
                    db.fire_and_return(name)
                elif value:
                    db.fire(name)
            elif type_ := self._sized(name):
                self._resize(name.removesuffix("_size"), type_, value)
            else:
                raise AttributeError(
                    f'the node has no output "{name}"; add it to the attributes of the node in the file'
                )
            return
        wanted = db.output_type(name)
        if wanted is not None and TYPES[wanted].storage != "bundle":
            try:
                value = coerce(TYPES[wanted], value)
            except ValueError as error:
                raise ValueError(f"output {name}: {error}") from None
        setattr(db.outputs, name, value)

    def close(self) -> None:
        """Ends the writing in place: from now on other nodes share the arrays."""
        for array in self._open:
            array.setflags(write=False)
        self._open.clear()

    def _sized(self, name: str) -> Type | None:
        """The type of the array output whose size this name sets; None for any other name."""
        array = name.removesuffix("_size")
        if array == name or not hasattr(self._db.outputs, array):
            return None
        wanted = self._db.output_type(array)
        return TYPES[wanted] if wanted is not None and TYPES[wanted].array else None

    def _resize(self, name: str, type_: Type, size: Any) -> None:
        db = self._db
        if not isinstance(size, int) or size < 0:
            raise ValueError(f"output {name}_size: expected a whole number from 0, got {shown(size)}")
        old = getattr(db.outputs, name)
        if type_.storage == "token":
            db.claim(8 * size)
            setattr(db.outputs, name, [*old[:size], *[""] * (size - len(old))])
            return
        import numpy as np

        dtype = np.dtype(dtype_of(type_))
        db.claim(size * dtype.itemsize * math.prod(type_.shape))
        array = np.zeros((size, *type_.shape), dtype)
        kept = min(size, len(old))
        array[:kept] = old[:kept]
        setattr(db.outputs, name, array)
        self._open.append(array)


class OgnDatabase:
    """`db` as OmniGraph's Python nodes know it: inputs, outputs, state, tokens, logging and private memory.

    `internal_state`, `per_instance_state` and `shared_state` are the same private memory, made again after every stop.
    Everything else comes from the node's own database (`graph.node.database.Database`).
    """

    def __init__(self, db: Database, tokens: Mapping[str, str] | None = None) -> None:
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
        """The same as `internal_state`: a node has one instance."""
        return self.internal_state

    @property
    def shared_state(self) -> Any:
        """The same as `internal_state`: a node has one instance."""
        return self.internal_state

    @property
    def abi_node(self) -> Any:
        """The node."""
        return self._db.node

    @property
    def abi_context(self) -> Any:
        """The times of this evaluation."""
        return self._db.context

    def log_warn(self, message: str) -> None:
        """An older name of `log_warning`."""
        self._db.log_warning(message)


def log_print(*values: Any, sep: str = " ", **_: Any) -> None:
    """`print` of a script, sent to the log, because standard output may hold a report."""
    LOGGER.info("%s", sep.join(map(str, values)))
