"""A scene's dynamics as plain data: between reading it from USD and compiling it for an engine.

Everything is in metres, kilograms, seconds and radians; poses are rigid (4, 4) column-vector matrices.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from graph.sim.tessellation import Triangles
from graph.sim.transforms import Floats

ColliderKind = Literal["box", "sphere", "ellipsoid", "capsule", "cylinder", "plane", "mesh"]
JointKind = Literal["fixed", "revolute", "prismatic", "spherical"]

DEFAULT_DENSITY = 1000.0
"""kg/m3, of what authors neither mass nor density."""

DEFAULT_FRICTION = 0.5
"""Of colliders without a physics material."""

FREE = math.inf


@dataclass(frozen=True)
class Collider:
    """A convex shape in the frame of its body (None: the world), along Z where it has an axis.

    size: half sizes of a box; radii of an ellipsoid; radius, then half height of a capsule or cylinder.
    """

    path: str
    body: str | None
    kind: ColliderKind
    pose: Floats
    size: tuple[float, ...] = ()
    vertices: Floats | None = None
    triangles: Triangles | None = None
    friction: float = DEFAULT_FRICTION
    density: float | None = None
    mass: float | None = None


@dataclass(frozen=True)
class Body:
    """A rigid body: where it starts, how it moves, and what of its mass is authored (None: from its colliders).

    velocity: of the centre of mass [m/s], angular_velocity [rad/s], both along world axes.
    """

    path: str
    pose: Floats
    kinematic: bool = False
    mass: float | None = None
    density: float | None = None
    center_of_mass: Floats | None = None
    diagonal_inertia: Floats | None = None
    principal_axes: Floats | None = None
    velocity: Floats = field(default_factory=lambda: np.zeros(3))
    angular_velocity: Floats = field(default_factory=lambda: np.zeros(3))
    name: str = ""
    """What the engine's model calls it, where that is not its path."""

    @property
    def model_name(self) -> str:
        """Its name in the engine's model."""
        return self.name or self.path


@dataclass(frozen=True)
class Drive:
    """Force = stiffness (position - q) + damping (velocity - dq), held within +-max_force; SI units.

    With `acceleration` it is multiplied by the inertia that the joint moves.
    """

    stiffness: float = 0.0
    damping: float = 0.0
    position: float = 0.0
    velocity: float = 0.0
    max_force: float = math.inf
    acceleration: bool = False


@dataclass(frozen=True)
class Joint:
    """Ties two bodies (None: the world): frame0 in the first one's frame, frame1 in the second one's.

    axis: 0, 1, 2 for the X, Y, Z of both frames. lower, upper, start: of the second body relative to the first.
    """

    path: str
    kind: JointKind
    bodies: tuple[str | None, str | None]
    frames: tuple[Floats, Floats]
    axis: int = 0
    lower: float = -FREE
    upper: float = FREE
    start: float = 0.0
    drive: Drive | None = None
    collide: bool = False
    in_tree: bool = True
    name: str = ""
    """What the engine's model calls it, where that is not its path."""

    @property
    def model_name(self) -> str:
        """Its name in the engine's model."""
        return self.name or self.path


@dataclass(frozen=True)
class Suction:
    """A point of a body that can hold what is before it: its joint prim, place [m] and unit direction in the body.

    clearance: how far before the point the search begins [m].
    """

    path: str
    body: str
    place: Floats
    direction: Floats
    clearance: float = 0.0


@dataclass(frozen=True)
class Gripper:
    """Points that grip together: how far they search [m], what they can hold [N], how long they go on trying [s]."""

    path: str
    points: tuple[Suction, ...]
    reach: float
    coaxial_limit: float = FREE
    shear_limit: float = FREE
    patience: float = 0.0


@dataclass(frozen=True)
class World:
    """All that one engine needs: gravity [m/s2], bodies, colliders, joints and pairs of bodies that never collide.

    given: bodies that a model brings which is simulated as it is; the others are added to it.
    """

    gravity: Floats
    bodies: tuple[Body, ...]
    colliders: tuple[Collider, ...]
    joints: tuple[Joint, ...]
    filtered: tuple[tuple[str, str], ...] = ()
    grippers: tuple[Gripper, ...] = ()
    given: tuple[Body, ...] = ()
