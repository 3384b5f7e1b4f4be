"""The interface of a physics engine. Everything outside an engine's own package uses these types.

Arrays are float64 in SI units (m, kg, s, rad) along world axes. Rows over bodies (B) follow `body_paths`, rows over
joints follow `joints`.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from graph.base.errors import RunError
from graph.base.records import dataclass, field
from graph.sim import transforms
from graph.sim.scene.stage import Warn
from graph.sim.transforms import Floats

if TYPE_CHECKING:
    from graph.sim.fidelity import Fidelity

    from .articulation import Articulation, Commanded
    from .solver import SolverOptions
    from .world_model import BodyForce, Joint, Volume, WorldModel

Rows = NDArray[np.intp]
"""(n,) row numbers."""


class Snapshot(Protocol):
    """Positions and velocities of everything at one moment. It stays valid while the engine continues."""

    def velocities(self) -> Floats:
        """(B, 6) of the bodies' origins: linear [m/s], then angular [rad/s]; zeros once the engine is closed."""

    def points(self, path: str) -> Floats | None:
        """(p, 3) the points of a deformable prim [m], in the prim's order; None for any other prim."""

    def point_velocities(self, path: str) -> Floats | None:
        """(p, 3) the velocities of these points [m/s]; None for any other prim, and where the engine does not know."""
        return None


def _no_vectors() -> Floats:
    return np.zeros((0, 3))


@dataclass(frozen=True)
class Contacts:
    """The contacts of the last physics step, n of them.

    pairs: paths of the two colliders; bodies: of their bodies, empty for static ones. positions (n, 3) [m], normals (n,
    3) from the first to the second, distances (n,) [m], negative if they overlap. forces (n, 3): of the first on the
    second [N]. dt: length of the step [s].
    """

    pairs: tuple[tuple[str, str], ...] = ()
    bodies: tuple[tuple[str, str], ...] = ()
    positions: Floats = field(default_factory=_no_vectors)
    normals: Floats = field(default_factory=_no_vectors)
    distances: Floats = field(default_factory=lambda: np.zeros(0))
    forces: Floats = field(default_factory=_no_vectors)
    dt: float = 0.0

    @property
    def impulses(self) -> Floats:
        """(n, 3) impulses of the first on the second in the step [N s]."""
        return self.forces * self.dt


@dataclass(frozen=True, slots=True)
class RayHit:
    """Where a ray meets a collider first: paths of it and its body (empty: static), distance [m], place [m], normal."""

    collider: str
    body: str
    distance: float
    position: Floats
    normal: Floats


@dataclass(frozen=True, slots=True)
class MotionTerms:
    """The equations of motion of a mechanism with n degrees of freedom: those of a free base, then its joints'.

    jacobians: (b, 6, n), linear then angular velocity of each body's origin by degree of freedom; masses: (n, n)
    inertia; gravity, coriolis: (n,) forces that balance the weight, and the velocities' forces [N or N m].
    """

    jacobians: Floats
    masses: Floats
    gravity: Floats
    coriolis: Floats


class SurfaceGripper(Protocol):
    """Points of a body that hold what is in front of them."""

    @property
    def status(self) -> Literal["Open", "Closing", "Closed"]:
        """Whether it holds something, or still tries to."""

    @property
    def held(self) -> tuple[str, ...]:
        """Paths of the bodies held."""

    def close(self) -> None:
        """Begins to grip; does nothing if it is closed or closing."""

    def open(self) -> None:
        """Releases everything."""


