"""The Franka's controllers: picking and placing and stacking, led by inverse kinematics."""

from __future__ import annotations

from typing import Any

from . import pick_place
from .arm_motion import RMPFlowController

__all__ = ["PickPlaceController", "RMPFlowController", "StackingController"]


class PickPlaceController(pick_place.PickPlaceController):
    def __init__(
        self,
        name: str,
        gripper: Any,
        robot_articulation: Any,
        end_effector_initial_height: float | None = None,
        events_dt: Any = None,
    ) -> None:
        lead = RMPFlowController(f"{name}_cspace_controller", robot_articulation)
        super().__init__(name, lead, gripper, end_effector_initial_height, events_dt)


class StackingController(pick_place.StackingController):
    def __init__(
        self,
        name: str,
        gripper: Any,
        robot_articulation: Any,
        picking_order_cube_names: Any,
        robot_observation_name: str,
    ) -> None:
        one = PickPlaceController(f"{name}_pick_place_controller", gripper, robot_articulation)
        super().__init__(name, one, picking_order_cube_names, robot_observation_name)
