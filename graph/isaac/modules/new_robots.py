"""`isaacsim.robot.experimental.wheeled_robots`."""

from __future__ import annotations

from .robots import ExperimentalDifferentialController as DifferentialController
from .robots import ExperimentalWheeledRobot as WheeledRobot
from .wheel_controllers import (
    ExperimentalAckermannController as AckermannController,
)
from .wheel_controllers import (
    ExperimentalHolonomicController as HolonomicController,
)
from .wheel_controllers import normalize_angle, pid_control, quintic_polynomials_planner

__all__ = [
    "AckermannController",
    "DifferentialController",
    "HolonomicController",
    "WheeledRobot",
    "normalize_angle",
    "pid_control",
    "quintic_polynomials_planner",
]
