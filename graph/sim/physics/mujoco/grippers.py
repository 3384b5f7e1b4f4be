"""Running surface grippers: they hold what is in front of their attachment points, up to a force."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from graph.sim import transforms
from graph.sim.physics.world_model import Gripper, Suction
from graph.sim.transforms import Floats

from .constraints import weld_name
from .library import mujoco
from .queries import SOLID

if TYPE_CHECKING:
    from .engine import MujocoEngine

Status = Literal["Open", "Closing", "Closed"]


class WeldGripper:
    """Holds bodies by welds, which are activated when a ray from an attachment point hits a body.

    While closing, it tries in every step until it holds something or its retry time is over; then it is open again. A
    point releases a body that pulls along its axis, or across it, with more than the limits.
    """

    def __init__(self, physics: MujocoEngine, spec: Gripper) -> None:
        self.spec = spec
        self.status: Status = "Open"
        self._physics = physics
        self._until = 0.0
        self._welds = [int(physics.model.equality(weld_name(point)).id) for point in spec.points]
        self._held: dict[int, str] = {}

    @property
    def held(self) -> tuple[str, ...]:
        """Paths of the bodies held."""
        return tuple(dict.fromkeys(self._held.values()))

    def close(self) -> None:
        """Begins to grip, now and in the following steps; does nothing if it is closed or closing."""
        if self.status == "Open":
            self.status = "Closing"
            self._until = float(self._physics.data.time) + self.spec.patience
            self._grip()

    def open(self) -> None:
        """Releases everything."""
        for number in tuple(self._held):
            self._release(number)
        self.status = "Open"

    def take_over(self, old: WeldGripper, weld_data: Floats) -> None:
        """Takes over the state of another model's gripper; weld_data: (P, 11) of its points' welds there."""
        physics = self._physics
        self.status, self._until = old.status, old._until
        for number, path in old._held.items():
            if path in physics.body_paths:
                self._hold(number, physics.body_paths.index(path) + 1)
                physics.model.eq_data[self._welds[number]] = weld_data[number]

    @property
    def weld_data(self) -> Floats:
        """(P, 11) the engine's data of each point's weld."""
        out: Floats = self._physics.model.eq_data[self._welds].copy()
        return out

    def step(self, data: Any) -> None:
        """After a step of the engine: releases what pulls too hard; tries again while closing."""
        for number in tuple(self._held):
            if self._overloaded(number):
                self._release(number)
        if self.status == "Closed" and not self._held:
            self.status = "Open"
        if self.status == "Closing":
            self._grip()

    def _grip(self) -> None:
        for number, point in enumerate(self.spec.points):
            body = self._before(point)
            if body and number not in self._held:
                self._hold(number, body)
        if self._held:
            self.status = "Closed"
        elif float(self._physics.data.time) >= self._until:
            self.status = "Open"

    def _frame(self, point: Suction) -> tuple[Floats, Floats, int]:
        """Position and direction of a point in the world, and the number of its body."""
        physics = self._physics
        body = physics.body_paths.index(point.body)
        turn = physics.rotations[body]
        return physics.positions[body] + turn @ point.place, turn @ point.direction, body

    def _before(self, point: Suction) -> int:
        """The number in the model of the body in front of a point; 0 if nothing is within reach."""
        physics = self._physics
        place, direction, body = self._frame(point)
        geom = np.array([-1], dtype=np.int32)
        start = place + point.clearance * direction
        distance = mujoco.mj_ray(physics.model, physics.data, start, direction, SOLID, 0, body + 1, geom)
        if geom[0] < 0 or not 0 <= distance <= self.spec.reach:
            return 0
        found = int(physics.model.geom_bodyid[geom[0]])
        return found if found <= len(physics.body_paths) else 0

    def _hold(self, number: int, body: int) -> None:
        physics, weld = self._physics, self._welds[number]
        holder = physics.body_paths.index(self.spec.points[number].body)
        turn = physics.rotations[holder].T
        model = physics.model
        model.eq_obj1id[weld], model.eq_obj2id[weld] = holder + 1, body
        model.eq_data[weld, :3] = 0
        model.eq_data[weld, 3:6] = turn @ (physics.positions[body - 1] - physics.positions[holder])
        model.eq_data[weld, 6:10] = transforms.quaternion(turn @ physics.rotations[body - 1])
        model.eq_data[weld, 10] = 1
        physics.data.eq_active[weld] = 1
        self._held[number] = physics.body_paths[body - 1]

    def _release(self, number: int) -> None:
        self._physics.data.eq_active[self._welds[number]] = 0
        del self._held[number]

    def _overloaded(self, number: int) -> bool:
        data, weld = self._physics.data, self._welds[number]
        welds = data.efc_type[: data.nefc] == mujoco.mjtConstraint.mjCNSTR_EQUALITY
        rows = np.flatnonzero(welds & (data.efc_id[: data.nefc] == weld))
        if not len(rows):
            return False
        force = data.efc_force[rows[:3]]
        along = float(force @ self._frame(self.spec.points[number])[1])
        across = float(np.sqrt(max(force @ force - along**2, 0.0)))
        return abs(along) > self.spec.coaxial_limit or across > self.spec.shear_limit
