"""Picking and placing in phases, and stacking; a controller of the arm leads the hand."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from graph.isaac.session import app
from graph.sim.usd import UsdGeom

from .arm_motion import DOWN
from .values import ArticulationAction

__all__ = ["PickPlaceController", "StackingController"]
ABOVE, LOWER, SETTLE, GRIP, LIFT, CARRY, SET_DOWN, RELEASE, RISE, BACK = range(10)
"""The phases."""
SPEEDS = (0.008, 0.005, 1.0, 0.1, 0.05, 0.05, 0.0025, 1.0, 0.008, 0.08)
"""Of the phases: the share of each that one call of `forward` takes."""
HEIGHT = 0.3
"""At which the hand moves sideways [m]."""


class PickPlaceController:
    """Leads the hand through ten phases: above the object, down, settle, grip, lift, carry, down, release, up, back.

    events_dt: the share of each phase that one call takes. end_effector_initial_height [stage units].
    """

    def __init__(
        self,
        name: str,
        cspace_controller: Any,
        gripper: Any,
        end_effector_initial_height: float | None = None,
        events_dt: Any = None,
    ) -> None:
        self.name, self._lead, self._gripper = name, cspace_controller, gripper
        self._speeds = list(SPEEDS if events_dt is None else np.asarray(events_dt, float).reshape(-1))
        if len(self._speeds) > len(SPEEDS):
            raise ValueError(f"events_dt has {len(self._speeds)} entries; there are {len(SPEEDS)} phases")
        self._height = end_effector_initial_height
        self._phase, self._share, self._paused = ABOVE, 0.0, False

    def forward(
        self,
        picking_position: Any,
        placing_position: Any,
        current_joint_positions: Any,
        end_effector_offset: Any = None,
        end_effector_orientation: Any = None,
    ) -> ArticulationAction:
        """The action of the present phase; positions of the object's centre in the world [stage units]."""
        if self._paused or self.is_done():
            return ArticulationAction(joint_positions=[None] * len(current_joint_positions))
        pick, place = np.asarray(picking_position, float), np.asarray(placing_position, float)
        if self._phase in (ABOVE, LOWER, SETTLE):
            self._picked = pick.copy()
        if self._phase in (GRIP, RELEASE):
            action: ArticulationAction = self._gripper.forward("close" if self._phase == GRIP else "open")
        elif self._phase == SETTLE:
            action = ArticulationAction(joint_positions=[None] * len(current_joint_positions))
        else:
            target = self._target(place) + (0 if end_effector_offset is None else np.asarray(end_effector_offset))
            turn = DOWN if end_effector_orientation is None else end_effector_orientation
            action = self._lead.forward(target, turn)
        self._share += self._speeds[self._phase]
        if self._share >= 1.0:
            self._phase, self._share = self._phase + 1, 0.0
        return action

    def _target(self, place: Any) -> Any:
        """Where the point between the fingertips should be now."""
        high = HEIGHT / UsdGeom.GetStageMetersPerUnit(app().stage) if self._height is None else self._height
        share = 0.5 * (1 - math.cos(math.pi * self._share))
        way = {CARRY: share, SET_DOWN: 1.0, RISE: 1.0, BACK: 1 - share}.get(self._phase, 0.0)
        low = self._picked[2] if self._phase <= LIFT else place[2]
        down = {LOWER: share, LIFT: 1 - share, SET_DOWN: share, RISE: 1 - share}.get(self._phase, 0.0)
        return np.array([*((1 - way) * self._picked[:2] + way * place[:2]), (1 - down) * high + down * low])

    def reset(self, end_effector_initial_height: float | None = None, events_dt: Any = None) -> None:
        self._lead.reset()
        self._phase, self._share, self._paused = ABOVE, 0.0, False
        if end_effector_initial_height is not None:
            self._height = end_effector_initial_height
        if events_dt is not None:
            self._speeds = list(np.asarray(events_dt, float).reshape(-1))

    def get_current_event(self) -> int:
        return self._phase

    def is_done(self) -> bool:
        return self._phase >= len(self._speeds)

    def is_paused(self) -> bool:
        return self._paused

    def pause(self) -> None:
        self._paused = True

    def resume(self) -> None:
        self._paused = False


class StackingController:
    """Picks the named objects one after the other and places each where its observation says."""

    def __init__(
        self,
        name: str,
        pick_place_controller: Any,
        picking_order_cube_names: Any,
        robot_observation_name: str,
    ) -> None:
        self.name, self._one = name, pick_place_controller
        self._names, self._robot, self._number = list(picking_order_cube_names), robot_observation_name, 0

    def forward(
        self, observations: Any, end_effector_orientation: Any = None, end_effector_offset: Any = None
    ) -> ArticulationAction:
        joints = observations[self._robot]["joint_positions"]
        if self.is_done():
            return ArticulationAction(joint_positions=[None] * len(joints))
        if self._one.is_done():
            self._number += 1
            self._one.reset()
            if self.is_done():
                return ArticulationAction(joint_positions=[None] * len(joints))
        cube = observations[self._names[self._number]]
        action: ArticulationAction = self._one.forward(
            cube["position"], cube["target_position"], joints, end_effector_offset, end_effector_orientation
        )
        return action

    def reset(self, picking_order_cube_names: Any = None) -> None:
        self._number = 0
        self._one.reset()
        if picking_order_cube_names is not None:
            self._names = list(picking_order_cube_names)

    def is_done(self) -> bool:
        return self._number >= len(self._names)
