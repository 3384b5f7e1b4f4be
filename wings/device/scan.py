"""A lidar on a device: the firings of a turn in any number of worlds, every channel by one launch."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from graph.sim.devices import warp
from sensors.lidar.receiver import Receiver
from sensors.surfaces.optics import Optics

from .devices import refuse_beyond
from .geometry import Geometry

if TYPE_CHECKING:
    from sensors.lidar.config import LidarConfig
    from sensors.lidar.pattern import Pattern

WIDTHS = {"distance": 1, "point": 3, "normal": 3, "intensity": 1, "velocity": 3, "surface": 1}
"""The channels of a scan and the numbers in each, of 4 bytes."""


class DeviceScan:
    """The scans of one lidar in `geometry.worlds` worlds.

    channels: those of `WIDTHS` that are wanted. body_of: (s,) the body of each surface; carrier: the body that carries
    the sensor, -1: none. Arrays of a scan are overwritten by the next one. Raises UserError for what does not fit.
    """

    def __init__(
        self,
        geometry: Geometry,
        pattern: Pattern,
        config: LidarConfig,
        optics: Optics,
        body_of: np.ndarray,
        carrier: int,
        channels: Iterable[str] = tuple(WIDTHS),
    ) -> None:
        from . import scan_kernels as kernels

        wp, device = warp(), geometry.device
        self.geometry, self._kernels, self.firings = geometry, kernels, len(pattern)
        worlds, wanted = geometry.worlds, frozenset(channels)
        size = sum(4 * WIDTHS[name] for name in wanted)
        refuse_beyond(
            device, worlds * len(pattern) * size, f"scans of {worlds:,} worlds with {len(pattern):,} rays each"
        )

        def upload(values: Any, dtype: Any = np.float32, kind: Any = None) -> Any:
            array = np.ascontiguousarray(values, dtype)
            return wp.array(array, dtype=kind or wp.dtype_from_numpy(dtype), device=device)

        self.rays = geometry.rays(pattern.directions, pattern.origins)
        gates = self._gates = kernels.Gates()
        gates.near, gates.far = upload(np.atleast_1d(pattern.near_m)), upload(np.atleast_1d(pattern.far_m))
        self._most = float(pattern.far_m.max()) * (1 + 1e-6)
        rule, receiver = Receiver(config), kernels.Receiver()
        self._receiver = receiver
        receiver.reflectance, receiver.retro = upload(optics.reflectance), upload(optics.retro, np.uint8)
        receiver.least, receiver.near, receiver.scale = rule.least, float(rule.near), float(rule.scale)
        receiver.normalised = int(rule.normalised)
        first, second = ([*rule.tables, [], []])[:2]
        receiver.first, receiver.second = upload(first), upload(second)
        motion = self.motion = kernels.Motion()
        motion.body_of, motion.carrier = upload(body_of, np.int32), carrier
        self.channels = kernels.Channels()
        kinds = {1: wp.float32, 3: wp.vec3}
        for name, width in WIDTHS.items():
            shape = (worlds, len(pattern)) if name in wanted else (0, 0)
            kind = wp.int32 if name == "surface" else kinds[width]
            setattr(self.channels, name, wp.zeros(shape, dtype=kind, device=device))
        self._local: Any = None
        self._mounted: Any = None
        self._every = upload(np.arange(worlds), np.int32)

    def mount(self, bodies: Any, local: np.ndarray) -> None:
        """Places the sensors: `local` (4, 4), or (w, 4, 4), to the body that carries them, or to the world [m]."""
        wp, geometry = warp(), self.geometry
        if self._mounted is not local:
            about = np.array(local, np.float64).reshape(-1, 4, 4)
            if self.motion.carrier < 0:
                about[:, :3, 3] -= geometry.anchor
            self._local, self._mounted = wp.array(about, dtype=wp.mat44d, device=geometry.device), local
        wp.launch(
            self._kernels.mount,
            dim=geometry.worlds,
            inputs=[bodies, self.motion.carrier, self._local],
            outputs=[self.rays.frames],
            device=geometry.device,
        )

    def scan(self, bodies: Any, linear: Any, angular: Any, due: np.ndarray | None = None) -> Any:
        """Casts the firings of the worlds `due` (d,), None: all; returns the channels, (w, n) each.

        bodies: (w, b) about the anchor, placed before; linear, angular: (w, b) their velocities.
        """
        wp, geometry = warp(), self.geometry
        rows = self._every if due is None else wp.array(due.astype(np.int32), dtype=wp.int32, device=geometry.device)
        self.motion.linear, self.motion.angular = linear, angular
        met = geometry.trace(self.rays, rows, self._most)
        wp.launch(
            self._kernels.scan_of(*geometry.kinds),
            dim=(len(rows), self.firings),
            inputs=[
                *(geometry.ground, geometry.items, geometry.placed, bodies, geometry.skip, self._gates),
                *(self._receiver, self.motion, self.rays, met, rows, self.channels),
            ],
            device=geometry.device,
        )
        return self.channels
