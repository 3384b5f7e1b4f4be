"""Readings of `isaacsim.sensors.experimental.physics`: IMU, contact, effort, joint state, rays."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from typing import Any

import numpy as np

from graph.base.errors import RunError
from graph.base.records import dataclass, field
from graph.isaac.session import app, kit, warn
from graph.sim.physics.protocol import contacts_of
from sensors.inertial import InertialUnit, attribute_of, body_of, widths_of
from sensors.rays import RaySensor

from .sensor_prims import IMU, Contact, Raycast, SensorPrim
from .stage import usd_stage

__all__ = [
    "ContactSensor",
    "ContactSensorReading",
    "EffortSensor",
    "EffortSensorReading",
    "IMUSensor",
    "IMUSensorReading",
    "JointStateSensor",
    "JointStateSensorReading",
    "Quaternion",
    "RaycastSensor",
]


@dataclass
class Quaternion:
    """Iterates as x, y, z, w."""

    w: float
    x: float
    y: float
    z: float

    def __iter__(self) -> Iterator[float]:
        return iter((self.x, self.y, self.z, self.w))

    def __len__(self) -> int:
        return len(list(iter(self)))

    def __getitem__(self, index: int) -> float:
        return (self.x, self.y, self.z, self.w)[index]

    def __array__(self, dtype: Any = None, copy: Any = None) -> np.ndarray:
        return np.array(list(self), dtype)


@dataclass
class IMUSensorReading:
    """Accelerations in stage units per s2, angular velocities in rad/s, time in s."""

    linear_acceleration_x: float = 0.0
    linear_acceleration_y: float = 0.0
    linear_acceleration_z: float = 0.0
    angular_velocity_x: float = 0.0
    angular_velocity_y: float = 0.0
    angular_velocity_z: float = 0.0
    orientation: Quaternion = field(default_factory=lambda: Quaternion(1.0, 0.0, 0.0, 0.0))
    time: float = 0.0
    is_valid: bool = False

    @property
    def orientation_w(self) -> float:
        return self.orientation.w

    @property
    def orientation_x(self) -> float:
        return self.orientation.x

    @property
    def orientation_y(self) -> float:
        return self.orientation.y

    @property
    def orientation_z(self) -> float:
        return self.orientation.z


@dataclass
class ContactSensorReading:
    value: float = 0.0
    time: float = 0.0
    is_valid: bool = False
    in_contact: bool = field(default=False, kw_only=True)


@dataclass
class EffortSensorReading:
    is_valid: bool = False
    time: float = 0
    value: float = 0


@dataclass
class JointStateSensorReading:
    is_valid: bool = False
    time: float = 0.0
    dof_names: list[str] = field(default_factory=list)
    positions: np.ndarray = field(default_factory=lambda: np.zeros(0, np.float32))
    velocities: np.ndarray = field(default_factory=lambda: np.zeros(0, np.float32))
    efforts: np.ndarray = field(default_factory=lambda: np.zeros(0, np.float32))
    dof_types: np.ndarray = field(default_factory=lambda: np.zeros(0, np.uint8))
    stage_meters_per_unit: float = 0.0


@dataclass
class RaycastSensorReading:
    is_valid: bool = False
    time: float = 0.0
    ray_count: int = 0
    depths: np.ndarray = field(default_factory=lambda: np.zeros(0, np.float32))
    hit_positions: np.ndarray = field(default_factory=lambda: np.zeros((0, 3), np.float32))
    hit_normals: np.ndarray = field(default_factory=lambda: np.zeros((0, 3), np.float32))
    hit_prim_paths: list[str] = field(default_factory=list)
    ray_origins_world: np.ndarray = field(default_factory=lambda: np.zeros((0, 3), np.float32))
    ray_end_points_world: np.ndarray = field(default_factory=lambda: np.zeros((0, 3), np.float32))


class _Sensor:
    """A reading of a prim: while physics steps, and the prim is there and enabled."""

    def __init__(self, path: str) -> None:
        self._prim_path = path
        self.enabled = True

    def _prim(self) -> Any:
        """The prim, if it can be read now; else None."""
        present = app()
        stepped = present.simulation.get_num_physics_steps() > 0  # none after a stop
        prim = usd_stage().GetPrimAtPath(self._prim_path)
        return prim if stepped and self.enabled and prim and attribute_of(prim, "enabled", True) else None

    def reset(self) -> None:
        """Forgets what was read so far; the next reading begins again."""

    def on_timeline_stop(self) -> None:
        self.reset()

    def _stage_open_callback_fn(self, event: Any = None) -> None:
        self.reset()


class _Authored(_Sensor):
    """A sensor with a prim of its own, given by its path or by the object that authors it."""

    authored_by: type[SensorPrim]

    def __init__(self, path: Any) -> None:
        self.authoring_object = path if isinstance(path, self.authored_by) else self.authored_by(path)
        super().__init__(self.authoring_object.path)

    @property
    def _frame(self) -> dict[str, Any]:
        return {"time": float(app().simulation.time), "physics_step": float(app().simulation.get_num_physics_steps())}


class _Followed:
    """The inertial unit of an IMU prim, from the first physics step of a play on; all that read the prim share it."""

    def __init__(self, path: str) -> None:
        self._app, self._path = app(), path
        self.unit: InertialUnit | None = None
        self._wait()
        self._app.on("stop", self.restart)
        self._app.on("stage_closing", self._end)

    def _wait(self) -> None:
        self._waiting = self._app.on("physics_pre_step", self._follow)

    def _follow(self) -> None:
        self._waiting()
        prim = self._app.stage.GetPrimAtPath(self._path)
        if not prim:
            return
        try:
            self.unit = InertialUnit(self._app.world, self._path, widths_of(prim))
        except RunError as error:
            warn("imu-without-body", self._path, str(error))

    def _end(self) -> None:
        self._waiting()
        if self.unit is not None:
            self.unit.close()
        self.unit = None

    def restart(self) -> None:
        """Forgets all readings; the next physics step begins again."""
        self._end()
        self._wait()


class IMUSensor(_Authored):
    authored_by = IMU

    def __init__(self, path: Any) -> None:
        super().__init__(path)
        self._followed = kit().singleton((IMUSensor, self._prim_path), lambda: _Followed(self._prim_path))

    @property
    def imu(self) -> IMU:
        return self.authoring_object  # type: ignore[return-value]

    def reset(self) -> None:
        self._followed.restart()

    def get_sensor_reading(self, read_gravity: bool = True) -> IMUSensorReading:
        unit, prim = self._followed.unit, self._prim()
        if prim is None or unit is None:
            return IMUSensorReading()
        unit.average_over(widths_of(prim))
        found = unit.reading(read_gravity)
        if found is None:
            return IMUSensorReading()
        x, y, z, w = map(float, found.orientation)
        felt = found.acceleration / app().meters_per_unit
        named = {f"linear_acceleration_{axis}": float(one) for axis, one in zip("xyz", felt, strict=True)}
        for axis, one in zip("xyz", found.angular_velocity, strict=True):
            named[f"angular_velocity_{axis}"] = float(one)
        return IMUSensorReading(orientation=Quaternion(w, x, y, z), time=found.time, is_valid=True, **named)

    def get_data(self, read_gravity: bool = True) -> dict[str, Any]:
        one = self.get_sensor_reading(read_gravity)
        turn = one.orientation
        felt = (one.linear_acceleration_x, one.linear_acceleration_y, one.linear_acceleration_z)
        turned = (one.angular_velocity_x, one.angular_velocity_y, one.angular_velocity_z)
        return {
            **self._frame,
            "time": one.time,
            "linear_acceleration": np.array(felt, np.float32),
            "angular_velocity": np.array(turned, np.float32),
            "orientation": np.array([turn.w, turn.x, turn.y, turn.z], np.float32),
        }


class ContactSensor(_Authored):
    authored_by = Contact

    def __init__(self, path: Any) -> None:
        super().__init__(path)
        self._data: dict[str, Any] = {}
        """What `get_data` gives: one dictionary, as the original's; it is filled again by each call."""

    @property
    def contact(self) -> Contact:
        return self.authoring_object  # type: ignore[return-value]

    def get_sensor_reading(self) -> ContactSensorReading:
        prim = self._prim()
        if prim is None:
            return ContactSensorReading()
        low, high = attribute_of(prim, "threshold", (0.0, 100000.0))
        total, _ = contacts_at(prim)
        value = min(total, float(high))
        touching = value > 0 and value >= low
        time = float(app().simulation.time)
        return ContactSensorReading(value if touching else 0.0, time, True, in_contact=touching)

    def get_raw_data(self) -> list[dict[str, Any]]:
        return raw_contacts(self._prim())

    def get_data(self) -> dict[str, Any]:
        prim, one, data = self._prim(), self.get_sensor_reading(), self._data
        if prim is None:
            data.update(time=0.0, physics_step=0.0)
            return data
        contacts = contacts_at(prim)[1]
        data.update(self._frame, in_contact=one.in_contact, force=one.value, number_of_contacts=len(contacts))
        if "contacts" in data:
            data["contacts"] = contacts
        return data

    def add_raw_contact_data_to_frame(self) -> None:
        self._data["contacts"] = []

    def remove_raw_contact_data_from_frame(self) -> None:
        self._data.pop("contacts", None)


