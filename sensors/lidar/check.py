"""What is wrong with the lidars of a stage, before anything runs."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from graph.base.errors import UserError

from .prim import read_config, read_tick_rate

if TYPE_CHECKING:
    from pxr import Usd


def lidar_problems(stage: Usd.Stage) -> Iterator[tuple[str, str]]:
    """(prim path, message) for each OmniLidar of the stage that describes no lidar there can be."""
    from graph.sim.usd import Usd

    for prim in stage.Traverse(Usd.TraverseInstanceProxies()):
        if prim.GetTypeName() == "OmniLidar":
            for read in (read_config, read_tick_rate):
                try:
                    read(prim)
                except UserError as error:
                    yield str(prim.GetPath()), str(error)
