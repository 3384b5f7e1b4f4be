"""`isaacsim.sensors.physics` and `omni.isaac.sensor`: IMU, contact and effort sensors of the former module."""

from __future__ import annotations

from typing import Any

import numpy as np

from graph.isaac.session import app
from sensors.inertial import attribute_of

from . import sensor_readings as readings
from .held_readings import Held
from .old_prims import SingleXFormPrim
from .prim_base import attribute
from .sensor_interfaces import (
    CsSensorReading,
    IsSensorReading,
    acquire_contact_sensor_interface,
    acquire_imu_sensor_interface,
)
from .sensor_prims import IMU, Contact
from .stage import usd_stage

__all__ = ["ContactSensor", "EffortSensor", "EsSensorReading", "IMUSensor"]
EsSensorReading = readings.EffortSensorReading


class _Paced(SingleXFormPrim):
    """A sensor with the calls of the former ones. `_frame` is one dictionary, filled by each valid reading."""

    _frame: dict[str, Any]

    def initialize(self, physics_sim_view: Any = None) -> None:
        return None

    def resume(self) -> None:
        attribute(self.prim, "enabled", "bool", True)

    def pause(self) -> None:
        attribute(self.prim, "enabled", "bool", False)

    def is_paused(self) -> bool:
        return not attribute_of(self.prim, "enabled", True)

    def get_dt(self) -> float:
        return float(attribute_of(self.prim, "sensorPeriod", app().simulation.get_physics_dt()))

    def set_dt(self, value: float) -> None:
        attribute(self.prim, "sensorPeriod", "float", value)

    def _pace(self, frequency: float | None, dt: float | None) -> None:
        if frequency is not None and dt is not None:
            raise Exception("give the frequency or dt of a sensor, not both")
        if frequency is not None or dt is not None:
            self.set_dt(1 / frequency if frequency is not None else dt)  # type: ignore[arg-type]

    def get_frequency(self) -> int:
        return int(1 / self.get_dt() + 1e-6)

    def set_frequency(self, value: int) -> None:
        self.set_dt(1 / value)


class IMUSensor(_Paced):
    def __init__(
        self,
        prim_path: str,
        name: str = "imu_sensor",
        frequency: int | None = None,
        dt: float | None = None,
        translation: Any = None,
        position: Any = None,
        orientation: Any = None,
        linear_acceleration_filter_size: int = 1,
        angular_velocity_filter_size: int = 1,
        orientation_filter_size: int = 1,
    ) -> None:
        IMU(
            prim_path,
            linear_acceleration_filter_size=linear_acceleration_filter_size,
            angular_velocity_filter_size=angular_velocity_filter_size,
            orientation_filter_size=orientation_filter_size,
        )
        super().__init__(prim_path, name, position, translation, orientation)
        self._interface = acquire_imu_sensor_interface()
        self._frame = {
            "time": 0.0,
            "physics_step": 0.0,
            "lin_acc": np.zeros(3, np.float32),
            "ang_vel": np.zeros(3, np.float32),
            "orientation": np.zeros(4, np.float32),
        }
        self._pace(frequency, dt)

    def get_sensor_reading(
        self, interpolation_function: Any = None, use_latest_data: bool = False, read_gravity: bool = True
    ) -> IsSensorReading:
        return self._interface.get_sensor_reading(self.prim_path, interpolation_function, use_latest_data, read_gravity)

    def get_current_frame(self, read_gravity: bool = True) -> dict[str, Any]:
        one = self.get_sensor_reading(read_gravity=read_gravity)
        self._frame["is_valid"] = one.is_valid
        if one.is_valid:
            x, y, z, w = one.orientation
            self._frame.update(time=one.time, physics_step=float(app().simulation.get_num_physics_steps()))
            self._frame["orientation"] = np.array([w, x, y, z], np.float32)
            for name in ("lin_acc", "ang_vel"):
                self._frame[name] = np.array([getattr(one, f"{name}_{axis}") for axis in "xyz"], np.float32)
        return self._frame


class ContactSensor(_Paced):
    def __init__(
        self,
        prim_path: str,
        name: str = "contact_sensor",
        frequency: int | None = None,
        dt: float | None = None,
        translation: Any = None,
        position: Any = None,
        min_threshold: float | None = None,
        max_threshold: float | None = None,
        radius: float | None = None,
    ) -> None:
        made = Contact(prim_path, min_threshold=min_threshold, max_threshold=max_threshold, radius=radius)
        super().__init__(prim_path, name, position, translation)
        self._sensor = readings.ContactSensor(made)
        self._frame = {"time": 0.0, "physics_step": 0.0, "in_contact": False, "force": 0.0, "number_of_contacts": 0}
        self._pace(frequency, dt)
        accessors = ("get_radius", "set_radius", "get_min_threshold", "set_min_threshold")
        for one in (*accessors, "get_max_threshold", "set_max_threshold"):
            setattr(self, one, getattr(made, one))

    def get_sensor_reading(self, use_latest_data: bool = False) -> CsSensorReading:
        return acquire_contact_sensor_interface().get_sensor_reading(self.prim_path, use_latest_data)

    def get_current_frame(self) -> dict[str, Any]:
        one = self.get_sensor_reading()
        if one.is_valid:
            self._frame.update(self._sensor.get_data())
            self._frame.update(time=one.time, in_contact=one.in_contact, force=one.value)
        return self._frame

    def add_raw_contact_data_to_frame(self) -> None:
        self._frame["contacts"] = []
        self._sensor.add_raw_contact_data_to_frame()

    def remove_raw_contact_data_from_frame(self) -> None:
        self._frame.pop("contacts", None)
        self._sensor.remove_raw_contact_data_from_frame()


class EffortSensor(readings.EffortSensor):
    def __init__(
        self, prim_path: str, sensor_period: float = -1, use_latest_data: bool = False, enabled: bool = True
    ) -> None:
        if not usd_stage().GetPrimAtPath(prim_path):
            raise ValueError(f"{prim_path} does not exist; give the path of a joint")
        self.sensor_period, self.use_latest_data = sensor_period, use_latest_data
        self._held = Held(super().get_sensor_reading, lambda: self.sensor_period, lambda: self.data_buffer_size)
        super().__init__(prim_path, enabled)

    @property
    def interpolation_buffer(self) -> list[EsSensorReading]:
        """The readings taken at the sensor's last time, newest first."""
        return self._held.filled()[: self.data_buffer_size]

    def get_sensor_reading(
        self, interpolation_function: Any = None, use_latest_data: bool = False
    ) -> readings.EffortSensorReading:
        return self._held.reading(interpolation_function, latest=use_latest_data or self.use_latest_data)
