"""Surfaces that move under what lies on them, such as the belt of a conveyor, while their bodies stay.

Friction acts on the velocity of the two surfaces relative to each other. Where one of them moves by itself, that
velocity is added before the engine solves for the forces; nothing else changes, so that friction limits, weights and
reactions are those of any other contact. The integrator `discrete` forms that velocity anew after all callbacks, so
that a world with moving surfaces is stepped with `implicitfast` instead.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from graph.sim import transforms
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


class Surfaces:
    """The moving surfaces of a world, by the path of the prim whose colliders they are."""

    def __init__(self, physics: MujocoEngine) -> None:
        self._physics, self._model = physics, physics.model
        self._belts: dict[str, Belt] = {}
        self._names = [physics.model.geom(number).name.rpartition("#")[0] for number in range(physics.model.ngeom)]
        self._of_geom: NDArray[np.intp] = np.full(physics.model.ngeom, -1, dtype=np.intp)

    def set_motion(self, path: str, pose: Floats, velocity: Floats, turn: Floats) -> bool:
        """Let the colliders at and below a prim move with `velocity` [m/s] and `turn` [rad/s] about its origin.

        Both are along the prim's axes; pose: (4, 4), the prim's rigid frame in the world now [m], which the body of the
        colliders carries along. Zeros end the motion. Returns whether this changed the integrator. Raises ValueError
        where the prim has no colliders.
        """
        geoms = [number for number, name in enumerate(self._names) if name == path or name.startswith(f"{path}/")]
        if not geoms:
            raise ValueError(f"{path} has no colliders")
        self._belts.pop(path, None)
        if velocity.any() or turn.any():
            body = int(self._model.geom_bodyid[geoms[0]])
            if body > len(self._physics.body_paths):  # a still part of the world
                body = 0
            local = self._in_body(body, pose)
            self._belts[path] = Belt(body, local[:3, :3] @ velocity, local[:3, :3] @ turn, local[:3, 3])
        self._of_geom[geoms] = -1
        self._find_geoms()
        return bool(self._belts) and self._leave_discrete()

    def take_over(self, old: Surfaces, numbers: dict[int, int]) -> None:
        """Go on with the motions of another model's surfaces; `numbers`: its bodies' numbers in this model."""
        for path, belt in old._belts.items():
            if belt.body in numbers and any(name == path or name.startswith(f"{path}/") for name in self._names):
                self._belts[path] = replace(belt, body=numbers[belt.body])
        self._find_geoms()
        if self._belts:
            self._leave_discrete()

    def _find_geoms(self) -> None:
        for place, name in enumerate(self._belts):
            mine = [number for number, geom in enumerate(self._names) if geom == name or geom.startswith(f"{name}/")]
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
        frame = np.eye(4)
        frame[:3, :3], frame[:3, 3] = self._physics.rotations[body - 1], self._physics.positions[body - 1]
        return transforms.inverse_rigid(frame) @ pose

    def step(self, data: Any) -> None:
        """One step of the engine."""
        if not self._belts:
            mujoco.mj_step(self._model, data)
            return
        previous = mujoco.get_mjcb_control()
        mujoco.set_mjcb_control(self._move)
        try:
            mujoco.mj_step(self._model, data)
        finally:
            mujoco.set_mjcb_control(previous)

    def _move(self, model: Any, data: Any) -> None:
        """Called between the engine's velocities and its forces: what friction is to bring to rest changes."""
        if not data.ncon or model._address != self._model._address:  # the callback is the whole process's
            return
        contacts = data.contact
        belts = np.where(contacts.geom >= 0, self._of_geom[contacts.geom], -1)  # a deformable is no geom
        active = ((belts >= 0).any(axis=1) & (contacts.dim > 1) & (contacts.efc_address >= 0)).nonzero()[0]
        if not len(active):
            return
        aim, gains = data.efc_aref, data.efc_KBIP[:, 1]
        moves = list(self._belts.values())
        for index in active:
            row, point = contacts.efc_address[index], contacts.pos[index]
            relative = np.zeros(3)
            for side, sign in ((0, 1.0), (1, -1.0)):
                if belts[index, side] >= 0:
                    relative += sign * moves[belts[index, side]].at(data, point[None])[0]
            along = contacts.frame[index].reshape(3, 3)[1:] @ relative
            if model.opt.cone == mujoco.mjtCone.mjCONE_ELLIPTIC:
                aim[row + 1 : row + 3] += gains[row + 1 : row + 3] * along
                continue
            for direction in (0, 1):  # a pyramid's edges come in pairs: normal + friction, normal - friction
                edge = row + 2 * direction
                change = contacts.friction[index, direction] * along[direction]
                aim[edge] += gains[edge] * change
                aim[edge + 1] -= gains[edge + 1] * change
