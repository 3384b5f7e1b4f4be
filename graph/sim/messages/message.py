"""What travels on the bus."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, slots=True)
class Message:
    """One published message; `stamp_ns` is simulation time, `sequence` counts from 1 on its topic since play."""

    topic: str
    type_name: str
    message: Any
    stamp_ns: int
    sequence: int
