"""`newton.actuators`, where Newton is not installed."""

from wings.actuators.laws import (
    Clamping,
    ClampingDCMotor,
    ClampingMaxEffort,
    ClampingPositionBased,
    Controller,
    ControllerPD,
    ControllerPID,
    Delay,
)
from wings.actuators.robot import Actuator

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
