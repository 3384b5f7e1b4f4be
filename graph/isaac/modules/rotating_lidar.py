"""`isaacsim.sensors.physx`: the rotating lidar of PhysX, with a frame of the data that a script adds."""

from __future__ import annotations

from typing import Any

from graph.isaac.parameters import renamed
from graph.isaac.session import app

from .old_prims import SingleXFormPrim
from .range_sensors import acquire_lidar_sensor_interface
from .sensor_schema import RangeSensorSchema
from .stage import usd_stage

__all__ = ["RotatingLidarPhysX"]
NEW = {"rotation_frequency": 20.0, "fov": (360.0, 10.0), "resolution": (1.0, 1.0), "valid_range": (0.4, 2000.0)}
"""What a new prim has unless the constructor names it: Hz, degrees, degrees, m."""
PARTS = ("depth", "linear_depth", "intensity", "zenith", "azimuth", "point_cloud", "semantics")


class RotatingLidarPhysX(SingleXFormPrim):
    def __init__(
        self,
        prim_path: str,
        name: str = "rotating_lidar_physX",
        rotation_frequency: float | None = None,
        rotation_dt: float | None = None,
        position: Any = None,
        translation: Any = None,
        orientation: Any = None,
        fov: tuple[float, float] | None = None,
        resolution: tuple[float, float] | None = None,
        valid_range: tuple[float, float] | None = None,
    ) -> None:
        if rotation_frequency is not None and rotation_dt is not None:
            raise Exception("give the rotation frequency or rotation_dt of a lidar, not both")
        if rotation_dt is not None:
            rotation_frequency = int(1 / rotation_dt)
        given: dict[str, Any] = {"rotation_frequency": rotation_frequency, "fov": fov, "resolution": resolution}
        given = {key: value for key, value in {**given, "valid_range": valid_range}.items() if value is not None}
        if not usd_stage().GetPrimAtPath(prim_path):
            RangeSensorSchema.Lidar.Define(usd_stage(), prim_path)
            given = {**NEW, **given}
        super().__init__(prim_path, name, position, translation, orientation)
        for key, value in given.items():
            getattr(self, f"set_{key}")(value)
        self._paused = False
        self._frame: dict[str, Any] = {"time": 0, "physics_step": 0}
        self._lidar = acquire_lidar_sensor_interface()

    def initialize(self, physics_sim_view: Any = None) -> None:
        self._lidar.get_num_cols(self.prim_path)  # it turns from now on

    def get_current_frame(self) -> dict[str, Any]:
        if not self._paused and not app().timeline.is_stopped():
            for part in self._frame.keys() & set(PARTS):
                self._frame[part] = self._read(part)
            simulation = app().simulation
            self._frame.update(time=float(simulation.time), physics_step=simulation.get_num_physics_steps())
        return self._frame

    def _read(self, part: str) -> Any:
        name = "semantic" if part == "semantics" else part
        return getattr(self._lidar, f"get_{name}_data")(self.prim_path).astype("float32")

    def get_num_rows(self) -> int:
        return self._lidar.get_num_rows(self.prim_path)

    def get_num_cols(self) -> int:
        return self._lidar.get_num_cols(self.prim_path)

    def get_num_cols_in_last_step(self) -> int:
        return self._lidar.get_num_cols_ticked(self.prim_path)

    def pause(self) -> None:
        self._paused = True

    def resume(self) -> None:
        self._paused = False

    def is_paused(self) -> bool:
        return self._paused

    def _set(self, **values: Any) -> None:
        for name, value in values.items():
            self.prim.GetAttribute(name).Set(value)

    def _pair(self, first: str, second: str) -> tuple[float, float]:
        return self.prim.GetAttribute(first).Get(), self.prim.GetAttribute(second).Get()

    def set_fov(self, value: tuple[float, float]) -> None:
        self._set(horizontalFov=value[0], verticalFov=value[1])

    def get_fov(self) -> tuple[float, float]:
        return self._pair("horizontalFov", "verticalFov")

    def set_resolution(self, value: Any) -> None:
        self._set(horizontalResolution=value[0], verticalResolution=value[1])

    def get_resolution(self) -> tuple[float, float]:
        return self._pair("horizontalResolution", "verticalResolution")

    def set_rotation_frequency(self, value: float) -> None:
        self._set(rotationRate=value)

    def get_rotation_frequency(self) -> float:
        return self.prim.GetAttribute("rotationRate").Get()  # type: ignore[no-any-return]

    def set_valid_range(self, value: tuple[float, float]) -> None:
        self._set(minRange=value[0], maxRange=value[1])

    def get_valid_range(self) -> tuple[float, float]:
        return self._pair("minRange", "maxRange")

    def enable_semantics(self) -> None:
        self._set(enableSemantics=True)

    def disable_semantics(self) -> None:
        self._set(enableSemantics=False)

    def is_semantics_enabled(self) -> bool:
        return bool(self.prim.GetAttribute("enableSemantics").Get())

    def enable_visualization(self, high_lod: bool = False, draw_points: bool = True, draw_lines: bool = True) -> None:
        self._set(highLod=high_lod, drawPoints=draw_points, drawLines=draw_lines)

    def disable_visualization(self) -> None:
        self.enable_visualization(high_lod=False, draw_points=False, draw_lines=False)


def _frame_calls(part: str) -> None:
    """Adds `add_..._data_to_frame` and `remove_..._data_from_frame`."""

    def add(self: RotatingLidarPhysX) -> None:
        if part == "semantics":
            self.enable_semantics()
        self._frame[part] = None

    def remove(self: RotatingLidarPhysX) -> None:
        if part == "semantics":
            self.disable_semantics()
        del self._frame[part]

    for call, name in ((add, f"add_{part}_data_to_frame"), (remove, f"remove_{part}_data_from_frame")):
        setattr(RotatingLidarPhysX, name, renamed(call, name))


for _part in PARTS:
    _frame_calls(_part)