def raw_contacts(prim: Any) -> list[dict[str, Any]]:
    """The contacts at a sensor's or body's prim with vectors by axis and bodies as numbers; none without a prim."""
    from graph.isaac.modules.physics_scripts import sdfPathToInt

    contacts = contacts_at(prim)[1] if prim else []
    for one in contacts:
        for name in ("position", "normal", "impulse"):
            one[name] = dict(zip("xyz", map(float, one[name]), strict=True))
        for name in ("body0", "body1"):
            one[name] = sdfPathToInt(one[name])
    return contacts


def contacts_at(prim: Any) -> tuple[float, list[dict[str, Any]]]:
    """Size of the total force on a sensor's body [kg * stage units / s2], and each contact within its radius.

    A contact: time and dt [s], body0 (the sensor's) and body1, position [stage units], normal, impulse
    [kg * stage units / s].
    """
    present, path = app(), str(prim.GetPath())
    body = body_of(present.world, path)
    if body is None or present.physics is None:
        return 0.0, []
    unit = present.meters_per_unit
    place = present.fabric.world_matrix(path)[:3, 3] * unit
    held = present.physics.contacts()
    chosen = contacts_of(held, body, place, float(attribute_of(prim, "radius", -1.0)) * unit)
    total = np.linalg.norm(sum((force for _, force in chosen), np.zeros(3)))
    step = {"time": float(present.simulation.time), "dt": held.dt}
    out = []
    for row, force in chosen:
        names = [one or shape for one, shape in zip(held.bodies[row], held.pairs[row], strict=True)]
        second = names[1] == body
        out.append(
            {
                **step,
                "body0": body,
                "body1": names[0] if second else names[1],
                "position": (held.positions[row] / unit).astype(np.float32),
                "normal": ((1.0 if second else -1.0) * held.normals[row]).astype(np.float32),
                "impulse": (force / unit * held.dt).astype(np.float32),
            }
        )
    return float(total / unit), out


