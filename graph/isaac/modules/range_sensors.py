"""`isaacsim.sensors.physx._range_sensor`: the data of PhysX lidars by the paths of their prims."""

from __future__ import annotations

from typing import Any

import numpy as np

from graph.isaac.outcomes import inert
from graph.isaac.session import app, kit

from .stage import usd_stage

__all__ = ["LidarSensorInterface", "acquire_lidar_sensor_interface", "release_lidar_sensor_interface"]
LIDAR = "Lidar"
CHANNELS = ("xyz", "distance", "flags", "beamTime")
FARTHEST = 65535
"""The depth, as a share of the range in 16 bits, of a beam that hits nothing."""


class _Followed:
    """The lidar at a path: it turns with every physics step, whether anybody reads it then or not."""

    def __init__(self, path: str) -> None:
        self._path = path
        self._polled: Any = None
        ends = [app().on("physics_post_step", self._turn)]
        app().on("stage_closing", lambda: ends.pop()() if ends else None)

    def _turn(self) -> None:
        prim = usd_stage().GetPrimAtPath(self._path)
        if prim and prim.GetTypeName() == LIDAR:
            polled = self._sensor()
            if prim.GetAttribute("rotationRate").Get():
                polled.read()

    def _sensor(self) -> Any:
        from sensors.polled import polled_sensor

        polled: Any = polled_sensor(app().world, self._path, LIDAR)
        if polled is not self._polled:
            polled.require(self, CHANNELS)
            self._polled = polled
        return polled

    def scan(self) -> Any:
        """The newest whole scan; None before the first and while stopped."""
        return None if app().timeline.is_stopped() else self._sensor().read()


class LidarSensorInterface:
    """Arrays of a whole scan, (columns, rows): of the present state at rotationRate 0, else of the last whole turn."""

    def __init__(self) -> None:
        app().on("play", self._follow)
        if app().simulation.built:
            self._follow()

    def _follow(self) -> None:
        for prim in (one for one in usd_stage().Traverse() if one.GetTypeName() == LIDAR):
            self._followed(str(prim.GetPath()))

    def _followed(self, path: str) -> _Followed:
        return kit().singleton((_Followed, path), lambda: _Followed(path))

    def _scan(self, path: str) -> Any:
        return self._followed(path).scan()

    def _channel(self, path: str, name: str) -> Any:
        """A channel as (columns, rows, ...); (0, 0) before the first scan."""
        scan = self._scan(path)
        if scan is None:
            return np.zeros((0, 0), np.float32)
        data = scan.channel(name)
        return data.reshape(scan.config.columns, scan.config.rows, *data.shape[1:])

    def is_lidar_sensor(self, lidar_path: str) -> bool:
        prim = usd_stage().GetPrimAtPath(lidar_path)
        return bool(prim) and prim.GetTypeName() == LIDAR

    def get_num_cols(self, lidar_path: str) -> int:
        return len(self._channel(lidar_path, "distance"))

    def get_num_rows(self, lidar_path: str) -> int:
        return int(self._channel(lidar_path, "distance").shape[1])

    def get_num_cols_ticked(self, lidar_path: str) -> int:
        return self.get_num_cols(lidar_path)

    def get_linear_depth_data(self, lidar_path: str) -> np.ndarray:
        """(columns, rows) float32 [m]; maxRange without a hit."""
        return np.array(self._channel(lidar_path, "distance"))

    def get_depth_data(self, lidar_path: str) -> np.ndarray:
        """(columns, rows) uint16: shares of maxRange, 65535 for 1 and without a hit."""
        scan, depth = self._scan(lidar_path), self._channel(lidar_path, "distance")
        farthest = 1.0 if scan is None else float(scan.config.ranges[1])
        return np.asarray(np.rint(depth / farthest * FARTHEST), np.uint16)

    def get_intensity_data(self, lidar_path: str) -> np.ndarray:
        """(columns, rows) uint8: 255 for a hit, else 0."""
        return np.where(self._channel(lidar_path, "flags"), np.uint8(255), np.uint8(0))

    def get_point_cloud_data(self, lidar_path: str) -> np.ndarray:
        """(columns, rows, 3) float32, ends of the beams in the sensor's axes [m]."""
        return np.array(self._channel(lidar_path, "xyz"))

    def get_beam_time_data(self, lidar_path: str) -> np.ndarray:
        """(columns, rows) float32, simulation time of each beam [s]."""
        return np.array(self._channel(lidar_path, "beamTime"))

    def get_azimuth_data(self, lidar_path: str) -> np.ndarray:
        """(columns,) float32 [rad]."""
        return self._angles(lidar_path, "azimuths")

    def get_zenith_data(self, lidar_path: str) -> np.ndarray:
        """(rows,) float32 [rad], downwards from the xy plane."""
        return self._angles(lidar_path, "zeniths")

    def _angles(self, path: str, name: str) -> np.ndarray:
        scan = self._scan(path)
        degrees: Any = [] if scan is None else getattr(scan.config, name)
        return np.asarray(np.deg2rad(degrees), np.float32)

    @inert("isaacsim.sensors.physx._range_sensor")
    def get_semantic_data(self, lidar_path: str) -> np.ndarray:
        return np.zeros((0, 0), np.uint16)


def acquire_lidar_sensor_interface() -> LidarSensorInterface:
    return kit().singleton(LidarSensorInterface, LidarSensorInterface)


def release_lidar_sensor_interface(interface: LidarSensorInterface) -> None: ...
