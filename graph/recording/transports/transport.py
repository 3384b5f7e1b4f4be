"""What a transport does: it carries topics between a run and other programs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from graph.sim.messages.bus import Topic


class NotSentError(Exception):
    """A message that could not be sent, and why, in a few words."""


@dataclass(frozen=True, slots=True)
class Outgoing:
    """A message to send: CDR bytes, the simulation time of its publication, whether late listeners get it."""

    topic: str
    type_name: str
    data: bytes
    sent_ns: int
    latched: bool


@dataclass(frozen=True, slots=True)
class Kind:
    """A kind of transport, declared in the entry point group `tickgraph.transports` under its name in `--live`.

    - module: the one with `open_transport(target) -> Transport`, imported when a target is opened; it raises UserError.
    - libraries: what it imports; installed by the extra that has the kind's name.
    - port: the usual one; None for transports without ports.
    - control: whether clients may publish only if the target says so (`NAME:control`).
    - domain: whether it lives in a domain of ROS 2.
    """

    module: str
    libraries: tuple[str, ...] = ()
    port: int | None = None
    control: bool = False
    domain: bool = False


class Transport(Protocol):
    """Carries topics over one network. All methods but `close` are called in one thread, which may wait in them."""

    place: str
    """Where listeners find it, such as "ws://127.0.0.1:8765"."""

    def advertise(self, topic: Topic) -> None:
        """Announces a topic before its first message. Raises NotSentError if this transport cannot carry its type."""

    def matched(self, topic: str) -> bool:
        """Whether an announced topic has found a listener."""

    def send(self, message: Outgoing) -> None:
        """Sends a message of an announced topic; waits a second at most. Raises NotSentError if it cannot be sent."""

    def subscribe(self, topic: Topic, receive: Callable[[bytes], None]) -> None:
        """Passes each CDR message that others publish on a topic to `receive`, in a thread of its own.

        The topic's quality is the one that the subscription requests.
        """

    def flush(self, seconds: float) -> None:
        """Waits until what was sent is on its way to the present listeners, for so long at most."""

    def close(self) -> None:
        """Leaves the network; calling it twice is harmless."""

    def notes(self) -> list[tuple[str, str]]:
        """(warning code, message) for messages that were lost after they were sent; called after `close`."""
