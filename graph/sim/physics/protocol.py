"""What a physics engine gives the world around it. Everything outside an engine's own package speaks to these types.

Arrays are float64 in SI units (m, kg, s, rad) along world axes. Rows over bodies (B) follow `body_paths`, rows over
joints follow `joints`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from graph.base.errors import RunError
from graph.sim import transforms
from graph.sim.scene.stage import Warn
from graph.sim.transforms import Floats

if TYPE_CHECKING:
    from graph.sim.fidelity import Fidelity
    from graph.sim.mjcf.scene import MjcfScene

    from .articulation import Articulation
    from .model import BodyForce, Joint, WorldModel

Rows = NDArray[np.intp]
"""(n,) row numbers."""


class Snapshot(Protocol):
    """Positions and velocities of everything at one moment. It stays valid while the engine steps on."""

    def velocities(self) -> Floats:
        """(B, 6) of the bodies' origins: linear [m/s], then angular [rad/s]; zeros once the engine is closed."""

    def points(self, path: str) -> Floats | None:
        """(p, 3) the points of a deformable prim [m], in the prim's order; None for any other prim."""


def _no_vectors() -> Floats:
    return np.zeros((0, 3))


@dataclass(frozen=True)
class Contacts:
    """The contacts of the last physics step, n of them.

    pairs: paths of the two colliders; bodies: of the bodies they belong to, empty for what does not move. positions
    (n, 3) [m], normals (n, 3) from the first to the second, distances (n,) [m], below 0 where they overlap. forces
    (n, 3): what the first gives to the second [N]. dt: length of the step [s].
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
        """(n, 3) what the first gives to the second in the step [N s]."""
        return self.forces * self.dt


class SurfaceGripper(Protocol):
    """Points of a body that hold what is in front of them."""

    @property
    def status(self) -> Literal["Open", "Closing", "Closed"]:
        """Whether it holds something, or still tries to."""

    @property
    def held(self) -> tuple[str, ...]:
        """Paths of the bodies held."""

    def close(self) -> None:
        """Begin to grip; nothing changes where it is closed or closing."""

    def open(self) -> None:
        """Let everything go."""


class PhysicsEngine(Protocol):
    """The bodies of a playing world. An engine derives from this class; what has a body here is optional.

    It is made by an `EngineFactory` from a `WorldModel` (plain data read from the stage) and freed by `close`.
    """

    name: str
    """What `SimulationManager.get_active_physics_engine` says."""
    dt: Fraction
    """Length of a step [s]."""
    meters_per_unit: float
    """Metres in a stage unit."""
    world: WorldModel
    """What the engine was built from."""
    body_paths: tuple[str, ...]
    """The rigid bodies that can move, kinematic ones included."""
    kinematic: frozenset[str]
    """Bodies that only users move."""
    joints: tuple[Joint, ...] = ()
    """All joints, in stage order; another tuple object after `adopt`."""
    taken: int
    """Steps done by the last call of `step`."""

    # -- stepping ----------------------------------------------------------------------------------------------------

    def step(self, count: int = 1) -> None:
        """Advance by `count` times dt. Raises RunError where the simulation diverges; `taken` steps are done then."""

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

    @property
    def centers_of_mass(self) -> Floats:
        """(B, 3) [m]."""

    def is_free(self, path: str) -> bool:
        """Whether nothing holds a body: neither a joint nor the user."""

    def can_place(self, path: str) -> bool:
        """Whether a body can be put somewhere: it is free or kinematic."""
        return path in self.kinematic or self.is_free(path)

    def set_poses(self, paths: Sequence[str], poses: Floats, velocities: Floats | None = None) -> None:
        """Put free or kinematic bodies at rigid poses (n, 4, 4) [m]. Raises RunError for one held by a joint.

        velocities: (n, 6) of the origins of kinematic bodies that pass through these poses, linear [m/s], then angular
        [rad/s]: what touches them is carried along. None: they are put there and rest.
        """

    def set_velocities(self, paths: Sequence[str], velocities: Floats) -> None:
        """Set (n, 6) of free bodies' origins: linear [m/s], then angular [rad/s]. Raises RunError for other bodies."""

    def set_forces(self, paths: Sequence[str], forces: Floats) -> None:
        """Have (n, 6) force [N] at the centre of mass, then torque [N m], act on bodies until they are set again."""

    def set_authored_forces(self, forces: Sequence[BodyForce]) -> None:
        """Have other forces of the stage act than `WorldModel.forces`, besides those of `set_forces`."""

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
        """Put joints at positions at once; what drives aim at stays."""

    def set_joint_velocities(self, rows: Rows, velocities: Floats) -> None:
        """Give joints velocities at once."""

    def set_joint_targets(
        self, rows: Rows, positions: Floats | None, velocities: Floats | None, efforts: Floats | None
    ) -> None:
        """Set what drives aim at, and efforts that act besides them until set again; NaN leaves one as it is."""

    def articulation(self, root: str) -> Articulation:
        """The mechanism at a path: a robot's root prim, or any of its bodies or joints, in stage units.

        Raises RunError where there is no revolute or prismatic joint.
        """
        from .articulation import Articulation

        if root not in self._articulations:
            found = Articulation(self, root, self.meters_per_unit)
            if not found.joint_paths:
                raise RunError(f"{root}: no revolute or prismatic joint is there")
            self._articulations[root] = found
        return self._articulations[root]

    @cached_property
    def _articulations(self) -> dict[str, Articulation]:
        return {}

    # -- contacts, grippers, belts, deformables ----------------------------------------------------------------------

    def contacts(self) -> Contacts:
        """The contacts that carried load in the last step."""
        return Contacts()

    def triggered(self) -> dict[str, tuple[str, ...]]:
        """By the path of each trigger the paths of the colliders that are in it now."""
        return {}

    def gripper(self, path: str) -> SurfaceGripper:
        """The surface gripper at a path. Raises RunError where there is none."""
        raise RunError(f"{path}: the physics engine {self.name} has no surface grippers")

    def set_surface_velocity(self, path: str, pose: Floats, velocity: Floats, turn: Floats) -> bool:
        """Let the surfaces of the colliders at and below a prim move while their body stays, as a belt does.

        velocity [m/s] and turn [rad/s] about the prim's origin, both along its axes; zeros end it. pose: (4, 4), the
        prim's rigid frame now [m]. Returns whether the engine had to change its integrator. Raises ValueError where the
        prim has no colliders.
        """
        raise RunError(f"{path}: the physics engine {self.name} has no moving surfaces")

    @property
    def deformable_paths(self) -> tuple[str, ...]:
        """The prims that deform."""
        return ()

    def deformable_start(self, path: str) -> Floats:
        """(p, 3) where the points of a deformable prim began [m], in the prim's order."""
        raise KeyError(path)

    # -- state -------------------------------------------------------------------------------------------------------

    def snapshot(self) -> Snapshot:
        """Positions and velocities of now."""

    def restore(self, snapshot: Snapshot) -> None:
        """Go back to the positions and velocities of a snapshot; targets, forces and the time stay.

        Raises RunError for a snapshot of another engine, or from before the last `adopt`.
        """

    def adopt(self, world: WorldModel, kept: frozenset[str] | None, warn: Warn) -> None:
        """Go on with another world: what both have keeps its state, what is new starts as the world says.

        kept: bodies whose rest poses are the same in both; None: nothing keeps its state. Raises UserError, the engine
        unchanged, for a world that the engine refuses.
        """

    def close(self) -> None:
        """Free the engine's memory; only snapshots may be read afterwards."""


class EngineFactory(Protocol):
    """Makes an engine: `App(physics=FACTORY)`. A class that derives from `PhysicsEngine` may be one itself."""

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
        mjcf: MjcfScene | None,
    ) -> PhysicsEngine:
        """The engine of a world, in the state that the world describes, with steps of `dt` [s].

        mjcf: the MJCF model that the stage mirrors, if it does; only MuJoCo simulates it. Raises UserError for a world
        that the engine refuses.
        """


def contact_force(engine: PhysicsEngine, body: str, near: Any = None, radius: float = 0.0) -> Floats:
    """(3,) total force of the last step's contacts on a body [N]; of a radius [m] only of those closer to `near` (3,).

    Contacts between colliders of the same body do not count.
    """
    contacts, total = engine.contacts(), np.zeros(3)
    for row, (first, second) in enumerate(contacts.bodies):
        if first == second or body not in (first, second):
            continue
        if near is not None and radius > 0 and np.linalg.norm(contacts.positions[row] - near) >= radius:
            continue
        total += contacts.forces[row] if second == body else -contacts.forces[row]
    return total
