"""`newton.actuators`, where Newton is not installed."""

from .laws import (
    Clamping,
    ClampingDCMotor,
    ClampingMaxEffort,
    ClampingPositionBased,
    Controller,
    ControllerPD,
    ControllerPID,
    Delay,
)
from .robot import Actuator

__all__ = [
    "Actuator",
    "Clamping",
    "ClampingDCMotor",
    "ClampingMaxEffort",
    "ClampingPositionBased",
    "Controller",
    "ControllerPD",
    "ControllerPID",
    "Delay",
]
