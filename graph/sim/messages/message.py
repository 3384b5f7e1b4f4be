"""A message on the bus."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from .cadence import Cadence
from .quality import DEFAULT, Quality


@dataclass(frozen=True, slots=True)
class Message:
    """One published message.

    stamp_ns: the simulation time of its content, as in its header. sequence: counts from 1 on its topic since play.
    sent_ns: the simulation time at which it was published. quality: the offer of its publisher. cadence: the sensor's
    schedule that it follows.
    """

    topic: str
    type_name: str
    message: Any
    stamp_ns: int
    sequence: int
    sent_ns: int
    quality: Quality = DEFAULT
    cadence: Cadence | None = None