class PhysicsEngine(Protocol):
    """The bodies of a playing world. An engine derives from this class; methods with a body here are optional.

    It is made by an `EngineFactory` from a `WorldModel` (plain data read from the stage) and freed by `close`.
    """

    name: str
    """The name that `SimulationManager.get_active_physics_engine` returns."""
    dt: Fraction
    """Length of a step [s]."""
    meters_per_unit: float
    """Metres in a stage unit."""
    world: WorldModel
    """The world from which the engine was built."""
    body_paths: tuple[str, ...]
    """The rigid bodies that can move, kinematic ones included."""
    kinematic: frozenset[str]
    """Bodies that only users move."""
    joints: tuple[Joint, ...] = ()
    """All joints, in stage order; another tuple object after `adopt`."""
    taken: int
    """Steps done by the last call of `step`."""

    def facts(self) -> dict[str, Any]:
        """Plain data about the engine for `graph explain`: counts, options, `advice` (lines about its accuracy)."""
        return {"engine": self.name, "bodies": len(self.body_paths), "joints": len(self.joints), "advice": []}

    # -- stepping ----------------------------------------------------------------------------------------------------

    def step(self, count: int = 1) -> None:
        """Advances by `count` times dt. Raises RunError if the simulation diverges, after `taken` steps."""

    def set_dt(self, dt: Fraction) -> None:
        """Change the length of a step [s]."""

    @property
    def gravity(self) -> Floats:
        """(3,) [m/s2]; a copy."""

    def set_gravity(self, gravity: Sequence[float] | Floats) -> None:
        """Change gravity, (3,) [m/s2], from the next step on."""

    # -- bodies ------------------------------------------------------------------------------------------------------

    @property
    def positions(self) -> Floats:
        """(B, 3) origins of the bodies [m]; may be a view of the engine's memory."""

    @property
    def quaternions(self) -> Floats:
        """(B, 4) w, x, y, z; may be a view of the engine's memory."""

    @property
    def rotations(self) -> Floats:
        """(B, 3, 3); may be a view of the engine's memory."""
        return transforms.rotation_matrices(self.quaternions)

    def velocities(self) -> Floats:
        """(B, 6) of the bodies' origins: linear [m/s], then angular [rad/s]."""
        return self.snapshot().velocities()

    @property
    def masses(self) -> Floats:
        """(B,) [kg]; 0 for kinematic bodies."""

    @property
    def inertias(self) -> Floats:
        """(B, 3, 3) about the centres of mass, along the bodies' axes [kg m2]; 0 for kinematic bodies."""

    def set_masses(self, paths: Sequence[str], masses: Floats | None, diagonals: Floats | None) -> None:
        """Gives free bodies masses (n,) [kg] and moments of inertia (n, 3) about their own axes [kg m2].

        None keeps the present ones. Raises RunError, with nothing changed, for other bodies, for values that are not
        positive, and for moments of a body whose principal axes are not its own.
        """

    @property
    def centers_of_mass(self) -> Floats:
        """(B, 3) [m]."""

    def is_free(self, path: str) -> bool:
        """Whether neither a joint nor the user holds a body."""

    def can_place(self, path: str) -> bool:
        """Whether a body can be placed: it is free or kinematic."""
        return path in self.kinematic or self.is_free(path)

    def set_poses(self, paths: Sequence[str], poses: Floats, velocities: Floats | None = None) -> None:
        """Puts free or kinematic bodies at rigid poses (n, 4, 4) [m]. Raises RunError for a body held by a joint.

        velocities: (n, 6) of the origins of kinematic bodies that pass through these poses, linear [m/s], then angular
        [rad/s]: they carry what touches them. None: they are placed there and rest.
        """

    def set_velocities(self, paths: Sequence[str], velocities: Floats) -> None:
        """Set (n, 6) of free bodies' origins: linear [m/s], then angular [rad/s]. Raises RunError for other bodies."""

    def set_forces(self, paths: Sequence[str], forces: Floats) -> None:
        """Applies (n, 6) forces [N] at the centres of mass and torques [N m] to bodies, until they are set again."""

    def set_authored_forces(self, forces: Sequence[BodyForce]) -> None:
        """Replaces the forces of the stage (`WorldModel.forces`), beside those of `set_forces`."""

    # -- joints ------------------------------------------------------------------------------------------------------
    # rows: joints with one degree of freedom; values: one per row [rad or m, per second, N m or N]

    def joint_positions(self, rows: Rows) -> Floats:
        """(n,) positions."""
        return np.zeros(len(rows))

    def joint_velocities(self, rows: Rows) -> Floats:
        """(n,) velocities."""
        return np.zeros(len(rows))

    def joint_efforts(self, rows: Rows) -> Floats:
        """(n,) efforts along the joints in the last step: drives, applied efforts and limits."""
        return np.zeros(len(rows))

    def joint_reactions(self, rows: Rows) -> Floats:
        """(n, 6) force [N], then torque [N m], that joints pass on to their second bodies, in the joints' frames."""
        return np.zeros((len(rows), 6))

    def driven(self, rows: Rows) -> NDArray[np.bool_]:
        """(n,) which joints follow position and velocity targets."""
        return np.zeros(len(rows), dtype=np.bool_)

    def set_joint_positions(self, rows: Rows, positions: Floats) -> None:
        """Puts joints at positions at once; the targets of drives stay."""

    def set_joint_velocities(self, rows: Rows, velocities: Floats) -> None:
        """Sets joint velocities at once."""

    def set_joint_targets(
        self, rows: Rows, positions: Floats | None, velocities: Floats | None, efforts: Floats | None
    ) -> None:
        """Sets the targets of drives, and efforts that act in addition until set again; NaN leaves one unchanged."""

    def motion_terms(self, bodies: Sequence[str], rows: Rows, base: str | None) -> MotionTerms:
        """The equations of motion of joints and of a free base, if any: 6 more, linear and angular, world axes [SI].

        A body that cannot move has a Jacobian of zeros. Raises RunError for an engine without them.
        """
        raise RunError(f"the physics engine {self.name} gives no equations of motion")

    def pose_at(self, body: str, rows: Rows, positions: Floats) -> tuple[Floats, Floats]:
        """Where a body would be with joints at positions: its (4, 4) pose [m] and the (6, n) Jacobian of its origin.

        Nothing moves. Raises RunError for an engine without it.
        """
        raise RunError(f"the physics engine {self.name} places no bodies by joint positions")

    def articulation(self, root: str) -> Articulation:
        """The mechanism at a path: a robot's root prim, or any of its bodies or joints, in stage units.

        Raises RunError if it has no revolute or prismatic joint.
        """
        from .articulation import Articulation

        if root not in self._articulations:
            found = Articulation(self, root, self.meters_per_unit)
            if not found.joint_paths:
                raise RunError(f"{root}: no revolute or prismatic joint is there")
            self._articulations[root] = found
        return self._articulations[root]

    @cached_property
    def commanded(self) -> Commanded:
        """What joints were commanded last."""
        from .articulation import Commanded

        return Commanded(self)

    @cached_property
    def _articulations(self) -> dict[str, Articulation]:
        return {}

    # -- contacts, grippers, belts, deformables ----------------------------------------------------------------------

    def contacts(self) -> Contacts:
        """The contacts with forces in the last step."""
        return Contacts()

    def triggered(self) -> dict[str, tuple[str, ...]]:
        """By the path of each trigger, the paths of the colliders that are inside now."""
        return {}

    def overlapping(self, pose: Floats, half: Floats) -> list[tuple[str, str]]:
        """The paths of the rigid colliders that overlap a box now, and of their bodies (empty: static).

        pose: (4, 4), the rigid frame of its centre [m]; half: (3,), its half lengths along its axes [m]. What only
        touches it is outside.
        """
        raise RunError(f"the physics engine {self.name} does not find what is in a box")

    def overlapping_sphere(self, center: Floats, radius: float) -> list[tuple[str, str]]:
        """The same for a sphere [m]."""
        raise RunError(f"the physics engine {self.name} does not find what is in a sphere")

    def ray_hits(self, origin: Floats, direction: Floats, most: float) -> list[RayHit]:
        """The first hit on each rigid collider within a distance [m], the nearest first.

        direction: of length 1. Inside a collider it is hit at distance 0, with the normal against the ray.
        """
        raise RunError(f"the physics engine {self.name} casts no rays")

    def sphere_hits(self, origin: Floats, direction: Floats, radius: float, most: float) -> list[RayHit]:
        """The same for a sphere of this radius [m] whose centre moves; the distance is the centre's."""
        raise RunError(f"the physics engine {self.name} sweeps no spheres")

    def gripper(self, path: str) -> SurfaceGripper:
        """The surface gripper at a path. Raises RunError if the path has no gripper."""
        raise RunError(f"{path}: the physics engine {self.name} has no surface grippers")

    def set_surface_velocity(self, path: str, pose: Floats, velocity: Floats, turn: Floats) -> bool:
        """Moves the surfaces of the colliders at and below a prim, as on a belt, while their body stays.

        velocity [m/s] and turn [rad/s] about the prim's origin, both along its axes; zeros end the motion. pose: (4,
        4), the prim's present rigid frame [m]. Returns whether the engine had to change its integrator. Raises
        ValueError if the prim has no colliders.
        """
        raise RunError(f"{path}: the physics engine {self.name} has no moving surfaces")

    @property
    def deformable_paths(self) -> tuple[str, ...]:
        """The prims that deform."""
        return ()

    def deformable_start(self, path: str) -> Floats:
        """(p, 3) initial positions of a deformable prim's points [m], in the prim's order."""
        raise KeyError(path)

    # -- state -------------------------------------------------------------------------------------------------------

    def snapshot(self) -> Snapshot:
        """The present positions and velocities."""

    def restore(self, snapshot: Snapshot) -> None:
        """Restores the positions and velocities of a snapshot; targets, forces and the time stay.

        Raises RunError for a snapshot of another engine, or from before the last `adopt`.
        """

    def adopt(self, world: WorldModel, kept: frozenset[str] | None, warn: Warn) -> None:
        """Continues with another world: what both worlds have keeps its state, new parts start as the world says.

        kept: bodies whose rest poses are the same in both; None: nothing keeps its state. Raises UserError, with the
        engine unchanged, for a world that the engine refuses.
        """

    def close(self) -> None:
        """Frees the engine's memory; only snapshots may be read afterwards."""


