"""Writers by name: callables that take each new frame of a sensor."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from .errors import SensorValueError
from .frame import Frame

Writer = Callable[[Frame], object]


@dataclass(frozen=True, slots=True)
class WriterSpec:
    """How a writer is made: a factory, its default arguments, and the channels it reads."""

    factory: Callable[..., Writer]
    defaults: Mapping[str, Any] = field(default_factory=dict)
    channels: frozenset[str] = frozenset({"xyz"})


WRITERS: dict[str, WriterSpec] = {}
"""The table; sensors copy it when they are made, so later entries reach later sensors only."""


def register_writer_spec(name: str, spec: WriterSpec) -> None:
    """Adds a writer. Raises SensorValueError if the name is taken."""
    if name in WRITERS:
        raise SensorValueError(f"there is a writer {name!r} already; give yours another name")
    WRITERS[name] = spec


def find_writer(table: Mapping[str, WriterSpec], name: str) -> WriterSpec:
    """The writer of this name. Raises SensorValueError listing those there are."""
    if name not in table:
        raise SensorValueError(f"there is no writer {name!r}; there are: {', '.join(sorted(table)) or 'none'}")
    return table[name]
