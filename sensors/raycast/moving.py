"""A moving mesh, for ray casting."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from graph.sim.geometry.collect import Mesh


@dataclass(frozen=True, slots=True)
class Moving:
    """A moving mesh, its surface number and its body's."""

    mesh: Mesh
    surface: int
    body: int