class ModelScene(Protocol):
    """A model that the stage mirrors, of an MJCF or URDF file."""

    stage: Any

    @property
    def moves(self) -> bool:
        """Whether anything in it can move."""

    def serve(self, world: Any, phases: Any) -> None:
        """Connects a world's Fabric and stage to the model's actuators and sensors, until the world closes."""

    def settle(self, warn: Warn) -> None:
        """Takes over the places that the stage gives to the roots of the model."""

    def compiled(
        self, world: WorldModel, dt: Fraction, options: SolverOptions, warn: Warn, volumes: dict[Any, Volume]
    ) -> Any:
        """The model with time step `dt` [s] and the additions of `world`, as MuJoCo's engine takes it."""


class EngineFactory(Protocol):
    """Makes an engine: `App(physics=FACTORY)`. A class that derives from `PhysicsEngine` can be a factory itself."""

    @property
    def name(self) -> str:
        """The engine's name."""

    def __call__(
        self,
        world: WorldModel,
        dt: Fraction,
        *,
        meters_per_unit: float,
        fidelity: Fidelity | None,
        warn: Warn,
        mjcf: ModelScene | None,
    ) -> PhysicsEngine:
        """The engine of a world, in the world's initial state, with steps of `dt` [s].

        mjcf: the MJCF model that the stage mirrors, if any; only MuJoCo simulates it. Raises UserError for a world that
        the engine refuses.
        """


def contact_force(engine: PhysicsEngine, body: str, near: Any = None, radius: float = 0.0) -> Floats:
    """(3,) total force of the last step's contacts on a body [N].

    With a radius [m], only of contacts closer to `near` (3,). Contacts between colliders of the same body do not count.
    """
    return sum((force for _, force in contacts_of(engine.contacts(), body, near, radius)), np.zeros(3))


def contacts_of(contacts: Contacts, body: str, near: Any = None, radius: float = 0.0) -> list[tuple[int, Floats]]:
    """The rows of the contacts that `contact_force` counts, and the force (3,) of each on the body [N]."""
    found = []
    for row, (first, second) in enumerate(contacts.bodies):
        if first == second or body not in (first, second):
            continue
        if near is not None and radius > 0 and np.linalg.norm(contacts.positions[row] - near) >= radius:
            continue
        found.append((row, contacts.forces[row] if second == body else -contacts.forces[row]))
    return found
