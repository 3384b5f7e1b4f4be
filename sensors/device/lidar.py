"""The scans of one lidar on a device: what `lidar.scan.Scanner` gives for beams of one ray, without noise and glass."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from graph.sim.devices import warp
from sensors.lidar.config import LidarConfig
from sensors.lidar.pattern import Pattern
from sensors.raycast.world import anchor_of
from sensors.surfaces.optics import Optics

from .frames import DeviceArrays, DeviceFrames
from .scan import DeviceScan

if TYPE_CHECKING:
    from .world import DeviceWorld


class DeviceLidar:
    """One lidar with a pattern. tables: channel -> rows of the surfaces; carrier: the body that it moves with."""

    def __init__(
        self,
        world: DeviceWorld,
        pattern: Pattern,
        config: LidarConfig,
        optics: Optics,
        exclude: frozenset[str],
        tables: Mapping[str, Callable[[], np.ndarray]],
        carrier: str | None,
    ) -> None:
        self.world, self._pattern, self._config, self._optics = world, pattern, config, optics
        self._exclude, self._tables = exclude, tables
        self._carrier = world.bodies.index(carrier) if carrier in world.bodies else -1
        self._frames: tuple[bytes, DeviceFrames] | None = None

    def scan(
        self, pose: np.ndarray, state: Any, velocities: np.ndarray, channels: frozenset[str]
    ) -> tuple[DeviceArrays, int]:
        """The channels of a whole scan from a pose (4, 4) float64 [m] in a state, and the number of returns.

        velocities: (b, 6) of the world's bodies at their origins [m/s, rad/s].
        """
        wp, device = warp(), self.world.device
        frames = self._about(anchor_of(pose[:3, 3]))
        geometry = frames.scan.geometry
        placed = self.world.placed(geometry, state)
        about = np.array(pose)
        about[:3, 3] -= geometry.anchor
        frames.scan.rays.frames.assign(about[None])
        linear, angular = (
            wp.array(np.ascontiguousarray(part)[None], dtype=wp.vec3d, device=device)
            for part in (velocities[:, :3], velocities[:, 3:])
        )
        frames.scan.scan(placed, linear, angular)
        return frames.frame(channels)

    def _about(self, anchor: np.ndarray) -> DeviceFrames:
        if self._frames is None or self._frames[0] != anchor.tobytes():
            geometry = self.world.geometry(anchor, self._exclude)
            scan = DeviceScan(geometry, self._pattern, self._config, self._optics, self.world.body_of, self._carrier)
            self._frames = anchor.tobytes(), DeviceFrames(scan, self._pattern, self._tables)
        return self._frames[1]
