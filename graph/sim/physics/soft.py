"""Cloth, soft bodies and particles: points with mass, and the elements between them."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from graph.base.records import dataclass, field
from graph.sim.transforms import Floats

from .contact_materials import PLAIN, Material


@dataclass(frozen=True)
class Soft:
    """The deforming part of a prim: positions (n, 3) [m, world], masses (n,) [kg], elements (m, 3) or (m, 4) (None:
    particles).

    young [Pa], poisson, damping [s]: of the material; thickness [m] of cloth; radius [m] of contacts. held: points that
    are fixed in the world (None) or to a body, by number, each with its position there. corners, weights: (p, k) the
    points that each point of the prim follows, and their weights.
    """

    path: str
    places: Floats
    masses: Floats
    elements: NDArray[np.intp] | None
    radius: float
    young: float = 0.0
    poisson: float = 0.0
    damping: float = 0.0
    thickness: float = 0.0
    self_collides: bool = False
    material: Material = PLAIN
    velocity: Floats = field(default_factory=lambda: np.zeros(3))
    held: Mapping[int, tuple[str | None, Floats]] = field(default_factory=dict)
    corners: NDArray[np.intp] = field(default_factory=lambda: np.zeros((0, 1), dtype=np.intp))
    weights: Floats = field(default_factory=lambda: np.zeros((0, 1)))
