"""`isaacsim.robot.experimental.wheeled_robots`."""

from __future__ import annotations

from .robots import ExperimentalDifferentialController as DifferentialController
from .robots import ExperimentalWheeledRobot as WheeledRobot

__all__ = ["DifferentialController", "WheeledRobot"]
