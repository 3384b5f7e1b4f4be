"""One frame of a sensor: times, poses, and the requested channel arrays."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from importlib import import_module
from typing import Any

import numpy as np

from graph.base.exact import nanoseconds
from graph.base.records import dataclass, field
from graph.base.suggesting import Suggesting
from graph.sim.transforms import quaternion

from .channels import CHANNELS, AuxLevel


@dataclass(frozen=True, slots=True)
class FramePose:
    """The sensor's pose at one moment.

    timestamp_ns: on the sensor's firing clock. world_sensor: (4, 4) float64, column vectors, sensor to world [m].
    """

    timestamp_ns: int
    world_sensor: np.ndarray

    @property
    def position_m(self) -> np.ndarray:
        """Position of the sensor in the world, (3,) float64 [m]."""
        return self.world_sensor[:3, 3]

    @property
    def orientation(self) -> np.ndarray:
        """Sensor to world rotation, (4,) float64, quaternion w, x, y, z."""
        return quaternion(self.world_sensor[:3, :3])


@dataclass(slots=True, repr=False)
class Frame(Suggesting):
    """A finished reading.

    timestamp_ns: start of the frame on the simulation clock; element time = timestamp_ns + timeOffsetNs. reference: the
    time [s], on the same clock, for its messages: the time of the pose that transforms the frame. frame_id counts the
    sensor's frames from 0. start, end: poses at both ends. frame_of_reference: SENSOR, WORLD or CUSTOM, the frame of
    xyz, azimuth, elevation, distance, normals and velocities. coords: SPHERICAL or CARTESIAN, the meaning of x, y, z in
    a GenericModelOutput. arrays: channel name -> array of `count` rows, an image of as many pixels, or a list of other
    objects; only requested channels. one_instant: whether the whole frame shows the state at its reference time,
    although its elements have other times. config: the sensor's configuration (a LidarConfig for lidars).
    facts: fields of a GenericModelOutput that only some sensors have, such as scanIdx of radars; they need an auxiliary
    level above NONE.
    """

    timestamp_ns: int
    frame_id: int
    start: FramePose
    end: FramePose
    count: int
    arrays: Mapping[str, np.ndarray]
    config: Any = None
    sensor_path: str = ""
    scan_complete: bool = True
    aux_level: AuxLevel = AuxLevel.NONE
    modality: str = "LIDAR"
    coords: str = "SPHERICAL"
    frame_of_reference: str = "SENSOR"
    motion_compensation: str = "NONCOMPENSATED"
    azimuth_offset_deg: float = 0.0
    reference: Fraction = Fraction(0)
    one_instant: bool = False
    facts: Mapping[str, Any] = field(default_factory=dict)
    cache: dict[str, Any] = field(default_factory=dict, repr=False)

    def channel(self, name: str) -> np.ndarray:
        """The channel's array; without elements if no consumer requested it. Raises KeyError for unknown names."""
        array = self.arrays.get(name)
        return CHANNELS[name].empty() if array is None else array

    def __repr__(self) -> str:
        held = ", ".join(f"{name} {getattr(one, 'shape', len(one))}" for name, one in self.arrays.items())
        sensor = self.sensor_path or "a sensor"
        return f"<Frame {self.frame_id} of {sensor} at {self.timestamp_ns} ns: {held or 'no channels'}>"

    def _repr_html_(self) -> str:
        html: str = import_module("sensors.writers.showing").frame_html(self)
        return html

    def has(self, name: str) -> bool:
        """Whether the frame holds this channel."""
        return name in self.arrays

    @property
    def common_ns(self) -> int | None:
        """The time [ns] of the one pose to which all points belong; None if each belongs to its own firing."""
        if self.motion_compensation != "COMPENSATED":
            return None
        end = self.end.timestamp_ns
        return max(nanoseconds(self.reference), end) if self.one_instant else end

    @property
    def xyz(self) -> np.ndarray:
        """Points, (count, 3) float32 [m], in the frame of reference; computed from angles and distance if needed."""
        if "xyz" not in self.arrays and {"azimuth", "elevation", "distance"} <= self.arrays.keys():
            points = self.cache.get("xyz")
            if points is None:
                points = cartesian(self.arrays["azimuth"], self.arrays["elevation"], self.arrays["distance"])
                self.cache["xyz"] = points
            return np.asarray(points)
        return self.channel("xyz")


def cartesian(azimuth_deg: np.ndarray, elevation_deg: np.ndarray, distance: np.ndarray) -> np.ndarray:
    """Points (N, 3) float32 of spherical coordinates; a distance below 1e-6 gives (0, 0, 0)."""
    azimuth, elevation = np.deg2rad(azimuth_deg, dtype=np.float32), np.deg2rad(elevation_deg, dtype=np.float32)
    points = np.empty((len(distance), 3), np.float32)
    level = distance * np.cos(elevation)
    np.multiply(level, np.cos(azimuth), out=points[:, 0])
    np.multiply(level, np.sin(azimuth), out=points[:, 1])
    np.multiply(distance, np.sin(elevation), out=points[:, 2])
    points[distance < 1e-6] = 0.0
    return points


def spherical(points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Azimuth [deg], elevation [deg] and distance of points (N, 3); float32 (N,) each."""
    x, y, z = (points[:, axis].astype(np.float64) for axis in range(3))
    level = np.hypot(x, y)
    azimuth = np.rad2deg(np.arctan2(y, x)).astype(np.float32)
    elevation = np.rad2deg(np.arctan2(z, level)).astype(np.float32)
    return azimuth, elevation, np.hypot(level, z).astype(np.float32)
