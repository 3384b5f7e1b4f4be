"""The soft parts of a model: the positions of their vertices in any state of the world."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from graph.sim.transforms import Floats

from .library import mujoco
from .memory import state_of

if TYPE_CHECKING:
    from .deformables import Deformables
    from .engine import MujocoEngine


class Flexes:
    """A model's flexes by the path of the mesh that mirrors each, beside the soft prims of the stage.

    Bodies, and nodes inside them, carry the vertices; they are computed with a second set of MuJoCo's data, which does
    not affect the motion. Vertices on bodies that users move follow the present poses of those bodies.
    """

    def __init__(self, physics: MujocoEngine, starts: Mapping[str, tuple[str, Floats]], others: Deformables) -> None:
        self._physics, self._starts, self._others = physics, starts, others
        self._model = physics.model
        self._aside = state_of(self._model)
        kind = mujoco.mjtObj.mjOBJ_FLEX
        self._numbers = {path: mujoco.mj_name2id(self._model, kind, name) for path, (name, _) in starts.items()}

    @property
    def paths(self) -> tuple[str, ...]:
        """The prims that deform."""
        return (*self._others.paths, *self._starts)

    def start_points(self, path: str) -> Floats:
        """(p, 3) initial positions of a prim's points, in the world [m]."""
        return self._starts[path][1] if path in self._starts else self._others.start_points(path)

    def start(self, data: mujoco.MjData) -> None:
        """Sets the initial velocities of the stage's prims."""
        self._others.start(data)

    def points(self, path: str, coordinates: Floats) -> Floats:
        """(p, 3) the points of a prim in the world [m], in its order; coordinates: (nq,) of the model's state."""
        if path not in self._starts:
            return self._others.points(path, coordinates)
        model, aside = self._model, self._aside
        aside.qpos[:] = coordinates
        if not self._physics.closed:
            aside.mocap_pos[:], aside.mocap_quat[:] = self._physics.data.mocap_pos, self._physics.data.mocap_quat
        mujoco.mj_kinematics(model, aside)
        mujoco.mj_comPos(model, aside)
        mujoco.mj_flex(model, aside)
        first, count = model.flex_vertadr[self._numbers[path]], model.flex_vertnum[self._numbers[path]]
        return np.array(aside.flexvert_xpos[first : first + count])
