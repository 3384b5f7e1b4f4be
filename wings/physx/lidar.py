"""The rotating lidar of PhysX: rows and columns of beams, the columns fired one after the other as it turns."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np

from graph.base.limits import check
from graph.base.records import dataclass
from graph.sim.renderer.schedule import Tick
from sensors.raycast.shared import cast_world
from sensors.runtime import Measurement, SensorRuntime

from .attributes import number, read_ranges
from .beams import fire, told
from .names import LIDAR

if TYPE_CHECKING:
    from pxr import Usd

HERE = np.zeros(3)


@dataclass(frozen=True, slots=True)
class PhysxLidarConfig:
    """The configuration of a PhysX lidar.

    Angles in degrees. columns: int(horizontalFov / horizontalResolution); rows: int(verticalFov / verticalResolution)
    + 1, or 1 without highLod. rotation_rate [Hz], 0: all columns at once. ranges: minRange, maxRange [m].
    """

    enabled: bool
    ranges: tuple[float, float]
    rotation_rate: Fraction
    horizontal_fov: float
    horizontal_resolution: float
    vertical_fov: float
    vertical_resolution: float
    yaw_offset: float
    columns: int
    rows: int

    @property
    def azimuths(self) -> np.ndarray:
        """(columns,) float64 [deg], counter-clockwise from +x; the first at -horizontalFov / 2 + yawOffset."""
        first = self.yaw_offset - self.horizontal_fov / 2
        return first + np.arange(self.columns) * self.horizontal_resolution

    @property
    def zeniths(self) -> np.ndarray:
        """(rows,) float64 [deg], downwards from the xy plane, as PhysX counts; 0 for a single row."""
        if self.rows == 1:
            return np.zeros(1)
        return np.arange(self.rows) * self.vertical_resolution - self.vertical_fov / 2

    def directions(self) -> np.ndarray:
        """(columns * rows, 3) float32 unit vectors in the sensor's axes, column after column."""
        azimuth, zenith = np.deg2rad(self.azimuths)[:, None], np.deg2rad(self.zeniths)[None, :]
        level = np.cos(zenith)
        parts = (
            np.cos(azimuth) * level,
            np.sin(azimuth) * level,
            np.broadcast_to(-np.sin(zenith), (self.columns, self.rows)),
        )
        return np.stack(parts, axis=-1).reshape(-1, 3).astype(np.float32)


def read_config(prim: Usd.Prim) -> PhysxLidarConfig:
    """What a prim describes. Raises UserError for invalid fields of view and rates, or too many beams."""
    resolutions = [number(prim, f"{name}Resolution", above=0) for name in ("horizontal", "vertical")]
    fields = [number(prim, f"{name}Fov", above=0, most=360) for name in ("horizontal", "vertical")]
    horizontal, vertical = (max(field, step) for field, step in zip(fields, resolutions, strict=True))
    columns = int(horizontal / resolutions[0])
    high = bool(prim.GetAttribute("highLod").Get())
    rows = int(vertical / resolutions[1]) + 1 if high else 1
    check("lidar.rays", rows * columns, f"{prim.GetPath()}: {rows:,} rows of {columns:,} columns")
    return PhysxLidarConfig(
        bool(prim.GetAttribute("enabled").Get()),
        read_ranges(prim),
        number(prim, "rotationRate", least=0),
        float(horizontal),
        float(resolutions[0]),
        float(vertical),
        float(resolutions[1]),
        float(number(prim, "yawOffset")),
        columns,
        rows,
    )


class PhysxLidarRuntime(SensorRuntime[PhysxLidarConfig]):
    """The sensor of a PhysX lidar prim.

    At rotationRate 0 each tick gives all beams. A rotating one fires in each tick the columns that it turned past,
    column j once (j + 1) / (columns * rotationRate) s are over, from the state of the update; a tick that completes a
    turn gives the whole turn, any other nothing. If a tick spans several turns, the newest whole one is given.
    """

    type_name = LIDAR

    def read(self, prim: Usd.Prim) -> PhysxLidarConfig:
        """The configuration that the prim describes."""
        return read_config(prim)

    def configure(self) -> None:
        """Prepares the beams of a turn."""
        config = self.config
        self._directions = config.directions()
        self._depths = np.zeros(len(self._directions), np.float32)
        self._times = np.zeros(config.columns, np.float32)

    def reset(self) -> None:
        """Drops an unfinished turn."""
        super().reset()
        self._since: int | None = None  # the first column fired, counted over all turns

    def measure(self, tick: Tick) -> Measurement | None:
        """All beams, or the turn that the tick completes."""
        config = self.config
        if not config.enabled:
            return None
        if not config.rotation_rate:
            self._depths = self._fire(slice(None), tick)
            self._times[:] = float(tick.time)
            return self._measured()
        speed = config.columns * config.rotation_rate
        first, last = math.floor(speed * tick.start), math.floor(speed * tick.end)
        turn = last // config.columns * config.columns
        newest = turn - config.columns  # where the newest whole turn begins
        first = max(first, newest)
        if self._since is None:
            self._since = first
        self._turn_to(first, min(turn, last), tick)
        whole = self._measured() if first < turn and self._since <= newest else None
        self._turn_to(max(first, turn), last, tick)
        return whole

    def _turn_to(self, first: int, last: int, tick: Tick) -> None:
        """Fires the columns [first, last), of one turn."""
        if first >= last:
            return
        start = first % self.config.columns
        columns = slice(start, start + last - first)
        beams = slice(columns.start * self.config.rows, columns.stop * self.config.rows)
        self._depths[beams] = self._fire(beams, tick)
        self._times[columns] = float(tick.time)

    def _fire(self, beams: slice, tick: Tick) -> np.ndarray:
        directions = self._directions[beams]
        world, poses = cast_world(tick.scene), tick.poses
        return fire(world, self.pose(poses), HERE, directions, self.config.ranges, poses, self.exclude)

    def _measured(self) -> Measurement:
        wanted, config = self.channels(), self.config
        arrays = told(wanted, self._depths, HERE, self._directions, config.ranges)
        if "beamTime" in wanted:
            arrays["beamTime"] = np.repeat(self._times, config.rows)
        return Measurement(arrays, len(self._depths))