class EffortSensor(_Sensor):
    """The effort of the joint at a path."""

    def __init__(self, path: str, enabled: bool = True) -> None:
        super().__init__(path)
        self.enabled = enabled
        self.data_buffer_size = 10
        self.reset()

    @property
    def dof_name(self) -> str:
        return self._prim_path.rpartition("/")[2]

    @property
    def body_prim_path(self) -> str:
        return self._prim_path.rpartition("/")[0]

    def reset(self) -> None:
        empty = (EffortSensorReading() for _ in range(self.data_buffer_size))
        self.sensor_reading_buffer = deque(empty, maxlen=self.data_buffer_size)

    def get_sensor_reading(self) -> EffortSensorReading:
        if self._prim() is None:
            return EffortSensorReading()
        tensors = app().simulation.tensors
        if self._prim_path not in tensors.joint_paths:
            return EffortSensorReading()
        value = float(tensors.joint_efforts[tensors.joint_paths.index(self._prim_path)])
        one = EffortSensorReading(True, float(app().simulation.time), value)
        self.sensor_reading_buffer.appendleft(one)
        return one

    def get_data(self) -> dict[str, Any]:
        one = self.get_sensor_reading()
        steps = app().simulation.get_num_physics_steps()
        return {"value": one.value, "is_valid": one.is_valid, "time": one.time, "physics_step": steps}

    def update_dof_name(self, dof_name: str) -> None:
        self._prim_path = f"{self.body_prim_path}/{dof_name}"
        self.reset()

    def change_buffer_size(self, new_buffer_size: int) -> None:
        kept = list(self.sensor_reading_buffer)[:new_buffer_size]
        self.data_buffer_size = new_buffer_size
        kept += [EffortSensorReading() for _ in range(new_buffer_size - len(kept))]
        self.sensor_reading_buffer = deque(kept, maxlen=new_buffer_size)


