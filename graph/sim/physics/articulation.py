"""Jointed mechanisms: reads their joints and sets the targets of their drives, as whole arrays."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from graph.sim.scene.mechanisms import Mechanisms, Tie
from graph.sim.transforms import Floats

if TYPE_CHECKING:
    from .protocol import MotionTerms, PhysicsEngine, Rows
    from .world_model import Joint

Values = Sequence[float] | Floats


COMMANDS = ("positions", "velocities", "efforts")


class Commanded:
    """What the joints of an engine were commanded last, in SI units; kept by path when it adopts another world."""

    def __init__(self, engine: PhysicsEngine) -> None:
        self._engine, self._known = engine, engine.joints
        self._table: Floats = np.full((len(COMMANDS), len(self._known)), np.nan)

    @property
    def table(self) -> Floats:
        """(3, joints) positions, velocities and efforts; NaN where none was given."""
        joints = self._engine.joints
        if joints is not self._known:
            rows = {joint.path: row for row, joint in enumerate(self._known)}
            old = [rows.get(joint.path, -1) for joint in joints]  # -1: the column of NaN
            self._table = np.column_stack([self._table, np.full(len(COMMANDS), np.nan)])[:, old]
            self._known = joints
        return self._table

    def note(self, rows: Rows, *given: Floats | None) -> None:
        """Keeps the commands of joints with these numbers; NaN leaves one unchanged."""
        table = self.table
        for row, values in enumerate(given):
            if values is not None:
                some = ~np.isnan(values)
                table[row, rows[some]] = values[some]


class _Found(NamedTuple):
    """The joints of a mechanism: their numbers in the engine, and their constant properties."""

    rows: Rows
    paths: tuple[str, ...]
    names: tuple[str, ...]
    labels: tuple[str, ...]
    scale: Floats
    limits: Floats
    linear: NDArray[np.bool_]


class Articulation:
    """The joints with one degree of freedom of the mechanism at a path, in stage order.

    Positions and velocities are radians and stage units, efforts N m and N: what the node library uses. It finds its
    joints again after the engine has adopted another world.
    """

    def __init__(self, engine: PhysicsEngine, root: str, meters_per_unit: float) -> None:
        self.path = root
        self.engine = engine
        self._meters_per_unit = meters_per_unit
        self._known = engine.joints
        self._joints = self._find()

    @property
    def _now(self) -> _Found:
        if self._known is not self.engine.joints:
            self._known, self._joints = self.engine.joints, self._find()
        return self._joints

    def _find(self) -> _Found:
        known = self.engine.joints
        rows = [row for row in self._rows(known) if known[row].kind in ("revolute", "prismatic")]
        joints = [known[row] for row in rows]
        linear = np.array([joint.kind == "prismatic" for joint in joints], dtype=np.bool_)
        scale = np.where(linear, 1 / self._meters_per_unit, 1.0)
        ends = np.array([(joint.lower, joint.upper) for joint in joints]).reshape(-1, 2)
        return _Found(
            np.array(rows, dtype=np.intp),
            tuple(joint.path for joint in joints),
            tuple(joint.name or _last(joint) for joint in joints),
            tuple(joint.label or joint.name or _last(joint) for joint in joints),
            scale,
            ends * scale[:, None],
            linear,
        )

    def _rows(self, joints: Sequence[Joint]) -> Iterable[int]:
        """Numbers of the joints of the articulation at the path; "/" stands for all joints."""
        if self.path == "/":
            return range(len(joints))
        mechanisms = self.engine.world.mechanisms or Mechanisms([Tie(joint.path, joint.bodies) for joint in joints])
        links = mechanisms.carriers(self.path)
        return [number for number, joint in enumerate(joints) if mechanisms.joins(links, joint.bodies)]

    @property
    def joint_paths(self) -> tuple[str, ...]:
        """Paths of the joints' prims; for an axis of a joint with several, followed by `:` and the axis."""
        return self._now.paths

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Their names in the MJCF or URDF model that they come from, else the last parts of their paths."""
        return self._now.names

    @property
    def labels(self) -> tuple[str, ...]:
        """Their names in messages: `isaac:nameOverride` where a joint's prim has it, else as `joint_names`."""
        return self._now.labels

    @property
    def numbers(self) -> dict[str, int]:
        """Numbers of joints by every name they have: `joint_names`, then `labels`, then the last parts of the paths."""
        now = self._now
        tails = (path.rpartition("/")[2] for path in now.paths)
        out: dict[str, int] = {}
        for names in (now.names, now.labels, tails):
            for number, name in enumerate(names):
                out.setdefault(name, number)
        return out

    @property
    def driven(self) -> NDArray[np.bool_]:
        """(J,) which joints have a drive; position and velocity targets of the others have no effect."""
        return self.engine.driven(self._now.rows)

    def deaf(self, *, positions: bool, velocities: bool) -> NDArray[np.bool_]:
        """(J,) which joints ignore such targets: those without a drive, or whose drive has a gain of 0 for them.

        A drive follows positions by its stiffness and velocities by its damping.
        """
        drives = [self.engine.joints[row].drive for row in self._now.rows]
        gains = [
            drive is None or bool((positions and drive.stiffness) or (velocities and drive.damping)) for drive in drives
        ]
        return ~(self.driven & np.array(gains, dtype=np.bool_))

    @property
    def positions(self) -> Floats:
        """(J,) joint positions [rad or stage units]."""
        now = self._now
        out: Floats = self.engine.joint_positions(now.rows) * now.scale
        return out

    @property
    def velocities(self) -> Floats:
        """(J,) joint velocities [rad/s or stage units/s]."""
        now = self._now
        out: Floats = self.engine.joint_velocities(now.rows) * now.scale
        return out

    @property
    def efforts(self) -> Floats:
        """(J,) efforts along the joints [N m or N] in the last physics step: drives, applied efforts and limits."""
        return self.engine.joint_efforts(self._now.rows)

    @property
    def reactions(self) -> Floats:
        """(J, 6) force [N] and torque [N m] that joints pass on to their second bodies, in the joint's frame there."""
        return self.engine.joint_reactions(self._now.rows)

    def motion_terms(self, links: Sequence[str]) -> MotionTerms:
        """Its equations of motion, in SI units; a link that is free is its base. See `PhysicsEngine.motion_terms`."""
        known = set(self.engine.body_paths)
        base = next((path for path in links if path in known and self.engine.is_free(path)), None)
        return self.engine.motion_terms(links, self._now.rows, base)

    def commanded(self, name: str) -> Floats:
        """(J,) the last "positions", "velocities" or "efforts" of `set_targets`, also where no drive follows them.

        Before the first, those of the drives; 0 without a drive.
        """
        now = self._now
        drives = [self.engine.joints[row].drive for row in now.rows]
        row = COMMANDS.index(name)
        at_first = [0.0 if drive is None else (drive.position, drive.velocity, 0.0)[row] for drive in drives]
        given = self.engine.commanded.table[row, now.rows]
        out: Floats = np.where(np.isnan(given), at_first, given) * (1.0 if name == "efforts" else now.scale)
        return out

    def pose_at(self, link: str, positions: Values, joints: Sequence[int]) -> tuple[Floats, Floats]:
        """Where a link would be with some joints at positions [rad or stage units], the others as they are.

        Returns its (4, 4) pose in the world [m] and the (6, n) Jacobian of its origin [m or rad per rad or m].
        """
        now = self._now
        return self.engine.pose_at(link, now.rows[list(joints)], np.asarray(positions) / now.scale[list(joints)])

    @property
    def limits(self) -> Floats:
        """(J, 2) lowest and highest positions [rad or stage units]; infinite without a limit."""
        return self._now.limits.copy()

    @property
    def linear(self) -> NDArray[np.bool_]:
        """(J,) which joints are prismatic; the others are revolute."""
        return self._now.linear.copy()

    def set_targets(
        self,
        positions: Values | None = None,
        velocities: Values | None = None,
        efforts: Values | None = None,
        joints: Sequence[int] | None = None,
    ) -> None:
        """Sets the targets of drives, and efforts that act in addition until set again.

        Each array has one number per joint (or per entry of `joints`, joint numbers); NaN leaves that joint unchanged,
        an empty array or None all of them. Raises ValueError, with nothing changed, if an array has another length.
        """
        rows, chosen = self._now.rows, self._chosen(joints)
        aims = [
            self._command("positions", positions, len(chosen)),
            self._command("velocities", velocities, len(chosen)),
        ]
        forces = self._command("efforts", efforts, len(chosen))
        scale = self._now.scale[chosen]
        position, velocity = (None if values is None else values / scale for values in aims)
        self.engine.commanded.note(rows[chosen], position, velocity, forces)
        self.engine.set_joint_targets(rows[chosen], position, velocity, forces)

    def set_positions(self, positions: Values, joints: Sequence[int] | None = None) -> None:
        """Puts joints at positions [rad or stage units] at once; NaN leaves one unchanged. Targets stay."""
        rows, values = self._wanted("positions", positions, joints)
        self.engine.set_joint_positions(rows, values)

    def set_velocities(self, velocities: Values, joints: Sequence[int] | None = None) -> None:
        """Sets joint velocities [rad/s or stage units/s] at once; NaN leaves one unchanged."""
        rows, values = self._wanted("velocities", velocities, joints)
        self.engine.set_joint_velocities(rows, values)

    def _chosen(self, joints: Sequence[int] | None) -> Rows:
        return np.arange(len(self._now.rows)) if joints is None else np.asarray(joints, dtype=np.intp)

    def _wanted(self, name: str, given: Values, joints: Sequence[int] | None) -> tuple[Rows, Floats]:
        """The engine's rows of the joints that get a value, and the values in SI units."""
        now, chosen = self._now, self._chosen(joints)
        values = self._command(name, given, len(chosen))
        if values is None:
            return now.rows[:0], np.zeros(0)
        some = ~np.isnan(values)
        return now.rows[chosen[some]], values[some] / now.scale[chosen[some]]

    def _command(self, name: str, values: Values | None, width: int) -> Floats | None:
        if values is None or not len(values):
            return None
        out = np.asarray(values, dtype=np.float64)
        if out.shape != (width,):
            raise ValueError(f"{self.path}: {name} have shape {out.shape}; there are {width} joints to command")
        if np.isinf(out).any():
            raise ValueError(f"{self.path}: {name} hold an infinite value")
        return out


def _last(joint: Joint) -> str:
    return joint.path.rpartition("/")[2]
