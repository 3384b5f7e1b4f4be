"""What the `check` of a node type sees of a node when a graph file is opened, before anything runs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pxr import Usd

    from .database import Database


@dataclass(frozen=True, slots=True)
class NodeAtLoad:
    """A compiled node, the stage it will run over, and what the file says of it."""

    db: Database
    """Its inputs as they start, and what is connected."""
    stage: Usd.Stage
    given: tuple[str, ...]
    """The inputs that the file gives a value and nothing is connected to; empty for a node that is not `enabled`."""
    sensors: tuple[str, ...]
    """Paths of the prims behind the render product that is connected to it, as far as the file says which."""
    parity: str
    """The profile, `documented` or `isaacsim-6.0.1`."""
