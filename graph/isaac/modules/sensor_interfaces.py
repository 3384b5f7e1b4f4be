"""`isaacsim.sensors.physics._sensor`: readings of contact sensors and IMUs by the paths of their prims."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from graph.isaac.session import app, kit

from . import sensor_readings as readings
from .physics_scripts import intToSdfPath
from .stage import usd_stage

__all__ = [
    "ContactSensorInterface",
    "CsSensorReading",
    "ImuSensorInterface",
    "IsSensorReading",
    "acquire_contact_sensor_interface",
    "acquire_imu_sensor_interface",
    "release_contact_sensor_interface",
    "release_imu_sensor_interface",
]
_VECTOR = np.dtype([(axis, np.float32) for axis in "xyz"])
_CONTACT = np.dtype(
    [
        *((name, np.float32) for name in ("time", "dt")),
        *((name, np.uint64) for name in ("body0", "body1")),
        *((name, _VECTOR) for name in ("position", "normal", "impulse")),
    ]
)


@dataclass
class CsSensorReading:
    time: float = 0.0
    value: float = 0.0
    in_contact: bool = False
    is_valid: bool = False

    @property
    def inContact(self) -> bool:
        return self.in_contact


@dataclass
class IsSensorReading:
    time: float = 0.0
    lin_acc_x: float = 0.0
    lin_acc_y: float = 0.0
    lin_acc_z: float = 0.0
    ang_vel_x: float = 0.0
    ang_vel_y: float = 0.0
    ang_vel_z: float = 0.0
    orientation: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0)
    is_valid: bool = False


def _is_sensor(path: str, type_name: str) -> bool:
    """Whether a prim is such a sensor in the physics that was built."""
    prim = usd_stage().GetPrimAtPath(path)
    return bool(prim) and prim.GetTypeName() == type_name and app().simulation.built


def _sensor(path: str, type_name: str, make: Callable[[str], Any]) -> Any:
    if not _is_sensor(path, type_name):
        return None
    return kit().singleton((type_name, path), lambda: make(path))


class ContactSensorInterface:
    def is_contact_sensor(self, sensor_path: str) -> bool:
        return _is_sensor(sensor_path, "IsaacContactSensor")

    def get_sensor_reading(self, sensor_path: str, use_latest_data: bool = False) -> CsSensorReading:
        sensor = _sensor(sensor_path, "IsaacContactSensor", readings.ContactSensor)
        if sensor is None:
            return CsSensorReading()
        one = sensor.get_sensor_reading()
        return CsSensorReading(one.time, one.value, one.in_contact, one.is_valid)

    def get_contact_sensor_raw_data(self, sensor_path: str) -> np.ndarray:
        sensor = _sensor(sensor_path, "IsaacContactSensor", readings.ContactSensor)
        return _array([] if sensor is None else sensor.get_raw_data())

    def get_rigid_body_raw_data(self, body_path: str) -> np.ndarray:
        return _array(readings.raw_contacts(usd_stage().GetPrimAtPath(body_path)))

    def decode_body_name(self, body: int) -> str:
        return str(intToSdfPath(int(body)))


class ImuSensorInterface:
    def __init__(self) -> None:
        app().on("play", self._follow)
        if app().simulation.built:
            self._follow()

    def _follow(self) -> None:
        """Follows every unit of the stage from now on: a reading needs the motion before it."""
        for prim in usd_stage().Traverse():
            _sensor(str(prim.GetPath()), "IsaacImuSensor", readings.IMUSensor)

    def is_imu_sensor(self, sensor_path: str) -> bool:
        return _is_sensor(sensor_path, "IsaacImuSensor")

    def get_sensor_reading(
        self,
        sensor_path: str,
        interpolation_function: Any = None,
        use_latest_data: bool = False,
        read_gravity: bool = True,
    ) -> IsSensorReading:
        sensor = _sensor(sensor_path, "IsaacImuSensor", readings.IMUSensor)
        one = readings.IMUSensorReading() if sensor is None else sensor.get_sensor_reading(read_gravity)
        if not one.is_valid:
            return IsSensorReading()
        turn, felt = one.orientation, {"lin_acc": "linear_acceleration", "ang_vel": "angular_velocity"}
        named = {f"{short}_{axis}": getattr(one, f"{name}_{axis}") for short, name in felt.items() for axis in "xyz"}
        orientation = (turn.x, turn.y, turn.z, turn.w)
        return IsSensorReading(time=one.time, orientation=orientation, is_valid=True, **named)


def _array(contacts: list[dict[str, Any]]) -> np.ndarray:
    out = np.zeros(len(contacts), _CONTACT)
    for row, one in zip(out, contacts, strict=True):
        for name, value in one.items():
            row[name] = tuple(value.values()) if isinstance(value, dict) else value
    return out


def acquire_contact_sensor_interface() -> ContactSensorInterface:
    return kit().singleton(ContactSensorInterface, ContactSensorInterface)


def acquire_imu_sensor_interface() -> ImuSensorInterface:
    return kit().singleton(ImuSensorInterface, ImuSensorInterface)


def release_contact_sensor_interface(interface: ContactSensorInterface) -> None: ...


def release_imu_sensor_interface(interface: ImuSensorInterface) -> None: ...
