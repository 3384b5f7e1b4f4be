"""A scene's dynamics as plain data: the result of reading USD and the input of an engine.

Everything is in metres, kilograms, seconds and radians; poses are rigid (4, 4) column-vector matrices.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from graph.base.records import dataclass, field
from graph.sim.scene.mechanisms import JointKind, Mechanisms
from graph.sim.transforms import Floats

from .contact_materials import PLAIN, Material
from .solver import UNCHOSEN, SolverOptions


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


ColliderKind = Literal["box", "sphere", "ellipsoid", "capsule", "cylinder", "plane", "mesh"]

DEFAULT_DENSITY = 1000.0
"""Density [kg/m3] if neither mass nor density is authored."""

FREE = math.inf


@dataclass(frozen=True)
class Volume:
    """Mass properties of a shape at density 1, in its body's frame: m3, centre [m], inertia about the centre (3, 3)."""

    volume: float
    center: Floats
    inertia: Floats


@dataclass(frozen=True)
class Collider:
    """A convex shape in the frame of its body (None: the world), with its axis along Z.

    size: half sizes of a box; radii of an ellipsoid; radius, then half height of a capsule or cylinder.
    """

    path: str
    body: str | None
    kind: ColliderKind
    pose: Floats
    size: tuple[float, ...] = ()
    vertices: Floats | None = None
    material: Material = PLAIN
    still: str = ""
    """For static shapes: the owning prim in `WorldModel.filtered`."""
    mask: int = 0
    """Its kind for the filters of collisions (see `WorldModel.meets`)."""
    trigger: bool = False
    """It does not collide and has no mass; the colliders inside it can be queried."""
    density: float | None = None
    material_density: float | None = None
    mass: float | None = None
    center: Floats | None = None
    """Authored centre of mass, in the body's frame [m]."""
    tensor: Floats | None = None
    """Authored inertia about the centre (3, 3) [kg m2], along the body's axes."""
    volume: Volume | None = None
    """Its mass properties, if they differ from those of its shape."""


@dataclass(frozen=True)
class Body:
    """A rigid body: its initial state, how it moves, and its authored mass properties (None: from its colliders).

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
    weightless: bool = False
    """Whether it ignores gravity."""
    damping: tuple[float, float] = (0.0, 0.0)
    """Fraction of the linear and of the angular velocity lost per second [1/s], if the body is free."""
    max_speed: tuple[float, float] = (math.inf, math.inf)
    """Its largest speed [m/s] (of the centre of mass) and angular speed [rad/s], if the body is free."""
    asleep: bool = False
    """It starts asleep: it does not move until a moving body touches it."""
    name: str = ""
    """Its name in the engine's model, if that is not its path."""

    @property
    def model_name(self) -> str:
        """Its name in the engine's model."""
        return self.name or self.path


@dataclass(frozen=True)
class Drive:
    """Force = stiffness (position - q) + damping (velocity - dq), limited to +-max_force; SI units.

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
    """Connects two bodies (None: the world): frame0 in the first one's frame, frame1 in the second one's.

    axis: 0, 1, 2 for the X, Y, Z of both frames. lower, upper, start: of the second body relative to the first; for a
    distance joint, the distance between the two frames' origins. cone: swing limit of the axis of a spherical joint
    [rad]. dofs: the free axes of a joint of kind d6 as joints with one axis each, in order from the first frame.
    armature: inertia that the joint adds [kg or kg m2]; friction: dry friction in it [N or N m]; damping: force against
    its velocity [N s/m or N m s/rad]; max_speed: its largest speed [m/s or rad/s]; initial_position, initial_velocity:
    its initial state, if that differs from the poses and velocities of its bodies.
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
    cone: float = FREE
    dofs: tuple[Joint, ...] = ()
    armature: float = 0.0
    friction: float = 0.0
    damping: float = 0.0
    max_speed: float = math.inf
    initial_position: float | None = None
    initial_velocity: float | None = None
    name: str = ""
    """Its name in the engine's model, if that is not its path."""
    label: str = ""
    """Its name in messages, if that is not the name of its prim or in the engine's model."""

    @property
    def model_name(self) -> str:
        """Its name in the engine's model."""
        return self.name or self.path

    @property
    def singles(self) -> tuple[Joint, ...]:
        """The joints with one axis, or the spherical one, of which it consists."""
        if self.kind == "d6":
            return self.dofs
        return (self,) if self.kind in ("revolute", "prismatic", "spherical") else ()

    @property
    def limited(self) -> bool:
        """Whether it has limits."""
        return math.isfinite(self.lower) or math.isfinite(self.upper) or math.isfinite(self.cone)


@dataclass(frozen=True)
class Mimic:
    """A joint with one axis that follows another one: position = offset + ratio * the leader's [rad or m]."""

    path: str
    leader: str
    offset: float
    ratio: float


@dataclass(frozen=True)
class Suction:
    """A point of a body that can hold what is in front of it: its joint prim, position [m] and unit direction in the
    body.

    clearance: how far in front of the point the search begins [m].
    """

    path: str
    body: str
    place: Floats
    direction: Floats
    clearance: float = 0.0


@dataclass(frozen=True)
class Gripper:
    """Points that grip together: their search distance [m], holding force [N], and how long they keep trying [s]."""

    path: str
    points: tuple[Suction, ...]
    reach: float
    coaxial_limit: float = FREE
    shear_limit: float = FREE
    patience: float = 0.0


@dataclass(frozen=True)
class BodyForce:
    """A force [N] at a body's centre of mass and a torque [N m], along the world's axes or its own (`local`).

    With `acceleration` they are [m/s2] and [rad/s2], whatever its mass and inertia.
    """

    path: str
    force: Floats
    torque: Floats
    local: bool = False
    acceleration: bool = False


@dataclass(frozen=True)
class MovingSurface:
    """The moving surface of a body, as of a belt: velocity [m/s] and angular velocity [rad/s] about its origin.

    Both are along its axes; pose: (4, 4), the body's initial rigid frame [m].
    """

    path: str
    pose: Floats
    velocity: Floats
    turn: Floats


@dataclass(frozen=True)
class WorldModel:
    """Everything that an engine needs: gravity [m/s2], bodies, colliders, joints and collision filters.

    filtered: pairs of bodies, or of a body and static geometry (`Collider.still`). meets: (k, k) which kinds of
    colliders (`Collider.mask`) collide, None: all. given: bodies of a model that is simulated unchanged; the others are
    added to it.
    """

    gravity: Floats
    bodies: tuple[Body, ...]
    colliders: tuple[Collider, ...]
    joints: tuple[Joint, ...]
    filtered: tuple[tuple[str, str], ...] = ()
    grippers: tuple[Gripper, ...] = ()
    mimics: tuple[Mimic, ...] = ()
    meets: NDArray[np.bool_] | None = None
    options: SolverOptions = UNCHOSEN
    softs: tuple[Soft, ...] = ()
    given: tuple[Body, ...] = ()
    forces: tuple[BodyForce, ...] = ()
    surfaces: tuple[MovingSurface, ...] = ()
    mechanisms: Mechanisms | None = None
    """The articulations of the stage that it was read from."""
