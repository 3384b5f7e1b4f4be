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
from .replay import Inputs, Replay
from .scan import DeviceScan

if TYPE_CHECKING:
    from .geometry import Geometry
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
        self._shots: tuple[bytes, _Shots] | None = None

    def scan(
        self, pose: np.ndarray, state: Any, velocities: np.ndarray, channels: frozenset[str]
    ) -> tuple[DeviceArrays, int]:
        """The channels of a whole scan from a pose (4, 4) float64 [m] in a state, and the number of returns.

        velocities: (b, 6) of the world's bodies at their origins [m/s, rad/s].
        """
        shots = self._about(anchor_of(pose[:3, 3]))
        shots.shoot(pose, state, velocities)
        return shots.frames.frame(channels)

    def _about(self, anchor: np.ndarray) -> _Shots:
        if self._shots is None or self._shots[0] != anchor.tobytes():
            geometry = self.world.geometry(anchor, self._exclude)
            scan = DeviceScan(geometry, self._pattern, self._config, self._optics, self.world.body_of, self._carrier)
            self._shots = (
                anchor.tobytes(),
                _Shots(self.world, geometry, DeviceFrames(scan, self._pattern, self._tables)),
            )
        return self._shots[1]


class _Shots:
    """Scans about one anchor: all that a scan takes on the device is replayed by one call."""

    def __init__(self, world: DeviceWorld, geometry: Geometry, frames: DeviceFrames) -> None:
        wp, bodies = warp(), len(world.bodies)
        self.frames, self._world, self._geometry = frames, world, geometry
        self._inputs = Inputs(
            world.device,
            {
                "frames": (wp.mat44d, (1,)),
                "bodies": (wp.mat44d, (1, bodies)),
                "linear": (wp.vec3d, (1, bodies)),
                "angular": (wp.vec3d, (1, bodies)),
            },
        )
        frames.scan.rays.frames = self._inputs.there["frames"]
        self._replay = Replay(world.device, self._work, recorded=not world.soft)

    def shoot(self, pose: np.ndarray, state: Any, velocities: np.ndarray) -> None:
        """One scan; see `DeviceLidar.scan`."""
        host = self._inputs.host
        self._world.deform(self._geometry, state)
        self._world.write_bodies(host["bodies"][0], self._geometry.anchor, state)
        host["frames"][0] = pose
        host["frames"][0, :3, 3] -= self._geometry.anchor
        host["linear"][0], host["angular"][0] = velocities[:, :3], velocities[:, 3:]
        self._replay()

    def _work(self) -> None:
        there, scan = self._inputs.there, self.frames.scan
        self._inputs.bring()
        self._geometry.settle(there["bodies"])
        scan.scan(there["bodies"], there["linear"], there["angular"])
        self.frames.find()
