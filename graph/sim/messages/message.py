"""A message on the bus."""

from __future__ import annotations

from typing import Any

from graph.base.records import dataclass, field

from .cadence import Cadence
from .quality import DEFAULT, Quality


@dataclass(frozen=True, slots=True)
class Message:
    """One published message; it and its content do not change after it was published.

    stamp_ns: the simulation time of its content, as in its header. sequence: counts from 1 on its topic since play.
    sent_ns: the simulation time at which it was published. quality: the offer of its publisher. cadence: the sensor's
    schedule that it follows. origin: the sink that received it from outside, which does not send it back; None for a
    publisher of the App.
    """

    topic: str
    type_name: str
    message: Any
    stamp_ns: int
    sequence: int
    sent_ns: int
    quality: Quality = DEFAULT
    cadence: Cadence | None = None
    origin: object | None = None
    _bytes: bytes | None = field(default=None, init=False, repr=False, compare=False)

    def cdr(self) -> bytes:
        """The message as little-endian CDR with its header of 4 bytes; made once for all sinks."""
        if self._bytes is None:
            from .ros_types import serialize

            object.__setattr__(self, "_bytes", serialize(self.message, self.type_name))
        assert self._bytes is not None
        return self._bytes