class JointStateSensor(_Sensor):
    """All joints of the articulation at a path."""

    def __init__(self, path: str, enabled: bool = True) -> None:
        super().__init__(path)
        self.enabled = enabled

    def get_sensor_reading(self) -> JointStateSensorReading:
        physics = app().physics
        if self._prim() is None or physics is None:
            return JointStateSensorReading()
        found = physics.articulation(self._prim_path)
        return JointStateSensorReading(
            True,
            float(app().simulation.time),
            list(found.joint_names),
            np.asarray(found.positions, np.float32),
            np.asarray(found.velocities, np.float32),
            np.asarray(found.efforts, np.float32),
            np.array([int(slides) for slides in found.linear], np.uint8),
            app().meters_per_unit,
        )

    def get_data(self) -> dict[str, Any]:
        one = self.get_sensor_reading()
        return {**vars(one), "physics_step": app().simulation.get_num_physics_steps()}


class RaycastSensor(_Authored):
    authored_by = Raycast

    def __init__(self, path: Any) -> None:
        super().__init__(path)
        self._rays: RaySensor | None = None
        app().on("play", self.reset)

    @property
    def raycast(self) -> Raycast:
        return self.authoring_object  # type: ignore[return-value]

    def reset(self) -> None:
        self._rays = None

    def get_sensor_reading(self) -> RaycastSensorReading:
        prim = self._prim()
        if prim is None:
            return RaycastSensorReading()
        try:
            self._rays = self._rays or RaySensor.of(prim)
        except RunError as error:
            warn("raycast-sensor-off", self._prim_path, str(error))
            return RaycastSensorReading()
        if not len(self._rays.directions):
            return RaycastSensorReading()
        found = self._rays.read(app().world)
        arrays = (found.depths, found.positions, found.normals)
        depths, positions, normals = (one.astype(np.float32) for one in arrays)
        origins, ends = found.origins.astype(np.float32), found.ends.astype(np.float32)
        return RaycastSensorReading(
            True, found.time, len(depths), depths, positions, normals, found.prims, origins, ends
        )

    def get_data(self) -> dict[str, Any]:
        one = self.get_sensor_reading()
        names = ("depths", "hit_positions", "hit_normals", "hit_prim_paths", "time")
        return {name: getattr(one, name) for name in names} | {"physics_step": app().simulation.get_num_physics_steps()}
