"""The schedule behind a topic: which sensor's ticks its messages come from."""

from __future__ import annotations

from fractions import Fraction

from graph.base.exact import shortest
from graph.base.records import dataclass, field

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
