"""A message on the bus, the quality of service that its publisher offers, and the schedule behind its topic."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from graph.base.exact import shortest
from graph.base.records import dataclass, field

# Numbers of rmw/types.h, which every rosbag2 since Foxy can read (it cannot read the newer words).
_HISTORY = {"systemDefault": 0, "keepLast": 1, "keepAll": 2, "unknown": 3}
_RELIABILITY = {"systemDefault": 0, "reliable": 1, "bestEffort": 2, "unknown": 3}
_DURABILITY = {"systemDefault": 0, "transientLocal": 1, "volatile": 2, "unknown": 3}
_LIVELINESS = {"systemDefault": 0, "automatic": 1, "manualByTopic": 3, "unknown": 4}
_INFINITE = 2**63 - 1
"""Nanoseconds that mean "no limit" (RMW_DURATION_INFINITE)."""


@dataclass(frozen=True, slots=True)
class Quality:
    """A quality of service profile in the words of ROS2QoSProfile; times in nanoseconds, 0 means no limit."""

    history: str = "keepLast"
    depth: int = 10
    reliability: str = "reliable"
    durability: str = "volatile"
    deadline_ns: int = 0
    lifespan_ns: int = 0
    liveliness: str = "systemDefault"
    lease_ns: int = 0

    def as_yaml(self) -> str:
        """The list of one profile that rosbag2 stores as `offered_qos_profiles`."""
        return (
            f"- history: {_HISTORY.get(self.history, 3)}\n"
            f"  depth: {self.depth}\n"
            f"  reliability: {_RELIABILITY.get(self.reliability, 3)}\n"
            f"  durability: {_DURABILITY.get(self.durability, 3)}\n"
            f"  deadline:\n{_time(self.deadline_ns)}"
            f"  lifespan:\n{_time(self.lifespan_ns)}"
            f"  liveliness: {_LIVELINESS.get(self.liveliness, 4)}\n"
            f"  liveliness_lease_duration:\n{_time(self.lease_ns)}"
            "  avoid_ros_namespace_conventions: false\n"
        )


DEFAULT = Quality()


def _time(nanoseconds: int) -> str:
    seconds, rest = divmod(nanoseconds or _INFINITE, 10**9)
    return f"    sec: {seconds}\n    nsec: {rest}\n"


SENSOR, RATE, EVERY = "tickgraph_sensor", "tickgraph_rate_hz", "tickgraph_every"
"""Keys of a channel's metadata in a recording: prim path, rate [Hz] as an exact number, ticks for one message."""


@dataclass(slots=True)
class Ticks:
    """The number of ticks that fell due, which a publisher counts; it outlives the publisher."""

    count: int = 0


@dataclass(frozen=True, slots=True)
class Cadence:
    """One message for every `every`-th tick of the sensor at prim path `sensor`.

    rate: ticks a second of simulation time [Hz]; 0 means one in every update in which time advances. ticks: those that
    fell due so far, since the publisher exists.
    """

    sensor: str
    rate: Fraction
    every: int = 1
    ticks: Ticks = field(default_factory=Ticks, compare=False)

    @property
    def due(self) -> int:
        """Messages that fell due so far."""
        return self.ticks.count // self.every

    def as_metadata(self) -> dict[str, str]:
        """What a recording notes beside the topic."""
        return {SENSOR: self.sensor, RATE: shortest(self.rate), EVERY: str(self.every)}


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
