"""`isaacsim.sensors.physics._sensor`: readings of contact sensors and IMUs by the paths of their prims."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, TypeVar

import numpy as np

from graph.isaac.session import app, kit
from sensors.inertial import attribute_of, widths_of

from . import sensor_readings as readings
from .held_readings import Held, Reading
from .physics_scripts import intToSdfPath
from .sensor_readings import Quaternion
from .stage import usd_stage

T = TypeVar("T", bound=Reading)
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
    orientation: Quaternion = field(default_factory=lambda: Quaternion(0.0, 0.0, 0.0, 0.0))
    is_valid: bool = False


def _is_sensor(path: str, type_name: str) -> bool:
    """Whether a prim is such a sensor in the physics that was built."""
    prim = usd_stage().GetPrimAtPath(path)
    return bool(prim) and prim.GetTypeName() == type_name and app().simulation.built


def _contact_sensor(path: str) -> Any:
    if not _is_sensor(path, "IsaacContactSensor"):
        return None
    return kit().singleton(("IsaacContactSensor", path), lambda: readings.ContactSensor(path))


def _period(path: str) -> float:
    prim = usd_stage().GetPrimAtPath(path)
    return float(attribute_of(prim, "sensorPeriod", 0.0)) if prim else 0.0


def _held(path: str, read: Callable[[], T], *key: Any, length: Callable[[], int] = lambda: 20) -> Held[T]:
    return kit().singleton((Held, path, *key), lambda: Held(read, lambda: _period(path), length))


class ContactSensorInterface:
    def is_contact_sensor(self, sensor_path: str) -> bool:
        return _is_sensor(sensor_path, "IsaacContactSensor")

    def get_sensor_reading(self, sensor_path: str, use_latest_data: bool = False) -> CsSensorReading:
        sensor = _contact_sensor(sensor_path)
        if sensor is None:
            return CsSensorReading()

        def read() -> CsSensorReading:
            one = sensor.get_sensor_reading()
            return CsSensorReading(one.time, one.value, one.in_contact, one.is_valid)

        return _held(sensor_path, read).reading(latest=use_latest_data)

    def get_contact_sensor_raw_data(self, sensor_path: str) -> np.ndarray:
        sensor = _contact_sensor(sensor_path)
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
        for prim in (one for one in usd_stage().Traverse() if one.GetTypeName() == "IsaacImuSensor"):
            for gravity in (True, False):
                self._held(str(prim.GetPath()), gravity)

    def is_imu_sensor(self, sensor_path: str) -> bool:
        return _is_sensor(sensor_path, "IsaacImuSensor")

    def get_sensor_reading(
        self,
        sensor_path: str,
        interpolation_function: Any = None,
        use_latest_data: bool = False,
        read_gravity: bool = True,
    ) -> IsSensorReading:
        if not self.is_imu_sensor(sensor_path):
            return IsSensorReading()
        return self._held(sensor_path, read_gravity).reading(interpolation_function, latest=use_latest_data)

    def _held(self, path: str, gravity: bool) -> Held[IsSensorReading]:
        sensor = kit().singleton(("IsaacImuSensor", path), lambda: readings.IMUSensor(path))

        def read() -> IsSensorReading:
            one = sensor.get_sensor_reading(gravity)
            if not one.is_valid:
                return IsSensorReading()
            named = {
                f"{short}_{axis}": getattr(one, f"{name}_{axis}")
                for short, name in (("lin_acc", "linear_acceleration"), ("ang_vel", "angular_velocity"))
                for axis in "xyz"
            }
            return IsSensorReading(time=one.time, orientation=one.orientation, is_valid=True, **named)

        return _held(path, read, gravity, length=lambda: 2 * max(10, *widths_of(usd_stage().GetPrimAtPath(path))))


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
