"""Moving surfaces: belts, whose bodies stay, and kinematic bodies, which users move.

MuJoCo takes both to be at rest. Friction and contact act on the relative velocity of two surfaces; if one of them moves
by itself, that velocity is added before the engine solves for the forces. Nothing else changes, so friction limits,
weights and reactions are those of any other contact. A belt moves only along its surface, a kinematic body in every
direction.

The integrator `discrete` computes that velocity again after all callbacks. A world with belts is stepped with
`implicitfast` instead. With kinematic bodies `discrete` stays, for the sake of stiff drives: these bodies then lift and
push, which is written as an equal depth of contact, but do not carry sideways (warning `kinematic-not-carrying`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from graph.base.paths import at_or_below
from graph.base.records import dataclass
from graph.sim import transforms
from graph.sim.scene.stage import Warn
from graph.sim.transforms import Floats

from .library import mujoco

if TYPE_CHECKING:
    from .engine import MujocoEngine


@dataclass(frozen=True, slots=True)
class Belt:
    """Motion of a surface in the rigid frame of its body: velocity [m/s], turn rate [rad/s] about `origin` [m]."""

    body: int
    velocity: Floats
    turn: Floats
    origin: Floats

    def at(self, data: Any, points: Floats) -> Floats:
        """(n, 3) velocities at points of the world, world axes."""
        rotation = data.xmat[self.body].reshape(3, 3)
        place = data.xpos[self.body] + rotation @ self.origin
        out: Floats = rotation @ self.velocity + np.cross(rotation @ self.turn, points - place)
        return out


SLIPS = 0.02
"""Sliding speed [m/s] on kinematic bodies above which the warning that they do not carry is given."""


class Surfaces:
    """The moving surfaces of a world: belts by the path of the prim with their colliders, bodies by number."""

    def __init__(self, physics: MujocoEngine, warn: Warn) -> None:
        self._physics, self._model, self._warn = physics, physics.model, warn
        self._twists: Floats = np.zeros((physics.model.nbody, 6))
        """Of kinematic bodies' origins: linear [m/s], then angular [rad/s], world axes."""
        self._moves: NDArray[np.bool_] = np.zeros(physics.model.nbody, dtype=np.bool_)
        self.own: Floats = np.zeros((0, 6))
        """(ncon, 6) for each contact of the last step, the first surface's own velocity minus that of the second:
        along the normal, sideways, and the rotation about them [m/s, rad/s]; no rows if no surface moved.
        """
        self._belts: dict[str, Belt] = {}
        self._names = [physics.model.geom(number).name.rpartition("#")[0] for number in range(physics.model.ngeom)]
        self._of_geom: NDArray[np.intp] = np.full(physics.model.ngeom, -1, dtype=np.intp)

    def set_motion(self, path: str, pose: Floats, velocity: Floats, turn: Floats) -> bool:
        """Moves the surfaces of the colliders at and below a prim with `velocity` [m/s] and `turn` [rad/s] about its
        origin.

        Both are along the prim's axes; pose: (4, 4), the prim's present rigid frame in the world [m], which moves with
        the body of the colliders. Zeros end the motion. Returns whether this changed the integrator. Raises ValueError
        if the prim has no colliders.
        """
        geoms = [number for number, name in enumerate(self._names) if at_or_below(name, path)]
        if not geoms:
            raise ValueError(f"{path} has no colliders")
        self._belts.pop(path, None)
        if velocity.any() or turn.any():
            body = int(self._model.geom_bodyid[geoms[0]])
            if body > len(self._physics.body_paths):  # a static part of the world
                body = 0
            local = self._in_body(body, pose)
            self._belts[path] = Belt(body, local[:3, :3] @ velocity, local[:3, :3] @ turn, local[:3, 3])
        self._of_geom[geoms] = -1
        self._find_geoms()
        return bool(self._belts) and self._leave_discrete()

    def set_velocities(self, bodies: Sequence[int], velocities: Floats | None) -> None:
        """Moves kinematic bodies with (n, 6) velocities of their origins, [m/s] and [rad/s] along world axes; None:
        rest.
        """
        rows = [(row, body) for row, body in enumerate(bodies) if self._model.body_mocapid[body] >= 0]
        for row, body in rows:
            self._twists[body] = 0.0 if velocities is None else velocities[row]
            self._moves[body] = self._twists[body].any()

    def take_over(self, old: Surfaces, numbers: dict[int, int]) -> None:
        """Takes over the motions of another model's surfaces; `numbers`: its bodies' numbers in this model."""
        for path, belt in old._belts.items():
            if belt.body in numbers and any(at_or_below(name, path) for name in self._names):
                self._belts[path] = replace(belt, body=numbers[belt.body])
        self._find_geoms()
        if self._belts:
            self._leave_discrete()

    def _find_geoms(self) -> None:
        for place, name in enumerate(self._belts):
            mine = [number for number, geom in enumerate(self._names) if at_or_below(geom, name)]
            self._of_geom[mine] = place

    def _leave_discrete(self) -> bool:
        option = self._model.opt
        if option.integrator != mujoco.mjtIntegrator.mjINT_DISCRETE:
            return False
        kinds = mujoco.mjtIntegrator
        option.integrator = kinds.mjINT_EULER if self._model.nflex else kinds.mjINT_IMPLICITFAST
        self._physics.set_dt(self._physics.dt)  # the drives' gains depend on the integrator
        return True

    def _in_body(self, body: int, pose: Floats) -> Floats:
        """A pose of the world in the rigid frame of a body (0: the world itself)."""
        if body == 0:
            return pose
        frame = transforms.rigid(self._physics.rotations[body - 1], self._physics.positions[body - 1])
        return transforms.inverse_rigid(frame) @ pose

    def step(self, model: Any, data: Any) -> None:
        """One step of the engine."""
        self.own = np.zeros((0, 6))
        if not self._belts and not self._moves.any():
            mujoco.mj_step(model, data)
            return
        previous = mujoco.get_mjcb_control()
        mujoco.set_mjcb_control(self._move)
        try:
            mujoco.mj_step(model, data)
        finally:
            mujoco.set_mjcb_control(previous)

    def _move(self, model: Any, data: Any) -> None:
        """Called between the engine's velocities and its forces: changes the velocity that friction brings to rest."""
        if not data.ncon or model._address != self._model._address:  # the callback is shared by the whole process
            return
        contacts = data.contact
        geoms = contacts.geom
        belts = np.where(geoms >= 0, self._of_geom[geoms], -1)  # a deformable is not a geom
        moving = (geoms >= 0) & self._moves[model.geom_bodyid[geoms]]
        touches = contacts.efc_address >= 0
        active = (((belts >= 0).any(axis=1) & (contacts.dim > 1)) | moving.any(axis=1)) & touches
        self.own = np.zeros((data.ncon, 6))
        for index in active.nonzero()[0]:
            along = self._belts_at(data, index, belts[index]) + self._bodies_at(data, index, moving[index])
            self.own[index] = along
            if model.opt.integrator == mujoco.mjtIntegrator.mjINT_DISCRETE:
                self._deepen(data, index, along)
            else:
                self._aim(data, index, along)

    def _belts_at(self, data: Any, index: int, belts: NDArray[np.intp]) -> Floats:
        """(6,) velocity of the first surface minus that of the second at a contact: normal, sideways, rotation."""
        moves, relative = list(self._belts.values()), np.zeros(3)
        for side, sign in ((0, 1.0), (1, -1.0)):
            if belts[side] >= 0:
                relative += sign * moves[belts[side]].at(data, data.contact.pos[index][None])[0]
        out = np.zeros(6)
        out[1:3] = data.contact.frame[index].reshape(3, 3)[1:] @ relative
        return out

    def _bodies_at(self, data: Any, index: int, moving: NDArray[np.bool_]) -> Floats:
        """The same for kinematic bodies."""
        relative = np.zeros(6)
        for side, sign in ((0, 1.0), (1, -1.0)):
            if moving[side]:
                body = self._model.geom_bodyid[data.contact.geom[index, side]]
                twist = self._twists[body]
                relative[:3] += sign * (twist[:3] + np.cross(twist[3:], data.contact.pos[index] - data.xpos[body]))
                relative[3:] += sign * twist[3:]
        frame = data.contact.frame[index].reshape(3, 3)
        return np.concatenate([frame @ relative[:3], frame @ relative[3:]])

    def _aim(self, data: Any, index: int, along: Floats) -> None:
        """Makes the constraints of a contact bring the surfaces' own velocity to rest too."""
        contacts, aim, gains = data.contact, data.efc_aref, data.efc_KBIP[:, 1]
        row, count = contacts.efc_address[index], int(contacts.dim[index])
        if count == 1 or self._model.opt.cone == mujoco.mjtCone.mjCONE_ELLIPTIC:
            rows = slice(row, row + count)
            change = along[:count]
        else:  # a pyramid's edges come in pairs: normal + friction, normal - friction
            rows = slice(row, row + 2 * (count - 1))
            sides = contacts.friction[index, : count - 1] * along[1:count]
            change = np.stack([along[0] + sides, along[0] - sides], axis=1).ravel()
        aim[rows] += gains[rows] * change

    def _deepen(self, data: Any, index: int, along: Floats) -> None:
        """The same along the normal only, as depth, which `discrete` does not compute again."""
        contacts, dt = data.contact, self._model.opt.timestep
        row, count = contacts.efc_address[index], int(contacts.dim[index])
        elliptic = count == 1 or self._model.opt.cone == mujoco.mjtCone.mjCONE_ELLIPTIC
        rows = slice(row, row + 1) if elliptic else slice(row, row + 2 * (count - 1))
        stiffness, damping = data.efc_KBIP[rows, 0] * data.efc_KBIP[rows, 2], data.efc_KBIP[rows, 1]
        known = stiffness > 0
        data.efc_pos[rows][known] -= along[0] * (dt + damping[known] / stiffness[known])
        if count > 1 and np.hypot(along[1], along[2]) > SLIPS:
            sides = [self._model.geom_bodyid[geom] for geom in contacts.geom[index] if geom >= 0]
            carrier = next(body for body in sides if self._moves[body])
            self._warn(
                "kinematic-not-carrying",
                self._physics.body_name(int(carrier)),
                "it moves sideways under a body, and the integrator discrete does not carry that along; set "
                "physics.integrator to implicitfast",
            )
