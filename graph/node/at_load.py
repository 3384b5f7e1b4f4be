"""What the `check` function of a node type gets when a graph file is opened, before anything runs."""

from __future__ import annotations

from typing import TYPE_CHECKING

from graph.base.records import dataclass

if TYPE_CHECKING:
    from pxr import Usd

    from graph.sim.settings import Settings

    from .database import Database


@dataclass(frozen=True, slots=True)
class NodeAtLoad:
    """A compiled node, the stage it will run on, and what the file says about it."""

    db: Database
    """The node's database: the initial values of its inputs, and what is connected."""
    stage: Usd.Stage
    given: tuple[str, ...]
    """The unconnected inputs to which the file gives a value; empty for a node that is not `enabled`."""
    sensors: tuple[str, ...]
    """Paths of the prims of the connected render product, as far as the file determines them."""
    settings: Settings
    """The settings of the run, as its profile and the file give them."""
