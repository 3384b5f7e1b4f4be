"""`isaacsim.sensors.experimental.physics`, `isaacsim.sensors.physics`: IMU, contact, effort and rays."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np

from graph.isaac.results import result
from graph.isaac.session import app
from graph.sim.physics.protocol import contacts_of
from sensors.inertial import InertialUnit, attribute_of, body_of, widths_of

from .old_prims import SingleXFormPrim
from .prim_base import XformPrim
from .prims import attribute
from .stage import define_prim, get_current_stage

__all__ = ["IMU", "Contact", "ContactSensor", "Effort", "EffortSensor", "IMUSensor", "Raycast"]


class _Authoring(XformPrim):
    kind = ""

    def __init__(self, path: Any, **named: Any) -> None:
        pose = {key: named.pop(key, None) for key in ("positions", "translations", "orientations", "scales")}
        named.pop("reset_xform_op_properties", None)
        text = path if isinstance(path, str) else path[0]
        if not get_current_stage().GetPrimAtPath(text):
            define_prim(text, self.kind)
        super().__init__(text, resolve_paths=False, **pose)
        for name, value in named.items():
            if value is not None:
                self._set(name, value)

    @classmethod
    def create(cls, path: str, **kwargs: Any) -> Any:
        return cls(path, **kwargs)

    def _set(self, name: str, value: Any) -> None:
        raise TypeError(f"{type(self).__name__} has no argument {name}")

    @property
    def path(self) -> str:
        return self.paths[0]


class IMU(_Authoring):
    kind = "IsaacImuSensor"

    def _set(self, name: str, value: Any) -> None:
        words = {
            "linear_acceleration_filter_widths": "linearAccelerationFilterWidth",
            "angular_velocity_filter_widths": "angularVelocityFilterWidth",
            "orientation_filter_widths": "orientationFilterWidth",
        }
        known = {**words, **{key.removesuffix("s"): one for key, one in words.items()}}
        if name not in known:
            super()._set(name, value)
        attribute(self.prims[0], known[name], "uint", int(np.asarray(value).reshape(-1)[0]))


class Contact(_Authoring):
    kind = "IsaacContactSensor"

    def _set(self, name: str, value: Any) -> None:
        from graph.sim.usd import Gf

        prim, given = self.prims[0], np.asarray(value, float).reshape(-1)
        if name in ("min_thresholds", "min_threshold", "max_thresholds", "max_threshold"):
            low, high = attribute_of(prim, "threshold", (0.0, 100000.0))
            pair = (float(given[0]), high) if name.startswith("min") else (low, float(given[0]))
            attribute(prim, "threshold", "float2", Gf.Vec2f(*pair))
        elif name in ("radii", "radius"):
            attribute(prim, "radius", "float", float(given[0]))
        else:
            super()._set(name, value)


class Raycast(_Authoring):
    kind = "IsaacRaycastSensor"

    def _set(self, name: str, value: Any) -> None:
        from graph.sim.scene.prim_attributes import set_property

        parts = name.split("_")
        full = parts[0] + "".join(one.capitalize() for one in parts[1:])
        set_property(self.prims[0], full, np.asarray(value).tolist())


class _Reading:
    def __init__(self, path: Any) -> None:
        self._path = path if isinstance(path, str) else getattr(path, "path", None) or path.paths[0]
        self._unit: InertialUnit | None = None
        self._play: Any = None

    @property
    def prim(self) -> Any:
        return get_current_stage().GetPrimAtPath(self._path)

    @property
    def path(self) -> str:
        return self._path


class IMUSensor(_Reading, SingleXFormPrim):
    """Both spellings: of a path or an IMU, and of the former module with `prim_path` and `name`."""

    def __init__(
        self,
        prim_path: Any = None,
        name: str = "imu_sensor",
        frequency: Any = None,
        dt: Any = None,
        translation: Any = None,
        position: Any = None,
        orientation: Any = None,
        linear_acceleration_filter_size: int | None = None,
        angular_velocity_filter_size: int | None = None,
        orientation_filter_size: int | None = None,
        path: Any = None,
    ) -> None:
        given = prim_path if prim_path is not None else path
        _Reading.__init__(self, given)
        if not self.prim:
            IMU(
                self._path,
                linear_acceleration_filter_width=linear_acceleration_filter_size,
                angular_velocity_filter_width=angular_velocity_filter_size,
                orientation_filter_width=orientation_filter_size,
            )
        SingleXFormPrim.__init__(self, self._path, name, position, translation, orientation)
        self._follow()
        app().on("play", self._follow)

    @property
    def prim(self) -> Any:
        return get_current_stage().GetPrimAtPath(self._path)

    def _follow(self) -> None:
        if self._unit is not None:
            self._unit.close()
        playing = not app().timeline.is_stopped() and bool(self.prim)
        self._unit = InertialUnit(app(), self._path, widths_of(self.prim)) if playing else None

    def get_sensor_reading(self, *_: Any, read_gravity: bool = True, **__: Any) -> Any:
        found = None if self._unit is None else self._unit.reading(read_gravity)
        if found is None:
            zero = np.zeros(3)
            return SimpleNamespace(is_valid=False, time=0.0, **_flat(zero, zero, np.array([0.0, 0, 0, 1])))
        return SimpleNamespace(
            is_valid=True, time=found.time, **_flat(found.acceleration, found.angular_velocity, found.orientation)
        )

    def get_data(self, *, read_gravity: bool = True) -> dict[str, Any]:
        one = self.get_sensor_reading(read_gravity=read_gravity)
        return {
            "is_valid": one.is_valid,
            "time": one.time,
            "physics_step": app().simulation.get_num_physics_steps(),
            "linear_acceleration": result([one.lin_acc_x, one.lin_acc_y, one.lin_acc_z]),
            "angular_velocity": result([one.ang_vel_x, one.ang_vel_y, one.ang_vel_z]),
            "orientation": result(np.roll(one.orientation, 1)),
        }

    def get_current_frame(self, read_gravity: bool = True) -> dict[str, Any]:
        found = self.get_data(read_gravity=read_gravity)
        return {
            "time": found["time"],
            "physics_step": found["physics_step"],
            "lin_acc": found["linear_acceleration"].numpy(),
            "ang_vel": found["angular_velocity"].numpy(),
            "orientation": found["orientation"].numpy(),
        }


def _flat(acceleration: Any, rate: Any, orientation: Any) -> dict[str, Any]:
    out: dict[str, Any] = {"orientation": orientation}
    for name, values in (("lin_acc", acceleration), ("ang_vel", rate)):
        out |= {f"{name}_{axis}": float(value) for axis, value in zip("xyz", values, strict=True)}
    return out


class ContactSensor(_Reading, SingleXFormPrim):
    def __init__(
        self,
        prim_path: Any = None,
        name: str = "contact_sensor",
        frequency: Any = None,
        dt: Any = None,
        translation: Any = None,
        position: Any = None,
        min_threshold: float | None = None,
        max_threshold: float | None = None,
        radius: float | None = None,
        path: Any = None,
    ) -> None:
        _Reading.__init__(self, prim_path if prim_path is not None else path)
        if not get_current_stage().GetPrimAtPath(self._path):
            Contact(self._path, min_threshold=min_threshold, max_threshold=max_threshold, radius=radius)
        SingleXFormPrim.__init__(self, self._path, name, position, translation)
        self._raw = False

    @property
    def prim(self) -> Any:
        return get_current_stage().GetPrimAtPath(self._path)

    def _contacts(self) -> tuple[float, list[dict[str, Any]]]:
        """Size of the total force [N], and each contact within the radius: bodies, place, normal, impulse [N s]."""
        present = app()
        body = body_of(present, self._path)
        if body is None or present.physics is None:
            return 0.0, []
        unit = present.meters_per_unit
        place = present.fabric.world_matrix(self._path)[:3, 3] * unit
        radius = float(attribute_of(self.prim, "radius", -1.0)) * unit
        held = present.physics.contacts()
        chosen = contacts_of(held, body, place, radius)
        total = np.linalg.norm(sum((force for _, force in chosen), np.zeros(3)))
        step = {"time": float(present.simulation.time), "dt": held.dt}
        raw = []
        for row, force in chosen:
            names = [one or shape for one, shape in zip(held.bodies[row], held.pairs[row], strict=True)]
            sign = 1.0 if names[1] == body else -1.0
            raw.append(
                {
                    **step,
                    "body0": body,
                    "body1": names[0] if names[1] == body else names[1],
                    "position": held.positions[row] / unit,
                    "normal": sign * held.normals[row],
                    "impulse": force * held.dt,
                }
            )
        return float(total), raw

    def get_data(self) -> dict[str, Any]:
        low, high = attribute_of(self.prim, "threshold", (0.0, 100000.0))
        force, contacts = self._contacts()
        value = min(force, float(high))
        touching = value > 0 and value >= low
        steps = app().simulation.get_num_physics_steps()
        return {
            "is_valid": steps > 0,
            "time": float(app().simulation.time),
            "physics_step": steps,
            "in_contact": touching,
            "force": value if touching else 0.0,
            "number_of_contacts": len(contacts),
        }

    def get_sensor_reading(self, *_: Any, **__: Any) -> Any:
        found = self.get_data()
        return SimpleNamespace(
            is_valid=found["is_valid"], time=found["time"], in_contact=found["in_contact"], value=found["force"]
        )

    def get_current_frame(self) -> dict[str, Any]:
        return {**self.get_data(), **({"contacts": self._contacts()[1]} if self._raw else {})}

    def add_raw_contact_data_to_frame(self) -> None:
        self._raw = True

    def remove_raw_contact_data_from_frame(self) -> None:
        self._raw = False


class Effort(_Authoring):
    """An effort sensor is a reading of a joint: nothing is authored for it. Raises ValueError without the joint."""

    def __init__(self, path: Any, **named: Any) -> None:
        text = path if isinstance(path, str) else path[0]
        if not get_current_stage().GetPrimAtPath(text):
            raise ValueError(f"{text} does not exist; give the path of a joint")
        super().__init__(path, **named)


class EffortSensor(_Reading):
    def __init__(
        self, prim_path: Any, sensor_period: float = -1, use_latest_data: bool = False, enabled: bool = True, **_: Any
    ) -> None:
        super().__init__(prim_path)
        self.enabled = enabled

    def get_sensor_reading(self, *_: Any, **__: Any) -> Any:
        tensors = app().simulation.tensors
        playing = app().physics is not None and self._path in tensors.joint_paths
        value = float(tensors.joint_efforts[tensors.joint_paths.index(self._path)]) if playing else 0.0
        valid = playing and self.enabled
        return SimpleNamespace(is_valid=valid, time=float(app().simulation.time), value=value)

    def get_data(self) -> dict[str, Any]:
        one = self.get_sensor_reading()
        return {"is_valid": one.is_valid, "time": one.time, "effort": one.value}
