"""Bodies that push each other in the last step, and how deep they overlap."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from graph.base.records import dataclass
from graph.sim.transforms import Floats

if TYPE_CHECKING:
    from .engine import MujocoEngine

DEEP = 0.01
"""Bodies that overlap by more than this [m] do not rest on each other: they are pushed apart, or sink."""


@dataclass(frozen=True, slots=True)
class Overlap:
    """A pair of bodies of the model in contact, the lower number first (0: what stands), and how deep [m]."""

    bodies: tuple[int, int]
    depth: float


def deepest_overlap(engine: MujocoEngine, body: int | None = None) -> Overlap | None:
    """The deepest overlap of rigid bodies that push each other, or of one body with others; None without any."""
    sides, depths = _pushing(engine)
    if body is not None:
        depths = np.where((sides == body).any(axis=1), depths, -np.inf)
    if not depths.size or not math.isfinite(depths.max()):
        return None
    first, second = sorted(sides[depths.argmax()].tolist())
    return Overlap((first, second), float(depths.max()))


def partners(engine: MujocoEngine, body: int) -> list[int]:
    """The bodies that push a body, and the body itself."""
    sides, _ = _pushing(engine)
    return [body, *np.unique(sides[(sides == body).any(axis=1)]).tolist()]


def _pushing(engine: MujocoEngine) -> tuple[Any, Floats]:
    """The bodies (n, 2) of the contacts between rigid bodies that push, and their depths (n,) [m]."""
    contact = engine.data.contact
    geoms = np.asarray(contact.geom)
    pushes = (geoms >= 0).all(axis=1) & (np.asarray(contact.efc_address) >= 0)
    return engine.model.geom_bodyid[geoms[pushes]], -np.asarray(contact.dist, np.float64)[pushes]
