"""The state of a playing world as arrays: all bodies, joints and contacts at once, in SI units for any stage."""

from __future__ import annotations

import fnmatch
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from graph.base.errors import RunError
from graph.base.suggesting import Suggesting
from graph.sim import transforms
from graph.sim.transforms import Floats

if TYPE_CHECKING:
    from graph.sim.physics.articulation import Articulation
    from graph.sim.physics.protocol import Contacts, PhysicsEngine, Snapshot
    from graph.sim.state.playing_world import PlayingWorld

Which = Sequence[str] | str | None
"""Some bodies or joints: paths or a pattern such as `/World/Box_*`; None: all of them."""


class Tensors(Suggesting):
    """`app.simulation.tensors`: reads and writes the physics of a playing App; arrays are copies of this moment.

    Everything raises RunError while no world is built ("call app.play() first"); an existing view continues with the
    next play. If nothing can move the arrays are empty. Bodies are in the order of `body_paths`, joints (those of the
    whole world with one degree of freedom) in that of `joint_paths`; both change only when the world is compiled again.
    """

    def __init__(self, world: PlayingWorld) -> None:
        self._world = world
        self._joints: Articulation | None = None

    # -- bodies ------------------------------------------------------------------------------------------------------

    @property
    def body_paths(self) -> tuple[str, ...]:
        """(B,) the rigid bodies that can move, kinematic ones included."""
        physics = self._physics()
        return physics.body_paths if physics is not None else ()

    @property
    def positions(self) -> Floats:
        """(B, 3) the bodies' origins in the world [m]."""
        physics = self._physics()
        return physics.positions.copy() if physics is not None else np.zeros((0, 3))

    @property
    def orientations(self) -> Floats:
        """(B, 4) w, x, y, z of the bodies in the world."""
        physics = self._physics()
        return physics.quaternions.copy() if physics is not None else np.zeros((0, 4))

    @property
    def linear_velocities(self) -> Floats:
        """(B, 3) of the bodies' origins, world axes [m/s]."""
        return self._motion()[:, :3]

    @property
    def angular_velocities(self) -> Floats:
        """(B, 3) world axes [rad/s]."""
        return self._motion()[:, 3:]

    def set_poses(self, positions: Any = None, orientations: Any = None, bodies: Which = None) -> None:
        """Places bodies at once: (n, 3) origins [m] and (n, 4) w, x, y, z, or one for all; None keeps the present ones.

        Velocities stay. Raises RunError, with nothing moved, for a body that a joint holds, ValueError for wrong
        shapes.
        """
        physics, rows = self._chosen(bodies)
        held = [physics.body_paths[row] for row in rows if not physics.can_place(physics.body_paths[row])]
        if held:
            raise RunError(f"{held[0]}: a joint holds this body; set the joint's position instead of its pose")
        places = _rows("positions", positions, physics.positions[rows], 3)
        turns = _rows("orientations", orientations, physics.quaternions[rows], 4)
        lengths = np.linalg.norm(turns, axis=1, keepdims=True)
        if (lengths < 1e-9).any():
            raise ValueError("orientations hold a quaternion of length 0")
        matrices = transforms.pose_matrices(places, turns / lengths)
        matrices[:, :3, 3] /= self._world.meters_per_unit
        for row, matrix in zip(rows, matrices, strict=True):
            self._world.fabric.place_body(physics.body_paths[row], matrix)

    def set_velocities(self, linear: Any = None, angular: Any = None, bodies: Which = None) -> None:
        """Sets velocities of bodies' origins at once:

        (n, 3) [m/s] and (n, 3) [rad/s], world axes; None keeps the present ones.

        Raises RunError, with nothing changed, for a body that is not free, ValueError for wrong shapes.
        """
        physics, rows = self._chosen(bodies)
        paths = [physics.body_paths[row] for row in rows]
        now = physics.velocities()[rows]
        motion = np.concatenate(
            [_rows("linear", linear, now[:, :3], 3), _rows("angular", angular, now[:, 3:], 3)], axis=1
        )
        held = [path for path in paths if not physics.is_free(path)]
        if held:
            physics.set_velocities(held[:1], motion[:1])  # says why not
        physics.set_velocities(paths, motion)
        self._world.fabric.touched()

    @property
    def masses(self) -> Floats:
        """(B,) [kg]."""
        physics = self._physics()
        return np.zeros(0) if physics is None else physics.masses

    @property
    def inertias(self) -> Floats:
        """(B, 3, 3) about the bodies' centres of mass, along the bodies' axes [kg m2]."""
        physics = self._physics()
        return np.zeros((0, 3, 3)) if physics is None else physics.inertias

    def set_masses(self, masses: Any = None, inertias: Any = None, bodies: Which = None) -> None:
        """Gives free bodies other masses (n,) [kg] and moments of inertia (n, 3) about their axes [kg m2], until stop.

        One row counts for all; None keeps the present ones. Raises RunError, with nothing changed, for bodies that a
        joint or the user holds, for values that are not positive, and for moments of a body whose principal axes are
        not its own; ValueError for wrong shapes.
        """
        physics, rows = self._chosen(bodies)
        paths = [physics.body_paths[row] for row in rows]
        given = None if masses is None else _rows("masses", np.reshape(masses, (-1, 1)), physics.masses[rows, None], 1)
        moments = physics.inertias[rows][:, range(3), range(3)]
        diagonals = None if inertias is None else _rows("inertias", inertias, moments, 3)
        physics.set_masses(paths, None if given is None else given[:, 0], diagonals)

    @property
    def centers_of_mass(self) -> Floats:
        """(B, 3) in the world [m]."""
        physics = self._physics()
        return np.zeros((0, 3)) if physics is None else physics.centers_of_mass

    @property
    def triggered(self) -> dict[str, tuple[str, ...]]:
        """By the path of each trigger (PhysxTriggerAPI), the paths of the colliders that are inside now."""
        physics = self._physics()
        return physics.triggered() if physics is not None else {}

    def set_forces(self, forces: Any = None, torques: Any = None, bodies: Which = None) -> None:
        """Applies forces at the centres of mass and torques to bodies in every step until they are set again.

        (n, 3) [N] and (n, 3) [N m], or one for all, world axes; None is zero. They have no effect on kinematic bodies.
        Raises ValueError for wrong shapes.
        """
        physics, rows = self._chosen(bodies)
        none = np.zeros((len(rows), 3))
        wrenches = np.concatenate([_rows("forces", forces, none, 3), _rows("torques", torques, none, 3)], axis=1)
        physics.set_forces([physics.body_paths[row] for row in rows], wrenches)

    # -- state -------------------------------------------------------------------------------------------------------

    def snapshot(self) -> Snapshot | None:
        """Positions and velocities of all bodies and joints, for `restore`; None if nothing can move."""
        physics = self._physics()
        return None if physics is None else physics.snapshot()

    def restore(self, snapshot: Snapshot | None) -> None:
        """Restores a snapshot of this play; clocks, targets and forces stay unchanged.

        Raises RunError for a snapshot from before the last play or recompilation.
        """
        physics = self._physics()
        if physics is not None and snapshot is not None:
            physics.restore(snapshot)
            self._world.fabric.touched()

    # -- joints ------------------------------------------------------------------------------------------------------

    @property
    def joint_paths(self) -> tuple[str, ...]:
        """(J,) the revolute and prismatic joints."""
        joints = self._articulation()
        return joints.joint_paths if joints is not None else ()

    @property
    def joint_positions(self) -> Floats:
        """(J,) [rad or m]."""
        joints = self._articulation()
        return joints.positions if joints is not None else np.zeros(0)

    @property
    def joint_velocities(self) -> Floats:
        """(J,) [rad/s or m/s]."""
        joints = self._articulation()
        return joints.velocities if joints is not None else np.zeros(0)

    @property
    def joint_efforts(self) -> Floats:
        """(J,) along the joints in the last physics step: drives, applied efforts and limits [N m or N]."""
        joints = self._articulation()
        return joints.efforts if joints is not None else np.zeros(0)

    def set_joint_positions(self, positions: Any, joints: Which = None) -> None:
        """Puts joints at positions at once [rad or m]; NaN leaves one unchanged."""
        found, rows = self._chosen_joints(joints)
        found.set_positions(positions, rows)
        self._world.fabric.touched()

    def set_joint_velocities(self, velocities: Any, joints: Which = None) -> None:
        """Sets joint velocities at once [rad/s or m/s]; NaN leaves one unchanged."""
        found, rows = self._chosen_joints(joints)
        found.set_velocities(velocities, rows)
        self._world.fabric.touched()

    def set_joint_targets(
        self, positions: Any = None, velocities: Any = None, efforts: Any = None, joints: Which = None
    ) -> None:
        """Sets the targets of drives, and additional efforts; see `Articulation.set_targets`, in SI units."""
        found, rows = self._chosen_joints(joints)
        found.set_targets(positions, velocities, efforts, rows)

    # -- contacts ----------------------------------------------------------------------------------------------------

    @property
    def contacts(self) -> Contacts:
        """The contacts of the last physics step and their forces."""
        from graph.sim.physics.protocol import Contacts

        physics = self._physics()
        return Contacts() if physics is None else physics.contacts()

    # -- inside ------------------------------------------------------------------------------------------------------

    def _physics(self) -> PhysicsEngine | None:
        if not self._world.built:
            raise RunError("there is no physics state while the simulation is stopped; call app.play() first")
        return self._world.physics

    def _motion(self) -> Floats:
        physics = self._physics()
        return np.zeros((0, 6)) if physics is None else physics.velocities()

    def _chosen(self, which: Which) -> tuple[PhysicsEngine, list[int]]:
        physics = self._physics()
        paths = physics.body_paths if physics is not None else ()
        rows = _select(which, paths, "body that can move")
        if physics is None:
            raise RunError("nothing can move in this world; give a prim a rigid body")
        return physics, rows

    def _articulation(self) -> Articulation | None:
        from graph.sim.physics.articulation import Articulation

        physics = self._physics()
        if physics is None:
            return None
        if self._joints is None or self._joints.engine is not physics:
            self._joints = Articulation(physics, "/", 1.0)
        return self._joints

    def _chosen_joints(self, which: Which) -> tuple[Articulation, list[int]]:
        joints = self._articulation()
        rows = _select(which, joints.joint_paths if joints is not None else (), "joint with one degree of freedom")
        if joints is None:
            raise RunError("nothing can move in this world; it has no joints")
        return joints, rows


def _select(which: Which, paths: Sequence[str], what: str) -> list[int]:
    """The rows of paths or of all that match a pattern. Raises RunError without a match."""
    if which is None:
        return list(range(len(paths)))
    if isinstance(which, str):
        rows = [row for row, path in enumerate(paths) if path == which or fnmatch.fnmatchcase(path, which)]
        if not rows:
            raise RunError(f"{which}: there is no {what} of that path or pattern")
        return rows
    number = {path: row for row, path in enumerate(paths)}
    for path in which:
        if path not in number:
            raise RunError(f"{path}: there is no {what} of that path")
    return [number[path] for path in which]


def _rows(name: str, given: Any, now: Floats, width: int) -> Floats:
    """(n, width) finite values, one for all or one each; the present ones for None."""
    if given is None:
        return np.array(now)
    out = np.asarray(given, dtype=np.float64)
    if out.shape not in ((width,), (1, width), now.shape):
        raise ValueError(f"{name} have shape {out.shape}; give ({width},) or {now.shape}")
    if not np.isfinite(out).all():
        raise ValueError(f"{name} hold a value that is not finite")
    return np.broadcast_to(out, now.shape).copy()
